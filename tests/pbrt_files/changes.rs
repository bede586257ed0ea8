//! Cameras and materials of pbrt scenes, changed by key.

use super::*;
use ondine::scene::builtin;
use ondine::scene::cache::Cache;
use ondine::scene::toml::{self, Change, write};
use std::sync::Arc;

const SCENE: &str = r#"
LookAt 0.1 0.2 -3  0 0 0.3  0 1 0
Camera "perspective" "float fov" 37
WorldBegin
MakeNamedMaterial "Wood" "string type" "coateddiffuse" "rgb reflectance" [0.1 0.2 0.3]
NamedMaterial "Wood"
Shape "sphere"
Material "diffuse" "rgb reflectance" [0.4 0.4 0.4]
AreaLightSource "diffuse" "rgb L" [1 1 1]
Shape "disk"
"#;

fn set(folder: &Folder, changes: &[&str]) -> Result<Description, String> {
    let changes = changes.iter().map(|text| Change::parse(text).map(Arc::new));
    let changes: Vec<_> = changes.collect::<Result<_, _>>().unwrap();
    let path = folder.path("a.pbrt").display().to_string();
    builtin::open_changed(&path, &changes, &mut Cache::default())
        .map_err(|error| folder.plain(&error.to_string()))
}

#[test]
fn camera_and_materials_are_changed_and_the_rest_keeps_its_bits() {
    let folder = Folder::new(SCENE);
    let before = set(&folder, &[]).unwrap();
    let names: Vec<&str> = before
        .materials
        .iter()
        .map(|named| named.name.as_str())
        .collect();
    assert_eq!(names, ["Wood", "diffuse 2"]);
    let wood = toml::material_key(&before, "Wood").unwrap();
    let other = toml::material_key(&before, "diffuse 2").unwrap();
    assert_eq!(
        (wood.as_str(), other.as_str()),
        ("materials.Wood", "materials.\"diffuse 2\"")
    );
    let lens = write::camera(&before.cameras[0].camera);
    let same = set(&folder, &[&format!("camera={lens}")]).unwrap();
    assert_eq!(write::camera(&same.cameras[0].camera), lens);
    assert_eq!(same.hash, before.hash);

    let changes = [
        "camera.aperture_radius=0.02",
        "materials.Wood.roughness=0.4",
        &format!("{other}.albedo=[0, 0, 0]"),
    ];
    let after = set(&folder, &changes).unwrap();
    assert_eq!(after.cameras[0].camera.aperture_radius, 0.02);
    assert_eq!(
        after.cameras[0].camera.position,
        before.cameras[0].camera.position
    );
    let Material::Principled {
        base_color,
        roughness,
        ..
    } = after.materials[0].material
    else {
        panic!("{:?}", after.materials[0]);
    };
    assert_eq!(base_color, Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(roughness, 0.4);
    assert_eq!(after.materials[1].material.albedo(), Rgb::BLACK);
    assert_ne!(after.hash, before.hash);
}

#[test]
fn what_cannot_be_changed_is_told_with_what_can() {
    let folder = Folder::new(SCENE);
    for (change, message) in [
        (
            "render.spp=3",
            "--set render.spp=3: a.pbrt: \"render\" cannot be changed, for this is no .toml scene; its keys are camera, cameras.NAME and materials.NAME; write a .toml scene for the rest",
        ),
        (
            "materials.wood.ior=2",
            "--set materials.wood.ior=2: a.pbrt: there is no \"wood\" in materials; did you mean \"Wood\"? There are: Wood, diffuse 2",
        ),
        (
            "materials.Wood.type=mirror",
            "--set materials.Wood.type=mirror: a.pbrt: materials.Wood: unknown key \"base_color\" in a mirror material; the nearest known key is \"type\". Known keys: type, normal_map, alpha_cutoff, reflectance",
        ),
        (
            // This world is mirrored.
            "camera.look_at=[-0.1, 0.2, -3]",
            "--set camera.look_at=[-0.1, 0.2, -3]: a.pbrt: camera: look_at is the same point as position, so the camera looks nowhere; move either",
        ),
    ] {
        let changed = set(&folder, &[change]).map(|scene| scene.hash);
        assert_eq!(changed, Err(message.to_owned()));
    }
}
