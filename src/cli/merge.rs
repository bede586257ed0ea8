//! `ondine merge`: parts of an image, put together.

use super::args::PictureArgs;
use super::outputs::{self, exr_and_png};
use super::report::{Samples, counted};
use super::{Outcome, memory};
use crate::error::{Error, Result};
use crate::film::{Coverage, Film, Shard, exr};
use crate::merge::{Missing, Parts};
use crate::stats::peak_rss_bytes;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  ondine render cornell --spp 1024 --shard 1/2 -o one.exr      on one machine
  ondine render cornell --spp 1024 --shard 2/2 -o two.exr      on another
  ondine merge one.exr two.exr -o cornell.exr                  the bits of one render

  ondine render cornell --spp 64 -o today.exr
  ondine render cornell --samples 64..256 -o tomorrow.exr
  ondine merge today.exr tomorrow.exr -o cornell.exr           the bits of --spp 256

Parts may come in any order, and may be merged images themselves. A part may be a pattern in quotes, as in 'parts/*.exr'.";

/// Put parts of an image together, bit for bit the whole
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct MergeArgs {
    /// The parts: images of the same scene and settings that `ondine render` or `ondine merge` wrote
    #[arg(required = true, value_name = "PART.exr")]
    parts: Vec<PathBuf>,
    /// The image to write; the PNG goes beside it
    #[arg(short, long, value_name = "OUT.exr", help_heading = "Output")]
    output: PathBuf,
    #[command(flatten)]
    picture: PictureArgs,
    /// Where parts are missing, make the best image of what there is
    #[arg(long)]
    partial: bool,
    /// Where OUT.exr has all of these samples already, leave it alone
    #[arg(long)]
    skip_done: bool,
    /// Print one JSON object on stdout instead of a summary
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What `merge --json` prints.
#[derive(Debug, Serialize)]
struct Report {
    parts: usize,
    width: u32,
    height: u32,
    spp: u32,
    samples: Samples,
    complete: bool,
    /// Whether the image was there before.
    skipped: bool,
    missing_shards: Vec<Shard>,
    missing_blocks: Coverage,
    rejected_samples: u64,
    seconds: f64,
    rays: u64,
    image_hash: String,
    outputs: Vec<String>,
    peak_rss_bytes: Option<u64>,
}

pub(super) fn run(args: &MergeArgs) -> Result<Outcome> {
    let [exr_path, png_path] = exr_and_png("-o", &args.output)?;
    let files = match args.picture.no_png {
        true => vec![exr_path.clone()],
        false => vec![exr_path.clone(), png_path.clone()],
    };
    let named = named(&args.parts)?;
    let inputs: Vec<_> = named.iter().map(PathBuf::as_path).collect();
    for file in &files {
        outputs::writable(file, &inputs)?;
    }
    let parts = Parts::open(&named)?;
    let missing = parts.missing();
    if !missing.is_empty() && !args.partial {
        return Err(Error::Usage(format!(
            "{}: parts of the image are missing: {missing}; render them, or add --partial for an image of what there is",
            args.output.display()
        )));
    }
    let pixels = parts.region().pixels() as u64;
    memory::check_films(pixels, parts.aovs(), "merge on a larger machine")?;
    let before = match args.skip_done {
        true => before(&exr_path, &parts),
        false => None,
    };
    let skipped = before.is_some();
    let film = match before {
        Some(film) => film,
        None => {
            let film = parts.merge()?;
            exr::write(&exr_path, &film, parts.metadata())?;
            film
        }
    };
    let has_png = args.picture.no_png || skipped && png_path.exists();
    if !has_png {
        args.picture.write(&png_path, &exr_path, &film)?;
    }
    if !missing.is_empty() {
        super::say(format_args!("the image lacks {missing}"));
    }
    let outputs = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    let mut report = Report::new(&parts, &film, missing, named.len(), outputs);
    report.skipped = skipped;
    match args.json {
        true => super::print_json(&report)?,
        false => super::print(&report.summary())?,
    }
    Ok(Outcome::Done)
}

/// The files of all patterns, which reach further than a command line: the system bounds its length.
///
/// # Errors
/// [`Error::Usage`] for a pattern that is none, or that no file matches.
fn named(parts: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut named = Vec::with_capacity(parts.len());
    for part in parts {
        let wrong = |what: &dyn std::fmt::Display| {
            let part = part.display();
            Error::Usage(format!(
                "{part}: {what}; name a file, or a pattern as in 'parts/*.exr'"
            ))
        };
        let pattern = part.to_str().filter(|text| text.contains(['*', '?', '[']));
        let Some(pattern) = pattern.filter(|_| !part.exists()) else {
            named.push(part.clone());
            continue;
        };
        let before = named.len();
        for found in glob::glob(pattern).map_err(|error| wrong(&error.msg))? {
            named.push(found.map_err(|error| wrong(&error))?);
        }
        if named.len() == before {
            return Err(wrong(&"no file matches this pattern"));
        }
    }
    Ok(named)
}

/// The image itself, if it has the samples of all parts and is whole.
fn before(exr: &Path, parts: &Parts) -> Option<Film> {
    let header = exr::read_header(exr).ok()?;
    let read = parts.are_all_in(&header).then(|| exr::read(exr).ok());
    read?.map(|(film, _)| film)
}

impl Report {
    fn new(
        parts: &Parts,
        film: &Film,
        missing: Missing,
        number: usize,
        outputs: Vec<String>,
    ) -> Self {
        let metadata = parts.metadata();
        let (min, max) = metadata.samples();
        Self {
            parts: number,
            width: film.width(),
            height: film.height(),
            spp: metadata.spp,
            samples: Samples { min, max },
            complete: missing.is_empty(),
            skipped: false,
            missing_shards: missing.shards,
            missing_blocks: missing.blocks,
            rejected_samples: film.rejected(),
            seconds: metadata.seconds,
            rays: metadata.rays,
            image_hash: film.image_hash(),
            outputs,
            peak_rss_bytes: peak_rss_bytes(),
        }
    }

    fn summary(&self) -> String {
        let what = match self.skipped {
            true => "Left alone",
            false => "Wrote",
        };
        format!(
            "{what} {}: {} of {}x{} pixels, {} per pixel\nImage hash {}\n",
            self.outputs.join(" and "),
            counted(self.parts, "part"),
            self.width,
            self.height,
            counted(self.samples, "sample"),
            self.image_hash
        )
    }
}
