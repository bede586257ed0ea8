//! What the scene format refuses, where it says so, and what it tells the author to do.

use ondine::error::Error;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::{Description, Environment, Filter, SamplerKind, Shape, Strategy};
use ondine::scene::{builtin, toml};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::path::Path;

/// A scene that is right, to be made wrong one line at a time: line numbers below count from its first.
const RIGHT: &str = r#"version = 1
[camera]
position = [0, 0, 3]
look_at = [0, 0, 0]
vertical_fov = 50
[materials.white]
type = "lambert"
albedo = [0.8, 0.8, 0.8]
[[objects]]
sphere = { center = [0, 0, 0], radius = 1 }
material = "white"
[[lights]]
quad = { corner = [-1, 3, -1], u = [2, 0, 0], v = [0, 0, 2] }
radiance = [5, 5, 5]
"#;

fn read(text: &str) -> Result<Description, Error> {
    toml::parse(text, "a.toml", None)
}

fn refusal(text: &str) -> String {
    match read(text) {
        Ok(_) => panic!("read without complaint:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// Replaces `from` in the right scene and asserts the place and the remedy of the refusal.
#[track_caller]
fn refuses(from: &str, to: &str, place: &str, words: &[&str]) {
    assert!(RIGHT.contains(from), "{from:?} is not in the scene");
    refuses_text(&RIGHT.replacen(from, to, 1), place, words);
}

#[track_caller]
fn refuses_text(text: &str, place: &str, words: &[&str]) {
    let message = refusal(text);
    let start = format!("a.toml:{place}: ");
    assert!(message.starts_with(&start), "{message}\nis not at {place}");
    for word in words {
        assert!(message.contains(word), "{message}\nlacks {word:?}");
    }
}

#[track_caller]
fn accepts(from: &str, to: &str) -> Description {
    assert!(RIGHT.contains(from), "{from:?} is not in the scene");
    read(&RIGHT.replacen(from, to, 1)).unwrap_or_else(|error| panic!("{error}"))
}

/// Appends to the right scene, whose next line is line 15.
#[track_caller]
fn refuses_appended(text: &str, place: &str, words: &[&str]) {
    refuses_text(&format!("{RIGHT}{text}"), place, words);
}

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

#[test]
fn colours_are_physical() {
    refuses(
        "[5, 5, 5]",
        "[5, 5, -0.1]",
        "14:19",
        &["b of radiance", "at least 0", "-0.1"],
    );
    refuses(
        "[0.8, 0.8, 0.8]",
        "[0.8, 1.1, 0.8]",
        "8:16",
        &["g of albedo", "from 0 to 1", "1.1"],
    );
    refuses("[0.8, 0.8, 0.8]", "[-1, 1, 0.8]", "8:11", &["r of albedo"]);
    accepts("[0.8, 0.8, 0.8]", "[0, 1, 1.0]");
    accepts("[5, 5, 5]", "[0, 0, 1e30]");
}

const ALBEDO: &str = "type = \"lambert\"\nalbedo = [0.8, 0.8, 0.8]";

#[test]
fn a_phong_material_reflects_no_more_than_it_gets() {
    let phong = |diffuse: &str, specular: &str, n: &str| {
        format!("type = \"phong\"\ndiffuse = {diffuse}\nspecular = {specular}\nexponent = {n}")
    };
    let red = "[0.1, 0.1, 0.1]";
    refuses(
        ALBEDO,
        &phong(red, "[0.1, 0.95, 0]", "5"),
        "9:12",
        &["diffuse + specular is 1.05 in green", "lower either"],
    );
    refuses(ALBEDO, &phong(red, red, "-1"), "10:12", &["at least 0"]);
    accepts(ALBEDO, &phong("[0.7, 0.1, 0.9]", "[0.3, 0.9, 0.1]", "0"));
    refuses(
        ALBEDO,
        "type = \"phong\"\ndiffuse = [0, 0, 0]",
        "6:1",
        &["has no specular; add specular ="],
    );
}

#[test]
fn every_material_has_its_own_ranges() {
    for roughness in ["0", "-0.5", "1.5"] {
        let conductor =
            format!("type = \"conductor\"\nreflectance = [1, 1, 1]\nroughness = {roughness}");
        refuses(
            ALBEDO,
            &conductor,
            "9:13",
            &["above 0 and at most 1", "mirror"],
        );
    }
    for ior in ["0", "-1.5"] {
        refuses(
            ALBEDO,
            &format!("type = \"glass\"\nior = {ior}"),
            "8:7",
            &["above 0", "1.5"],
        );
    }
    let inverted = accepts(ALBEDO, "type = \"glass\"\nior = 0.66");
    assert_eq!(
        inverted.materials[0].material,
        Material::Glass { ior: 0.66 }
    );
    refuses(
        ALBEDO,
        "type = \"mirror\"",
        "6:1",
        &["a mirror material has no reflectance; add"],
    );
    refuses(
        ALBEDO,
        "albedo = [1, 1, 1]",
        "6:1",
        &["[materials.white] has no type; add type ="],
    );
    refuses(
        "\"lambert\"",
        "\"lambrt\"",
        "7:8",
        &["did you mean \"lambert\"?", "conductor"],
    );
    refuses(
        "\"lambert\"",
        "\"velvet\"",
        "7:8",
        &["unknown material type \"velvet\".", "Use lambert"],
    );
}

#[test]
fn cameras_look_somewhere_with_a_right_side() {
    refuses(
        "look_at = [0, 0, 0]",
        "look_at = [0, 0, 3]",
        "4:11",
        &["the same point as position", "move either"],
    );
    let up = |up: &str| format!("vertical_fov = 50\nup = {up}");
    refuses(
        "vertical_fov = 50",
        &up("[0, 0, 2]"),
        "6:6",
        &["parallel", "write up = [0.0, 1.0, 0.0]"],
    );
    refuses(
        "vertical_fov = 50",
        &up("[0, 0, 0]"),
        "6:6",
        &["no direction"],
    );
    refuses(
        "look_at = [0, 0, 0]",
        "look_at = [0, 9, 3]",
        "4:11",
        &["parallel", "write up = [0.0, 0.0, -1.0]"],
    );
    for fov in ["0", "180", "-5", "200"] {
        refuses(
            "vertical_fov = 50",
            &format!("vertical_fov = {fov}"),
            "5:16",
            &["above 0 and below 180 degrees"],
        );
    }
    refuses(
        "vertical_fov = 50",
        "vertical_fov = 50\naperture_radius = -1",
        "6:19",
        &["at least 0"],
    );
    refuses(
        "vertical_fov = 50",
        "vertical_fov = 50\nfocus_distance = 0",
        "6:18",
        &["above 0"],
    );
    refuses(
        "vertical_fov = 50\n",
        "",
        "2:1",
        &["[camera] has no vertical_fov; add vertical_fov = 50.0"],
    );
}

#[test]
fn cameras_keep_the_order_of_the_file() {
    let body = "position = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 50\n";
    let several = format!("[cameras.zoe]\n{body}[cameras.adam]\n{body}[cameras.mia]\n{body}");
    let scene = accepts(&format!("[camera]\n{body}"), &several);
    let names: Vec<_> = scene
        .cameras
        .iter()
        .map(|camera| camera.name.as_str())
        .collect();
    assert_eq!(names, ["zoe", "adam", "mia"]);
    refuses_appended(
        "[cameras.b]\n",
        "15:2",
        &["both [camera] and [cameras]", "rename [camera]"],
    );
    refuses(
        &format!("[camera]\n{body}"),
        "",
        "1:1",
        &["no camera; add [camera]"],
    );
    refuses(
        &format!("[camera]\n{body}"),
        "[cameras]\n",
        "2:2",
        &["[cameras] is empty"],
    );
    refuses("[camera]", "[[camera]]", "2:1", &["a table", "[camera]"]);
}

#[test]
fn film_and_render_settings_have_ranges() {
    let film = |w: &str, h: &str| format!("[film]\nwidth = {w}\nheight = {h}\n");
    refuses_appended(&film("0", "4"), "16:9", &["from 1 to 65535", "this is 0"]);
    refuses_appended(&film("4", "65536"), "17:10", &["from 1 to 65535"]);
    refuses_appended(
        &film("4.0", "4"),
        "16:9",
        &["a whole number without a decimal point"],
    );
    refuses_appended(&film("4", "99999999999999999999999"), "17:10", &["65535"]);
    refuses_appended(
        "[film]\nwidth = 4\n",
        "15:1",
        &["[film] has no height; add height = 256"],
    );
    refuses_appended(
        &format!("{}filter = \"gauss\"\n", film("4", "4")),
        "18:10",
        &["gaussian", "did you mean"],
    );
    for (setting, column, word) in [
        ("spp = 0", 7, "from 1"),
        ("path_length = 0", 15, "from 1"),
        ("path_length = 10001", 15, "to 10000"),
        ("spp = 134217729", 7, "to 134217728"),
        ("strategy = \"mix\"", 12, "did you mean \"mis\"?"),
        ("sampler = \"halton\"", 11, "Known: pcg, sobol"),
        ("seed = -1", 8, "from 0 to 18446744073709551615"),
        ("roulette = 0", 12, "from 1"),
        ("spp = true", 7, "true or false"),
    ] {
        let text = format!("[render]\n{setting}\n");
        refuses_appended(&text, &format!("16:{column}"), &[word]);
    }
    let settings = "spp = 7\npath_length = 1\nstrategy = \"light\"\nsampler = \"pcg\"\nseed = 18446744073709551615\nroulette = 2\n";
    let scene = read(&format!(
        "{RIGHT}[render]\n{settings}[film]\nwidth = 65535\nheight = 1\nfilter = \"tent\"\n"
    ))
    .unwrap();
    assert_eq!(scene.render.seed, Some(u64::MAX));
    assert_eq!(scene.render.roulette, Some(2));
    assert_eq!(scene.render.strategy, Some(Strategy::Light));
    assert_eq!(scene.render.sampler, Some(SamplerKind::Pcg));
    assert_eq!(scene.film.filter, Filter::Tent);
}

#[test]
fn choices_are_written_as_they_are_read() {
    for (name, strategy) in Strategy::NAMES {
        assert_eq!(name.parse::<Strategy>().unwrap(), *strategy);
        assert_eq!(strategy.to_string(), *name);
    }
    assert_eq!(Strategy::NAMES.len(), 4);
    assert_eq!(SamplerKind::Sobol.to_string(), "sobol");
    assert_eq!(format!("{:>6}", Filter::Box), "   box");
    let error = "cosin".parse::<Strategy>().unwrap_err().to_string();
    assert_eq!(
        error,
        "unknown strategy \"cosin\"; did you mean \"cosine\"? Known: uniform, cosine, light, mis"
    );
}

#[test]
fn shapes_have_an_extent() {
    for radius in ["0", "-1", "1e-60", "1e-10", "2e9"] {
        refuses(
            "radius = 1",
            &format!("radius = {radius}"),
            "10:41",
            &["radius must be above 0"],
        );
    }
    refuses(
        "u = [2, 0, 0]",
        "u = [0, 0, 0]",
        "13:36",
        &["u has no length"],
    );
    refuses(
        "v = [0, 0, 2]",
        "v = [-4, 0, 0]",
        "13:51",
        &["parallel to u", "span a parallelogram"],
    );
    refuses(
        "v = [0, 0, 2]",
        "v = [2, 0, 1e-7]",
        "13:51",
        &["parallel to u"],
    );
    let tiny = "u = [1e-9, 0, 0], v = [0, 1e-8, 0]";
    accepts("u = [2, 0, 0], v = [0, 0, 2]", tiny);
    refuses(
        "u = [2, 0, 0], v = [0, 0, 2]",
        "u = [1e-9, 0, 0], v = [1e-9, 5e-10, 0]",
        "13:54",
        &["too small", "at least 1e-18"],
    );
}

#[test]
fn an_object_has_one_shape_and_a_material() {
    refuses(
        "sphere = { center = [0, 0, 0], radius = 1 }\n",
        "",
        "9:1",
        &["this object has no shape; add sphere ="],
    );
    let two = "quad = { corner = [0, 0, 0], u = [1, 0, 0], v = [0, 1, 0] }\nsphere =";
    refuses("sphere =", two, "11:1", &["two shapes", "its own table"]);
    refuses(
        "material = \"white\"\n",
        "",
        "9:1",
        &["this object has no material; add material = \"white\""],
    );
    refuses(
        "\"white\"",
        "\"whte\"",
        "11:12",
        &["material \"whte\" is not defined; did you mean \"white\"?"],
    );
    refuses("\"white\"", "\"brass\"", "11:12", &["defined are: white"]);
    refuses("\"white\"", "0", "11:12", &["a string in quotes"]);
    refuses(
        &RIGHT[RIGHT.find("[materials").unwrap()..RIGHT.find("[[objects").unwrap()],
        "",
        "8:12",
        &["add [materials.\"white\"]"],
    );
    refuses(
        "[[objects]]",
        "[objects]",
        "9:1",
        &["a list of tables, each written [[objects]]"],
    );
    refuses(
        "radius = 1",
        "raduis = 1",
        "10:32",
        &["did you mean \"radius\"?"],
    );
    refuses(
        ", radius = 1",
        "",
        "10:10",
        &["this sphere has no radius; add radius ="],
    );
    refuses(
        "sphere = { center = [0, 0, 0], radius = 1 }",
        "sphere = 1",
        "10:10",
        &["a table, as in sphere = { center"],
    );
}

#[test]
fn a_light_may_scatter_and_be_two_sided() {
    let scene = accepts(
        "radiance = [5, 5, 5]",
        "radiance = [5, 5, 5]\ntwo_sided = true\nmaterial = \"white\"",
    );
    assert!(scene.lights[0].two_sided);
    assert_eq!(scene.lights[0].material, Some(0));
    refuses(
        "radiance = [5, 5, 5]",
        "radiance = [5, 5, 5]\ntwo_sided = 1",
        "15:13",
        &["true or false"],
    );
    refuses(
        "radiance = [5, 5, 5]",
        "radiance = [5, 5, 5]\nmaterial = \"w\"",
        "15:12",
        &["not defined"],
    );
    refuses(
        "radiance = [5, 5, 5]\n",
        "",
        "12:1",
        &["this light has no radiance; add radiance ="],
    );
}

#[test]
fn what_a_later_version_reads_is_refused_with_what_to_use_now() {
    refuses(
        "sphere = {",
        "mesh = { file = \"a.ply\" } #",
        "10:1",
        &["mesh is not supported by this version", "spheres and quads"],
    );
    refuses(
        "material =",
        "transform = { scale = 2 }\nmaterial =",
        "11:1",
        &["transform is not supported", "world space"],
    );
    refuses(
        "\"lambert\"",
        "\"principled\"",
        "7:8",
        &["not supported by this version", "\"conductor\""],
    );
    refuses(
        "[0.8, 0.8, 0.8]",
        "{ texture = \"wood.png\" }",
        "8:10",
        &["texture is not supported by this version", "colour"],
    );
    refuses_appended(
        "[environment]\nsh = \"probe.json\"\n",
        "16:1",
        &["sh is not supported by this version", "lat-long"],
    );
}

#[test]
fn a_scene_has_something_to_see() {
    let lights = RIGHT.find("[[lights]]").unwrap();
    let objects = RIGHT.find("[[objects]]").unwrap();
    refuses_text(
        &RIGHT[..objects],
        "1:1",
        &["the scene is empty; add [[lights]]", "[environment]"],
    );
    refuses_text(&RIGHT[..lights], "1:1", &["the scene has no light; add"]);
    read(&format!(
        "{}[environment]\nconstant = [1, 1, 1]\n",
        &RIGHT[..objects]
    ))
    .unwrap();
    read(&format!("{}{}", &RIGHT[..objects], &RIGHT[lights..])).unwrap();
}

#[test]
fn an_environment_is_exactly_one_thing() {
    refuses_appended(
        "[environment]\n",
        "15:1",
        &["[environment] is empty; add constant"],
    );
    let gradient = "gradient = { zenith = [0, 0, 1], horizon = [1, 1, 1], ground = [0, 1, 0] }\n";
    refuses_appended(
        &format!("[environment]\nconstant = [1, 1, 1]\n{gradient}"),
        "17:1",
        &["both constant and gradient; keep one"],
    );
    refuses_appended(
        "[environment]\nconstant = [1, 1, 1]\nrotate_degrees = 3\n",
        "17:1",
        &["turns an image", "remove it"],
    );
    refuses_appended(
        "[environment]\ngradient = { zenith = [1, 1, 1] }\n",
        "16:12",
        &["this gradient has no horizon; add horizon ="],
    );
    refuses_appended(
        "[environment]\nimage = \"sky.exr\"\n",
        "16:9",
        &["this scene is not a file", "absolute path"],
    );
    refuses_appended(
        "[environment]\nimage = \"\"\n",
        "16:9",
        &["name a lat-long EXR"],
    );
    let scene = read(&format!("{RIGHT}[environment]\n{gradient}")).unwrap();
    assert!(
        matches!(scene.environment, Some(Environment::Gradient { zenith, .. }) if zenith == Rgb::new(0.0, 0.0, 1.0))
    );
}

/// Writes an EXR whose pixel (x, y) is `pixel(x, y)`.
fn write_exr(
    path: &Path,
    width: usize,
    height: usize,
    pixel: impl Fn(usize, usize) -> [f32; 3] + Sync,
) {
    exr::prelude::write_rgb_file(path, width, height, |x, y| {
        let [r, g, b] = pixel(x, y);
        (r, g, b)
    })
    .unwrap();
}

fn with_image(folder: &Path, file: &str) -> Result<Description, Error> {
    let text = format!("{RIGHT}[environment]\nimage = \"{file}\"\nrotate_degrees = 90\n");
    toml::parse(&text, "a.toml", Some(folder))
}

#[test]
fn an_environment_image_is_read_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    write_exr(&folder.path().join("sky.exr"), 8, 4, |x, y| {
        [x as f32, y as f32, 0.5]
    });
    let scene = with_image(folder.path(), "sky.exr").unwrap();
    let Some(Environment::Image {
        image,
        rotate_degrees,
    }) = scene.environment
    else {
        panic!("no image");
    };
    assert_eq!((image.width, image.height, rotate_degrees), (8, 4, 90.0));
    assert_eq!(image.pixels[2 * 8 + 5], Rgb::new(5.0, 2.0, 0.5));
}

#[test]
fn an_environment_image_that_cannot_be_used_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    write_exr(&file("square.exr"), 4, 4, |_, _| [1.0; 3]);
    write_exr(&file("nan.exr"), 4, 2, |x, y| {
        [1.0, if (x, y) == (3, 1) { f32::NAN } else { 1.0 }, 1.0]
    });
    write_exr(&file("inf.exr"), 4, 2, |_, _| [f32::INFINITY; 3]);
    write_exr(&file("dark.exr"), 4, 2, |x, _| [1.0, 1.0, 1.0 - x as f32]);
    std::fs::write(file("text.exr"), "not an image").unwrap();
    let whole = std::fs::read(file("inf.exr")).unwrap();
    std::fs::write(file("cut.exr"), &whole[..whole.len() - 20]).unwrap();
    for (name, words) in [
        (
            "square.exr",
            "4×4 pixels, and a lat-long image is twice as wide as high; resize it to 8×4",
        ),
        ("nan.exr", "pixel (3, 1) has G = NaN"),
        ("inf.exr", "pixel (0, 0) has R = inf"),
        ("dark.exr", "pixel (2, 0) has B = -1"),
        ("text.exr", "is not an EXR image"),
        ("cut.exr", ""),
        ("missing.exr", "cannot read"),
        (".", "cannot read"),
    ] {
        let message = with_image(folder.path(), name).unwrap_err().to_string();
        assert!(message.starts_with("a.toml:16:9: image "), "{message}");
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn no_damage_to_an_environment_image_makes_its_reader_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    write_exr(&path, 16, 8, |x, y| [x as f32, y as f32, 0.5]);
    let whole = std::fs::read(&path).unwrap();
    let mut random = Pcg32::new(3, 5);
    for _ in 0..500 {
        std::fs::write(&path, mutated(&whole, &mut random)).unwrap();
        let _ = with_image(folder.path(), "sky.exr");
    }
}

#[test]
fn a_file_that_is_no_text_is_refused_where_it_stops_being_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, b"version = 1\n# caf\xe9\n").unwrap();
    let message = toml::load(&path).unwrap_err().to_string();
    assert!(
        message.ends_with("a.toml:2:6: this is not UTF-8 text; save the scene file as UTF-8"),
        "{message}"
    );
    let message = toml::load(folder.path()).unwrap_err().to_string();
    assert!(message.contains("cannot read"), "{message}");
    std::fs::write(&path, RIGHT).unwrap();
    let scene = builtin::open(path.to_str().unwrap()).unwrap();
    assert_eq!(scene.name, path.to_str().unwrap());
}

#[test]
fn every_scene_of_the_folder_is_built_in_and_read() {
    let mut files: Vec<String> = std::fs::read_dir("scenes")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    let mut names: Vec<_> = builtin::ALL.iter().map(|scene| scene.name).collect();
    files.sort();
    names.sort_unstable();
    assert_eq!(files, names);
    for scene in builtin::ALL {
        let description = scene.load().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(description.name, scene.name);
        assert!(description.objects.len() + description.lights.len() < 64);
        assert!(description.render.spp.is_some() && description.render.path_length.is_some());
        assert!(
            scene.text.starts_with("# ") && scene.title().len() > 20,
            "{}",
            scene.title()
        );
    }
}

#[test]
fn a_scene_that_does_not_exist_is_refused_with_those_that_do() {
    assert_eq!(builtin::open("cornell").unwrap().name, "cornell");
    for (scene, words) in [
        (
            "cornel",
            "did you mean \"cornell\"? Built-in scenes: cornell, mirror,",
        ),
        (
            "my/cornel.toml",
            "no built-in scene \"my/cornel.toml\"; did you mean \"cornell\"?",
        ),
        ("", "Built-in scenes: cornell,"),
        (
            "castle.GLB",
            "glTF scenes are not supported by this version; write the scene as .toml",
        ),
        ("castle.gltf", "glTF scenes are not supported"),
        ("castle.pbrt", "pbrt scenes are not supported"),
        ("Cargo.lock", "is not a scene file; scenes are .toml files"),
    ] {
        let message = builtin::open(scene).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn errors_in_a_built_in_scene_would_name_it() {
    let error = toml::parse("version = 1", "built-in scene x", None).unwrap_err();
    assert!(error.to_string().starts_with("built-in scene x:1:1: "));
}

#[test]
fn cornell_is_the_scene_of_the_reference_image() {
    let scene = builtin::open("cornell").unwrap();
    let camera = scene.cameras[0].camera;
    assert_eq!(camera.position.to_array(), [0.0, 0.0, 2.95]);
    assert_eq!(camera.look_at.to_array(), [0.0, 0.0, -1.0]);
    assert_eq!(camera.up.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(
        (
            camera.vertical_fov,
            camera.aperture_radius,
            camera.focus_distance
        ),
        (50.0, 0.0, 3.3)
    );
    assert_eq!(
        (scene.film.width, scene.film.height, scene.film.filter),
        (256, 256, Filter::Box)
    );
    assert_eq!(
        (scene.render.spp, scene.render.path_length),
        (Some(64), Some(6))
    );
    assert_eq!(scene.render.strategy, Some(Strategy::Mis));
    assert_eq!(scene.render.sampler, Some(SamplerKind::Sobol));
    let lambert = |name: &str| {
        let named = scene
            .materials
            .iter()
            .find(|material| material.name == name)
            .unwrap();
        let Material::Lambert { albedo } = named.material else {
            panic!("{name} is not matte");
        };
        albedo.to_array()
    };
    assert_eq!(lambert("white"), [0.73, 0.73, 0.73]);
    assert_eq!(lambert("red"), [0.65, 0.05, 0.05]);
    assert_eq!(lambert("green"), [0.12, 0.45, 0.15]);
    assert_eq!(lambert("blue"), [0.3, 0.4, 0.73]);
    let quad = |corner: [f32; 3], u: [f32; 3], v: [f32; 3]| Shape::Quad {
        corner: corner.into(),
        u: u.into(),
        v: v.into(),
    };
    let sphere = |center: [f32; 3], radius| Shape::Sphere {
        center: center.into(),
        radius,
    };
    let expected = [
        (quad([-1., -1., 3.], [2., 0., 0.], [0., 0., -4.]), "white"),
        (quad([-1., 1., -1.], [2., 0., 0.], [0., 0., 4.]), "white"),
        (quad([-1., -1., -1.], [2., 0., 0.], [0., 2., 0.]), "white"),
        (quad([1., -1., 3.], [-2., 0., 0.], [0., 2., 0.]), "white"),
        (quad([-1., -1., 3.], [0., 0., -4.], [0., 2., 0.]), "red"),
        (quad([1., -1., -1.], [0., 0., 4.], [0., 2., 0.]), "green"),
        (sphere([-0.42, -0.65, -0.35], 0.35), "white"),
        (sphere([0.42, -0.7, 0.25], 0.3), "blue"),
    ];
    assert_eq!(scene.objects.len(), expected.len());
    for (object, (shape, material)) in scene.objects.iter().zip(expected) {
        assert_eq!(object.shape, shape);
        assert_eq!(scene.materials[object.material].name, material);
    }
    let [light] = scene.lights.as_slice() else {
        panic!("one light");
    };
    assert_eq!(light.shape, sphere([0.0, 0.7, 0.0], 0.15));
    assert_eq!(light.radiance, Rgb::new(20.0, 18.0, 15.0));
    assert!(light.material.is_none() && !light.two_sided && scene.environment.is_none());
}

/// A copy with one to four random edits: flipped, deleted or inserted bytes, duplicated lines.
fn mutated(original: &[u8], random: &mut Pcg32) -> Vec<u8> {
    let mut below = |limit: usize| random.next_u32() as usize % limit.max(1);
    let mut bytes = original.to_vec();
    for _ in 0..=below(4) {
        let at = below(bytes.len());
        let end = (at + 1 + below(8)).min(bytes.len());
        match below(4) {
            0 => bytes[at] ^= 1 << below(8),
            1 => drop(bytes.drain(at..end)),
            2 => {
                const ALPHABET: &[u8] = b"[]{}=\"',.#\n -+_0123456789eE:nainftrux\xc3\xa9\xff\0";
                let inserted: Vec<u8> =
                    (at..end).map(|_| ALPHABET[below(ALPHABET.len())]).collect();
                drop(bytes.splice(at..at, inserted));
            }
            _ => {
                let start = bytes[..at]
                    .iter()
                    .rposition(|&byte| byte == b'\n')
                    .map_or(0, |newline| newline + 1);
                let stop = bytes[at..]
                    .iter()
                    .position(|&byte| byte == b'\n')
                    .map_or(bytes.len(), |length| at + length + 1);
                let line = bytes[start..stop].to_vec();
                drop(bytes.splice(start..start, line));
            }
        }
        if bytes.is_empty() {
            bytes.push(b'=');
        }
    }
    bytes
}

#[test]
fn no_damage_to_a_scene_file_makes_its_reader_panic() {
    let mut random = Pcg32::new(1, 2);
    let mut read_still = 0;
    for round in 0..20_000 {
        let scene = builtin::ALL[round % builtin::ALL.len()];
        let bytes = mutated(scene.text.as_bytes(), &mut random);
        match read(&String::from_utf8_lossy(&bytes)) {
            Ok(_) => read_still += 1,
            Err(Error::Scene { place, .. }) => assert!(place.line >= 1 && place.column >= 1),
            Err(error) => panic!("{error} names no place"),
        }
    }
    // Most damage is in comments or digits, or is refused: both happen, or the edits test nothing.
    assert!((500..18_000).contains(&read_still), "{read_still}");
}

#[test]
fn deep_nesting_and_endless_names_are_refused_not_run_into() {
    let deep = "[".repeat(100_000);
    refuses_text(
        &format!("version = {deep}"),
        "1:91",
        &["not valid TOML", "recurs"],
    );
    let dotted = "a.".repeat(100_000);
    assert!(refusal(&format!("version = 1\n{dotted}a = 1")).contains("recursion limit"));
    // As deep as the parser lets through: dotted keys in nested inline tables.
    let keys = "a.".repeat(70);
    let nested = format!(
        "{}1{}",
        format!("{{ {keys}a = ").repeat(70),
        " }".repeat(70)
    );
    refuses_text(
        &format!("version = 1\na = {nested}"),
        "2:1",
        &["unknown key \"a\""],
    );
    let long = "x".repeat(5_000_000);
    assert!(refusal(&format!("version = 1\n{long} = 1")).len() < 400);
    assert!(refusal(&RIGHT.replace("\"white\"", &format!("\"{long}\""))).len() < 400);
}
