//! Metallic-roughness materials, their textures, what emits and what transmits.

use super::*;
use glam::{Affine2, Vec2};
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::{Alpha, Image, Maps, NamedMaterial, Pixels, Wrap};
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

/// A triangle of this material.
fn of(material: Value) -> Asset {
    let mut asset = Asset::triangle();
    asset.material(material);
    asset
}

/// The only material.
#[track_caller]
fn only(scene: &Description) -> &NamedMaterial {
    assert_eq!(scene.materials.len(), 1);
    &scene.materials[0]
}

#[test]
fn factors_have_the_defaults_of_the_standard() {
    let plain = Asset::triangle().load();
    let material = Material::Principled {
        base_color: Rgb::WHITE,
        metallic: 1.0,
        roughness: 1.0,
        ior: 1.5,
    };
    assert_eq!(only(&plain).material, material);
    assert_eq!(only(&plain).name, "default material");
    let empty = of(json!({})).load();
    assert_eq!(only(&empty).material, material);
    assert_eq!(only(&empty).name, "material 0");
    assert_eq!(only(&empty).maps, Maps::default());
}

#[test]
fn factors_are_read() {
    let scene = of(json!({
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 1.0], "metallicFactor": 0.4, "roughnessFactor": 0.5
        },
        "extensions": { "KHR_materials_ior": { "ior": 1.25 } }
    }))
    .load();
    assert_eq!(only(&scene).name, "paint");
    assert_eq!(
        only(&scene).material,
        Material::Principled {
            base_color: Rgb::new(0.1, 0.2, 0.3),
            metallic: 0.4,
            roughness: 0.5,
            ior: 1.25
        }
    );
}

#[test]
fn factors_out_of_range_are_clamped_and_told() {
    let scene = of(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [2, -1, 0.5, 1] },
        "extensions": { "KHR_materials_ior": { "ior": 0 } }
    }))
    .load();
    assert_eq!(
        only(&scene).material,
        Material::Principled {
            base_color: Rgb::new(1.0, 0.0, 0.5),
            metallic: 1.0,
            roughness: 1.0,
            ior: 1.0
        }
    );
    assert_eq!(
        scene.warnings,
        [
            "a.gltf: materials[0]: an ior below 1 is taken as 1",
            "a.gltf: materials[0]: factors are clamped to [0, 1]"
        ]
    );
}

#[test]
fn textures_become_maps_of_their_colour_space() {
    let mut asset = Asset::triangle();
    let texture = asset.texture();
    asset.material(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": texture },
            "metallicRoughnessTexture": { "index": texture }
        },
        "normalTexture": { "index": texture, "scale": 0.5 }
    }));
    let scene = asset.load();
    // Roughness and normals share the linear image.
    assert_eq!(
        only(&scene).maps,
        Maps {
            color: Some(0),
            metallic_roughness: Some(1),
            normal: Some((1, 0.5)),
            alpha: None
        }
    );
    assert_eq!(scene.textures.len(), 2);
    let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 128]];
    let image: &Image = &scene.textures[0].image;
    assert_eq!((image.width, image.height), (2, 1));
    assert!(image.file.ends_with("a.gltf: images[0]"), "{}", image.file);
    assert!(matches!(&image.pixels, Pixels::Srgb8(found) if *found == pixels));
    let image: &Image = &scene.textures[1].image;
    assert!(matches!(&image.pixels, Pixels::Linear8(found) if *found == pixels));
}

#[test]
fn textures_of_one_image_share_its_pixels() {
    let mut asset = Asset::triangle();
    let first = asset.texture();
    asset.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]);
    let second = asset.push("textures", json!({ "source": 0, "sampler": 0 }));
    asset.material(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": first } },
        "emissiveTexture": { "index": second },
        "emissiveFactor": [1, 1, 1]
    }));
    let scene = asset.load();
    let [plain, sampled] = &scene.textures[..] else {
        panic!("{} textures", scene.textures.len());
    };
    assert!(Arc::ptr_eq(&plain.image, &sampled.image));
    assert_eq!((plain.wrap, plain.nearest), ([Wrap::Repeat; 2], false));
    assert_eq!(
        (sampled.wrap, sampled.nearest),
        ([Wrap::Clamp, Wrap::Mirror], true)
    );
}

#[test]
fn texture_transforms_scale_turn_and_move() {
    // The example of KHR_texture_transform: the lower left quarter of the image, turned by 90°.
    let quarter = json!({ "offset": [0, 1], "rotation": FRAC_PI_2, "scale": [0.5, 0.5] });
    for slot in ["baseColorTexture", "normalTexture"] {
        let mut asset = Asset::triangle();
        let info = json!({
            "index": asset.texture(),
            "extensions": { "KHR_texture_transform": quarter }
        });
        asset.material(match slot {
            "normalTexture" => json!({ "normalTexture": info }),
            _ => json!({ "pbrMetallicRoughness": { "baseColorTexture": info } }),
        });
        let scene = asset.load();
        let transform: Affine2 = scene.textures[0].transform;
        for (uv, expected) in [
            (Vec2::ZERO, Vec2::new(0.0, 1.0)),
            (Vec2::X, Vec2::new(0.0, 0.5)),
            (Vec2::Y, Vec2::new(0.5, 1.0)),
            (Vec2::ONE, Vec2::new(0.5, 0.5)),
        ] {
            let found = transform.transform_point2(uv);
            assert!(
                (found - expected).length() < 1e-6,
                "{slot} {uv}: {found} is not {expected}"
            );
        }
    }
}

#[test]
fn one_set_of_texture_coordinates_serves_a_material() {
    let mut asset = Asset::triangle();
    let uvs = asset.floats("VEC2", &[0.5, 0.5, 0.75, 0.5, 0.5, 0.75]);
    asset.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = uvs.into();
    let texture = asset.texture();
    asset.material(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {
                "index": texture,
                "extensions": { "KHR_texture_transform": { "texCoord": 1 } }
            },
            "metallicRoughnessTexture": { "index": texture, "texCoord": 1 }
        },
        "normalTexture": { "index": texture, "texCoord": 0 },
        "emissiveTexture": { "index": texture },
        "emissiveFactor": [1, 1, 1]
    }));
    let scene = asset.load();
    assert_eq!(only_mesh(&scene).uvs[1], Vec2::new(0.75, 0.5));
    let maps = only(&scene).maps;
    assert_eq!(
        (maps.color, maps.metallic_roughness, maps.normal),
        (Some(0), Some(1), None)
    );
    assert!(scene.lights.is_empty());
    assert_eq!(
        scene.warnings,
        [
            "a.gltf: materials[0] and 1 more: textures with another TEXCOORD than the material's first are left out, and so is light that they shape"
        ]
    );
}

#[test]
fn masks_are_cut_out_and_blends_too() {
    let mut asset = Asset::triangle();
    let texture = asset.texture();
    let pbr =
        json!({ "baseColorTexture": { "index": texture }, "baseColorFactor": [1, 1, 1, 0.75] });
    asset
        .material(json!({ "pbrMetallicRoughness": pbr, "alphaMode": "MASK", "alphaCutoff": 0.25 }));
    let scene = asset.load();
    let alpha = |cutoff| {
        Some(Alpha {
            texture: Some(0),
            factor: 0.75,
            cutoff,
        })
    };
    assert_eq!(only(&scene).maps.alpha, alpha(0.25));
    assert_eq!(only(&scene).maps.color, Some(0));
    assert_eq!(scene.warnings, [""; 0]);

    asset.json["materials"] = json!([{ "pbrMetallicRoughness": pbr, "alphaMode": "BLEND" }]);
    let scene = asset.load();
    assert_eq!(only(&scene).maps.alpha, alpha(0.5));
    assert_eq!(
        scene.warnings,
        ["a.gltf: materials[0]: alphaMode BLEND is rendered as a cut-out at alpha 0.5"]
    );

    let opaque = of(json!({ "alphaMode": "BLEND" })).load();
    assert_eq!(only(&opaque).maps.alpha, None);
    assert_eq!(opaque.warnings, [""; 0]);
}

#[test]
fn transmission_is_glass() {
    let glass = json!({ "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 0.9 },
        "KHR_materials_volume": { "thicknessFactor": 1.0, "attenuationColor": [0, 1, 0] },
        "KHR_materials_ior": { "ior": 1.33 }
    } });
    let scene = of(glass).load();
    assert_eq!(only(&scene).material, Material::Glass { ior: 1.33 });
    assert_eq!(
        scene.warnings,
        [
            "a.gltf: materials[0]: transmission is rendered as solid, smooth and clear glass, whatever its tint, roughness and thickness"
        ]
    );
    let little =
        json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.25 } } });
    let scene = of(little).load();
    assert!(matches!(only(&scene).material, Material::Principled { .. }));
    assert_eq!(
        scene.warnings,
        ["a.gltf: materials[0]: transmission below 0.5 is left out"]
    );
}

#[test]
fn what_emits_is_a_light_that_scatters() {
    let mut asset = Asset::triangle();
    let texture = asset.texture();
    asset.material(json!({
        "emissiveFactor": [1.0, 0.5, 0.25],
        "emissiveTexture": { "index": texture },
        "doubleSided": true,
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } }
    }));
    asset.node(json!({ "mesh": 0, "translation": [1, 0, 0] }));
    let scene = asset.load();
    assert!(scene.objects.is_empty());
    assert_eq!(scene.lights.len(), 2);
    for light in &scene.lights {
        assert_eq!(instance(light.shape).0, 0);
        assert_eq!(light.radiance, Rgb::new(8.0, 4.0, 2.0));
        assert!(light.two_sided);
        assert_eq!((light.material, light.texture), (Some(0), Some(0)));
    }
    let one_sided = of(json!({ "emissiveFactor": [0, 0, 1] })).load();
    assert!(!one_sided.lights[0].two_sided);
    assert_eq!(one_sided.lights[0].texture, None);
}
