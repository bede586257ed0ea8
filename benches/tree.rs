//! The tree of triangles alone: building it, and tracing rays that keep together, rays that do not, and shadow rays.
//!
//! A landscape of half a million triangles; elements are triangles or rays. `ondine rays` measures given rays on a given
//! mesh.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Affine3A, Vec3};
use ondine::bvh::{Bvh, HitX8, Instance, NO_TRIANGLE, Quality, Ray, RayX8, Stacks, Triangles};
use ondine::lanes::{Queue, WIDTH, f32x8, u32x8};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::time::Duration;

/// Vertices on a side.
const SIDE: u32 = 512;
/// Rays on a side of the image.
const IMAGE: u32 = 64;
const PLAIN: Instance = Instance {
    mesh: 0,
    to_world: Affine3A::IDENTITY,
};

fn landscape() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let height = |x: f32, z: f32| {
        (0..7).fold(0.0, |sum, octave| {
            let f = 2f32.powi(octave);
            sum + ((x * f * 6.0).sin() * (z * f * 7.0 + f).cos()).abs() * 0.15 / f
        })
    };
    let grid = (0..SIDE * SIDE).map(|i| {
        let (x, z) = (
            (i % SIDE) as f32 / SIDE as f32,
            (i / SIDE) as f32 / SIDE as f32,
        );
        Vec3::new(x, height(x, z), z)
    });
    let squares = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| z * SIDE + x));
    let triangles = squares.flat_map(|a| [[a, a + SIDE, a + 1], [a + 1, a + SIDE, a + SIDE + 1]]);
    (grid.collect(), triangles.collect())
}

fn queue(rays: impl Iterator<Item = Ray>) -> Queue<RayX8> {
    let rays: Vec<Ray> = rays.collect();
    let mut queue = Queue::with_capacity(rays.len());
    rays.into_iter().for_each(|ray| queue.push_one(ray));
    queue
}

/// Camera rays over the landscape, in tiles of 8 × 8.
fn camera_rays() -> Queue<RayX8> {
    let origin = Vec3::new(0.5, 0.9, -0.6);
    queue((0..IMAGE * IMAGE).map(|i| {
        let (tile, pixel) = (i / 64, i % 64);
        let x = (tile % (IMAGE / 8) * 8 + pixel % 8) as f32 / IMAGE as f32 - 0.5;
        let y = (tile / (IMAGE / 8) * 8 + pixel / 8) as f32 / IMAGE as f32 - 0.5;
        let direction = Vec3::new(x, -0.55 - 0.6 * y, 1.0).normalize();
        Ray::new(origin, direction)
    }))
}

/// From what camera rays met, upwards at random.
fn bounced(bvh: &Bvh, camera_rays: &Queue<RayX8>) -> Queue<RayX8> {
    let hits = trace(bvh, camera_rays, &mut Stacks::default());
    let mut random = Pcg32::new(1, 2);
    let mut unit = move || random.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0;
    queue((0..camera_rays.len()).filter_map(move |i| {
        let (ray, lane) = (camera_rays.get(i), i % WIDTH);
        let distance = hits[i / WIDTH].distance.to_array()[lane];
        let met = hits[i / WIDTH].triangle.to_array()[lane] != NO_TRIANGLE;
        let direction = Vec3::new(unit(), unit().abs() + 0.05, unit()).normalize();
        let origin = ray.origin + ray.direction * distance + Vec3::Y * 1e-4;
        met.then_some(Ray::new(origin, direction))
    }))
}

fn trace(bvh: &Bvh, rays: &Queue<RayX8>, stacks: &mut Stacks) -> Vec<HitX8> {
    let nothing = HitX8 {
        distance: f32x8::splat(f32::INFINITY),
        triangle: u32x8::splat(NO_TRIANGLE),
        instance: u32x8::splat(NO_TRIANGLE),
    };
    let mut hits = vec![nothing; rays.len().div_ceil(WIDTH)];
    bvh.closest(rays, &mut hits, stacks);
    hits
}

fn tree(criterion: &mut Criterion) {
    let (positions, corners) = landscape();
    let mesh = Triangles {
        positions: &positions,
        corners: &corners,
    };
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    let build = |quality| one.install(|| Bvh::build(&[mesh], &[PLAIN], quality));
    let mut group = criterion.benchmark_group("tree");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(corners.len() as u64));
    for (name, quality) in [("build/fast", Quality::Fast), ("build/best", Quality::Best)] {
        group.bench_function(name, |bencher| {
            bencher.iter_batched(|| (), |()| build(quality), BatchSize::PerIteration);
        });
    }
    let bvh = build(Quality::Fast);
    let camera_rays = camera_rays();
    let bounced = bounced(&bvh, &camera_rays);
    assert!(
        bounced.len() > 1000,
        "{} rays meet the landscape",
        bounced.len()
    );
    let mut stacks = Stacks::default();
    for (name, rays) in [
        ("closest/camera", &camera_rays),
        ("closest/bounced", &bounced),
    ] {
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| trace(&bvh, rays, &mut stacks))
        });
    }
    let mut occluded = vec![0; bounced.len().div_ceil(WIDTH)];
    group.throughput(Throughput::Elements(bounced.len() as u64));
    group.bench_function("any/bounced", |bencher| {
        bencher.iter(|| bvh.occluded(&bounced, &mut occluded, &mut stacks));
    });
    group.finish();
}

criterion_group!(benches, tree);
criterion_main!(benches);
