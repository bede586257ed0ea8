//! Spherical harmonics: directions, pixels and points a second.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::sampling::{Dimension, Sampler, warp};
use ondine::sh::{Basis, Lobe, Shading, coefficients, project, published};
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

/// A sky of 2048 × 1024 pixels to degrees 2, 8 and 32, on one thread and on two.
fn projection(criterion: &mut Criterion) {
    let (width, height) = (2048, 1024);
    let value = |i: usize| (i as u32).wrapping_mul(2_654_435_761) as f32 / 4e9;
    let pixels: Vec<Rgb> = (0..width * height).map(|i| Rgb::splat(value(i))).collect();
    let mut group = criterion.benchmark_group("project");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(pixels.len() as u64));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        for degree in [2, 8, 32] {
            group.bench_function(format!("degree {degree}, threads {threads}"), |bencher| {
                bencher.iter(|| pool.install(|| project(width, height, &pixels, degree)));
            });
        }
    }
    group.finish();
}

/// Eight points at a time, by nine coefficients and by those to degree 8.
fn shading(criterion: &mut Criterion) {
    let normals = directions();
    let grace = published("grace").expect("a published probe");
    let sky = project(64, 32, &[Rgb::WHITE; 2048], 8).expect("a sky");
    let mut group = criterion.benchmark_group("shade");
    group.throughput(Throughput::Elements(DIRECTIONS as u64));
    for (name, light, lobe) in [
        ("lambert, degree 2", &grace, Lobe::Cosine),
        ("phong, degree 2", &grace, Lobe::Phong(50.0)),
        ("phong, degree 8", &sky, Lobe::Phong(50.0)),
    ] {
        let shading = Shading::new(light, lobe, Rgb::WHITE).expect("radiance");
        let outgoing = Vec3x8::Z;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for &normal in &normals {
                    black_box(shading.shade(normal, outgoing));
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, basis, projection, shading);
criterion_main!(benches);
