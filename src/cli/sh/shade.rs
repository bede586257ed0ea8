//! `ondine sh shade`: a picture by the double sum.

use super::super::Outcome;
use super::super::args::{choice, exposure, size, threads};
use super::super::memory;
use super::super::outputs;
use super::super::report::counted;
use super::{light, object};
use crate::error::{Error, Result};
use crate::film::tonemap::{Operator, Tonemap};
use crate::lanes::Rgb;
use crate::render::{all_processors, workers};
use crate::scene::description::MAX_SIDE;
use crate::sh::{Lobe, Shading};
use clap::Args;
use glam::DMat3;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  ondine sh shade --light grace --bsdf lambert
  ondine sh shade --light sky.exr --bands 16 --bsdf phong:50 --shape teapot.ply -o teapot.exr
  ondine sh shade --light probe.json --bsdf lambert --rotate 0,90,0

A Lambertian surface sends out albedo/pi times its irradiance, a Phong lobe (of integral 1, about the mirror \
direction) albedo times the mean of the light under it. Nothing casts a shadow. Negative values, which a series cut \
off may have, are kept in the EXR and counted.";

/// The most pixels of a picture.
const MOST_PIXELS: u64 = 1 << 26;

/// Bytes of a pixel: its colour, and three and a little while files are written.
const PIXEL: u64 = 12 + 4;

/// Shade an object by the double sum over light and lobe
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct ShadeArgs {
    /// The light: grace, eucalyptus, st-peters, uffizi, a file of coefficients (.json, .csv), or a lat-long image (.exr)
    #[arg(long, value_name = "LIGHT")]
    pub light: String,
    /// What the surface reflects by: lambert, or phong:N
    #[arg(long, value_name = "BSDF", value_parser = light::lobe)]
    pub bsdf: Lobe,
    /// What is seen: sphere (of radius 1, from +z), a mesh or scene file, or a built-in scene
    #[arg(long, value_name = "SHAPE", default_value = "sphere")]
    pub shape: String,
    /// Greatest degree L of the light that counts [default: all there is; 8 of an image]
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = super::bands)]
    pub bands: Option<usize>,
    /// Part of the light that is reflected: a number from 0 to 1, or r,g,b
    #[arg(long, value_name = "ALBEDO", default_value = "1", allow_hyphen_values = true, value_parser = albedo)]
    pub albedo: Rgb,
    /// Turn the light about x, then y, then z, degrees
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = light::rotation)]
    pub rotate: Option<DMat3>,
    /// Width and height in pixels [default: the shape's; 512x512 for the sphere]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// The image to write; the PNG goes beside it
    #[arg(short, long, value_name = "OUT.exr", default_value = "shade.exr")]
    pub output: PathBuf,
    /// Tone curve of the PNG
    #[arg(long, value_name = "CURVE", default_value = "linear", value_parser = choice::<Operator>(&["linear", "reinhard", "aces"]))]
    pub tonemap: Operator,
    /// Exposure of the PNG: radiance times 2^EV
    #[arg(long, value_name = "EV", default_value = "0", allow_negative_numbers = true, value_parser = exposure)]
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
struct ShadeReport {
    light: String,
    bsdf: String,
    shape: String,
    l_max: usize,
    coefficients: usize,
    width: usize,
    height: usize,
    threads: usize,
    load_s: f64,
    shade_s: f64,
    /// Of all values of the picture.
    least: f32,
    /// Part of the pixels with a negative value.
    negative: f64,
    outputs: Vec<String>,
}

pub(super) fn run(args: &ShadeArgs) -> Result<Outcome> {
    let files = outputs::exr_and_png("-o", &args.output)?;
    for path in &files {
        outputs::writable(path, &[Path::new(&args.light), Path::new(&args.shape)])?;
    }
    let threads = args.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let begin = Instant::now();
    let object = object::open(&args.shape)?;
    let (width, height) = args.size.unwrap_or((object.film.width, object.film.height));
    if !(1..=MAX_SIDE).contains(&width)
        || !(1..=MAX_SIDE).contains(&height)
        || u64::from(width) * u64::from(height) > MOST_PIXELS
    {
        return Err(Error::Usage(format!(
            "a picture of {width}x{height} pixels cannot be made; a side has 1 to {MAX_SIDE} pixels, and all are at most \
             {MOST_PIXELS}"
        )));
    }
    memory::check_bytes(
        u64::from(width) * u64::from(height) * PIXEL,
        &format!("{width}x{height} pixels"),
        "choose a smaller --size",
    )?;
    let mut light = pool.install(|| light::open(&args.light, args.bands))?.probe;
    if let Some(rotation) = &args.rotate {
        light = light.rotated(rotation);
    }
    let shading = Shading::new(&light, args.bsdf, args.albedo)?;
    let load = begin.elapsed();
    let begin = Instant::now();
    let picture = pool.install(|| {
        object::picture(&object, (width, height), |normal, outgoing| {
            shading.shade(normal, outgoing)
        })
    })?;
    let shade = begin.elapsed();

    let [exr, png] = &files;
    picture.write_exr(exr)?;
    let tonemap = Tonemap {
        operator: args.tonemap,
        exposure: args.exposure,
    };
    picture.write_png(png, tonemap)?;
    let (least, negative) = picture.negative();
    let report = ShadeReport {
        light: args.light.clone(),
        bsdf: args.bsdf.surface(),
        shape: args.shape.clone(),
        l_max: light.degree,
        coefficients: light.coefficients.len(),
        width: picture.width(),
        height: picture.height(),
        threads,
        load_s: load.as_secs_f64(),
        shade_s: shade.as_secs_f64(),
        least,
        negative,
        outputs: files
            .iter()
            .map(|path| path.display().to_string())
            .collect(),
    };
    match args.json {
        true => super::super::print_json(&report)?,
        false => super::super::print(&report.text())?,
    }
    Ok(Outcome::Done)
}

impl ShadeReport {
    /// For people.
    fn text(&self) -> String {
        let negative = match self.negative > 0.0 {
            true => format!(
                "least value {:.4}; {:.1} % of the pixels are negative\n",
                self.least,
                self.negative * 100.0,
            ),
            false => String::new(),
        };
        format!(
            "{} on {} ({}), l_max = {}: {}x{} pixels in {:.1} ms with {}\n{negative}wrote {}\n",
            self.light,
            self.shape,
            self.bsdf,
            self.l_max,
            self.width,
            self.height,
            self.shade_s * 1e3,
            counted(self.threads, "thread"),
            self.outputs.join(", "),
        )
    }
}

fn albedo(text: &str) -> std::result::Result<Rgb, String> {
    let parts = text.split(',').map(|part| part.trim().parse().ok());
    let parts: Option<Vec<f32>> = parts.collect();
    let parts = parts.filter(|parts| parts.iter().all(|part| (0.0..=1.0).contains(part)));
    match parts.as_deref() {
        Some(&[all]) => Ok(Rgb::splat(all)),
        Some(&[r, g, b]) => Ok(Rgb::new(r, g, b)),
        _ => Err("write a number from 0 to 1, or three as in 0.8,0.6,0.2".to_owned()),
    }
}
