//! `ondine compare`: whether two images agree.

mod html;
mod pictures;
mod tables;
mod text;

use super::{Outcome, outputs};
use crate::compare::flip::{self, Exposures};
use crate::compare::{self, Options, Verdict};
use crate::error::Result;
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  ondine compare reference.exr port.exr
  ondine compare reference.exr port.exr --html report.html
  ondine compare reference.exr port.exr --json | jq .verdict

Exit codes: 0 bit-equal or consistent, 1 biased, 2 they cannot be compared.";

/// Tell noise from bias in two images of one scene
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompareArgs {
    /// What is right: an OpenEXR image of any program
    #[arg(value_name = "REFERENCE.exr")]
    pub reference: PathBuf,
    /// What is tested
    #[arg(value_name = "TEST.exr")]
    pub test: PathBuf,
    /// The layer whose R, G and B are compared, as "ViewLayer.Combined"; "" is the plain one [default: the plain or only one]
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// The layer of the test image, where it is called otherwise
    #[arg(long, value_name = "NAME")]
    pub test_layer: Option<String>,
    /// How probable it may be that images that differ by noise alone are called biased
    #[arg(long, value_name = "P", default_value_t = Options::default().alpha,
          allow_negative_numbers = true, value_parser = probability)]
    pub alpha: f64,
    /// Relative bias that is not called one
    #[arg(long, value_name = "X", default_value_t = Options::default().tolerance,
          allow_negative_numbers = true, value_parser = tolerance)]
    pub tolerance: f64,
    /// Leave out ꟻLIP, which takes longer than all the rest
    #[arg(long)]
    pub no_flip: bool,
    /// Write a page that shows both images, where they differ and by how much
    #[arg(long, value_name = "REPORT.html")]
    pub html: Option<PathBuf>,
    /// Print one JSON object instead of a text
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &CompareArgs) -> Result<Outcome> {
    let options = Options {
        alpha: args.alpha,
        tolerance: args.tolerance,
    };
    let layer = args.layer.as_deref();
    let test_layer = args.test_layer.as_deref().or(layer);
    if let Some(page) = &args.html {
        outputs::writable(page, &[&args.reference, &args.test])?;
    }
    // While the blocks of one file are unpacked, those of the other can be read.
    let (reference, test) = rayon::join(
        || compare::read(&args.reference, layer),
        || compare::read(&args.test, test_layer),
    );
    let (reference, test) = (reference?, test?);
    let mut report = compare::compare(&reference, &test, &options)?;
    let flip = (!args.no_flip).then(|| {
        let exposures = Exposures::of(&reference.image.radiance);
        let [a, b] = [&reference, &test].map(|image| &image.image.radiance);
        let flip = flip::hdr(a, b, reference.width, exposures);
        report.metrics.flip = Some(flip.mean);
        report.metrics.flip_exposures = Some(exposures);
        flip
    });
    if let Some(path) = &args.html {
        html::write(path, &report, [&reference, &test], flip.as_ref())?;
    }
    match args.json {
        true => super::print_json(&report)?,
        false => super::print(&text::text(&report))?,
    }
    Ok(match report.verdict {
        Verdict::BitEqual | Verdict::Consistent => Outcome::Done,
        Verdict::Biased => Outcome::Differs,
    })
}

fn probability(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|p: &f64| (1e-12..=0.5).contains(p))
        .ok_or_else(|| "a probability of a false alarm is a number from 1e-12 to 0.5".to_owned())
}

fn tolerance(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| (0.0..=1.0).contains(x))
        .ok_or_else(|| "a tolerance is a number from 0 to 1".to_owned())
}
