//! Image files: written, read, and added to a sum.
//!
//! Criterion's bytes are those of the channels before they are packed, 124 for a pixel.

mod common;

use common::{PATH_LENGTH, Setup, TILE, wave};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ondine::film::tonemap::Tonemap;
use ondine::film::{AovSet, BLOCK, Coverage, Film, Layers, Metadata, Region, exr, png};
use ondine::scene::description::SamplerKind;
use ondine::wavefront::{self, Workspace};
use std::hint::black_box;

/// Bytes of a pixel's channels.
const PIXEL: u64 = 124;

/// A block of samples for each pixel of the Cornell box.
fn film(side: u32) -> Film {
    let setup = Setup::cornell(side, SamplerKind::Sobol, None);
    let ctx = setup.context();
    let region = Region::full(side, side);
    let film = Film::new(side, side, region, AovSet::default()).expect("a region");
    let mut ws = Workspace::new(wave(0, 0).paths(), &setup.scene, AovSet::default());
    let tiles = side / TILE;
    for (column, row) in (0..tiles).flat_map(|row| (0..tiles).map(move |x| (x, row))) {
        let wave = wave(column, row);
        wavefront::trace(&ctx, &wave, &mut ws);
        let radiance = &ws.radiance[..wave.paths()];
        film.add(wave.tile(), wave.samples, radiance, Layers::default());
    }
    film
}

/// What the file says beside its pixels.
fn metadata(crop: Region) -> Metadata {
    Metadata {
        scene: "cornell".to_owned(),
        scene_hash: String::new(),
        camera: String::new(),
        crop,
        seed: 0,
        spp: BLOCK,
        shard: None,
        blocks: Coverage::of_samples(0..BLOCK, crop.pixels() as u64),
        path_length: PATH_LENGTH,
        strategy: "mis".to_owned(),
        sampler: "sobol".to_owned(),
        roulette: None,
        version: String::new(),
        target_features: String::new(),
        seconds: 0.0,
        rays: 0,
        interrupted: false,
    }
}

fn files(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("image.exr");
    for side in [11 * TILE, 93 * TILE] {
        let film = film(side);
        let metadata = metadata(film.region());
        let mut group = criterion.benchmark_group(format!("film, {side} pixels a side"));
        group
            .sample_size(10)
            .throughput(Throughput::Bytes(PIXEL * film.region().pixels() as u64));
        group.bench_function("write", |bencher| {
            bencher.iter(|| exr::write(&path, black_box(&film), &metadata).expect("written"));
        });
        group.bench_function("read", |bencher| {
            bencher.iter(|| exr::read(black_box(&path)).expect("read"));
        });
        group.bench_function("add to a sum", |bencher| {
            let sum = Film::new(side, side, film.region(), film.aovs()).expect("a region");
            bencher.iter(|| exr::add_to(black_box(&path), &sum).expect("added"));
        });
        group.bench_function("image hash", |bencher| bencher.iter(|| film.image_hash()));
        group.bench_function("PNG", |bencher| {
            bencher.iter(|| png::encode(std::io::sink(), black_box(&film), Tonemap::default()));
        });
        group.finish();
    }
}

criterion_group!(benches, files);
criterion_main!(benches);
