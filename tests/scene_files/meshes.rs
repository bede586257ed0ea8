//! Mesh files and textures that a scene names.

use super::*;
use glam::{Affine3A, Vec2, Vec3};
use ondine::scene::description::{Pixels, Wrap};
use std::fs;
use tempfile::TempDir;

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 1\n";

/// A folder with a mesh of each kind and a picture.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("a.ply", TRIANGLE.as_bytes());
    write(
        "a.obj",
        b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl glow\nf 3 2 1\n",
    );
    write("a.mtl", b"newmtl red\nKd 1 0 0\nnewmtl glow\nKe 3 2 1\n");
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 0, 0, 128]));
    picture.save(folder.path().join("wood.png")).unwrap();
    folder
}

fn read_in(folder: &TempDir, text: &str) -> Result<Description, Error> {
    toml::parse(text, "a.toml", Some(folder.path()))
}

fn with_object(folder: &TempDir, object: &str) -> Result<Description, Error> {
    let text = RIGHT.replacen(
        "sphere = { center = [0, 0, 0], radius = 1 }\nmaterial = \"white\"",
        object,
        1,
    );
    read_in(folder, &text)
}

fn with_albedo(folder: &TempDir, albedo: &str) -> Result<Description, Error> {
    read_in(
        folder,
        &RIGHT.replacen("albedo = [0.8, 0.8, 0.8]", albedo, 1),
    )
}

#[test]
fn a_mesh_is_read_once_and_put_where_the_scene_says() {
    let folder = folder();
    let scene = with_object(
        &folder,
        "mesh = { file = \"a.ply\" }\nmaterial = \"white\"\n[[objects]]\nmesh = { file = \"a.ply\" }\ntransform = { translate = [0, 0, 1] }",
    )
    .unwrap();
    assert_eq!((scene.meshes.len(), scene.objects.len()), (1, 2));
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].ends_with("a.ply: 1 triangle without an area left out"));
    let expected = Affine3A::from_translation(Vec3::Z);
    let moved = Shape::Mesh {
        mesh: 0,
        transform: expected,
    };
    assert_eq!(scene.objects[1].shape, moved);
    assert_eq!(scene.materials[scene.objects[0].material].name, "white");
}

#[test]
fn an_obj_brings_its_materials_and_lights_unless_the_scene_says_otherwise() {
    let folder = folder();
    let scene = with_object(&folder, "mesh = { file = \"a.obj\" }").unwrap();
    let red = &scene.materials[scene.objects[0].material];
    assert_eq!(
        red.material,
        Material::Lambert {
            albedo: Rgb::new(1.0, 0.0, 0.0)
        }
    );
    assert_eq!((scene.objects.len(), scene.lights.len()), (1, 2));
    assert_eq!(scene.lights[0].radiance, Rgb::new(3.0, 2.0, 1.0));

    let scene = with_object(&folder, "mesh = { file = \"a.obj\" }\nmaterial = \"white\"").unwrap();
    assert_eq!((scene.objects.len(), scene.lights.len()), (2, 1));
    assert!(scene.objects.iter().all(|object| object.material == 0));

    let lamp = "quad = { corner = [-1, 3, -1], u = [2, 0, 0], v = [0, 0, 2] }";
    let scene = read_in(
        &folder,
        &RIGHT.replacen(lamp, "mesh = { file = \"a.obj\" }", 1),
    )
    .unwrap();
    assert_eq!(scene.lights.len(), 2);
    assert!(
        scene
            .lights
            .iter()
            .all(|light| light.radiance == Rgb::new(5.0, 5.0, 5.0))
    );
}

#[test]
fn the_hash_of_a_scene_is_that_of_its_meshes_and_textures_too() {
    let folder = folder();
    for (file, object) in [
        ("a.ply", "mesh = { file = \"a.ply\" }"),
        ("a.obj", "mesh = { file = \"a.obj\" }"),
        ("a.mtl", "mesh = { file = \"a.obj\" }"),
    ] {
        let before = with_object(&folder, object).unwrap().hash;
        assert_eq!(with_object(&folder, object).unwrap().hash, before);
        let path = folder.path().join(file);
        let bytes = fs::read_to_string(&path).unwrap().replacen('1', "1.5", 2);
        let bytes = if file == "a.ply" {
            TRIANGLE.replace("1 0 0", "2 0 0")
        } else {
            bytes
        };
        fs::write(&path, bytes.replace("f 1.5", "f 1")).unwrap();
        assert_ne!(with_object(&folder, object).unwrap().hash, before, "{file}");
    }
    let albedo = "albedo = { texture = \"wood.png\" }";
    let before = with_albedo(&folder, albedo).unwrap().hash;
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([254, 0, 0, 128]));
    picture.save(folder.path().join("wood.png")).unwrap();
    assert_ne!(with_albedo(&folder, albedo).unwrap().hash, before);
}

#[test]
fn a_mesh_that_cannot_be_read_is_refused_at_its_name() {
    let folder = folder();
    for (object, words) in [
        ("mesh = { file = \"b.ply\" }", "cannot read"),
        (
            "mesh = { file = \"a.toml\" }",
            "name a .ply, .obj, .gltf or .glb file",
        ),
        ("mesh = { file = \"\" }", "file is empty"),
    ] {
        let message = with_object(&folder, object).unwrap_err().to_string();
        assert!(message.starts_with("a.toml:10:17: "), "{message}");
        assert!(message.contains(words), "{message}");
    }
    let far = "mesh = { file = \"a.ply\" }\ntransform = { scale = 1e9, translate = [1e9, 0, 0] }";
    let message = with_object(&folder, far).unwrap_err().to_string();
    assert!(message.starts_with("a.toml:11:13: "), "{message}");
}

#[test]
fn a_colour_may_be_a_texture() {
    let folder = folder();
    let scene = with_albedo(
        &folder,
        "albedo = { texture = \"wood.png\", scale = [0.5, 1, 1], wrap = \"mirror\", filter = \"nearest\", repeat = [2, 4] }\n\
        normal_map = { texture = \"wood.png\", strength = 0.5 }\nalpha_cutoff = 0.25",
    )
    .unwrap();
    let white = &scene.materials[0];
    assert_eq!(
        white.material,
        Material::Lambert {
            albedo: Rgb::new(0.5, 1.0, 1.0)
        }
    );
    let texture = &scene.textures[white.maps.color.unwrap()];
    assert!(matches!(&texture.image.pixels, Pixels::Srgb8(texels) if texels.len() == 4));
    assert_eq!((texture.wrap, texture.nearest), ([Wrap::Mirror; 2], true));
    // v counts upwards, rows downwards.
    let at = texture.transform.transform_point2(Vec2::new(0.25, 0.125));
    assert_eq!(at, Vec2::new(0.5, 0.5));
    let (normal, strength) = white.maps.normal.unwrap();
    assert!(matches!(
        scene.textures[normal].image.pixels,
        Pixels::Linear8(_)
    ));
    assert_eq!(strength, 0.5);
    let alpha = white.maps.alpha.unwrap();
    assert_eq!(
        (alpha.texture, alpha.factor, alpha.cutoff),
        (white.maps.color, 1.0, 0.25)
    );
}

#[test]
fn a_texture_that_cannot_be_is_refused() {
    let folder = folder();
    for (albedo, place, words) in [
        ("albedo = { texture = \"b.png\" }", "8:22", "cannot read"),
        (
            "albedo = { texture = \"a.ply\" }",
            "8:22",
            "is not an image that is read",
        ),
        (
            "albedo = { file = \"wood.png\" }",
            "8:12",
            "unknown key \"file\"",
        ),
        (
            "albedo = { texture = \"wood.png\", wrap = \"miror\" }",
            "8:41",
            "did you mean \"mirror\"?",
        ),
        (
            "albedo = { texture = \"wood.png\", filter = \"linear\" }",
            "8:43",
            "\"bilinear\" or \"nearest\"",
        ),
        (
            "albedo = { texture = \"wood.png\", repeat = [1] }",
            "8:43",
            "must have 2 numbers",
        ),
        (
            "albedo = { texture = \"wood.png\", scale = [2, 1, 1] }",
            "8:43",
            "no more light than it gets",
        ),
        (
            "albedo = [1, 1, 1]\nalpha_cutoff = 0.5",
            "9:1",
            "this colour has none",
        ),
    ] {
        let message = with_albedo(&folder, albedo).unwrap_err().to_string();
        assert!(
            message.starts_with(&format!("a.toml:{place}: ")),
            "{message}"
        );
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn a_principled_material_has_defaults_where_gltf_has() {
    let folder = folder();
    let principled = |rest: &str| {
        let text = RIGHT.replacen(
            "\"lambert\"\nalbedo = [0.8, 0.8, 0.8]",
            &format!("\"principled\"\n{rest}"),
            1,
        );
        read_in(&folder, &text)
    };
    let scene = principled("base_color = [1, 0, 0]\nmetallic = 1\nroughness = 0.25").unwrap();
    let Material::Principled {
        metallic,
        roughness,
        ior,
        ..
    } = scene.materials[0].material
    else {
        panic!("{:?}", scene.materials[0]);
    };
    assert_eq!((metallic, roughness, ior), (1.0, 0.25, 1.5));
    let textured = "base_color = [1, 0, 0]\nmetallic_roughness = { texture = \"wood.png\" }";
    let scene = principled(textured).unwrap();
    assert!(scene.materials[0].maps.metallic_roughness.is_some());
    let missing = principled("base_color = [1, 0, 0]\nmetallic = 1")
        .unwrap_err()
        .to_string();
    assert!(missing.contains("has no roughness; add"), "{missing}");
}

#[test]
fn no_damage_to_a_scene_of_meshes_and_textures_makes_its_reader_panic() {
    let folder = folder();
    let text = RIGHT
        .replacen("albedo = [0.8, 0.8, 0.8]", "albedo = { texture = \"wood.png\", repeat = [2, 2] }\nalpha_cutoff = 0.5", 1)
        .replacen(
            "sphere = { center = [0, 0, 0], radius = 1 }",
            "mesh = { file = \"a.obj\" }\ntransform = { translate = [0, 0, 1], rotate_degrees = [1, 2, 3], scale = [1, -2, 1] }",
            1,
        )
        + "[[lights]]\nspot = { position = [0, 3, 0], direction = [0, -1, 0], intensity = [1, 1, 1], outer_degrees = 20 }\n";
    read_in(&folder, &text).unwrap();
    let mut random = Pcg32::new(5, 7);
    let mut refused = 0;
    for _ in 0..2000 {
        let bytes = mutated(text.as_bytes(), &mut random);
        if let Err(error) = read_in(&folder, &String::from_utf8_lossy(&bytes)) {
            assert!(error.to_string().starts_with("a.toml:"), "{error}");
            refused += 1;
        }
    }
    assert!(refused > 500, "{refused} refused");
}
