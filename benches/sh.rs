//! Spherical harmonics: directions a second.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ondine::lanes::{Vec3x8, WIDTH, f32x8, u32x8};
use ondine::sampling::{Dimension, Sampler, warp};
use ondine::sh::{Basis, coefficients};
use std::hint::black_box;

/// Directions: as many as a wave has paths.
const DIRECTIONS: usize = 2048;

/// Uniform over the sphere.
fn directions() -> Vec<Vec3x8> {
    let sampler = Sampler::pcg(0, 1);
    (0..DIRECTIONS / WIDTH)
        .map(|batch| {
            let pixel = u32x8::splat(batch as u32);
            let path = sampler.path_key(pixel, u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]));
            warp::uniform_sphere(sampler.pair(path, Dimension::BsdfDirection, 0))
        })
        .collect()
}

/// The basis in eight lanes, as kernels use it, and in rows, as NumPy has it.
fn basis(c: &mut Criterion) {
    let wide = directions();
    let rows: Vec<[f32; 3]> = wide
        .iter()
        .flat_map(|batch| (0..WIDTH).map(|lane| batch.lane(lane).to_array()))
        .collect();
    let mut group = c.benchmark_group("basis");
    group.throughput(Throughput::Elements(DIRECTIONS as u64));
    for degree in [2, 4, 8, 16, 64] {
        let basis = Basis::new(degree);
        let mut values = vec![f32x8::ZERO; coefficients(degree)];
        group.bench_function(format!("lanes, degree {degree}"), |b| {
            b.iter(|| {
                for direction in black_box(&wide) {
                    basis.evaluate(direction, &mut values);
                    black_box(&mut values);
                }
            });
        });
        let mut table = vec![0.0; DIRECTIONS * coefficients(degree)];
        group.bench_function(format!("rows, degree {degree}"), |b| {
            b.iter(|| basis.tabulate(black_box(&rows), black_box(&mut table)));
        });
    }
}

criterion_group!(benches, basis);
criterion_main!(benches);
