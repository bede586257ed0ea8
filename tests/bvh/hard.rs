//! What is hard to build a tree from.

use crate::common::Random;
use crate::oracle::Oracle;
use crate::rays::{Ray, closest, occluded, tree};
use crate::scenes::{point, soup};
use crate::{PLAIN, QUALITIES, assert_agrees, rays_at};
use glam::{Affine3A, Vec3};
use ondine::bvh::{Bvh, Instance, NO_TRIANGLE};
use ondine::scene::mesh::Mesh;

/// A triangle of that size around a point, not along any axis.
fn around(center: Vec3, size: f32) -> [Vec3; 3] {
    [
        Vec3::new(1.0, 0.1, -0.2),
        Vec3::new(-0.3, 0.9, 0.3),
        Vec3::new(-0.7, -1.0, -0.1),
    ]
    .map(|corner| center + corner * size)
}

#[track_caller]
fn assert_finds(mesh: Mesh, seed: u64) {
    let rays = rays_at(&mesh, &mut Random::new(seed), 1500);
    let meshes = [mesh];
    let oracle = Oracle::new(&meshes, &[PLAIN]);
    for quality in QUALITIES {
        let sure = assert_agrees(&tree(&meshes, &[PLAIN], quality), &oracle, &rays);
        assert!(sure > 150, "{sure} of 1500 rays are no test");
    }
}

#[test]
fn in_nothing_nothing_is_met() {
    let rays = rays_at(&soup([around(Vec3::ZERO, 1.0)]), &mut Random::new(221), 20);
    let empty = [Mesh::default()];
    for bvh in [
        Bvh::default(),
        tree(&[], &[], QUALITIES[0]),
        tree(&empty, &[], QUALITIES[1]),
        tree(&empty, &[PLAIN, PLAIN], QUALITIES[0]),
    ] {
        for (hit, ray) in closest(&bvh, &rays).iter().zip(&rays) {
            assert_eq!((hit.triangle, hit.distance), (NO_TRIANGLE, ray.farthest));
        }
        assert!(occluded(&bvh, &rays).iter().all(|met| !met));
        assert!(closest(&bvh, &[]).is_empty());
    }
}

#[test]
fn a_thousand_copies_of_a_triangle_are_its_first() {
    let meshes = [soup([around(Vec3::ZERO, 1.0); 1000])];
    let instances = [PLAIN; 3];
    for quality in QUALITIES {
        let bvh = tree(&meshes, &instances, quality);
        let rays = [1.0, -1.0].map(|z| Ray::new(Vec3::new(0.01, 0.02, -z), Vec3::new(0.0, 0.0, z)));
        for hit in closest(&bvh, &rays) {
            assert_eq!((hit.instance, hit.triangle), (0, 0));
        }
        assert_eq!(occluded(&bvh, &rays), [true; 2]);
    }
}

#[test]
fn triangles_around_one_point_are_told_apart() {
    let turned = |i: u32| {
        let turn = glam::Quat::from_rotation_y(i as f32 * 0.7)
            * glam::Quat::from_rotation_x(i as f32 * 0.3);
        around(Vec3::ZERO, 0.5 + 0.1 * i as f32).map(|corner| turn * corner)
    };
    for count in [1, 9, 40] {
        assert_finds(soup((0..count).map(turned)), u64::from(count));
    }
}

#[test]
fn sizes_and_distances_that_double_make_no_tree_too_deep() {
    let doubling = (-30..30).map(|i| {
        let size = 2f32.powi(i);
        around(Vec3::splat(3.0 * size), size)
    });
    assert_finds(soup(doubling.clone()), 222);
    // Along one axis, and all from one corner.
    let nested = (-30..30).map(|i| around(Vec3::ZERO, 2f32.powi(i)).map(|corner| corner.abs()));
    assert_finds(soup(nested), 223);
    let along = (0..60).map(|i| around(Vec3::new(2f32.powi(i - 30), 0.0, 0.0), 0.1));
    assert_finds(soup(along), 224);
}

#[test]
fn a_plane_of_triangles_is_met_from_within_its_box() {
    // All boxes are flat; rays run along the plane's axes, and through it.
    let tile = |i: u32| {
        let corner = Vec3::new((i % 12) as f32 - 6.0, 0.0, (i / 12) as f32 - 6.0) / 4.0;
        let [u, v] = [Vec3::X / 4.0, Vec3::Z / 4.0];
        [
            [corner, corner + u, corner + u + v],
            [corner, corner + u + v, corner + v],
        ]
    };
    assert_finds(soup((0..144).flat_map(tile)), 225);
}

#[test]
fn long_thin_triangles_across_each_other_are_met() {
    let mut random = Random::new(226);
    let needle = |_| {
        let [a, b] = [point(&mut random, 2.0), point(&mut random, 2.0)];
        [a, b, b + point(&mut random, 0.05)]
    };
    assert_finds(soup((0..500).map(needle)), 227);
}

#[test]
fn coordinates_at_the_limit_are_met() {
    // Meshes end at ±10⁹.
    let mut random = Random::new(228);
    let huge = |_| around(point(&mut random, 5e8), 4e8);
    let meshes = [soup((0..50).map(huge))];
    let oracle = Oracle::new(&meshes, &[PLAIN]);
    let mut random = Random::new(229);
    let rays: Vec<Ray> = (0..1000)
        .map(|_| Ray::new(point(&mut random, 1e9), point(&mut random, 1.0)))
        .collect();
    for quality in QUALITIES {
        let sure = assert_agrees(&tree(&meshes, &[PLAIN], quality), &oracle, &rays);
        assert!(sure > 150, "{sure} of 1000 rays are no test");
    }
}

#[test]
fn ten_thousand_instances_are_one_tree() {
    let meshes = [
        soup([around(Vec3::ZERO, 0.3)]),
        soup([around(Vec3::ZERO, 0.2), around(0.5 * Vec3::X, 0.1)]),
    ];
    let instances: Vec<Instance> = (0..10_000)
        .map(|i| Instance {
            mesh: i % 2,
            to_world: Affine3A::from_translation(Vec3::new(
                (i % 100) as f32,
                0.0,
                (i / 100) as f32,
            )),
        })
        .collect();
    let bvh = tree(&meshes, &instances, QUALITIES[0]);
    let some = (0..10_000).step_by(37);
    let above = |i| Vec3::new((i % 100) as f32 + 0.02, 5.0, (i / 100) as f32 + 0.01);
    let rays: Vec<Ray> = some
        .clone()
        .map(|i| Ray::new(above(i), Vec3::NEG_Y))
        .collect();
    for (hit, i) in closest(&bvh, &rays).iter().zip(some) {
        assert_eq!((hit.instance as usize, hit.triangle), (i, 0));
    }
}
