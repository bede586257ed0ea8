//! Light probes: paths a second from a point in the Cornell box, to degrees that are asked for.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use ondine::render::probes::bake;
use ondine::render::{Control, Settings};
use ondine::scene::builtin;
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Samples of a probe.
const SPP: u32 = 1 << 15;

fn probe(c: &mut Criterion) {
    let scene = builtin::open("cornell").expect("a built-in scene");
    let settings = Settings {
        spp: SPP,
        path_length: 5,
        threads: Some(1),
        ..Settings::of(&scene)
    };
    let stop = AtomicBool::new(false);
    let control = Control {
        stop: &stop,
        progress: &|_| (),
    };
    let mut group = c.benchmark_group("probe");
    group.throughput(Throughput::Elements(SPP.into()));
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(3));
    for degree in [0, 2, 8] {
        group.bench_function(format!("to degree {degree}"), |b| {
            b.iter(|| {
                bake(
                    &scene,
                    black_box(&[Vec3::ZERO]),
                    degree,
                    &settings,
                    &control,
                )
            });
        });
    }
    group.finish();
}

criterion_group!(benches, probe);
criterion_main!(benches);
