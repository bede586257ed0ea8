//! A mesh is content: of rooms, of hulls, and of the size of a scene.

use crate::render::*;
use crate::{add, ball, empty, sheet};
use glam::{Affine3A, Quat, Vec3};
use ondine::lanes::Rgb;
use ondine::scene::Scene;
use ondine::scene::description::{Description, Environment, Object, Punctual, Shape};

const CAMERA: &str = "position = [0.2, 0.1, -0.8]\nlook_at = [0.0, 0.0, 1.0]\nvertical_fov = 60.0";

/// The walls of the cube [-1, 1]³.
fn walls(description: &mut Description) {
    let (low, x, y, z) = (Vec3::NEG_ONE, Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    for (corner, u, v) in [
        (low, x, z),
        (low + y, x, z),
        (low, y, z),
        (low + x, y, z),
        (low, x, y),
        (low + z, x, y),
    ] {
        let shape = Shape::Quad { corner, u, v };
        description.objects.push(Object { shape, material: 0 });
    }
}

fn room(place: Affine3A, lamp: Vec3) -> Description {
    let mut description = empty(CAMERA);
    walls(&mut description);
    add(&mut description, &ball(1, true), place, 0);
    description.punctual.push(Punctual::Point {
        position: lamp,
        intensity: Rgb::WHITE,
    });
    description
}

fn at(x: f32) -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.3),
        Quat::from_rotation_x(0.5),
        Vec3::new(x, -0.2, 0.3),
    )
}

#[test]
fn six_walls_are_a_room_unless_a_mesh_or_a_lamp_is_beyond_them() {
    let is_room = |place, lamp| Scene::compile(&room(place, lamp)).room.is_some();
    assert!(is_room(at(0.0), Vec3::Y * 0.9));
    assert!(!is_room(at(0.8), Vec3::Y * 0.9));
    assert!(!is_room(at(0.0), Vec3::Y * 1.1));
}

#[test]
fn a_room_with_a_mesh_in_it_is_the_same_room_made_of_meshes() {
    for lamp in [Vec3::new(0.1, 0.8, 0.0), Vec3::new(0.0, 1.5, 0.0)] {
        let quads = room(at(0.0), lamp);
        let mut meshes = quads.clone();
        meshes
            .objects
            .retain(|o| matches!(o.shape, Shape::Mesh { .. }));
        for object in &quads.objects {
            if let Shape::Quad { corner, u, v } = object.shape {
                add(&mut meshes, &sheet(corner, u, v, 2), Affine3A::IDENTITY, 0);
            }
        }
        let [quads, meshes] = [quads, meshes].map(|description| {
            let settings = settings(&description, (24, 24), 64);
            mean_and_error(&film(&description, &settings))
        });
        let off = (quads.0[0] - meshes.0[0]).abs();
        // A path in a thousand turns another way by rounding.
        assert!(
            off <= 2e-3 * quads.0[0],
            "{lamp}: {quads:?} is not {meshes:?}"
        );
        assert_eq!(quads.0[0] > 0.0, lamp.y < 1.0, "{lamp}");
    }
}

#[test]
fn meshes_hide_the_sky_and_shapes_from_one_another() {
    // A closed box of triangles around a sphere that the sky would light.
    let mut description = empty(CAMERA);
    description.environment = Some(Environment::Constant(Rgb::WHITE));
    description.objects.push(Object {
        shape: Shape::Sphere {
            center: Vec3::Z * 0.4,
            radius: 0.2,
        },
        material: 0,
    });
    let mut outer = empty(CAMERA);
    walls(&mut outer);
    for object in &outer.objects {
        if let Shape::Quad { corner, u, v } = object.shape {
            add(
                &mut description,
                &sheet(corner, u, v, 3),
                Affine3A::IDENTITY,
                0,
            );
        }
    }
    for strategy in STRATEGIES {
        let mut settings = settings(&description, (24, 24), 64);
        settings.strategy = strategy;
        let film = film(&description, &settings);
        assert!(
            film.means().iter().all(|mean| *mean == [0.0; 3]),
            "{strategy}: it leaks"
        );
    }
}

#[test]
fn a_hundred_thousand_instances_are_quickly_there() {
    let mut description = empty(CAMERA);
    let mesh = sheet(Vec3::ZERO, Vec3::X * 1e-3, Vec3::Y * 1e-3, 1);
    for i in 0..100_000 {
        let (x, y) = ((i % 400) as f32, (i / 400) as f32);
        let place = Affine3A::from_translation(Vec3::new(x * 2e-3, y * 2e-3, 1.0));
        add(&mut description, &mesh, place, 0);
    }
    let meshes = Scene::compile(&description).meshes.expect("meshes");
    assert!(!meshes.opaque.tree.is_empty() && meshes.masked.tree.is_empty());
}
