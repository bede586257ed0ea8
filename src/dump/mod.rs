//! Floor 5: dumps. Every record of every queue after every stage, of a few pixels and samples, as files that a port to other
//! hardware can be held to.
//!
//! [`trace`] makes a [`Dump`], [`folder::write`] makes a folder of it: `.npy` arrays, a field each, and a
//! [`manifest`]. [`check`](mod@check) compares such folders: for each field there is a [`budget`] of units in the last
//! place. [`text`] tells the paths of one pixel.

pub mod budget;
pub mod check;
pub mod folder;
pub mod manifest;
mod recorder;
pub mod scene;
pub mod table;
pub mod text;

use crate::error::{Error, Result};
use crate::film::{BLOCK, BlockSum, Film, Layers, MAX_SAMPLES, Region, block_sum};
use crate::render::{Settings, camera_of};
use crate::scene::Scene;
use crate::scene::description::Description;
use crate::scene::sensor::Sensor;
use crate::wavefront::{Wave, Workspace, trace_observed};
use recorder::Recorder;
use std::ops::Range;
use table::Table;

/// The most paths of a dump.
pub const MOST_PATHS: u64 = 1 << 20;

/// The most bytes of records of a dump.
const MOST_BYTES: usize = 1 << 28;

/// Columns of the waves that are traced for it. No bit depends on them.
const WAVE_COLUMNS: usize = 64;

/// What a part of an image came from: all records of its paths.
#[derive(Debug)]
pub struct Dump {
    /// The pixels.
    pub tile: Region,
    /// The samples of each.
    pub samples: Range<u32>,
    /// The queues, edge by edge, in the order in which they are filled.
    pub tables: Vec<Table>,
    /// Radiance of each path.
    pub radiance: Vec<[f32; 3]>,
    /// What the film adds up of blocks of samples: pixel by pixel, for each block by block.
    pub blocks: Vec<Block>,
    /// What it makes of them.
    pub film: Film,
}

/// A block of samples of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Place of the pixel in the tile, row after row.
    pub pixel: u32,
    /// Its first sample.
    pub first_sample: u32,
    /// What its samples add up to.
    pub sum: BlockSum,
}

impl Dump {
    /// The paths, by number: the pixel's place in the tile × samples + sample, counted from the first that is dumped. Gives
    /// column, row and sample.
    pub fn paths(&self) -> impl Iterator<Item = [u32; 3]> {
        let pixels = self.tile.coordinates();
        pixels.flat_map(|(x, y)| self.samples.clone().map(move |sample| [x, y, sample]))
    }

    /// The table of a queue, if the loop came to it.
    pub fn table(&self, edge: u32, stage: &str, queue: &str) -> Option<&Table> {
        self.tables
            .iter()
            .find(|table| table.edge == edge && table.stage.name() == stage && table.queue == queue)
    }
}

/// Traces the samples of a tile as a render does, and keeps everything. Of the settings, those count that decide the bits of
/// an image; the number of samples is that of `samples`.
///
/// # Errors
/// [`Error::Usage`] for a tile that is empty or not in the image, no samples, too many paths, too many records, and as
/// [`render`](crate::render::render).
pub fn trace(
    description: &Description,
    settings: &Settings,
    tile: Region,
    samples: Range<u32>,
) -> Result<Dump> {
    settings.check()?;
    check(settings, tile, &samples)?;
    let camera = camera_of(description, settings)?;
    let scene = Scene::compile_with(description, settings.bvh);
    let sampler = settings.random_numbers();
    let ctx = settings.context(&scene, Sensor::Camera(&camera), &sampler);

    let film = Film::new(settings.width, settings.height, tile, ctx.aovs)?;
    let count = samples.len();
    let mut radiance = vec![[0.0; 3]; tile.pixels() * count];
    let mut blocks = Vec::new();
    let largest = tile.pixels().min(WAVE_COLUMNS) * count.min(BLOCK as usize);
    let mut ws = Workspace::new(largest, &scene, ctx.aovs);
    let mut recorder = Recorder::new(MOST_BYTES);
    for wave in waves(tile, &samples) {
        let number = Numbering::new(tile, &samples, &wave);
        recorder.number = number;
        trace_observed(&ctx, &wave, &mut ws, &mut recorder);
        if recorder.is_full() {
            return Err(Error::Usage(format!(
                "the dump takes more than {} MiB; choose a smaller --tile-size, fewer --samples or a lower --path-length",
                MOST_BYTES >> 20
            )));
        }
        let traced = &ws.radiance[..wave.paths()];
        film.add(wave.tile(), wave.samples, traced, Layers::default());
        for (path, &[r, g, b, _]) in (0..).zip(traced) {
            radiance[number.of(path) as usize] = [r, g, b];
        }
        for (pixel, samples) in (0..).zip(traced.chunks_exact(wave.samples as usize)) {
            blocks.push(Block {
                pixel: number.first_pixel + pixel,
                first_sample: wave.first_sample,
                sum: block_sum(samples),
            });
        }
    }
    blocks.sort_by_key(|block| (block.pixel, block.first_sample));
    Ok(Dump {
        tile,
        samples,
        tables: recorder.finish(),
        radiance,
        blocks,
        film,
    })
}

fn check(settings: &Settings, tile: Region, samples: &Range<u32>) -> Result<()> {
    let image = Region::full(settings.width, settings.height);
    if tile.is_empty() || !image.contains(tile) {
        return Err(Error::Usage(format!(
            "the tile {tile} (x0,y0,x1,y1) is empty or reaches outside the {}x{} image",
            settings.width, settings.height
        )));
    }
    if samples.is_empty() || samples.end > MAX_SAMPLES {
        return Err(Error::Usage(format!(
            "the samples {}..{} are none, or go past {MAX_SAMPLES}; give --samples a..b with a < b <= {MAX_SAMPLES}",
            samples.start, samples.end
        )));
    }
    let paths = tile.pixels() as u64 * samples.len() as u64;
    if paths > MOST_PATHS {
        return Err(Error::Usage(format!(
            "{paths} paths are more than a dump holds ({MOST_PATHS}); choose a smaller --tile-size or fewer --samples"
        )));
    }
    Ok(())
}

/// Within rows and blocks of samples, which begin at multiples of [`BLOCK`], as in any render.
fn waves(tile: Region, samples: &Range<u32>) -> impl Iterator<Item = Wave> {
    let Range { start, end } = *samples;
    let ends = (start / BLOCK + 1..=end.div_ceil(BLOCK)).map(move |block| (block * BLOCK).min(end));
    ends.flat_map(move |block_end| {
        let first_sample = start.max((block_end - 1) / BLOCK * BLOCK);
        (tile.y0..tile.y1).flat_map(move |y| {
            (tile.x0..tile.x1).step_by(WAVE_COLUMNS).map(move |x| Wave {
                x,
                y,
                width: (tile.x1 - x).min(WAVE_COLUMNS as u32),
                height: 1,
                first_sample,
                samples: block_end - first_sample,
            })
        })
    })
}

/// From a path's place in a wave, of one row, to its number in the dump.
#[derive(Clone, Copy, Debug, Default)]
struct Numbering {
    first_pixel: u32,
    first_sample: u32,
    samples: u32,
    samples_of_wave: u32,
}

impl Numbering {
    fn new(tile: Region, samples: &Range<u32>, wave: &Wave) -> Self {
        Self {
            first_pixel: (wave.y - tile.y0) * tile.width() + wave.x - tile.x0,
            first_sample: wave.first_sample - samples.start,
            samples: samples.end - samples.start,
            samples_of_wave: wave.samples,
        }
    }

    fn of(self, path: u32) -> u32 {
        let (pixel, sample) = (path / self.samples_of_wave, path % self.samples_of_wave);
        (self.first_pixel + pixel) * self.samples + self.first_sample + sample
    }
}
