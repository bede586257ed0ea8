//! Quads that share an edge leave no gap.

use crate::common::{Random, V, lane, pack, unit};
use crate::{Parallelogram, kernel, point, sub};
use ondine::lanes::{WIDTH, f32x8};
use ondine::scene::{Scene, builtin};
use ondine::shape::Shapes;

/// A million rays from inside a box (affine image of [−1, 1]³), aimed at its edges and corners.
fn misses_at_the_seams(shapes: &Shapes, place: impl Fn(V) -> V, seed: u64) -> usize {
    let mut random = Random::new(seed);
    let mut misses = 0;
    for batch in 0..1_000_000 / WIDTH {
        // Every other ray starts close to a wall.
        let starts: [V; 8] = std::array::from_fn(|i| {
            let mut p = point(&mut random, 0.999);
            if i % 2 == 1 {
                p[i / 2 % 3] =
                    (1.0 - 10f64.powf(-1.0 - 5.0 * f64::from(random.one()))).copysign(p[0]);
            }
            place(p)
        });
        let o = pack(starts);
        let d = pack(std::array::from_fn(|i| {
            let mut seam = point(&mut random, 1.0).map(|c: f64| 1f64.copysign(c));
            if batch % 4 != 0 {
                seam[(batch + i) % 3] = f64::from(random.one()) * 2.0 - 1.0;
            }
            unit(sub(place(seam), lane(&o, i)))
        }));
        let (t, _) = shapes.closest(o, d);
        misses += t
            .simd_eq(f32x8::splat(f32::INFINITY))
            .to_bitmask()
            .count_ones() as usize;
    }
    misses
}

#[test]
fn no_ray_slips_through_the_seams_of_the_cornell_box() {
    let scene = Scene::compile(
        &builtin::find("cornell")
            .expect("built in")
            .load()
            .expect("valid"),
    );
    let misses = misses_at_the_seams(&scene.shapes, |[x, y, z]| [x, y, 2.0 * z + 1.0], 105);
    assert_eq!(misses, 0);
}

#[test]
fn no_ray_slips_through_the_seams_of_a_turned_box() {
    // Columns of a rotation, by half widths of 1, 1.5 and 2, and off the origin.
    let axes = [[0.36, 0.48, -0.8], [-1.2, 0.9, 0.0], [0.96, 1.28, 1.2]];
    let place = |p: V| -> V {
        std::array::from_fn(|c| 0.3 + (0..3).map(|k| p[k] * axes[k][c]).sum::<f64>())
    };
    let mut walls = Vec::new();
    for k in 0..3 {
        for side in [-1.0, 1.0] {
            let mut corner = [-1.0; 3];
            corner[k] = side;
            let [u, v] = [1, 2].map(|step| axes[(k + step) % 3].map(|c| 2.0 * c));
            walls.push(Parallelogram {
                corner: place(corner),
                u,
                v,
            });
        }
    }
    assert_eq!(misses_at_the_seams(&kernel(&walls), place, 106), 0);
}
