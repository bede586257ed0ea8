//! What is decided by rule, not by rounding: parallels, ties, targets, what is not a number.

use crate::common::Random;
use crate::{Ball, Parallelogram, kernel, world};
use glam::Vec3;
use ondine::lanes::{Vec3x8, WIDTH, f32x8, u32x8};
use ondine::shape::NO_PRIMITIVE;

fn eight(v: [f32; 3]) -> Vec3x8 {
    Vec3x8::splat(Vec3::from_array(v))
}

#[test]
fn a_ray_parallel_to_a_quad_misses_it_in_its_plane_and_out_of_it() {
    let quad = Parallelogram {
        corner: [-1.0, 0.5, -1.0],
        u: [2.0, 0.0, 0.0],
        v: [0.0, 0.0, 2.0],
    };
    let shapes = kernel(&[quad]);
    for y in [0.5, 0.0, 0.6] {
        for d in [
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [0.6, 0.0, 0.8],
            [-0.6, -0.0, 0.8],
        ] {
            for x in [-3.0, 0.0, 0.9] {
                let (t, id) = shapes.closest(eight([x, y, 0.1]), eight(d));
                assert_eq!(
                    (t.to_array(), id.to_array()),
                    ([f32::INFINITY; 8], [NO_PRIMITIVE; 8])
                );
            }
        }
    }
}

#[test]
fn of_two_hits_at_the_same_distance_the_first_wins_and_quads_come_before_spheres() {
    let quad = Parallelogram {
        corner: [-1.0, -1.0, 0.0],
        u: [2.0, 0.0, 0.0],
        v: [0.0, 2.0, 0.0],
    };
    let ball = Ball {
        center: [0.0, 0.0, -1.0],
        radius: 1.0,
    };
    for (primitives, first) in [
        (vec![quad, quad, ball], 0),
        (vec![ball, ball], 0),
        (vec![ball, quad], 1),
        (vec![ball, ball, quad, quad], 2),
    ] {
        let (t, id) = kernel(&primitives).closest(eight([0.0, 0.0, 2.0]), eight([0.0, 0.0, -1.0]));
        assert_eq!((t.to_array(), id.to_array()), ([2.0; 8], [first; 8]));
    }
}

#[test]
fn the_target_of_a_shadow_ray_does_not_block_it_and_what_lies_before_it_does() {
    let ball = |z: f64| Ball {
        center: [0.0, 0.0, z],
        radius: 0.5,
    };
    let wall = Parallelogram {
        corner: [-1.0, -1.0, -4.0],
        u: [2.0, 0.0, 0.0],
        v: [0.0, 2.0, 0.0],
    };
    let shapes = kernel(&[ball(-1.0), wall]);
    let (o, d) = (eight([0.0; 3]), eight([0.0, 0.0, -1.0]));
    let blocked = |reach: f32, target: u32| {
        let bits = shapes
            .occluded(o, d, f32x8::splat(reach), u32x8::splat(target))
            .to_bitmask();
        assert!(bits == 0 || bits == 0xff);
        bits == 0xff
    };
    assert!(!blocked(0.5, 0) && !blocked(0.4, 1) && !blocked(0.5, NO_PRIMITIVE));
    assert!(blocked(0.6, NO_PRIMITIVE) && blocked(0.6, 1));
    assert!(!blocked(4.0, 0), "the wall ends the ray, not before it");
    assert!(blocked(4.1, 0) && blocked(4.0, 1) && blocked(f32::INFINITY, NO_PRIMITIVE));
}

#[test]
fn what_is_not_a_number_meets_nothing_and_leaves_its_neighbours_alone() {
    let mut random = Random::new(104);
    let primitives = world(&mut random);
    let shapes = kernel(&primitives);
    let (o, d) = (eight([3.0, 0.2, 0.1]), eight([-1.0, 0.0, 0.0]));
    let (want_t, want_id) = shapes.closest(o, d);
    assert_ne!(want_id.as_array()[0], NO_PRIMITIVE);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for component in 0..6 {
            for i in 0..WIDTH {
                let (mut o, mut d) = (o, d);
                let Vec3x8 { x, y, z } = if component < 3 { &mut o } else { &mut d };
                [x, y, z][component % 3].as_mut_array()[i] = bad;
                let (t, id) = shapes.closest(o, d);
                let far = f32x8::splat(f32::INFINITY);
                let occluded = shapes
                    .occluded(o, d, far, u32x8::splat(NO_PRIMITIVE))
                    .to_bitmask();
                for j in 0..WIDTH {
                    let (t, id) = (t.as_array()[j], id.as_array()[j]);
                    let want = if i == j {
                        (f32::INFINITY, NO_PRIMITIVE)
                    } else {
                        (want_t.as_array()[j], want_id.as_array()[j])
                    };
                    assert_eq!(
                        (t, id),
                        want,
                        "{bad} in component {component}, lane {j} of {i}"
                    );
                    assert_eq!(occluded >> j & 1, u32::from(i != j));
                }
            }
        }
    }
    let reach = f32x8::splat(f32::NAN);
    assert_eq!(
        shapes
            .occluded(o, d, reach, u32x8::splat(NO_PRIMITIVE))
            .to_bitmask(),
        0
    );
}
