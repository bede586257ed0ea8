//! `manifest.json`: what a folder holds, and of what.

use super::budget;
use super::table::Table;
use super::{Block, Dump, MOST_PATHS};
use crate::film::{PixelSums, hexadecimal};
use crate::npy::{Array, Numbers};
use crate::render::Settings;
use crate::scene::description::Description;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The name of the file.
pub const FILE: &str = "manifest.json";

/// What the manifests of dumps begin with.
pub const FORMAT: &str = "ondine dump";

/// The version of this layout.
pub const SCHEMA: u32 = 1;

/// What a folder holds.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`SCHEMA`].
    pub schema: u32,
    /// The version of the program.
    pub version: String,
    /// What the program was compiled for.
    pub target_features: String,
    /// The scene's name.
    pub scene: String,
    /// SHA-256 of the scene's files.
    pub scene_hash: String,
    /// All that decides the bits of an image.
    pub settings: Estimator,
    /// The pixels: x0, y0, x1, y1.
    pub tile: [u32; 4],
    /// The first sample of each pixel, and the one past the last.
    pub samples: [u32; 2],
    /// How many paths there are: the pixel's place in the tile × samples + sample, counted from the first, is a path's number.
    pub paths: usize,
    /// One path in so many may part from ours; of fewer, none.
    pub paths_per_parting: usize,
    /// In the order in which they are filled.
    pub queues: Vec<Queue>,
}

/// All that decides the bits of an image beside the scene.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq, Eq)]
pub struct Estimator {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The camera's name.
    pub camera: String,
    /// Greatest number of edges of a path.
    pub path_length: u32,
    /// How light is looked for.
    pub strategy: String,
    /// Where random numbers come from.
    pub sampler: String,
    /// Seed.
    pub seed: u64,
    /// First path edge at which Russian roulette may end a path.
    pub roulette: Option<u32>,
}

/// A queue after a stage, or a table of the whole dump.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Queue {
    /// Path edge, from 1; 0 for what belongs to none.
    pub edge: u32,
    /// The stage that filled it.
    pub stage: String,
    /// Its name.
    pub queue: String,
    /// Where its arrays are, from the manifest.
    pub folder: String,
    /// How many records it holds; without any there is no array.
    pub records: usize,
    /// An array each.
    pub fields: Vec<Field>,
}

/// An array.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Field {
    /// Its name.
    pub field: String,
    /// The file, from the manifest.
    pub file: String,
    /// As NumPy has it: `<f4`, `<f8` or `<u4`.
    pub dtype: String,
    /// Records, and numbers of each.
    pub shape: Vec<usize>,
    /// Space and unit.
    pub meaning: String,
    /// How far a port may be off, in units in the last place of the greatest component.
    pub budget_ulp: f64,
    /// Of the file.
    pub sha256: String,
}

/// A file: its place in the folder, and what is in it.
pub type File = (String, Vec<u8>);

impl Manifest {
    /// With the files of all arrays.
    pub fn new(
        dump: &Dump,
        description: &Description,
        settings: &Settings,
        target_features: &str,
    ) -> (Self, Vec<File>) {
        let mut all = Arrays {
            // What is added up along a path has the errors of its last edge.
            last_edge: settings.path_length,
            queues: Vec::new(),
            files: Vec::new(),
        };
        all.add_paths(dump);
        dump.tables.iter().for_each(|table| all.add_table(table));
        all.add_film(dump);
        let first = || Some(description.cameras.first()?.name.clone());
        let manifest = Self {
            format: FORMAT.to_owned(),
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            target_features: target_features.to_owned(),
            scene: description.name.clone(),
            scene_hash: description.hash.clone(),
            settings: Estimator {
                width: settings.width,
                height: settings.height,
                camera: settings.camera.clone().or_else(first).unwrap_or_default(),
                path_length: settings.path_length,
                strategy: settings.strategy.to_string(),
                sampler: settings.sampler.to_string(),
                seed: settings.seed,
                roulette: settings.roulette,
            },
            tile: [dump.tile.x0, dump.tile.y0, dump.tile.x1, dump.tile.y1],
            samples: [dump.samples.start, dump.samples.end],
            paths: dump.radiance.len(),
            paths_per_parting: budget::PATHS_PER_PARTING,
            queues: all.queues,
        };
        (manifest, all.files)
    }

    /// How many pixels there are, and samples of each; none where they are not those of its paths.
    pub fn pixels_and_samples(&self) -> Option<(usize, usize)> {
        let [x0, y0, x1, y1] = self.tile;
        let samples = self.samples[1].checked_sub(self.samples[0])? as usize;
        let (width, height) = (x1.checked_sub(x0)? as usize, y1.checked_sub(y0)? as usize);
        let pixels = width.checked_mul(height)?;
        let all = pixels.checked_mul(samples)?;
        (all == self.paths && (1..=MOST_PATHS).contains(&(all as u64))).then_some((pixels, samples))
    }
}

/// An array: its name, what it means, what it holds.
type Named = (&'static str, String, Array);

fn named(name: &'static str, meaning: &str, array: Array) -> Named {
    (name, meaning.to_owned(), array)
}

/// Arrays as they are added.
struct Arrays {
    last_edge: u32,
    queues: Vec<Queue>,
    files: Vec<File>,
}

impl Arrays {
    fn add_table(&mut self, table: &Table) {
        let arrays = table
            .arrays()
            .map(|(field, array)| named(field.name, &plain(field.doc), array));
        let place = (table.edge, table.stage.name(), table.queue.as_str());
        self.add(place, table.len(), arrays.collect());
    }

    /// Column, row and sample of each path.
    fn add_paths(&mut self, dump: &Dump) {
        let column = |of: usize| integers(dump.paths().map(|path| path[of]));
        let arrays = vec![
            named("x", "Column of the path's pixel in the image.", column(0)),
            named("y", "Row of it.", column(1)),
            named("sample", "Its sample, from 0.", column(2)),
        ];
        self.add((0, "paths", ""), dump.radiance.len(), arrays);
    }

    /// Radiance of paths, sums of blocks, exact sums of pixels.
    fn add_film(&mut self, dump: &Dump) {
        let paths = dump.radiance.len();
        let radiance = Array {
            shape: vec![paths, 3],
            numbers: Numbers::F32(dump.radiance.concat()),
        };
        let meaning = "Of each path, by its number, W·sr⁻¹·m⁻².";
        let arrays = vec![named("radiance", meaning, radiance)];
        self.add((0, "film", "radiance"), paths, arrays);

        let blocks = &dump.blocks;
        let of_blocks = |of: fn(&Block) -> u32| integers(blocks.iter().map(of));
        let sums = |of: fn(&Block) -> [f64; 4]| {
            let colors = blocks
                .iter()
                .flat_map(|block| of(block).into_iter().take(3));
            Array {
                shape: vec![blocks.len(), 3],
                numbers: Numbers::F64(colors.collect()),
            }
        };
        let arrays = vec![
            named(
                "pixel",
                "The pixel's place in the tile, row after row.",
                of_blocks(|block| block.pixel),
            ),
            named(
                "first_sample",
                "First sample of the block; blocks begin at multiples of 16.",
                of_blocks(|block| block.first_sample),
            ),
            named(
                "count",
                "Samples that are kept: those that are finite and below 2³².",
                of_blocks(|block| block.sum.kept),
            ),
            named(
                "sum",
                "Their radiance, added up in their order in double precision.",
                sums(|block| block.sum.sum.to_array()),
            ),
            named(
                "square",
                "Squares of it likewise.",
                sums(|block| block.sum.square.to_array()),
            ),
        ];
        self.add((0, "film", "blocks"), blocks.len(), arrays);

        let pixels = || dump.tile.coordinates();
        let words = |of: fn(PixelSums) -> [i128; 3]| {
            let sums = pixels().flat_map(|(x, y)| of(dump.film.sums(x, y)));
            let words = sums.flat_map(|sum| (0..4).map(move |word| (sum >> (32 * word)) as u32));
            Array {
                shape: vec![pixels().count(), 3, 4],
                numbers: Numbers::U32(words.collect()),
            }
        };
        let arrays = vec![
            named(
                "x",
                "Column in the image.",
                integers(pixels().map(|(x, _)| x)),
            ),
            named("y", "Row in the image.", integers(pixels().map(|(_, y)| y))),
            named(
                "count",
                "Samples that are kept.",
                integers(pixels().map(|(x, y)| dump.film.count(x, y))),
            ),
            named(
                "exact_sum",
                "The sums of the blocks, each rounded to a multiple of 2⁻⁶⁴, ties to even, added up: an integer of 128 bits \
                 in two's complement, the least word first.",
                words(|sums| sums.sum.map(|sum| sum.0)),
            ),
            named(
                "exact_square",
                "The squares of the blocks likewise, in units of 2⁻⁴⁰.",
                words(|sums| sums.square.map(|square| square.0)),
            ),
        ];
        self.add((0, "film", "pixels"), pixels().count(), arrays);
    }

    /// Adds the files of a queue; none where it is empty.
    fn add(&mut self, (edge, stage, queue): (u32, &str, &str), records: usize, arrays: Vec<Named>) {
        let folder = match (edge, queue) {
            (0, "") => stage.to_owned(),
            (0, queue) => format!("{stage}/{queue}"),
            (edge, queue) => format!("edge{edge:02}/{stage}/{queue}"),
        };
        let errors_of = if edge == 0 { self.last_edge } else { edge };
        let arrays = arrays.into_iter().filter(|_| records > 0);
        let fields = arrays.map(|(name, meaning, array)| {
            let mut bytes = Vec::new();
            array.write(&mut bytes).expect("a Vec takes all");
            let field = Field {
                field: name.to_owned(),
                file: format!("{folder}/{name}.npy"),
                dtype: array.numbers.dtype().to_owned(),
                shape: array.shape,
                meaning,
                budget_ulp: budget::of(name, errors_of).map_or(0.0, |budget| budget.ulp),
                sha256: sha256(&bytes),
            };
            self.files.push((field.file.clone(), bytes));
            field
        });
        let fields = fields.collect();
        self.queues.push(Queue {
            edge,
            stage: stage.to_owned(),
            queue: queue.to_owned(),
            folder,
            records,
            fields,
        });
    }
}

fn integers(of: impl Iterator<Item = u32>) -> Array {
    let all: Vec<u32> = of.collect();
    Array {
        shape: vec![all.len()],
        numbers: Numbers::U32(all),
    }
}

/// In hexadecimal.
pub(super) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Documentation without its links.
fn plain(doc: &str) -> String {
    let mut plain = String::new();
    let mut rest = doc.trim();
    while let Some((before, after)) = rest.split_once("](") {
        plain += before;
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    plain += rest;
    plain.replace(['[', ']', '`'], "")
}
