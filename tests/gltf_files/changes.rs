//! Cameras and materials that are changed by key, as those of a .toml scene are.

use super::*;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::cache::Cache;
use ondine::scene::description::Maps;
use ondine::scene::toml::{self, Change, write};
use std::sync::Arc;

/// A file in a folder of its own.
struct Model(TempDir);

impl Model {
    fn of(asset: &Asset) -> Self {
        let folder = TempDir::new().expect("a folder");
        std::fs::write(folder.path().join("a.glb"), asset.binary()).expect("a file");
        Self(folder)
    }

    fn path(&self) -> String {
        self.0.path().join("a.glb").display().to_string()
    }

    /// Opened with changes; messages are without the folder's name.
    fn try_set(&self, changes: &[&str]) -> std::result::Result<Description, String> {
        let changes = changes.iter().map(|text| Change::parse(text).map(Arc::new));
        let opened = changes.collect::<Result<Vec<_>>>().and_then(|changes| {
            builtin::open_changed(&self.path(), &changes, &mut Cache::default())
        });
        let folder = format!("{}/", self.0.path().display());
        opened.map_err(|error| error.to_string().replace(&folder, ""))
    }

    #[track_caller]
    fn set(&self, changes: &[&str]) -> Description {
        self.try_set(changes)
            .unwrap_or_else(|message| panic!("{message}"))
    }

    #[track_caller]
    fn refuses(&self, changes: &[&str], message: &str) {
        match self.try_set(changes) {
            Ok(_) => panic!("changed without complaint"),
            Err(found) => assert_eq!(found, message),
        }
    }
}

/// A triangle, two cameras, and materials of which two have one name.
fn model() -> Model {
    let mut asset = Asset::triangle();
    let texture = asset.texture();
    asset.json["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }]);
    asset.node(json!({ "camera": 0, "name": "front", "translation": [0.1, 0.2, 3.3] }));
    asset.node(json!({ "camera": 0, "name": "Camera 2", "translation": [1e-7, -7.3, 1e7] }));
    let [bark, leaf] = ["Bark", "Leaf"].map(|name| {
        json!({
            "name": name, "alphaMode": "MASK", "alphaCutoff": 0.25,
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": texture }, "baseColorFactor": [0.1, 0.2, 0.3, 0.5],
                "metallicRoughnessTexture": { "index": texture }, "roughnessFactor": 0.7
            },
            "normalTexture": { "index": texture }
        })
    });
    let plain = json!({ "name": "Leaf", "pbrMetallicRoughness": { "roughnessFactor": 0.3 } });
    for material in [bark, leaf, plain] {
        let index = asset.push("materials", material);
        let mut primitive = asset.json["meshes"][0]["primitives"][0].clone();
        primitive["material"] = index.into();
        let mesh = asset.mesh(primitive);
        asset.node(json!({ "mesh": mesh }));
    }
    Model::of(&asset)
}

#[test]
fn a_camera_is_changed_by_its_name_and_the_rest_keeps_its_bits() {
    let model = model();
    let before = model.set(&[]);
    let after = model.set(&[
        "cameras.\"Camera 2\".look_at=[0, 1, 2]",
        "cameras.\"Camera 2\".aperture_radius = 0.02",
    ]);
    let (old, new) = (before.cameras[1].camera, after.cameras[1].camera);
    assert_eq!(new.look_at.to_array(), [0.0, 1.0, 2.0]);
    assert_eq!(new.aperture_radius, 0.02);
    assert_eq!(new.position, old.position);
    assert_eq!(new.up, old.up);
    assert_eq!(new.vertical_fov.to_bits(), old.vertical_fov.to_bits());
    assert_eq!(new.focus_distance, old.focus_distance);
    let first = |scene: &Description| write::camera(&scene.cameras[0].camera);
    assert_eq!(first(&after), first(&before));
    assert_ne!(after.hash, before.hash);
    let key = toml::camera_key(&before, "Camera 2");
    assert_eq!(key, "cameras.\"Camera 2\"");
    assert_eq!(toml::camera_key(&before, "front"), "cameras.front");
}

#[test]
fn what_is_set_to_what_it_is_changes_nothing() {
    let model = model();
    let before = model.set(&[]);
    let mut changes = Vec::new();
    for named in &before.cameras {
        let key = toml::camera_key(&before, &named.name);
        changes.push(format!("{key}={}", write::camera(&named.camera)));
    }
    let bark = &before.materials[1];
    let key = toml::material_key(&before, &bark.name).expect("a key");
    changes.push(format!("{key}={}", write::material(&bark.material)));
    let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
    let after = model.set(&changes);
    assert_eq!(after.hash, before.hash);
    let cameras = |scene: &Description| {
        let lenses = scene.cameras.iter().map(|named| named.camera);
        let bits = lenses.map(|lens| {
            let points = [lens.position, lens.look_at, lens.up].map(|point| point.to_array());
            let numbers = [lens.vertical_fov, lens.aperture_radius, lens.focus_distance];
            (
                points.map(|point| point.map(f32::to_bits)),
                numbers.map(f32::to_bits),
            )
        });
        bits.collect::<Vec<_>>()
    };
    assert_eq!(cameras(&after), cameras(&before));
    assert_eq!(after.materials[1].material, bark.material);
    assert_eq!(after.materials[1].maps, bark.maps);
}

#[test]
fn textures_stay_while_the_type_does_and_of_another_only_the_cut_out() {
    let model = model();
    let before = model.set(&[]);
    let maps = before.materials[1].maps;
    assert_eq!(maps.textures().count(), 4);
    let rough = model.set(&["materials.Bark.roughness=0.4"]);
    assert_eq!(rough.materials[1].maps, maps);
    let Material::Principled {
        base_color,
        roughness,
        ..
    } = rough.materials[1].material
    else {
        panic!("{:?}", rough.materials[1]);
    };
    assert_eq!((base_color, roughness), (Rgb::new(0.1, 0.2, 0.3), 0.4));

    let mirror =
        model.set(&[r#"materials.Bark={ type = "mirror", reflectance = [0.9, 0.9, 0.9] }"#]);
    assert_eq!(mirror.materials[1].name, "Bark");
    let cut_out = Maps {
        alpha: maps.alpha,
        ..Maps::default()
    };
    assert_eq!(mirror.materials[1].maps, cut_out);
    assert!(cut_out.alpha.is_some());

    // The cut-out stays one of the same texture and factor.
    let cut = model.set(&["materials.Bark.alpha_cutoff=0.75"]);
    let alpha = cut.materials[1].maps.alpha.expect("a cut-out");
    assert_eq!(
        (alpha.texture, alpha.factor, alpha.cutoff),
        (maps.color, 0.5, 0.75)
    );
    let hashes = [&before, &rough, &mirror, &cut].map(|scene| scene.hash.clone());
    for (index, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..index].contains(hash));
    }
}

#[test]
fn an_image_beside_the_file_may_be_named() {
    let model = model();
    let before = model.set(&[]);
    let write = |pixel: u8| {
        let image = image::RgbImage::from_pixel(1, 1, image::Rgb([pixel, 0, 0]));
        image.save(model.0.path().join("a.png")).expect("an image");
    };
    write(9);
    let change = |wrap: &str| {
        let color =
            format!("materials.Bark.base_color={{ texture = \"a.png\", wrap = \"{wrap}\" }}");
        model.set(&[&color])
    };
    let after = change("clamp");
    let color = after.materials[1].maps.color.expect("a texture");
    assert_eq!(color, before.textures.len());
    assert!(after.textures[color].image.file.ends_with("a.png"));
    assert_ne!(after.hash, change("repeat").hash);
    write(8);
    assert_ne!(after.hash, change("clamp").hash, "of the image too");
}

#[test]
fn materials_of_one_name_are_changed_together() {
    let model = model();
    let before = model.set(&[]);
    let indices: Vec<usize> = toml::materials_named(&before, "Leaf").collect();
    assert_eq!(indices, [2, 3]);
    let after = model.set(&["materials.Leaf.metallic=0.25"]);
    for index in indices {
        let (old, new) = (&before.materials[index], &after.materials[index]);
        let (
            Material::Principled { roughness: was, .. },
            Material::Principled {
                roughness,
                metallic,
                ..
            },
        ) = (old.material, new.material)
        else {
            panic!("{new:?}");
        };
        assert_eq!((roughness, metallic), (was, 0.25));
        assert_eq!(new.maps, old.maps);
    }
    assert_eq!(after.materials[1].material, before.materials[1].material);
}

#[test]
fn the_hash_is_of_what_is_other_than_before() {
    let model = model();
    let hash = |changes: &[&str]| model.set(changes).hash;
    let one = hash(&[
        "materials.Bark.roughness=0.5",
        "cameras.front.vertical_fov=30",
    ]);
    let other = hash(&[
        "cameras.front.vertical_fov=3e1",
        "materials.Bark.roughness=5e-1",
    ]);
    assert_eq!(one, other, "however it is said");
    assert_ne!(one, hash(&["materials.Bark.roughness=0.5"]));
    assert_ne!(
        hash(&["cameras.front.vertical_fov=30"]),
        hash(&["cameras.\"Camera 2\".vertical_fov=30"])
    );
}

#[test]
fn what_cannot_be_changed_is_told_with_what_can() {
    let model = model();
    model.refuses(
        &["camera.vertical_fov=20"],
        "--set camera.vertical_fov=20: a.glb: the scene has 2 cameras; name one of them, as in cameras.front: front, Camera 2",
    );
    model.refuses(
        &["cameras.frnt.vertical_fov=20"],
        "--set cameras.frnt.vertical_fov=20: a.glb: there is no \"frnt\" in cameras; did you mean \"front\"? There are: front, Camera 2",
    );
    model.refuses(
        &["cameras=1"],
        "--set cameras=1: a.glb: cameras is a table; change one of its keys: front, Camera 2",
    );
    model.refuses(
        &["materials.Wood.roughness=1"],
        "--set materials.Wood.roughness=1: a.glb: there is no \"Wood\" in materials; there are: default material, Bark, Leaf, Leaf",
    );
    model.refuses(
        &["cameras.front.fov=20", "materials.Bark.roughness=0.1"],
        "--set cameras.front.fov=20: a.glb: cameras.front: unknown key \"fov\" in [cameras.front]; did you mean \"vertical_fov\"? Known keys: position, look_at, up, vertical_fov, aperture_radius, focus_distance",
    );
    model.refuses(
        &["cameras.front.position.5=20"],
        "--set cameras.front.position.5=20: a.glb: cameras.front.position has no 5; write cameras.front.position.0 to 2",
    );
    model.refuses(
        &["materials.Bark.roughness=3"],
        "--set materials.Bark.roughness=3: a.glb: materials.Bark: roughness must be from 0 to 1, and this is 3",
    );
    model.refuses(
        &["materials.Bark=3"],
        "--set materials.Bark=3: a.glb: materials.Bark: Bark must be a table, as in [materials.Bark], and this is a whole number",
    );
    model.refuses(
        &["material.Bark.roughness=1"],
        "--set material.Bark.roughness=1: a.glb: \"material\" cannot be changed, for this is no .toml scene; its keys are camera, cameras.NAME and materials.NAME; did you mean \"materials\"?",
    );
}

#[test]
fn material_changes_make_the_material_they_are_asked_for() {
    let model = model();
    let before = model.set(&[]);
    let Material::Principled {
        base_color,
        metallic,
        ior,
        ..
    } = before.materials[1].material
    else {
        panic!("{:?}", before.materials[1]);
    };
    let rough = Material::Principled {
        base_color,
        metallic,
        roughness: 0.123,
        ior,
    };
    let glass = Material::Glass { ior: 1.3 };
    for (name, material, changes) in [
        ("Bark", rough, vec!["materials.Bark.roughness=0.123"]),
        ("Bark", before.materials[1].material, vec![]),
        (
            "Bark",
            glass,
            vec![r#"materials.Bark={ type = "glass", ior = 1.3 }"#],
        ),
        (
            "Leaf",
            glass,
            vec![r#"materials.Leaf={ type = "glass", ior = 1.3 }"#],
        ),
    ] {
        let found = write::material_changes(&before, name, &material);
        assert_eq!(found.expect("a material"), changes);
        let after = model.set(&changes);
        for index in toml::materials_named(&before, name) {
            assert_eq!(after.materials[index].material, material);
            let kept = toml::maps_kept(&before, index, material.kind());
            assert_eq!(after.materials[index].maps, kept);
        }
    }
    assert_eq!(write::material_changes(&before, "Wood", &glass), None);
}
