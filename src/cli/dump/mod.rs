//! `ondine dump`: golden data of every stage, for a port to be held to.

mod check;
mod vectors;

use super::Outcome;
use super::args::{ChangeArgs, SettingsArgs, samples, size};
use super::report::counted;
use super::target::target_features;
use crate::dump::manifest::Manifest;
use crate::dump::scene::SceneIds;
use crate::dump::text::text;
use crate::dump::{self, folder};
use crate::error::{Error, Result};
use crate::film::{BLOCK, Region};
use crate::render::Settings;
use clap::Args;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What asks for a dump, and would be ignored by what is done instead of one.
const OF_A_DUMP: [&str; 14] = [
    "scene",
    "tile",
    "tile_size",
    "samples",
    "pixel",
    "out",
    "set",
    "size",
    "camera",
    "seed",
    "path_length",
    "strategy",
    "sampler",
    "roulette",
];

const EXAMPLES: &str = "\
Examples:
  ondine dump cornell --tile 120,96 --out golden       16x16 pixels, 16 samples of each
  ondine dump cornell --pixel 128,100 --samples 3..4   one path, vertex by vertex
  ondine dump --check golden port                      what differs first, and by how much
  ondine dump --vectors vectors                        functions, one by one

Exit codes of --check: 0 within the budgets, 1 different, 2 cannot be compared.";

/// Write what passes between the stages, for a port to be held to
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, override_usage = "ondine dump SCENE --tile X,Y --out DIR [OPTIONS]\n       \
    ondine dump SCENE --pixel X,Y [OPTIONS]\n       ondine dump --check DIR OTHER\n       ondine dump --vectors DIR")]
pub(in crate::cli) struct DumpArgs {
    /// A scene, as `ondine render` takes it
    #[arg(required_unless_present_any = ["check", "vectors"])]
    scene: Option<String>,

    /// Left column and top row of the pixels to dump
    #[arg(long, value_name = "X,Y", help_heading = "What to dump", allow_hyphen_values = true,
          value_parser = pixel, requires = "out")]
    tile: Option<(u32, u32)>,
    /// Their columns and rows; cut off at the edge of the image
    #[arg(long, value_name = "WxH", default_value = "16x16", help_heading = "What to dump",
          allow_hyphen_values = true, value_parser = size)]
    tile_size: (u32, u32),
    /// Their samples, counted from 0; the last is not among them [default: 0..16, or as many as the scene has]
    #[arg(long, value_name = "a..b", help_heading = "What to dump",
          allow_hyphen_values = true, value_parser = samples)]
    samples: Option<Range<u32>>,
    /// Print the paths of a pixel, vertex by vertex
    #[arg(long, value_name = "X,Y", help_heading = "What to dump", allow_hyphen_values = true,
          value_parser = pixel, conflicts_with = "json")]
    pixel: Option<(u32, u32)>,
    #[command(flatten)]
    changes: ChangeArgs,
    #[command(flatten)]
    settings: SettingsArgs,

    /// The folder to write; a dump that is there is replaced
    #[arg(long, value_name = "DIR", help_heading = "Output", requires = "tile")]
    out: Option<PathBuf>,
    /// Print one JSON object: the manifest, or the verdict of --check
    #[arg(long, help_heading = "Output")]
    json: bool,

    /// Compare a port's dump with one of ours
    #[arg(long, num_args = 2, value_names = ["DIR", "OTHER"], help_heading = "Instead of a dump",
          conflicts_with = "vectors", conflicts_with_all = OF_A_DUMP)]
    check: Option<Vec<PathBuf>>,
    /// Write test vectors: inputs and outputs of samplers, warps, materials and shapes
    #[arg(long, value_name = "DIR", help_heading = "Instead of a dump",
          conflicts_with = "json", conflicts_with_all = OF_A_DUMP)]
    vectors: Option<PathBuf>,
}

pub(in crate::cli) fn run(args: &DumpArgs) -> Result<Outcome> {
    if let Some(dir) = &args.vectors {
        vectors::write(dir)?;
        return Ok(Outcome::Done);
    }
    match (&args.check, &args.scene) {
        (Some(folders), _) => check::run(folders, args.json),
        (None, Some(scene)) => dump(args, scene),
        (None, None) => Err(nothing_asked()),
    }
}

/// Traces what was asked for; writes it, prints it, or both.
fn dump(args: &DumpArgs, scene: &str) -> Result<Outcome> {
    if args.tile.is_none() && args.pixel.is_none() {
        return Err(nothing_asked());
    }
    if let Some(out) = &args.out {
        folder::check(out)?;
    }
    let description = args.changes.open(scene)?;
    for warning in &description.warnings {
        super::say(format_args!("warning: {warning}"));
    }
    let settings = args.settings.of(&description);
    settings.check()?;
    let samples = args.samples.clone().unwrap_or(0..settings.spp.min(BLOCK));
    let traced = |option: &str, at, size| {
        let tile = region(option, at, size, &settings)?;
        dump::trace(&description, &settings, tile, samples.clone())
    };
    if let (Some(at), Some(out)) = (args.tile, &args.out) {
        let dump = traced("--tile", at, args.tile_size)?;
        let (manifest, files) = Manifest::new(&dump, &description, &settings, &target_features());
        folder::write(out, &manifest, &SceneIds::of(&description), &files)?;
        match args.json {
            true => super::print_json(&manifest)?,
            false => super::print(&summary(out, &manifest, files.len()))?,
        }
    }
    if let Some(at) = args.pixel {
        let dump = traced("--pixel", at, (1, 1))?;
        super::print(&text(&dump, &description))?;
    }
    Ok(Outcome::Done)
}

fn nothing_asked() -> Error {
    Error::Usage(
        "nothing is asked for; give --tile X,Y --out DIR to write a dump, or --pixel X,Y to print paths".to_owned(),
    )
}

/// The pixels from `at` on, as far as there are any.
fn region(
    option: &str,
    at: (u32, u32),
    (columns, rows): (u32, u32),
    settings: &Settings,
) -> Result<Region> {
    let ((x, y), (width, height)) = (at, (settings.width, settings.height));
    if x >= width || y >= height {
        return Err(Error::Usage(format!(
            "{option} {x},{y} lies outside the {width}x{height} image; columns are 0 to {}, rows 0 to {}",
            width - 1,
            height - 1
        )));
    }
    if columns == 0 || rows == 0 {
        return Err(Error::Usage(format!(
            "--tile-size {columns}x{rows} has no pixel; give at least 1x1"
        )));
    }
    Ok(Region {
        x0: x,
        y0: y,
        x1: x.saturating_add(columns).min(width),
        y1: y.saturating_add(rows).min(height),
    })
}

/// For people: what was written.
fn summary(out: &Path, manifest: &Manifest, arrays: usize) -> String {
    let [x0, y0, x1, y1] = manifest.tile;
    let [first, end] = manifest.samples;
    let edges = manifest.queues.iter().map(|queue| queue.edge).max();
    format!(
        "Wrote {}: {} of {}, pixels {x0},{y0} to {},{}, samples {first} to {}, {} in {}\n",
        out.display(),
        counted(manifest.paths, "path"),
        manifest.scene,
        x1 - 1,
        y1 - 1,
        end - 1,
        counted(edges.unwrap_or_default(), "edge"),
        counted(arrays, "array"),
    )
}

fn pixel(text: &str) -> std::result::Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "write column and row, counted from 0, as in 120,96".to_owned())
}
