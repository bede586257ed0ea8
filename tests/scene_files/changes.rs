//! Values of a scene file that are changed before it is read.

use super::RIGHT;
use ondine::error::Error;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::builtin;
use ondine::scene::cache::Cache;
use ondine::scene::description::Description;
use ondine::scene::toml::Change;
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
fn only_toml_can_be_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj").display().to_string();
    std::fs::write(&path, "").unwrap();
    let message = open(&path, &["camera.vertical_fov=20"])
        .unwrap_err()
        .to_string();
    assert!(message.contains("is no .toml scene"), "{message}");
    assert!(message.contains("mesh = { file = "), "{message}");
}
