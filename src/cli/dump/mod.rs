//! `ondine dump`: golden data of every stage, for a port to be held to.

mod vectors;

use super::Outcome;
use super::args::{SettingsArgs, size};
use crate::error::{Error, Result};
use clap::Args;
use std::ops::Range;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  ondine dump cornell --tile 120,96 --out golden         each queue after each stage, of 16x16 pixels and 16 samples
  ondine dump cornell --pixel 128,100 --samples 3..4     one path, vertex by vertex
  ondine dump --check golden of-my-port                  the first stage, edge and path that differ, and by how many ulp
  ondine dump --vectors vectors                          inputs and outputs of samplers, warps, materials, shapes

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
    settings: SettingsArgs,

    /// The folder to write; a dump that is there is replaced
    #[arg(long, value_name = "DIR", help_heading = "Output", requires = "tile")]
    out: Option<PathBuf>,
    /// Print one JSON object: the manifest, or the verdict of --check
    #[arg(long, help_heading = "Output")]
    json: bool,

    /// Compare a port's dump with one of ours
    #[arg(long, num_args = 2, value_names = ["DIR", "OTHER"], help_heading = "Instead of a dump",
          conflicts_with_all = ["scene", "tile", "pixel", "samples", "vectors"])]
    check: Option<Vec<PathBuf>>,
    /// Write test vectors: inputs and outputs of samplers, warps, materials and shapes
    #[arg(long, value_name = "DIR", help_heading = "Instead of a dump",
          conflicts_with_all = ["scene", "tile", "pixel", "samples", "json"])]
    vectors: Option<PathBuf>,
}

pub(in crate::cli) fn run(args: &DumpArgs) -> Result<Outcome> {
    if let Some(dir) = &args.vectors {
        vectors::write(dir)?;
        return Ok(Outcome::Done);
    }
    Err(Error::Usage("nothing is dumped yet".to_owned()))
}

fn pixel(text: &str) -> std::result::Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "write column and row, counted from 0, as in 120,96".to_owned())
}

fn samples(text: &str) -> std::result::Result<Range<u32>, String> {
    text.split_once("..")
        .and_then(|(from, to)| Some(from.trim().parse().ok()?..to.trim().parse().ok()?))
        .filter(|samples: &Range<u32>| !samples.is_empty())
        .ok_or_else(|| "write the first sample and the one past the last, as in 0..16".to_owned())
}
