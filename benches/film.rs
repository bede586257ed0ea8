//! Image files: written, read, and added to a sum. Elements are pixels, of 124 bytes before they are packed.

use crate::common::case::{Case, Face, Pace};
use crate::common::{PATH_LENGTH, Setup, TILE, wave};
use ondine::film::tonemap::Tonemap;
use ondine::film::{AovSet, BLOCK, Coverage, Film, Layers, Metadata, Region, exr, png};
use ondine::scene::description::SamplerKind;
use ondine::wavefront::{self, Workspace};
use std::hint::black_box;
use std::sync::LazyLock;

static SMALL: LazyLock<Film> = LazyLock::new(|| film(4 * TILE));
static LARGE: LazyLock<Film> = LazyLock::new(|| film(93 * TILE));

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, work) in [
        ("write", write as fn(&Film, Face)),
        ("read", read),
        ("add-to-sum", add_to_sum),
        ("image-hash", image_hash),
        ("png", write_png),
    ] {
        let small = move |face: Face| work(&SMALL, face);
        let large = move |face: Face| work(&LARGE, face);
        cases.push(Case::new(format!("small/{name}"), Pace::Quick, small));
        cases.push(Case::timed(format!("large/{name}"), Pace::Slow, large));
    }
    cases
}

fn write(film: &Film, face: Face) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("image.exr");
    let metadata = metadata(film.region());
    face(film.region().pixels(), &mut || {
        exr::write(&path, black_box(film), &metadata).expect("written");
    });
}

fn read(film: &Film, face: Face) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("image.exr");
    exr::write(&path, film, &metadata(film.region())).expect("written");
    face(film.region().pixels(), &mut || {
        black_box(exr::read(black_box(&path)).expect("read"));
    });
}

fn add_to_sum(film: &Film, face: Face) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("image.exr");
    exr::write(&path, film, &metadata(film.region())).expect("written");
    let Region { x1, y1, .. } = film.region();
    let sum = Film::new(x1, y1, film.region(), film.aovs()).expect("a region");
    face(film.region().pixels(), &mut || {
        exr::add_to(black_box(&path), &sum).expect("added");
    });
}

fn image_hash(film: &Film, face: Face) {
    face(film.region().pixels(), &mut || {
        black_box(black_box(film).image_hash());
    });
}

fn write_png(film: &Film, face: Face) {
    face(film.region().pixels(), &mut || {
        png::encode(std::io::sink(), black_box(film), Tonemap::default()).expect("encoded");
    });
}

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
