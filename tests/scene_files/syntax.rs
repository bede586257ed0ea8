//! What a scene file may say at all: versions, keys, numbers.

use super::*;

#[test]
fn the_right_scene_is_read_as_written() {
    let scene = read(RIGHT).unwrap();
    assert_eq!(scene.name, "a.toml");
    assert_eq!(scene.cameras[0].name, "camera");
    let camera = scene.cameras[0].camera;
    assert_eq!(camera.position.to_array(), [0.0, 0.0, 3.0]);
    assert_eq!(camera.up.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(camera.aperture_radius, 0.0);
    assert_eq!(camera.focus_distance, 3.0, "the distance to look_at");
    assert_eq!((scene.film.width, scene.film.height), (256, 256));
    assert_eq!(scene.film.filter, Filter::Box);
    assert!(scene.render.spp.is_none() && scene.render.strategy.is_none());
    assert_eq!(scene.objects[0].material, 0);
    assert!(!scene.lights[0].two_sided && scene.lights[0].material.is_none());
}

#[test]
fn the_version_comes_first_and_must_be_known() {
    refuses(
        "version = 1\n",
        "",
        "1:1",
        &["add `version = 1` as its first line"],
    );
    refuses(
        "version = 1",
        "version = 2\nfuture = 3",
        "1:11",
        &["version 2", "reads version 1"],
    );
    refuses(
        "version = 1",
        "version = \"1\"",
        "1:11",
        &["a whole number", "this is a string"],
    );
    refuses("version = 1", "version = -1", "1:11", &["this is -1"]);
}

#[test]
fn what_is_not_toml_is_refused_where_it_breaks() {
    refuses(
        "[camera]",
        "[camera",
        "2:8",
        &["not valid TOML", "expected `]`"],
    );
    refuses(
        "vertical_fov = 50",
        "vertical_fov = 50\nvertical_fov = 50",
        "6:1",
        &["duplicate key"],
    );
    refuses(
        "[[objects]]",
        "[[objects]]\nx = ",
        "10:5",
        &["not valid TOML"],
    );
}

#[test]
fn columns_count_characters_and_lines_survive_windows_and_a_byte_order_mark() {
    let text = RIGHT.replace("material = \"white\"", "# é漢\nmaterial = \"é漢\"");
    refuses_text(
        &text,
        "12:12",
        &["material \"é漢\" is not defined; defined are: white"],
    );
    let text = RIGHT.replace("\"white\"", "\"whte\"");
    refuses_text(
        &text.replace('\n', "\r\n"),
        "11:12",
        &["did you mean \"white\"?"],
    );
    let text = RIGHT.replace("version = 1", "\u{feff}version = 3");
    refuses_text(&text, "1:11", &["version 3"]);
    refuses_text(
        &RIGHT.replace("[0, 0, 3]", "{ \"é\" = 1, z = 2 }"),
        "3:12",
        &["a list of 3 numbers"],
    );
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_known_one_and_all_of_them() {
    let words = [
        "unknown key \"postion\" in [camera]",
        "did you mean \"position\"?",
        "Known keys: position, look_at, up,",
    ];
    refuses("position", "postion", "3:1", &words);
    refuses(
        "vertical_fov",
        "fov",
        "5:1",
        &["did you mean \"vertical_fov\"?"],
    );
    refuses(
        "radius = 1",
        "radius = 1, zzz = 2",
        "10:44",
        &["in a sphere", "the nearest known key is"],
    );
    refuses(
        "[[lights]]",
        "[[light]]",
        "12:3",
        &["did you mean \"lights\"?", "environment"],
    );
    refuses(
        "albedo = [0.8, 0.8, 0.8]",
        "albedo = [0.8, 0.8, 0.8]\nroughness = 1",
        "9:1",
        &["in a lambert material"],
    );
    refuses(
        "radiance",
        "power = 1\nradiance",
        "14:1",
        &["in [[lights]]", "two_sided"],
    );
    refuses_appended("[film]\nwidht = 5\n", "16:1", &["did you mean \"width\"?"]);
    refuses_appended("[render]\nmax_depth = 5\n", "16:1", &["path_length"]);
    refuses_appended("[environment]\ncolour = 5\n", "16:1", &["constant"]);
}

#[test]
fn the_first_of_several_unknown_keys_is_reported() {
    refuses(
        "position",
        "zeta = 1\nalpha = 2\nposition",
        "3:1",
        &["\"zeta\""],
    );
}

#[test]
fn numbers_are_finite_and_fit_in_32_bits() {
    for bad in ["nan", "-nan", "inf", "+inf", "-inf"] {
        refuses(
            "radius = 1",
            &format!("radius = {bad}"),
            "10:41",
            &["a finite number", bad],
        );
    }
    refuses(
        "radius = 1",
        "radius = 1e39",
        "10:41",
        &["too large for a 32-bit float"],
    );
    refuses("radius = 1", "radius = 1e999999", "10:41", &["too large"]);
    refuses(
        "[5, 5, 5]",
        "[5, -inf, 5]",
        "14:16",
        &["g of radiance", "finite"],
    );
    let huge = "9".repeat(200);
    refuses(
        "radius = 1",
        &format!("radius = {huge}"),
        "10:41",
        &["too large"],
    );
    accepts("radius = 1", "radius = 0x10");
    accepts("radius = 1", "radius = 1_0.5e-1");
}

#[test]
fn vectors_have_three_numbers() {
    refuses("[0, 0, 3]", "[0, 0]", "3:12", &["3 numbers", "this has 2"]);
    refuses("[0, 0, 3]", "[0, 0, 0, 3]", "3:12", &["this has 4"]);
    refuses(
        "[0, 0, 3]",
        "3",
        "3:12",
        &["a list of 3 numbers", "a whole number"],
    );
    refuses(
        "[0, 0, 3]",
        "[0, \"0\", 3]",
        "3:16",
        &["y of position", "a string"],
    );
    refuses(
        "[0, 0, 3]",
        "[0, 0, 2e9]",
        "3:19",
        &["z of position", "within ±1e9"],
    );
    refuses(
        "[5, 5, 5]",
        "5.0",
        "14:12",
        &["a list of 3 numbers, as in [1.0, 1.0, 1.0]"],
    );
}
