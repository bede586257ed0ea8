//! The whole loop on one core: waves through a scene into the film, path length 6, strategy `mis`.
//!
//! Elements are camera paths: criterion's Melem/s are the `mpaths_per_s` of `ondine render --threads 1 --json`.

use crate::common::case::{Case, Pace};
use crate::common::{Setup, TILE, wave};
use ondine::film::{AovSet, Film, Layers, Region};
use ondine::scene::description::SamplerKind;
use ondine::wavefront::{self, Workspace};
use std::hint::black_box;

pub fn cases() -> Vec<Case> {
    let cornell = |sampler| {
        let name = format!("cornell/{sampler}");
        case(name, 8, move |side| Setup::cornell(side, sampler, None))
    };
    let landscape = |sampler| {
        let name = format!("landscape/{sampler}");
        case(name, 4, move |side| Setup::landscape(side, sampler, None))
    };
    vec![
        cornell(SamplerKind::Pcg),
        cornell(SamplerKind::Sobol),
        landscape(SamplerKind::Sobol),
    ]
}

/// An image of so many tiles a side.
fn case(name: String, tiles: u32, setup: impl Fn(u32) -> Setup + 'static) -> Case {
    Case::new(name, Pace::Slow, move |face| {
        let side = tiles * TILE;
        let setup = setup(side);
        let ctx = setup.context();
        let mut ws = Workspace::new(wave(0, 0).paths(), &setup.scene, AovSet::default());
        let paths = (tiles * tiles) as usize * wave(0, 0).paths();
        face(paths, &mut || {
            let region = Region::full(side, side);
            let film = Film::new(side, side, region, AovSet::default()).expect("a region");
            for (column, row) in (0..tiles).flat_map(|row| (0..tiles).map(move |x| (x, row))) {
                let wave = wave(column, row);
                wavefront::trace(&ctx, black_box(&wave), &mut ws);
                let radiance = &ws.radiance[..wave.paths()];
                film.add(wave.tile(), wave.samples, radiance, Layers::default());
            }
            black_box(film);
        });
    })
}
