//! What a scene is made of: shapes, objects, lights.

use super::*;

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
fn harmonics_are_a_published_light_or_a_file_beside_the_scene() {
    refuses_appended(
        "[environment]\nsh = \"probe.json\"\n",
        "16:6",
        &["sh is relative to the scene file", "absolute path"],
    );
    refuses_appended(
        "[environment]\nconstant = [1, 1, 1]\nclamp = true\n",
        "17:1",
        &["clamp cuts off what is below 0 in sh", "remove it"],
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
