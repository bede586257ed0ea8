//! What a built tree holds.

use crate::common::Random;
use crate::rays::tree;
use crate::scenes::{mixed, placed, point, soup};
use crate::{PLAIN, QUALITIES};
use glam::Vec3;
use ondine::bvh::Quality;

#[test]
fn every_triangle_is_in_the_tree() {
    let mut random = Random::new(301);
    for count in [1, 7, 8, 9, 64, 65, 1000, 20_000] {
        let mesh = [mixed(&mut random, count)];
        for quality in QUALITIES {
            let census = tree(&mesh, &[PLAIN], quality).validate(quality).unwrap();
            assert_eq!(
                census.meshes,
                [(0..count as u32).collect::<Vec<_>>()],
                "{quality:?}"
            );
            assert!(census.blocks >= count.div_ceil(8));
        }
    }
}

#[test]
fn instances_share_their_meshes_tree() {
    let mut random = Random::new(302);
    let meshes = [mixed(&mut random, 300), mixed(&mut random, 20)];
    let instances = placed(&mut random, 2);
    assert!(instances.len() > 2);
    let census = tree(&meshes, &instances, Quality::Fast)
        .validate(Quality::Fast)
        .unwrap();
    let mut sizes: Vec<usize> = census.meshes.iter().map(Vec::len).collect();
    sizes.sort_unstable();
    assert_eq!(sizes, [20, 300]);
}

#[test]
fn long_triangles_go_in_pieces_and_few_do() {
    let mut random = Random::new(303);
    let mut needles = |count: usize| {
        soup((0..count).map(|_| {
            let [from, to] = [0; 2].map(|_| point(&mut random, 1.0));
            [from, to, to + Vec3::splat(1e-3)]
        }))
    };
    let mesh = [needles(4000)];
    let [fast, best] =
        QUALITIES.map(|quality| tree(&mesh, &[PLAIN], quality).validate(quality).unwrap());
    assert!(best.blocks > fast.blocks);
    let [fast, best] = QUALITIES.map(|quality| tree(&mesh, &[PLAIN], quality).bytes());
    let sum = |(nodes, blocks): (usize, usize)| nodes + blocks;
    assert!(sum(best) < 2 * sum(fast), "{best:?} {fast:?}");
}

#[test]
fn a_tree_is_no_deeper_than_a_stack_whatever_the_triangles() {
    // Each an eighth of the next: the heuristic would split off one at a time.
    let mesh = [soup((0..120).flat_map(|power| {
        let size = 1e-9 * 1.4f32.powi(power);
        let corner = Vec3::new(size, 0.0, 0.0);
        let small = |copy: f32| {
            let at = corner * (1.0 + 1e-3 * copy);
            [at, at + Vec3::Y * size * 0.1, at + Vec3::Z * size * 0.1]
        };
        [small(0.0), small(1.0), small(2.0)]
    }))];
    for quality in QUALITIES {
        let census = tree(&mesh, &[PLAIN], quality).validate(quality).unwrap();
        assert!(census.depth <= 24, "{}", census.depth);
    }
}
