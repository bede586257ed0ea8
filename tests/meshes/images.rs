//! Images of meshes against images of what they stand for.

use crate::render::*;
use crate::{add, ball, empty, sheet};
use glam::{Affine3A, Quat, Vec3};
use ondine::film::Film;
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::scene::description::{
    Description, Environment, Light, Object, Punctual, SamplerKind, Shape,
};

const CAMERA: &str = "position = [0.0, 0.6, 4.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 40.0";

/// A lamp above, a floor below.
fn stage() -> Description {
    let mut description = empty(CAMERA);
    description.objects.push(Object {
        shape: Shape::Quad {
            corner: Vec3::new(-3.0, -1.0, 3.0),
            u: Vec3::X * 6.0,
            v: Vec3::Z * -6.0,
        },
        material: 0,
    });
    description.lights.push(Light {
        shape: Shape::Sphere {
            center: Vec3::new(1.5, 3.0, 1.0),
            radius: 0.5,
        },
        radiance: Rgb::new(10.0, 9.0, 8.0),
        two_sided: false,
        material: None,
        texture: None,
    });
    description
}

/// A ball alone, lit by a sun behind the camera: without noise.
fn sunlit() -> Description {
    let mut description = empty(CAMERA);
    description.punctual.push(Punctual::Distant {
        direction: Vec3::new(0.0, -0.6, -4.0).normalize(),
        irradiance: Rgb::splat(3.0),
    });
    description
}

#[test]
fn a_tessellated_ball_converges_to_the_sphere_by_its_edges_and_with_normals_by_their_square() {
    let mut sphere = sunlit();
    sphere.objects.push(Object {
        shape: Shape::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        },
        material: 0,
    });
    let mut settings = settings(&sphere, (96, 96), 16);
    settings.path_length = 2;
    settings.sampler = SamplerKind::Sobol;
    let reference = film(&sphere, &settings).means();
    // Normals are off by the edge; interpolated they, the silhouette and the places are off by its square.
    // Where the sun is behind the camera a flat face's error is of either order.
    for (smooth, orders) in [(false, 1.8..4.4), (true, 3.6..4.4)] {
        let errors = [2, 3, 4].map(|level| {
            let mut scene = sunlit();
            add(&mut scene, &ball(level, smooth), Affine3A::IDENTITY, 0);
            let image = film(&scene, &settings).means();
            let off = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((a[0] - b[0]).abs());
            image.iter().zip(&reference).map(off).sum::<f64>()
        });
        println!("smooth {smooth}: {errors:?}");
        for pair in errors.windows(2) {
            let ratio = pair[0] / pair[1];
            assert!(
                orders.contains(&ratio),
                "{ratio}, smooth {smooth}: {errors:?}"
            );
        }
    }
}

#[test]
fn in_a_white_furnace_a_white_ball_cannot_be_seen() {
    for (smooth, tolerance) in [(false, 1e-4), (true, 2e-2)] {
        for material in [
            Material::Lambert { albedo: Rgb::WHITE },
            Material::Mirror {
                reflectance: Rgb::WHITE,
            },
            Material::Glass { ior: 1.5 },
        ] {
            let mut description = empty(CAMERA);
            description.environment = Some(Environment::Constant(Rgb::splat(0.5)));
            description.materials[0].material = material;
            add(&mut description, &ball(3, smooth), Affine3A::IDENTITY, 0);
            let mut settings = settings(&description, (16, 16), 16);
            // Light stays in a faceted ball of glass for long.
            settings.path_length = 1000;
            let film = film(&description, &settings);
            let (mean, error) = mean_and_error(&film);
            let off = (mean[0] - 0.5).abs();
            assert!(
                off < tolerance * 0.5 + 4.0 * error[0],
                "{material:?}, smooth {smooth}: {mean:?} +- {error:?}"
            );
        }
    }
}

/// A heap of balls at these places.
fn heap(places: &[Affine3A], instanced: bool) -> Description {
    let mut description = stage();
    let shared = ball(2, true);
    for &place in places {
        let mesh = if instanced {
            shared.clone()
        } else {
            ball(2, true)
        };
        add(&mut description, &mesh, place, 0);
    }
    description
}

#[test]
fn instances_are_their_flattened_copies() {
    let places: Vec<Affine3A> = (0..20)
        .map(|i| {
            let x = i as f32;
            Affine3A::from_scale_rotation_translation(
                Vec3::new(0.3 + 0.01 * x, 0.2, if i % 3 == 0 { -0.3 } else { 0.3 }),
                Quat::from_rotation_z(x),
                Vec3::new(
                    (x * 0.7).sin() * 1.2,
                    (x * 1.3).cos() * 0.8,
                    (x * 2.1).sin(),
                ),
            )
        })
        .collect();
    let [instances, copies] = [true, false].map(|instanced| {
        let description = heap(&places, instanced);
        let mut settings = settings(&description, (32, 32), 64);
        settings.aovs = "depth,normal".parse().expect("layers");
        film(&description, &settings)
    });
    // Paths are the same but for rounding: one in some thousands turns another way.
    let (a, b) = (mean_and_error(&instances), mean_and_error(&copies));
    for c in 0..3 {
        let off = (a.0[c] - b.0[c]).abs();
        assert!(off < 2e-3 * a.0[c] && off < a.1[c], "{a:?} is not {b:?}");
    }
    // The same hits: a sample in a hundred on a silhouette may fall beside it.
    let depth = |film: &Film, i: u32| film.aov(i % 32, i / 32).depth;
    let off =
        |i: &u32| (depth(&instances, *i) - depth(&copies, *i)).abs() > 1e-5 * depth(&copies, *i);
    let others = (0..32 * 32).filter(off).count();
    assert!(others < 10, "{others} pixels have another depth");
    let (a, b) = (instances.means(), copies.means());
    let variances = instances.variances();
    for (i, (a, b)) in a.iter().zip(&b).enumerate() {
        let error = f64::from(variances[i][0]).sqrt();
        assert!(
            f64::from(a[0] - b[0]).abs() <= 4.0 * error + 1e-4,
            "pixel {i}: {a:?} {b:?}"
        );
    }
}

#[test]
fn no_surface_shades_itself_near_or_far_large_or_small() {
    for (scale, at) in [
        (1.0, Vec3::ZERO),
        (1e-3, Vec3::ZERO),
        (1e5, Vec3::ZERO),
        (1.0, Vec3::new(1e4, -3e3, 2e3)),
        (1e-2, Vec3::new(-3.0, 40.0, 10.0)),
    ] {
        for instanced in [false, true] {
            let mut description = empty(CAMERA);
            let camera = &mut description.cameras[0].camera;
            camera.look_at = at;
            camera.position = at + Vec3::Z * (8.0 * scale);
            camera.vertical_fov = 3.0;
            description.punctual.push(Punctual::Distant {
                direction: -Vec3::Z,
                irradiance: Rgb::splat(3.0),
            });
            let place = |at| {
                Affine3A::from_scale_rotation_translation(
                    Vec3::splat(scale),
                    Quat::from_rotation_x(0.4),
                    at,
                )
            };
            let mesh = ball(4, false);
            add(&mut description, &mesh, place(at), 0);
            if instanced {
                add(
                    &mut description,
                    &mesh,
                    place(at + Vec3::X * (9.0 * scale)),
                    0,
                );
            }
            let mut settings = settings(&description, (16, 16), 16);
            settings.path_length = 2;
            let film = film(&description, &settings);
            // The middle of the ball faces the sun within 18°, and faces are off by some more.
            let least = 0.9 * 0.5 * 3.0 / std::f32::consts::PI;
            let lit = film.means().iter().all(|mean| mean[0] > least);
            assert!(lit, "scale {scale}, at {at}, instanced {instanced}");
        }
    }
}

#[test]
fn a_sheet_of_triangles_is_a_quad() {
    let (corner, u, v) = (Vec3::new(-3.0, -1.0, 3.0), Vec3::X * 6.0, Vec3::Z * -6.0);
    let quad = stage();
    let mut mesh = stage();
    mesh.objects.clear();
    add(&mut mesh, &sheet(corner, u, v, 7), Affine3A::IDENTITY, 0);
    let [quad, mesh] = [quad, mesh].map(|description| {
        let settings = settings(&description, (32, 32), 64);
        mean_and_error(&film(&description, &settings))
    });
    for c in 0..3 {
        let off = (quad.0[c] - mesh.0[c]).abs();
        assert!(off < 1e-4 * quad.0[c], "{quad:?} is not {mesh:?}");
    }
}
