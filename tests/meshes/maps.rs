//! What textures do to a surface.

use crate::bits::{checkers, material};
use crate::common::assert_close;
use crate::render::*;
use crate::{add, empty, sheet};
use glam::{Affine2, Affine3A, Quat, Vec2, Vec3};
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::{
    Description, Environment, Image, Maps, Object, Pixels, Punctual, Shape, Texture, Wrap,
};
use std::f64::consts::PI;
use std::sync::Arc;

/// Straight down on the middle.
const CAMERA: &str = "position = [0.0, 2.0, 0.0]\nlook_at = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, -1.0]\nvertical_fov = 0.1";

const WHITE: Material = Material::Lambert { albedo: Rgb::WHITE };

/// One texel.
pub fn plain(texel: [f32; 4]) -> Texture {
    Texture {
        image: Arc::new(Image {
            file: "plain".into(),
            width: 1,
            height: 1,
            pixels: Pixels::Float(vec![texel]),
        }),
        wrap: [Wrap::Repeat; 2],
        nearest: false,
        transform: Affine2::IDENTITY,
    }
}

/// A sheet on the floor, u to the right (+x), v away from the viewer's down: towards −z.
fn floor(description: &mut Description, place: Affine3A, material: usize) {
    let mesh = sheet(Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::Z * -4.0, 3);
    add(description, &mesh, place, material);
}

fn red(description: &Description) -> f64 {
    let mut settings = settings(description, (8, 8), 16);
    settings.path_length = 2;
    mean_and_error(&film(description, &settings)).0[0]
}

fn sun(description: &mut Description, direction: Vec3) {
    description.punctual.push(Punctual::Distant {
        direction: direction.normalize(),
        irradiance: Rgb::WHITE,
    });
}

#[test]
fn a_normal_map_turns_normals_as_its_image_shows_them() {
    // x of the map along +u, y up in the image, which is towards −v.
    for (local, transform) in [
        (Vec3::Z, Affine2::IDENTITY),
        (Vec3::new(0.6, 0.0, 0.8), Affine2::IDENTITY),
        (Vec3::new(0.0, 0.6, 0.8), Affine2::IDENTITY),
        (Vec3::new(0.48, -0.36, 0.8), Affine2::IDENTITY),
        (Vec3::new(0.48, -0.36, 0.8), Affine2::from_angle(0.5)),
        (
            Vec3::new(0.48, -0.36, 0.8),
            Affine2::from_scale(Vec2::new(1.0, -2.0)),
        ),
    ] {
        for place in [
            Affine3A::IDENTITY,
            Affine3A::from_rotation_y(0.8),
            Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
        ] {
            let mut description = empty(CAMERA);
            let c = (local + Vec3::ONE) * 0.5;
            description.textures = vec![Texture {
                transform,
                ..plain([c.x, c.y, c.z, 1.0])
            }];
            let maps = Maps {
                normal: Some((0, 1.0)),
                ..Maps::default()
            };
            let mapped = material(&mut description, WHITE, maps);
            floor(&mut description, place, mapped);
            let light = Vec3::new(-0.3, -1.0, 0.2).normalize();
            sun(&mut description, light);

            // Directions of the image's s and t on the floor: rows of the inverse of uv -> st are du/ds and so on.
            let (u, v) = (
                place.transform_vector3(Vec3::X),
                place.transform_vector3(-Vec3::Z),
            );
            let inverse = transform.matrix2.inverse();
            let s = (u * inverse.x_axis.x + v * inverse.x_axis.y).normalize();
            let t = (u * inverse.y_axis.x + v * inverse.y_axis.y).normalize();
            let normal = s * local.x - t * local.y + Vec3::Y * local.z;
            let want = f64::from(-normal.dot(light)).max(0.0) / PI;
            assert_close(
                red(&description),
                want,
                1e-4,
                0.0,
                &format!("{local}, {transform:?}"),
            );
        }
    }
}

#[test]
fn colour_maps_paint_meshes_quads_and_the_albedo_layer() {
    let texels = [[255, 200, 90], [90, 140, 255]];
    let colors = texels.map(|texel| Rgb::from(texel.map(|c| c as f32 / 255.0)));
    let camera = "position = [0.3, 2.0, 2.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 40.0";
    let (corner, u, v) = (Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Z * -2.0);
    let painted = |with: &dyn Fn(&mut Description, usize)| {
        let mut description = empty(camera);
        description.environment = Some(Environment::Constant(Rgb::WHITE));
        description.textures = vec![checkers(2.0)];
        let maps = Maps {
            color: Some(0),
            ..Maps::default()
        };
        let painted = material(&mut description, WHITE, maps);
        with(&mut description, painted);
        description
    };
    let on_mesh = painted(&|description, painted| {
        add(
            description,
            &sheet(corner, u, v, 3),
            Affine3A::IDENTITY,
            painted,
        );
    });
    let on_quad = painted(&|description, painted| {
        let shape = Shape::Quad { corner, u, v };
        description.objects.push(Object {
            shape,
            material: painted,
        });
    });
    let mut cells = empty(camera);
    cells.environment = Some(Environment::Constant(Rgb::WHITE));
    let ids =
        colors.map(|albedo| material(&mut cells, Material::Lambert { albedo }, Maps::default()));
    for i in 0..16 {
        let (x, y) = (i % 4, i / 4);
        let corner = corner + u * (x as f32 / 4.0) + v * (y as f32 / 4.0);
        let cell = sheet(corner, u / 4.0, v / 4.0, 1);
        let id = ids[((x + y) % 2) as usize];
        add(&mut cells, &cell, Affine3A::IDENTITY, id);
    }
    let [mesh, quad, cells] = [on_mesh, on_quad, cells].map(|description| {
        let mut settings = settings(&description, (24, 24), 16);
        settings.aovs = "albedo".parse().expect("a layer");
        film(&description, &settings)
    });
    for (what, painted) in [("mesh", &mesh), ("quad", &quad)] {
        let (a, b) = (mean_and_error(painted), mean_and_error(&cells));
        for c in 0..3 {
            assert_close(a.0[c], b.0[c], 1e-3, 0.0, what);
        }
        for y in 0..24 {
            for x in 0..24 {
                let [a, b] = [painted, &cells].map(|film| film.aov(x, y).albedo);
                for (a, b) in a.iter().zip(&b) {
                    // Samples on the border of two cells may fall on either side.
                    assert!((a - b).abs() < 0.1, "{what} at ({x}, {y}): {a} is not {b}");
                }
            }
        }
    }
}

#[test]
fn metallic_and_roughness_multiply_what_the_material_says() {
    let principled = |metallic, roughness| Material::Principled {
        base_color: Rgb::new(0.9, 0.6, 0.3),
        metallic,
        roughness,
        ior: 1.5,
    };
    let seen = |material_of: Material, textured: bool| {
        let mut description = empty(CAMERA);
        description.textures = vec![plain([0.0, 0.5, 0.25, 1.0])];
        let maps = Maps {
            metallic_roughness: textured.then_some(0),
            ..Maps::default()
        };
        let id = material(&mut description, material_of, maps);
        let tilted = Affine3A::from_quat(Quat::from_rotation_x(0.2));
        floor(&mut description, tilted, id);
        sun(&mut description, Vec3::new(0.1, -1.0, 0.1));
        red(&description)
    };
    let want = seen(principled(0.2, 0.4), false);
    assert_close(seen(principled(0.8, 0.8), true), want, 1e-5, 0.0, "mapped");
    assert!((seen(principled(0.8, 0.8), false) - want).abs() > 0.05 * want);
}
