//! Cameras and materials of files that have none of TOML, changed by key.

use ondine::error::Result;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::builtin;
use ondine::scene::cache::Cache;
use ondine::scene::description::Description;
use ondine::scene::toml::{self, Change, write};
use std::sync::Arc;
use tempfile::TempDir;

const OBJ: &str = "mtllib a.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 2 3
usemtl dark wood
f 1 2 4
usemtl missing
f 1 3 4
usemtl lamp
f 2 3 4
";

const MTL: &str = "newmtl dark wood
Kd 0.1 0.2 0.3
newmtl lamp
Kd 0.5 0.5 0.5
Ke 4 3 2
";

const PLY: &str = "ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("a.obj", OBJ), ("a.mtl", MTL), ("a.ply", PLY)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn open(folder: &TempDir, name: &str, changes: &[&str], cache: &mut Cache) -> Result<Description> {
    let path = folder.path().join(name).display().to_string();
    let changes = changes.iter().map(|text| Change::parse(text).map(Arc::new));
    builtin::open_changed(&path, &changes.collect::<Result<Vec<_>>>()?, cache)
}

#[test]
fn the_camera_that_a_file_was_given_is_changed_like_its_own() {
    let folder = folder();
    for name in ["a.ply", "a.obj"] {
        let set = |changes: &[&str]| open(&folder, name, changes, &mut Cache::default()).unwrap();
        let before = set(&[]);
        assert_eq!(toml::camera_key(&before, "camera"), "camera");
        let after = set(&["camera.vertical_fov=20"]);
        let camera = after.cameras[0].camera;
        assert_eq!(camera.vertical_fov, 20.0);
        assert_eq!(camera.position, before.cameras[0].camera.position);
        assert_ne!(after.hash, before.hash);
        assert_eq!(set(&["cameras.camera.vertical_fov=20"]).hash, after.hash);
        let lens = write::camera(&before.cameras[0].camera);
        let same = set(&[&format!("camera={lens}")]);
        assert_eq!(write::camera(&same.cameras[0].camera), lens);
        assert_eq!(same.hash, before.hash);
    }
}

#[test]
fn materials_are_changed_by_their_names_and_lamps_go_on_shining() {
    let folder = folder();
    let mut cache = Cache::default();
    let before = open(&folder, "a.obj", &[], &mut cache).unwrap();
    let names: Vec<&str> = before
        .materials
        .iter()
        .map(|named| named.name.as_str())
        .collect();
    assert_eq!(names, ["white", "dark wood", "white", "lamp"]);
    let changes = [
        "materials.\"dark wood\".albedo.0=0.9",
        r#"materials.lamp={ type = "glass", ior = 1.5 }"#,
        "materials.white.albedo=[0, 0, 0]",
    ];
    let after = open(&folder, "a.obj", &changes, &mut cache).unwrap();
    let glass = Material::Glass { ior: 1.5 };
    let albedos: Vec<Rgb> = after.materials[..3]
        .iter()
        .map(|named| named.material.albedo())
        .collect();
    assert_eq!(albedos, [Rgb::BLACK, Rgb::new(0.9, 0.2, 0.3), Rgb::BLACK]);
    assert_eq!(after.materials[3].material, glass);
    assert_eq!(after.lights[0].material, Some(3));
    assert_eq!(after.lights[0].radiance, before.lights[0].radiance);
}

#[test]
fn scenes_of_one_file_share_its_meshes() {
    let folder = folder();
    let mut cache = Cache::default();
    let mut set = |change: &str| open(&folder, "a.ply", &[change], &mut cache).unwrap();
    let (one, other) = (set("camera.vertical_fov=20"), set("camera.vertical_fov=30"));
    assert!(Arc::ptr_eq(&one.meshes[0], &other.meshes[0]));
}

#[test]
fn the_rest_is_for_a_scene_file_that_names_the_mesh() {
    let folder = folder();
    for change in [
        "film.width=3",
        "environment.constant=[1,1,1]",
        "lights.0.radiance=[1,1,1]",
    ] {
        let error = open(&folder, "a.obj", &[change], &mut Cache::default()).unwrap_err();
        let message = error.to_string();
        for words in [
            format!("--set {change}: ").as_str(),
            "a.obj: ",
            "cannot be changed, for this is no .toml scene; its keys are camera, cameras.NAME and materials.NAME",
            "write a .toml scene with [[objects]] and mesh = { file = \"",
        ] {
            assert!(message.contains(words), "{message}\nlacks {words}");
        }
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}
