//! Light from triangles and from nowhere, on a plane: against quads and closed forms.

use crate::common::assert_close;
use crate::maps::plain;
use crate::render::*;
use crate::{add, add_light, empty, sheet};
use glam::{Affine3A, Vec3};
use ondine::film::Film;
use ondine::lanes::Rgb;
use ondine::scene::description::{
    Alpha, Description, Light, Maps, NamedMaterial, Object, Punctual, Shape, Strategy,
};
use std::f64::consts::PI;

/// Straight down on the floor's middle, within a millimetre.
const CAMERA: &str = "position = [0.0, 1.0, 0.0]\nlook_at = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, -1.0]\nvertical_fov = 0.1";

/// A floor of albedo a half, facing up, at y = 0.
fn floor() -> Description {
    let mut description = empty(CAMERA);
    description.objects.push(Object {
        shape: Shape::Quad {
            corner: Vec3::new(-20.0, 0.0, 20.0),
            u: Vec3::X * 40.0,
            v: Vec3::Z * -40.0,
        },
        material: 0,
    });
    description
}

/// The radiance seen, red.
fn seen(description: &Description, strategy: Strategy) -> (f64, f64, Film) {
    let mut settings = settings(description, (16, 16), 64);
    settings.strategy = strategy;
    settings.path_length = 2;
    let film = film(description, &settings);
    let (mean, error) = mean_and_error(&film);
    (mean[0], error[0], film)
}

/// Radiance of the floor under an irradiance.
fn reflected(irradiance: f64) -> f64 {
    0.5 / PI * irradiance
}

#[test]
fn points_spots_and_the_sun_light_a_plane_as_their_closed_forms_say() {
    let at = Vec3::new(0.6, 1.5, -0.8);
    let squared = f64::from(at.length_squared());
    let cosine = f64::from(at.y) / squared.sqrt();
    let intensity = Rgb::new(3.0, 2.0, 1.0);
    let spot = |axis: Vec3, cos_inner: f32, cos_outer: f32| Punctual::Spot {
        position: at,
        direction: axis.normalize(),
        intensity,
        cos_inner,
        cos_outer,
    };
    // The angle between the axis and the way to the floor's middle.
    let axis = Vec3::new(-0.2, -1.0, 0.3);
    let off = f64::from(axis.normalize().dot(-at.normalize()));
    let ramp = (off - 0.8) / (0.99 - 0.8);
    let sun = Vec3::new(1.0, -2.0, 0.5).normalize();
    for (light, irradiance) in [
        (
            Punctual::Point {
                position: at,
                intensity,
            },
            3.0 * cosine / squared,
        ),
        (spot(-at, 0.9, 0.8), 3.0 * cosine / squared),
        (spot(axis, 0.99, 0.8), 3.0 * cosine / squared * ramp * ramp),
        (spot(axis, 0.999, 0.998), 0.0),
        (
            Punctual::Distant {
                direction: sun,
                irradiance: Rgb::splat(2.0),
            },
            2.0 * f64::from(-sun.y),
        ),
    ] {
        let mut description = floor();
        description.punctual.push(light);
        for strategy in STRATEGIES {
            let (got, _, _) = seen(&description, strategy);
            assert_close(
                got,
                reflected(irradiance),
                2e-3,
                0.0,
                &format!("{light:?}, {strategy}"),
            );
        }
    }
}

#[test]
fn many_lights_without_a_surface_add_up_whoever_samples_them() {
    let mut description = floor();
    let mut irradiance = 0.0;
    for i in 1..6 {
        let position = Vec3::new(0.0, i as f32, 0.0);
        description.punctual.push(Punctual::Point {
            position,
            intensity: Rgb::splat(1.0),
        });
        irradiance += 1.0 / f64::from(i * i);
    }
    for strategy in STRATEGIES {
        let (got, error, _) = seen(&description, strategy);
        assert_close(
            got,
            reflected(irradiance),
            0.0,
            4.0 * error,
            &format!("{strategy}"),
        );
    }
}

#[test]
fn what_stands_in_the_way_of_a_lamp_shades_it_even_the_only_light_there_is() {
    let mut description = floor();
    description.punctual.push(Punctual::Point {
        position: Vec3::new(0.0, 3.0, 0.0),
        intensity: Rgb::splat(1.0),
    });
    description.lights.push(Light {
        shape: Shape::Sphere {
            center: Vec3::new(0.0, 2.0, 0.0),
            radius: 0.2,
        },
        radiance: Rgb::BLACK,
        two_sided: false,
        material: None,
        texture: None,
    });
    assert_eq!(seen(&description, Strategy::Mis).0, 0.0);
    // A wall outside of which the lamp is.
    let mut description = floor();
    description.punctual.push(Punctual::Distant {
        direction: Vec3::Y,
        irradiance: Rgb::splat(1.0),
    });
    description.punctual.push(Punctual::Point {
        position: Vec3::new(0.0, -1.0, 0.0),
        intensity: Rgb::splat(1.0),
    });
    assert_eq!(seen(&description, Strategy::Mis).0, 0.0);
}

#[test]
fn a_lamp_with_holes_is_shaded_by_instances_whose_triangles_have_its_numbers() {
    let lit = |blocked: bool| {
        let mut description = floor();
        let material = NamedMaterial {
            name: "leaf".into(),
            material: description.materials[0].material,
            maps: Maps {
                alpha: Some(Alpha {
                    texture: Some(0),
                    factor: 1.0,
                    cutoff: 0.5,
                }),
                ..Maps::default()
            },
        };
        description.materials.push(material);
        description.textures.push(plain([1.0; 4]));
        let [corner, u, v] = LAMP;
        let lamp = sheet(corner, u, v, 1);
        add_light(&mut description, &lamp, Affine3A::IDENTITY, Rgb::splat(3.0));
        description.lights[0].material = Some(1);
        // Twice, so that it is no part of the world: nothing else opaque is.
        let roof = sheet(Vec3::new(-4.0, 1.1, -4.0), Vec3::X * 8.0, Vec3::Z * 8.0, 1);
        let near = if blocked { 0.0 } else { 40.0 };
        for x in [near, 80.0] {
            let place = Affine3A::from_translation(Vec3::X * x);
            add(&mut description, &roof, place, 0);
        }
        seen(&description, Strategy::Light).0
    };
    assert!(lit(false) > 0.01);
    assert_eq!(lit(true), 0.0);
}

/// Facing down, above the floor.
const LAMP: [Vec3; 3] = [
    Vec3::new(-0.5, 1.2, -0.3),
    Vec3::new(1.0, 0.2, 0.0),
    Vec3::new(0.1, 0.0, 0.9),
];

#[test]
fn a_mesh_that_emits_is_the_quad_that_emits() {
    let [corner, u, v] = LAMP;
    let radiance = Rgb::new(4.0, 3.0, 2.0);
    for two_sided in [false, true] {
        let mut quad = floor();
        quad.lights.push(Light {
            shape: Shape::Quad { corner, u, v },
            radiance,
            two_sided,
            material: None,
            texture: None,
        });
        let (want, want_error, _) = seen(&quad, Strategy::Mis);
        for side in [1, 9] {
            let mut mesh = floor();
            add_light(
                &mut mesh,
                &sheet(corner, u, v, side),
                Affine3A::IDENTITY,
                radiance,
            );
            mesh.lights[0].two_sided = two_sided;
            for strategy in STRATEGIES {
                let (got, error, _) = seen(&mesh, strategy);
                let all = error.hypot(want_error);
                assert_close(got, want, 0.0, 4.0 * all, &format!("{side}, {strategy}"));
                assert!(error < 0.05 * got, "{error} of {got} tells nothing");
            }
        }
    }
}

#[test]
fn turned_about_a_mesh_is_dark_and_mirrored_it_shines_on_the_side_it_is_mirrored_to() {
    let [corner, u, v] = LAMP;
    for (u, v, mirror, lit) in [
        (u, v, Vec3::ONE, true),
        (v, u, Vec3::ONE, false),
        (u, v, Vec3::new(-1.0, 1.0, 1.0), true),
        (v, u, Vec3::new(-1.0, 1.0, 1.0), false),
    ] {
        let mut description = floor();
        let place = Affine3A::from_scale(mirror);
        add_light(&mut description, &sheet(corner, u, v, 3), place, Rgb::WHITE);
        for strategy in STRATEGIES {
            assert_eq!(
                seen(&description, strategy).0 > 0.0,
                lit,
                "{mirror}, {strategy}"
            );
        }
    }
}
