//! `ondine sh project`: an environment as coefficients, and back.

use super::super::Outcome;
use super::super::args::{choice, exposure, threads};
use super::super::outputs;
use super::super::report::counted;
use super::light;
use crate::error::Result;
use crate::film::tonemap::{Operator, Tonemap};
use crate::film::{Raster, write_whole};
use crate::render::{all_processors, workers};
use crate::scene::lat_long;
use crate::sh::{Document, Lobe, Probe, Window};
use clap::Args;
use glam::DMat3;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  ondine sh project sky.exr --bands 8 -o sky.json
  ondine sh project sky.exr --bands 8 --lobe cosine -o irradiance.csv
  ondine sh project sky.exr --bands 16 --reconstruct smooth.exr --window lanczos

Pixels are constant over their solid angles, and integrals over them are exact. The basis is real and orthonormal, \
without the Condon-Shortley sign, in the axes of the world; row 0 of the image is at +y, its left edge at -z, its \
middle at +z. Without -o and --reconstruct the file goes to stdout.";

/// Project a lat-long image onto spherical harmonics
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct ProjectArgs {
    /// A lat-long OpenEXR image of radiance, twice as wide as high
    pub image: PathBuf,
    /// Greatest degree L: (L + 1)² coefficients
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = super::bands)]
    pub bands: usize,
    /// The file to write: JSON, or CSV where its name ends in .csv
    #[arg(short, long, value_name = "PROBE")]
    pub output: Option<PathBuf>,
    /// Convolve with a lobe: cosine (irradiance), or phong:N
    #[arg(long, value_name = "LOBE", value_parser = light::lobe)]
    pub lobe: Option<Lobe>,
    /// Turn the light about x, then y, then z, degrees
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = light::rotation)]
    pub rotate: Option<DMat3>,
    /// Write the image that the coefficients stand for; the PNG beside it shows the original on its left
    #[arg(long, value_name = "OUT.exr")]
    pub reconstruct: Option<PathBuf>,
    /// Against ringing in the reconstructed image; coefficients are written without it
    #[arg(long, default_value = "none", requires = "reconstruct", value_parser = choice::<Window>(&["none", "hanning", "lanczos"]))]
    pub window: Window,
    /// Make negative values of the reconstructed image 0
    #[arg(long, requires = "reconstruct")]
    pub clamp: bool,
    /// Tone curve of the PNG
    #[arg(long, value_name = "CURVE", default_value = "linear", requires = "reconstruct",
          value_parser = choice::<Operator>(&["linear", "reinhard", "aces"]))]
    pub tonemap: Operator,
    /// Exposure of the PNG: radiance times 2^EV
    #[arg(long, value_name = "EV", default_value = "0", requires = "reconstruct",
          allow_negative_numbers = true, value_parser = exposure)]
    pub exposure: f32,
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// What was done.
#[derive(Debug, Serialize)]
struct ProjectReport {
    image: String,
    width: usize,
    height: usize,
    threads: usize,
    read_s: f64,
    project_s: f64,
    reconstruction: Option<Reconstruction>,
    outputs: Vec<String>,
    #[serde(flatten)]
    document: Document,
}

/// The image that was made of the coefficients.
#[derive(Debug, Serialize)]
struct Reconstruction {
    window: String,
    /// Of the values that the series has.
    least: f32,
    /// Part of the pixels with a negative value.
    negative: f64,
    clamped: bool,
}

pub(super) fn run(args: &ProjectArgs) -> Result<Outcome> {
    let picture = args.reconstruct.as_deref();
    let picture = picture.map(|path| outputs::exr_and_png("--reconstruct", path));
    let picture = picture.transpose()?;
    let paths = args.output.iter().chain(picture.iter().flatten());
    let paths: Vec<&Path> = paths.map(PathBuf::as_path).collect();
    for path in &paths {
        outputs::writable(path, &[&args.image])?;
    }
    outputs::distinct(&paths)?;
    let threads = args.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let begin = Instant::now();
    let image = lat_long::read(&args.image)?;
    let read = begin.elapsed();
    let begin = Instant::now();
    let mut probe = pool.install(|| light::project(&image, args.bands))?;
    let project = begin.elapsed();

    if let Some(rotation) = &args.rotate {
        probe = probe.rotated(rotation);
    }
    if let Some(lobe) = args.lobe {
        probe = probe.convolved(lobe)?;
    }
    if let Some(path) = &args.output {
        let text = probe.to_text(path)?;
        write_whole(path, |file| file.write_all(text.as_bytes()))?;
    }
    let reconstruction = match &picture {
        None => None,
        Some([exr, png]) => {
            let original = Raster::new(image.width, image.pixels)?;
            let (made, facts) = pool.install(|| reconstruct(&probe, image.height, args))?;
            made.write_exr(exr)?;
            let tonemap = Tonemap {
                operator: args.tonemap,
                exposure: args.exposure,
            };
            Raster::strip(&[&original, &made])?.write_png(png, tonemap)?;
            Some(facts)
        }
    };
    if !args.json && paths.is_empty() {
        super::super::print(&probe.to_json()?)?;
        return Ok(Outcome::Done);
    }
    let report = ProjectReport {
        image: image.file,
        width: image.width,
        height: image.height,
        threads,
        read_s: read.as_secs_f64(),
        project_s: project.as_secs_f64(),
        reconstruction,
        outputs: paths
            .iter()
            .map(|path| path.display().to_string())
            .collect(),
        document: probe.document()?,
    };
    match args.json {
        true => super::super::print_json(&report)?,
        false => super::super::print(&report.text(&probe))?,
    }
    Ok(Outcome::Done)
}

/// The image of a probe, and what is to be said of it.
fn reconstruct(
    probe: &Probe,
    height: usize,
    args: &ProjectArgs,
) -> Result<(Raster, Reconstruction)> {
    let pixels = probe.windowed(args.window).reconstruct(height);
    let made = Raster::new(2 * height, pixels)?;
    let (least, negative) = made.negative();
    let facts = Reconstruction {
        window: args.window.to_string(),
        least,
        negative,
        clamped: args.clamp,
    };
    let made = match args.clamp {
        true => made.clamped(),
        false => made,
    };
    Ok((made, facts))
}

impl ProjectReport {
    /// For people.
    fn text(&self, probe: &Probe) -> String {
        let mut text = format!(
            "{}: {}x{} pixels, read in {:.3} s\n{} to l_max = {} in {:.1} ms with {}\n",
            self.image,
            self.width,
            self.height,
            self.read_s,
            counted(probe.coefficients.len(), "coefficient"),
            probe.degree,
            self.project_s * 1e3,
            counted(self.threads, "thread"),
        );
        if let Some(made) = &self.reconstruction {
            let fate = match (made.negative > 0.0, made.clamped) {
                (false, _) => "",
                (true, true) => ", made 0",
                (true, false) => ", kept; --clamp makes them 0, as a scene's environment needs",
            };
            text += &format!(
                "reconstructed with window {}: least value {:.4}, {:.1} % of the pixels negative{fate}\n",
                made.window,
                made.least,
                made.negative * 100.0,
            );
        }
        text + &format!("wrote {}\n", self.outputs.join(", "))
    }
}
