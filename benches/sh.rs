//! Spherical harmonics.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ondine::lanes::{Rgb, Vec3x8, f32x8, sin_cos_turns};
use ondine::sh::{Lobe, Shading, project, published};
use std::hint::black_box;

/// A sky of 2048 × 1024 pixels to degrees 2, 8 and 32, on one thread and on two.
fn projection(criterion: &mut Criterion) {
    let (width, height) = (2048, 1024);
    let value = |i: usize| (i as u32).wrapping_mul(2_654_435_761) as f32 / 4e9;
    let pixels: Vec<Rgb> = (0..width * height).map(|i| Rgb::splat(value(i))).collect();
    let mut group = criterion.benchmark_group("sh/project");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(pixels.len() as u64));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        for degree in [2, 8, 32] {
            group.bench_function(format!("degree {degree}/threads {threads}"), |bencher| {
                bencher.iter(|| pool.install(|| project(width, height, &pixels, degree)));
            });
        }
    }
    group.finish();
}

/// Eight points at a time, by nine coefficients and by those to degree 8.
fn shading(criterion: &mut Criterion) {
    const POINTS: u32 = 4096;
    let normals: Vec<Vec3x8> = (0..POINTS / 8)
        .map(|i| {
            let turns = f32x8::new(std::array::from_fn(|lane| {
                (8 * i + lane as u32) as f32 / POINTS as f32
            }));
            let (sin, cos) = sin_cos_turns(turns);
            Vec3x8::new(sin * 0.8, cos * 0.8, f32x8::splat(0.6))
        })
        .collect();
    let grace = published("grace").expect("a published probe");
    let sky = project(64, 32, &[Rgb::WHITE; 2048], 8).expect("a sky");
    let mut group = criterion.benchmark_group("sh/shade");
    group.throughput(Throughput::Elements(u64::from(POINTS)));
    for (name, light, lobe) in [
        ("lambert/degree 2", &grace, Lobe::Cosine),
        ("phong/degree 2", &grace, Lobe::Phong(50.0)),
        ("phong/degree 8", &sky, Lobe::Phong(50.0)),
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

criterion_group!(benches, projection, shading);
criterion_main!(benches);
