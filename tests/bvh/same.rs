//! The same bits: a hit depends on the ray and its triangle alone, not on the tree and not on the rays beside it.

use crate::common::Random;
use crate::rays::{Ray, closest, occluded, tree};
use crate::scenes::{below, corners, mixed, mixed_sturdy, placed, point, soup};
use crate::{PLAIN, QUALITIES, rays_at};
use ondine::bvh::{Bvh, Hit, Instance, NO_TRIANGLE, Quality};
use ondine::scene::mesh::Mesh;

fn bits(hit: &Hit) -> (u32, u32, u32) {
    (hit.distance.to_bits(), hit.instance, hit.triangle)
}

/// The first of the nearest hits over trees of one triangle each.
fn one_at_a_time(meshes: &[Mesh], instances: &[Instance], rays: &[Ray]) -> Vec<Hit> {
    let nothing = |ray: &Ray| Hit {
        distance: ray.farthest,
        triangle: NO_TRIANGLE,
        instance: NO_TRIANGLE,
    };
    let mut nearest: Vec<Hit> = rays.iter().map(nothing).collect();
    for (id, instance) in instances.iter().enumerate() {
        let mesh = &meshes[instance.mesh];
        for triangle in 0..mesh.triangles.len() {
            let alone = soup([corners(mesh, triangle)]);
            let bvh = tree(
                &[alone],
                &[Instance {
                    mesh: 0,
                    ..*instance
                }],
                Quality::Fast,
            );
            for (best, hit) in nearest.iter_mut().zip(closest(&bvh, rays)) {
                if hit.distance < best.distance {
                    *best = Hit {
                        triangle: triangle as u32,
                        instance: id as u32,
                        ..hit
                    };
                }
            }
        }
    }
    nearest
}

#[track_caller]
fn assert_same(got: &[Hit], want: &[Hit], rays: &[Ray], what: &str) {
    assert_eq!(got.len(), want.len());
    for ((got, want), ray) in got.iter().zip(want).zip(rays) {
        assert_eq!(
            bits(got),
            bits(want),
            "{what}: {got:?} is not {want:?} for {ray:?}"
        );
    }
}

#[test]
fn a_tree_finds_what_its_triangles_find_alone_and_the_first_of_equals() {
    let mut random = Random::new(211);
    for round in 0..12 {
        let meshes: Vec<Mesh> = (0..1 + round % 2)
            .map(|_| mixed_sturdy(&mut random, 80))
            .collect();
        let mut instances = if round % 3 == 0 {
            vec![PLAIN]
        } else {
            placed(&mut random, meshes.len())
        };
        // Everything twice: each hit is a tie.
        instances.extend_from_within(..);
        let rays = rays_at(&meshes[0], &mut random, 1000);
        let want = one_at_a_time(&meshes, &instances, &rays);
        assert!(
            want.iter()
                .filter(|hit| hit.triangle != NO_TRIANGLE)
                .count()
                > 200
        );
        for quality in QUALITIES {
            let bvh = tree(&meshes, &instances, quality);
            assert_same(&closest(&bvh, &rays), &want, &rays, "together");
        }
    }
}

#[test]
fn a_hit_does_not_depend_on_the_rays_beside_it() {
    let mut random = Random::new(212);
    let meshes = [mixed(&mut random, 300), mixed(&mut random, 100)];
    let instances = placed(&mut random, 2);
    let bvh = tree(&meshes, &instances, Quality::Fast);
    let alike = |random: &mut Random| {
        // As from a camera: one origin, neighbouring directions.
        let to = Ray::new(glam::Vec3::new(0.1, 0.2, 4.0), glam::Vec3::ZERO);
        let direction = move |i: usize| {
            glam::Vec3::new(
                (i % 40) as f32 * 0.02 - 0.4,
                (i / 40) as f32 * 0.02 - 0.4,
                -1.0,
            )
        };
        let mut rays: Vec<Ray> = (0..1600)
            .map(|i| Ray {
                direction: direction(i),
                ..to
            })
            .collect();
        rays.extend(rays_at(&meshes[0], random, 1600));
        rays
    };
    let rays = alike(&mut random);
    let (want, any) = (closest(&bvh, &rays), occluded(&bvh, &rays));

    let mut order: Vec<usize> = (0..rays.len()).collect();
    for i in (1..order.len()).rev() {
        order.swap(i, below(&mut random, i + 1));
    }
    let shuffled: Vec<Ray> = order.iter().map(|&i| rays[i]).collect();
    let expected: Vec<Hit> = order.iter().map(|&i| want[i]).collect();
    assert_same(&closest(&bvh, &shuffled), &expected, &shuffled, "shuffled");
    let expected: Vec<bool> = order.iter().map(|&i| any[i]).collect();
    assert_eq!(occluded(&bvh, &shuffled), expected);

    for length in [1, 3, 8, 13, 129] {
        let parts = rays
            .chunks(length)
            .zip(want.chunks(length))
            .zip(any.chunks(length));
        for ((part, want), any) in parts {
            assert_same(&closest(&bvh, part), want, part, "in parts");
            assert_eq!(occluded(&bvh, part), any);
        }
    }
}

#[test]
fn an_any_hit_is_what_a_closest_hit_says() {
    let mut random = Random::new(213);
    let meshes = [mixed(&mut random, 200)];
    let instances = placed(&mut random, 1);
    let bvh = tree(&meshes, &instances, Quality::Fast);
    let mut rays = rays_at(&meshes[0], &mut random, 4000);
    for ray in &mut rays {
        ray.ignored = NO_TRIANGLE;
    }
    let met: Vec<bool> = closest(&bvh, &rays)
        .iter()
        .map(|hit| hit.triangle != NO_TRIANGLE)
        .collect();
    assert_eq!(occluded(&bvh, &rays), met);
    assert!((800..3600).contains(&met.iter().filter(|&&met| met).count()));
}

#[test]
fn a_hit_that_is_given_stays_unless_a_nearer_one_is_found() {
    let mut random = Random::new(214);
    let meshes = [mixed(&mut random, 100)];
    let bvh = tree(&meshes, &[PLAIN], Quality::Fast);
    let rays = rays_at(&meshes[0], &mut random, 2000);
    let found = closest(&bvh, &rays);
    // With the limit at the hit itself nothing is met; a little farther, the same.
    let limited = |distance: &dyn Fn(f32) -> f32| -> Vec<Ray> {
        rays.iter()
            .zip(&found)
            .map(|(ray, hit)| Ray {
                farthest: distance(hit.distance),
                ..*ray
            })
            .collect()
    };
    for (ray, hit) in limited(&|t| t).iter().zip(closest(&bvh, &limited(&|t| t))) {
        assert_eq!(
            (hit.triangle, hit.distance.to_bits()),
            (NO_TRIANGLE, ray.farthest.to_bits())
        );
    }
    for (want, hit) in found.iter().zip(closest(&bvh, &limited(&f32::next_up))) {
        if want.triangle != NO_TRIANGLE {
            assert_eq!(bits(&hit), bits(want));
        }
    }
    assert!(Bvh::default().is_empty());
}

#[test]
fn short_rays_and_negative_zeros_meet_in_company_what_they_meet_alone() {
    let mut random = Random::new(214);
    // Enough triangles for a tree, around the origin of some rays.
    let mesh = [mixed(&mut random, 900)];
    let bvh = tree(&mesh, &[PLAIN], Quality::Fast);
    let mut met = 0;
    for length in [1.0, 1e-7, 1e-12] {
        for nearest in [0.0, -0.0] {
            let together: Vec<Ray> = (0..64)
                .map(|i| Ray {
                    nearest,
                    farthest: f32::INFINITY,
                    ..Ray::new(
                        glam::Vec3::new(i as f32 * 1e-3 - 0.03, 0.01, 0.0),
                        glam::Vec3::new(0.0, 0.0, -length),
                    )
                })
                .collect();
            let (hits, any) = (closest(&bvh, &together), occluded(&bvh, &together));
            for ((ray, hit), any) in together.iter().zip(&hits).zip(any) {
                let alone = closest(&bvh, &[*ray])[0];
                assert_eq!(alone.triangle, hit.triangle, "{ray:?}");
                assert_eq!(alone.distance.to_bits(), hit.distance.to_bits(), "{ray:?}");
                assert_eq!(any, hit.triangle != NO_TRIANGLE, "{ray:?}");
                met += u32::from(any);
            }
        }
    }
    assert!(met > 100, "{met} of 384 rays are no test");
}

#[test]
fn neighbours_that_part_meet_together_what_each_meets_alone() {
    let mut random = Random::new(216);
    // Few triangles, and a tree of many: rays are sorted by direction in one, and go down together in the other.
    for count in [50, 250] {
        let mesh = [mixed_sturdy(&mut random, count)];
        let bvh = tree(&mesh, &[PLAIN], Quality::Fast);
        let mut rays = Vec::new();
        // Eight and more from nearly one place: all around, and towards a lamp that is wide.
        for place in 0..60 {
            let origin = point(&mut random, 1.0);
            for i in 0..17 {
                let origin = origin + 1e-3 * point(&mut random, 1.0);
                let towards = match place % 2 {
                    0 => point(&mut random, 1.0),
                    _ => glam::Vec3::new(0.0, 3.0, 0.0) + point(&mut random, 1.0) - origin,
                };
                let ray = Ray::new(origin, towards);
                let farthest = if i % 3 == 0 { 0.9 } else { f32::INFINITY };
                rays.push(Ray { farthest, ..ray });
            }
        }
        let (hits, any) = (closest(&bvh, &rays), occluded(&bvh, &rays));
        let alone: Vec<Hit> = rays.iter().map(|&ray| closest(&bvh, &[ray])[0]).collect();
        assert_same(&hits, &alone, &rays, "together");
        let met: Vec<bool> = alone
            .iter()
            .map(|hit| hit.triangle != NO_TRIANGLE)
            .collect();
        assert_eq!(any, met);
        let met = met.iter().filter(|&&met| met).count();
        assert!((100..900).contains(&met), "{met} of 1020 rays are no test");
    }
}
