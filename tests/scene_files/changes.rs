//! Values of a scene file that are changed before it is read.

use super::RIGHT;
use ondine::error::Error;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::builtin;
use ondine::scene::cache::Cache;
use ondine::scene::description::Description;
use ondine::scene::toml::{self, Change, write};
use std::sync::Arc;

fn open(scene: &str, changes: &[&str]) -> Result<Description, Error> {
    let changes = changes.iter().map(|text| Change::parse(text).map(Arc::new));
    let changes = changes.collect::<Result<Vec<_>, _>>()?;
    builtin::open_changed(scene, &changes, &mut Cache::default())
}

/// The right scene as a file, and its path.
fn scene() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, RIGHT).unwrap();
    let path = path.display().to_string();
    (folder, path)
}

#[track_caller]
fn refuses(change: &str, words: &[&str]) {
    let (_folder, path) = scene();
    let message = open(&path, &[change]).unwrap_err().to_string();
    for word in words {
        assert!(message.contains(word), "{message}\nlacks {word}");
    }
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn a_change_reads_as_if_the_file_said_so() {
    let (folder, path) = scene();
    let changed = open(
        &path,
        &[
            "materials.white.albedo=[0.1, 0.2, 0.3]",
            "lights.0.radiance.1=7",
            "camera.aperture_radius = 0.1",
            "render.strategy=light",
            "objects.0.transform.translate=[1,2,3]",
        ],
    )
    .unwrap();
    let Material::Lambert { albedo } = changed.materials[0].material else {
        panic!("{:?}", changed.materials[0]);
    };
    assert_eq!(albedo, Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(changed.lights[0].radiance, Rgb::new(5.0, 7.0, 5.0));
    assert_eq!(changed.cameras[0].camera.aperture_radius, 0.1);
    assert_eq!(changed.render.strategy.unwrap().to_string(), "light");

    let other = folder.path().join("b.toml");
    let by_hand = RIGHT.replace("[0.8, 0.8, 0.8]", "[0.1, 0.2, 0.3]");
    std::fs::write(&other, by_hand).unwrap();
    let by_hand = builtin::open(&other.display().to_string()).unwrap();
    let changed = open(&path, &["materials.white.albedo=[0.1, 0.2, 0.3]"]).unwrap();
    assert_eq!(changed.hash, by_hand.hash, "the hash of the changed text");
    let same = open(&path, &["camera.vertical_fov=50"]).unwrap();
    assert_eq!(same.hash, builtin::open(&path).unwrap().hash);
}

#[test]
fn names_with_blanks_and_built_in_scenes_can_be_changed() {
    let (folder, _) = scene();
    let path = folder.path().join("c.toml").display().to_string();
    std::fs::write(
        &path,
        RIGHT
            .replace("white", "\"off. white\"")
            .replace("\"\"", "\""),
    )
    .unwrap();
    open(&path, &["materials.\"off. white\".albedo=[0,0,0]"]).unwrap();
    let cornell = open("cornell", &["render.spp=3"]).unwrap();
    assert_eq!(cornell.render.spp, Some(3));
    assert_ne!(cornell.hash, builtin::open("cornell").unwrap().hash);
}

#[test]
fn a_place_that_the_scene_lacks_is_named_with_what_it_has() {
    refuses(
        "materials.whyte.albedo=[1,1,1]",
        &[
            "--set materials.whyte.albedo=[1,1,1]: ",
            "a.toml",
            "did you mean \"white\"? There are: white",
        ],
    );
    refuses(
        "cameras.front.up=[0,1,0]",
        &["the scene has no cameras; it has: version, camera,"],
    );
    refuses(
        "materials.white.albdo=[1,1,1]",
        &[
            "--set materials.white.albdo=",
            "a.toml:",
            "unknown key \"albdo\"",
            "did you mean \"albedo\"?",
        ],
    );
    refuses("light.0.radiance=[1,1,1]", &["did you mean \"lights\"?"]);
    refuses(
        "lights.3.radiance=[1,1,1]",
        &["lights has no 3; write lights.0 (its only one)"],
    );
    refuses("lights.x.radiance=[1,1,1]", &["lights is a list", "\"x\""]);
    refuses("lights.0=1", &["lights.0 is a table", "quad, radiance"]);
    refuses(
        "lights.0.radiance.7=1",
        &["lights.0.radiance has no 7", "lights.0.radiance.0 to 2"],
    );
    refuses(
        "camera.vertical_fov.x=1",
        &["camera.vertical_fov is a single value"],
    );
}

#[test]
fn a_value_that_cannot_be_says_whose_it_is() {
    refuses(
        "camera.vertical_fov=200",
        &[
            "--set camera.vertical_fov=200: ",
            "a.toml:5:16: ",
            "below 180 degrees",
        ],
    );
    refuses("camera.vertical_fov=[1,", &["is no value of TOML"]);
    refuses("camera.vertical_fov", &["has no value", "KEY=VALUE"]);
    refuses("a b.c=1", &["is no key"]);
}

#[test]
fn a_scene_that_is_wrong_without_the_change_is_not_its_fault() {
    let (_folder, path) = scene();
    std::fs::write(
        &path,
        RIGHT.replace("vertical_fov = 50", "vertical_fov = 500"),
    )
    .unwrap();
    let message = open(&path, &["render.spp=4"]).unwrap_err().to_string();
    assert!(message.starts_with(&path), "{message}");
}

#[test]
fn a_whole_table_takes_the_place_of_another() {
    let (_folder, path) = scene();
    let changed = open(
        &path,
        &[
            r#"materials.white={ type = "glass", ior = 1.5 }"#,
            "camera.position=[1e-7, 2, 3]",
        ],
    )
    .unwrap();
    assert_eq!(changed.materials[0].material, Material::Glass { ior: 1.5 });
    let position = changed.cameras[0].camera.position;
    assert_eq!(position.to_array(), [1e-7, 2.0, 3.0]);
    let lens = write::camera(&changed.cameras[0].camera);
    let again = open(&path, &[&format!("camera={lens}")]).unwrap();
    assert_eq!(write::camera(&again.cameras[0].camera), lens);
}

#[test]
fn a_name_in_quotes_may_hold_any_character() {
    let (folder, _) = scene();
    let path = folder.path().join("d.toml").display().to_string();
    for name in [
        "a=b",
        "a.b",
        "",
        "ä",
        "\"'",
        "a\nb",
        "#\t\u{7f}",
        "a b",
        "b",
    ] {
        let key = toml::camera_key(&named(&path, name), name);
        let changed = open(&path, &[&format!("{key}.vertical_fov=20")]).unwrap();
        let found = changed.cameras.iter().find(|camera| camera.name == name);
        assert_eq!(found.unwrap().camera.vertical_fov, 20.0, "{key}");
        let key = toml::material_key(&changed, name).unwrap();
        let changed = open(&path, &[&format!("{key}.albedo=[0, 0, 0]")]).unwrap();
        assert_eq!(changed.materials[0].material.albedo(), Rgb::BLACK, "{key}");
    }
}

/// The right scene with a camera and a material of that name, written there.
fn named(path: &str, name: &str) -> Description {
    let key = toml_edit::Key::new(name);
    let text = RIGHT
        .replace("[camera]", &format!("[cameras.{key}]"))
        .replace("[materials.white]", &format!("[materials.{key}]"))
        .replace("\"white\"", &toml_edit::Value::from(name).to_string());
    std::fs::write(path, text).unwrap();
    builtin::open(path).unwrap()
}

#[test]
fn keys_are_those_that_the_scene_has() {
    let (folder, path) = scene();
    let lone = builtin::open(&path).unwrap();
    assert_eq!(toml::camera_key(&lone, "camera"), "camera");
    assert_eq!(
        toml::material_key(&lone, "white").unwrap(),
        "materials.white"
    );
    assert_eq!(toml::material_key(&lone, "black"), None);
    let path = folder.path().join("d.toml").display().to_string();
    let only = named(&path, "camera");
    assert_eq!(toml::camera_key(&only, "camera"), "cameras.camera");
    let blank = named(&path, "Camera 2");
    let key = toml::camera_key(&blank, "Camera 2");
    assert_eq!(key, "cameras.\"Camera 2\"");

    // What is in a mesh file is not the scene's to change.
    std::fs::write(
        folder.path().join("a.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    let text = format!("{RIGHT}[[objects]]\nmesh = {{ file = \"a.obj\" }}\n");
    let text = text.replace("white", "grey");
    std::fs::write(&path, &text).unwrap();
    let meshed = builtin::open(&path).unwrap();
    assert_eq!(meshed.materials[1].name, "white");
    assert_eq!(toml::material_key(&meshed, "white"), None);
    std::fs::write(&path, text.replace("grey", "white")).unwrap();
    let both = builtin::open(&path).unwrap();
    assert_eq!(both.materials[1].name, "white");
    let indices: Vec<usize> = toml::materials_named(&both, "white").collect();
    assert_eq!(indices, [0]);
    let changed = open(&path, &["materials.white.albedo=[0, 0, 0]"]).unwrap();
    assert_eq!(changed.materials[0].material.albedo(), Rgb::BLACK);
    assert_ne!(changed.materials[1].material.albedo(), Rgb::BLACK);
}

#[test]
fn a_texture_of_the_scene_stays_where_its_colour_is_changed() {
    let (folder, path) = scene();
    let image = image::RgbImage::from_pixel(1, 1, image::Rgb([9, 9, 9]));
    image.save(folder.path().join("a.png")).unwrap();
    let text = RIGHT.replace("[0.8, 0.8, 0.8]", "{ texture = \"a.png\" }");
    std::fs::write(&path, text).unwrap();
    let before = builtin::open(&path).unwrap();
    let grey = Material::Lambert {
        albedo: Rgb::new(0.5, 0.25, 0.1),
    };
    let mirror = Material::Mirror {
        reflectance: Rgb::WHITE,
    };
    let scale = "materials.white.albedo.scale=[0.5, 0.25, 0.1]";
    let table = r#"materials.white={ type = "mirror", reflectance = [1.0, 1.0, 1.0] }"#;
    for (material, change) in [(grey, scale), (mirror, table)] {
        let changes = write::material_changes(&before, "white", &material).unwrap();
        assert_eq!(changes, [change]);
        let after = open(&path, &[change]).unwrap();
        assert_eq!(after.materials[0].material, material);
        let kept = toml::maps_kept(&before, 0, material.kind());
        assert_eq!(after.materials[0].maps, kept);
    }
}
