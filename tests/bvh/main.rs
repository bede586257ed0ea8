//! The tree against every triangle in turn: the nearest hit, any hit, ties, and inputs that are hard to build from.

mod census;
#[path = "../common/mod.rs"]
mod common;
mod hard;
mod oracle;
#[path = "../common/rays.rs"]
mod rays;
mod same;
mod scenes;

use common::Random;
use glam::Affine3A;
use ondine::bvh::{Bvh, Instance, Quality};
use ondine::scene::mesh::Mesh;
use oracle::Oracle;
use rays::{Ray, closest, occluded, tree};
use scenes::{below, mixed, placed, ray};

const QUALITIES: [Quality; 2] = [Quality::Fast, Quality::Best];

const PLAIN: Instance = Instance {
    mesh: 0,
    to_world: Affine3A::IDENTITY,
};

/// Asks the tree and the oracle; returns how many rays surely meet something.
#[track_caller]
fn assert_agrees(bvh: &Bvh, oracle: &Oracle, rays: &[Ray]) -> usize {
    let hits = closest(bvh, rays);
    for (ray, met) in rays.iter().zip(occluded(bvh, rays)) {
        oracle.assert_any(ray, met);
    }
    let nearest = |(ray, hit)| oracle.assert_nearest(ray, hit);
    rays.iter()
        .zip(&hits)
        .map(nearest)
        .filter(|&sure| sure)
        .count()
}

fn rays_at(mesh: &Mesh, random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count).map(|_| ray(random, mesh)).collect()
}

#[test]
fn the_nearest_hit_of_a_soup_is_that_of_every_triangle_in_turn() {
    let mut random = Random::new(201);
    let mut sure = 0;
    for round in 0..60 {
        let count = [1, 2, 7, 8, 9, 64, 65, 200, 600][round % 9];
        let mesh = [mixed(&mut random, count)];
        let oracle = Oracle::new(&mesh, &[PLAIN]);
        let rays = rays_at(&mesh[0], &mut random, 500);
        let bvh = tree(&mesh, &[PLAIN], QUALITIES[round % 2]);
        assert!(!bvh.is_empty());
        sure += assert_agrees(&bvh, &oracle, &rays);
    }
    assert!(
        (6_000..27_000).contains(&sure),
        "{sure} of 30000 rays are no test"
    );
}

#[test]
fn the_nearest_hit_of_instances_is_that_of_every_triangle_in_turn() {
    let mut random = Random::new(202);
    let mut sure = 0;
    for round in 0..30 {
        let meshes: Vec<Mesh> = (0..1 + round % 3)
            .map(|_| {
                let count = 1 + below(&mut random, 60);
                mixed(&mut random, count)
            })
            .collect();
        let instances = placed(&mut random, meshes.len());
        let oracle = Oracle::new(&meshes, &instances);
        let rays = rays_at(&meshes[0], &mut random, 500);
        let bvh = tree(&meshes, &instances, QUALITIES[round % 2]);
        sure += assert_agrees(&bvh, &oracle, &rays);
    }
    assert!(
        (3_000..14_000).contains(&sure),
        "{sure} of 15000 rays are no test"
    );
}
