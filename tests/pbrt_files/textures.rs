//! Textures: images, their mapping, and how they reach materials.

use super::*;
use glam::Vec2;
use ondine::scene::description::{Pixels, Wrap};

/// 2 × 2 pixels: red and green above, blue and white below.
fn png(pixels: [[u8; 4]; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&pixels.concat()).unwrap();
    writer.finish().unwrap();
    bytes
}

const COLORS: [[u8; 4]; 4] = [
    [255, 0, 0, 255],
    [0, 255, 0, 255],
    [0, 0, 255, 255],
    [255, 255, 255, 255],
];
const TRIANGLE: &str = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";

#[track_caller]
fn textured(scene: &str) -> Description {
    read_folder(&Folder::new(scene).with("t.png", png(COLORS)))
}

#[test]
fn an_image_multiplies_a_white_material() {
    let scene = textured(&format!(
        "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\" \"float scale\" .5 \"string wrap\" \"clamp\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\" {TRIANGLE} {TRIANGLE}"
    ));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let material = &scene.materials[0];
    assert_eq!(
        material.material,
        Material::Lambert {
            albedo: Rgb::splat(0.5)
        }
    );
    assert_eq!((material.maps.color, scene.textures.len()), (Some(0), 1));
    let texture = &scene.textures[0];
    assert_eq!(texture.wrap, [Wrap::Clamp; 2]);
    assert!(matches!(&texture.image.pixels, Pixels::Srgb8(pixels) if pixels == &COLORS));
    // pbrt's v goes up: (0, 0) is the lower left corner of the image.
    assert_eq!(texture.transform.transform_point2(Vec2::ZERO), Vec2::Y);
    assert_eq!(texture.transform.transform_point2(Vec2::ONE), Vec2::X);
    // The triangle has no UV of its own: pbrt's default.
    let uvs: Vec<[f32; 2]> = scene.meshes[0].uvs.iter().map(|uv| uv.to_array()).collect();
    assert_eq!(uvs, [[0., 0.], [1., 0.], [1., 1.]]);
}

#[test]
fn uv_are_scaled_and_shifted_before_they_are_turned() {
    let scene = textured(&format!(
        "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\" \"float uscale\" 2 \"float vscale\" 3 \"float udelta\" .1 \"float vdelta\" .2 \"string filter\" \"point\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\" {TRIANGLE}"
    ));
    let at = scene.textures[0]
        .transform
        .transform_point2(Vec2::new(0.3, 0.1));
    close(at.to_array(), [0.7, 1.0 - 0.5]);
    assert!(scene.textures[0].nearest);
}

#[test]
fn constants_scales_and_mixes_of_constants_are_numbers() {
    let scene = textured(&format!(
        "WorldBegin Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [.2 .4 .6]\n\
         Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"float scale\" .5\n\
         Texture \"c\" \"spectrum\" \"mix\" \"texture tex1\" \"b\" \"rgb tex2\" [1 1 1] \"float amount\" .25\n\
         Material \"diffuse\" \"texture reflectance\" \"c\" {TRIANGLE}"
    ));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let Material::Lambert { albedo } = scene.materials[0].material else {
        panic!("matte");
    };
    close(albedo.to_array(), [0.325, 0.4, 0.475]);
    assert!(scene.textures.is_empty());
}

#[test]
fn a_checkerboard_has_its_first_colour_at_the_origin() {
    let scene = textured(&format!(
        "WorldBegin Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 1 0] \"float uscale\" 4 \"float vscale\" 4\n\
         Material \"diffuse\" \"texture reflectance\" \"t\" {TRIANGLE}"
    ));
    let texture = &scene.textures[0];
    let Pixels::Float(pixels) = &texture.image.pixels else {
        panic!("floats");
    };
    for (u, v) in [
        (0.1, 0.1),
        (0.3, 0.1),
        (0.1, 0.3),
        (0.3, 0.3),
        (0.9, 0.4),
        (0.6, 0.6),
    ] {
        let at = texture
            .transform
            .transform_point2(Vec2::new(u, v))
            .rem_euclid(Vec2::ONE);
        let pixel = pixels[2 * (2.0 * at.y) as usize + (2.0 * at.x) as usize];
        let is_first = ((4.0 * u).floor() + (4.0 * v).floor()) % 2.0 == 0.0;
        assert_eq!(pixel[0] == 1.0, is_first, "({u}, {v})");
    }
}

#[test]
fn a_mask_cuts_out_by_its_brightness() {
    let scene = textured(&format!(
        "WorldBegin Texture \"m\" \"float\" \"imagemap\" \"string filename\" \"t.png\" \"string encoding\" \"linear\"\n\
         {TRIANGLE} {} {}",
        TRIANGLE.to_owned() + " \"texture alpha\" \"m\"",
        TRIANGLE.to_owned() + " \"float alpha\" 0",
    ));
    assert_eq!((scene.objects.len(), scene.materials.len()), (2, 2));
    assert!(scene.materials[0].maps.alpha.is_none());
    let alpha = scene.materials[1].maps.alpha.unwrap();
    assert_eq!(
        (alpha.texture, alpha.factor, alpha.cutoff),
        (Some(0), 1.0, 0.5)
    );
    let Pixels::Linear8(pixels) = &scene.textures[0].image.pixels else {
        panic!("bytes");
    };
    assert_eq!(
        pixels.iter().map(|pixel| pixel[3]).collect::<Vec<_>>(),
        [85, 85, 85, 255]
    );
}

#[test]
fn a_normal_map_is_data() {
    let scene = textured(&format!(
        "WorldBegin Material \"diffuse\" \"string normalmap\" \"t.png\" {TRIANGLE}"
    ));
    assert_eq!(scene.materials[0].maps.normal, Some((0, 1.0)));
    assert!(matches!(scene.textures[0].image.pixels, Pixels::Linear8(_)));
}

#[test]
fn an_image_of_roughness_is_its_mean() {
    let scene = textured(&format!(
        "WorldBegin Texture \"r\" \"float\" \"imagemap\" \"string filename\" \"t.png\" \"string encoding\" \"linear\"\n\
         Material \"conductor\" \"rgb reflectance\" [1 1 1] \"texture roughness\" \"r\" \"bool remaproughness\" false {TRIANGLE}"
    ));
    let Material::Conductor { roughness, .. } = scene.materials[0].material else {
        panic!("rough");
    };
    close([roughness], [0.5]);
    assert_eq!(
        scene.warnings,
        ["a.pbrt:2:1: an image for roughness is not supported; it is its mean"]
    );
}

#[test]
fn an_area_light_may_shine_by_an_image() {
    let scene = textured(&format!(
        "WorldBegin AreaLightSource \"diffuse\" \"string filename\" \"t.png\" \"float scale\" 3 {TRIANGLE}"
    ));
    assert_eq!(
        (scene.lights[0].texture, scene.lights[0].radiance.to_array()),
        (Some(0), [3.0; 3])
    );
}

#[test]
fn textured_spheres_and_patches_are_meshes_with_uv() {
    let scene = textured(
        "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\" Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
    );
    let [sphere, patch] = scene.meshes.as_slice() else {
        panic!("two meshes");
    };
    // At the bottom v = 0, on +x u = 0.
    for (position, uv) in sphere.positions.iter().zip(&sphere.uvs) {
        assert!((position.z + (std::f32::consts::PI * uv.y).cos()).abs() < 1e-5);
        assert!(
            (position.x
                - (1.0 - position.z.powi(2)).max(0.0).sqrt()
                    * (std::f32::consts::TAU * uv.x).cos())
            .abs()
                < 1e-3
        );
    }
    for (position, uv) in patch.positions.iter().zip(&patch.uvs) {
        assert_eq!(position.truncate(), *uv);
    }
}

#[test]
fn what_a_texture_cannot_do_is_told() {
    let scene = textured(
        "WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\" \"string wrap\" \"black\" \"bool invert\" true \"string mapping\" \"planar\"\n\
         Texture \"u\" \"float\" \"fbm\" \"integer octaves\" 3\nTexture \"v\" \"spectrum\" \"dots\"",
    );
    assert_eq!(
        scene.warnings,
        [
            "a.pbrt:2:1: the mapping \"planar\" is not supported; the shape's uv is used",
            "a.pbrt:2:1: wrap \"black\" is not supported; the border goes on",
            "a.pbrt:2:1: invert is not supported; the image is used as it is",
            "a.pbrt:3:1: the texture \"fbm\" is not supported; it is a grey of 0.5",
            "a.pbrt:4:1: the texture \"dots\" is not supported; what is outside the dots is everywhere",
        ]
    );
}
