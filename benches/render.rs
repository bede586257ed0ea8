//! The whole loop on one core: waves through the Cornell box into the film, path length 6, strategy `mis`.
//!
//! Criterion's elements are camera paths: its Melem/s are the `mpaths_per_s` of `ondine render --threads 1 --json`.

mod common;

use common::{Setup, TILE, wave};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ondine::film::{AovSet, Film, Layers, Region};
use ondine::scene::description::SamplerKind;
use ondine::wavefront::{self, Workspace};
use std::hint::black_box;
use std::time::Duration;

/// Tiles on a side of the image.
const TILES: u32 = 8;

fn whole_loop(criterion: &mut Criterion) {
    let side = TILES * TILE;
    let paths = (0..TILES * TILES).map(|_| wave(0, 0).paths() as u64).sum();
    let mut group = criterion.benchmark_group("render");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(3))
        .throughput(Throughput::Elements(paths));
    for sampler in [SamplerKind::Pcg, SamplerKind::Sobol] {
        let setup = Setup::cornell(side, sampler, None);
        let ctx = setup.context();
        let mut ws = Workspace::new(wave(0, 0).paths(), &setup.scene, AovSet::default());
        group.bench_function(format!("cornell/{sampler}"), |bencher| {
            bencher.iter(|| {
                let region = Region::full(side, side);
                let film = Film::new(side, side, region, AovSet::default()).expect("a region");
                for (column, row) in (0..TILES).flat_map(|row| (0..TILES).map(move |x| (x, row))) {
                    let wave = wave(column, row);
                    wavefront::trace(&ctx, black_box(&wave), &mut ws);
                    let radiance = &ws.radiance[..wave.paths()];
                    film.add(wave.tile(), wave.samples, radiance, Layers::default());
                }
                film
            });
        });
    }
    group.finish();
}

criterion_group!(benches, whole_loop);
criterion_main!(benches);
