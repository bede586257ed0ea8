//! `ondine sh compare`: the double sum against rays.

use super::super::args::{choice, size, threads, whole, within};
use super::super::memory;
use super::super::outputs;
use super::super::plot::{Axis, Line, Plot, Scale, Style};
use super::super::progress::Progress;
use super::super::report::seconds;
use super::super::{Outcome, interrupt, print, print_json, say};
use super::comparison::{
    Agreement, Comparison, LEAST_REGIONS, LEAST_SAMPLES, LEAST_SPP, Row, Subject,
};
use super::{light, object};
use crate::error::{Error, Result};
use crate::film::tonemap::Tonemap;
use crate::film::{MAX_SAMPLES, write_whole};
use crate::render::{Control, Settings, all_processors, workers};
use crate::scene::description::{SamplerKind, Strategy};
use crate::sh::{Lobe, Probe};
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  ondine sh compare --light grace --bsdf lambert
  ondine sh compare --light sky.exr --bands 12 --bsdf phong:50 -o compared
  ondine sh compare --light probe.json --bsdf lambert --shape teapot.ply -o compared

What is compared: for lambert, the path tracer with a white lambert surface and paths of two edges. For phong:N, rays drawn \
from the lobe itself, which is what the double sum integrates; the path tracer's phong material stands beside it, and is \
another model: it has the cosine of the light's angle, is normalised by n + 2, and ends at the horizon. Both see the light \
as far as its coefficients go; of an image, the whole image is compared too. \
On an object that is not convex the path tracer's image has shadows, and the double sum has none.";

/// Compare the double sum with rays: by degree, as a table, a plot and pictures
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct CompareArgs {
    /// The light: grace, eucalyptus, st-peters, uffizi, a file of coefficients (.json, .csv), or a lat-long image (.exr)
    #[arg(long, value_name = "LIGHT")]
    pub light: String,
    /// What the surface reflects by: lambert, or phong:N
    #[arg(long, value_name = "BSDF", value_parser = light::lobe)]
    pub bsdf: Lobe,
    /// What is seen: sphere (of radius 1, from +z), a mesh or scene file, or a built-in scene
    #[arg(long, value_name = "SHAPE", default_value = "sphere")]
    pub shape: String,
    /// Greatest degree L of the light [default: all there is; 8 of an image]
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = super::bands)]
    pub bands: Option<usize>,
    /// Samples per pixel, 4 or more: their spread is the noise
    #[arg(long, value_name = "N", default_value_t = 256, allow_negative_numbers = true, value_parser = samples)]
    pub spp: u32,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "160x160", allow_hyphen_values = true, value_parser = size)]
    pub size: (u32, u32),
    /// How the path tracer looks for light
    #[arg(long, default_value = "mis", value_parser = choice::<Strategy>(&["uniform", "cosine", "light", "mis"]))]
    pub strategy: Strategy,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub seed: u64,
    /// A folder for strip.png, difference.svg and difference.csv; it is made where it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Show no progress bar
    #[arg(short, long)]
    pub quiet: bool,
}

/// What rays found, in numbers.
#[derive(Debug, Serialize)]
struct Found {
    name: &'static str,
    /// Of the object's pixels.
    rms: f64,
    /// Root mean square of their standard errors, over `rms`.
    relative_noise: f64,
    /// What its difference is multiplied with in the strip.
    strip_gain: u32,
}

/// What `sh compare --json` prints.
#[derive(Debug, Serialize)]
struct CompareReport {
    light: String,
    bsdf: String,
    shape: String,
    l_max: usize,
    width: u32,
    height: u32,
    /// Pixels that the object covers wholly: those that are compared.
    pixels: usize,
    spp: u32,
    strategy: String,
    seed: u64,
    threads: usize,
    seconds: f64,
    estimators: Vec<Found>,
    by_degree: Vec<Row>,
    agreement: Agreement,
    outputs: Vec<String>,
}

pub(super) fn run(args: &CompareArgs) -> Result<Outcome> {
    let begin = Instant::now();
    let threads = args.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let light = pool.install(|| light::open(&args.light, args.bands))?;
    shines(&args.light, &light.probe)?;
    let subject = Subject {
        object: object::open(&args.shape)?,
        light: light.probe,
        image: light.image.map(Arc::new),
        lobe: args.bsdf,
    };
    let settings = args.settings(&subject, threads);
    settings.check()?;
    memory::check(&settings, subject.held(), "choose a smaller --size")?;
    let files = match &args.output {
        Some(folder) => Some(args.files(folder, &subject)?),
        None => None,
    };

    let paths = settings.region.pixels() as u64 * u64::from(settings.spp) * subject.images();
    let progress = Progress::new(&args.light, paths, None, args.quiet);
    let control = Control {
        stop: interrupt::listen(),
        progress: &|paths| progress.add(paths),
    };
    let compared = subject.compare(&settings, &control);
    progress.finish();
    let Some(comparison) = compared? else {
        say("interrupted before the last image; nothing was written");
        return Ok(Outcome::Interrupted);
    };
    let pixels = comparison.covered.iter().filter(|covered| **covered);
    let pixels = pixels.count();

    let (strip, gains) = comparison.strip()?;
    if let Some([png, svg, table]) = &files {
        strip.write_png(png, Tonemap::default())?;
        args.plot(&comparison).write(svg)?;
        let text = csv(&comparison);
        write_whole(table, |file| file.write_all(text.as_bytes()))?;
    }
    let outputs = files
        .iter()
        .flatten()
        .map(|path| path.display().to_string());
    let found = comparison
        .views
        .iter()
        .zip(gains)
        .map(|(view, gain)| Found {
            name: view.name,
            rms: view.rms,
            relative_noise: view.noise / view.rms,
            strip_gain: gain,
        });
    let report = CompareReport {
        light: args.light.clone(),
        bsdf: args.bsdf.surface(),
        shape: args.shape.clone(),
        l_max: subject.light.degree,
        width: settings.width,
        height: settings.height,
        pixels,
        spp: settings.spp,
        strategy: settings.strategy.to_string(),
        seed: settings.seed,
        threads,
        seconds: begin.elapsed().as_secs_f64(),
        estimators: found.collect(),
        by_degree: comparison.rows,
        agreement: comparison.agreement,
        outputs: outputs.collect(),
    };
    match args.json {
        true => print_json(&report)?,
        false => print(&report.text())?,
    }
    Ok(Outcome::Done)
}

/// Refuses light that there is nothing to compare of.
fn shines(name: &str, light: &Probe) -> Result<()> {
    let mut values = light.coefficients.iter().flatten();
    match values.any(|&value| value as f32 != 0.0) {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{name} is black; choose a --light that shines"
        ))),
    }
}

impl CompareArgs {
    /// The folder is made, and each of its files can be written.
    fn files(&self, folder: &Path, subject: &Subject) -> Result<[PathBuf; 3]> {
        let wrong = |what: &dyn std::fmt::Display| {
            Error::Usage(format!("-o {}: {what}; name a folder", folder.display()))
        };
        if folder.is_file() {
            return Err(wrong(&"this is a file"));
        }
        std::fs::create_dir_all(folder).map_err(|error| wrong(&error.kind()))?;
        let files = ["strip.png", "difference.svg", "difference.csv"].map(|name| folder.join(name));
        for file in &files {
            outputs::spare_inputs(file, &subject.object)?;
            outputs::writable(file, &[Path::new(&self.light), Path::new(&self.shape)])?;
        }
        Ok(files)
    }

    /// Independent samples: their variance is what the film says it is. Direct light: what the double sum is about.
    fn settings(&self, subject: &Subject, threads: usize) -> Settings {
        let mut settings = Settings::of(&subject.object);
        settings.set_size(self.size.0, self.size.1);
        Settings {
            spp: self.spp,
            seed: self.seed,
            path_length: 2,
            strategy: self.strategy,
            sampler: SamplerKind::Pcg,
            threads: Some(threads),
            ..settings
        }
    }

    fn plot(&self, comparison: &Comparison) -> Plot {
        let line = |name, colour, style, points| Line {
            name,
            colour,
            style,
            points,
        };
        let mut lines = Vec::new();
        for (index, view) in comparison.views.iter().enumerate() {
            let rows = || comparison.rows.iter();
            let apart = rows().map(|row| (row.l as f64, row.relative_rms[index]));
            lines.push(line(
                view.name.to_owned(),
                index,
                Style::Dotted,
                apart.collect(),
            ));
            let noise = rows().map(|row| (row.l as f64, view.noise / view.rms));
            let name = format!("{}: noise", view.name);
            lines.push(line(name, index, Style::Dashed, noise.collect()));
        }
        let light = Path::new(&self.light)
            .file_name()
            .unwrap_or_default()
            .display();
        Plot {
            title: format!("{light}, {}: the double sum and rays", self.bsdf.surface()),
            x: Axis::new("greatest degree L of the double sum", Scale::Whole),
            y: Axis::new("relative difference (rms)", Scale::Logarithmic),
            lines,
        }
    }
}

fn samples(text: &str) -> std::result::Result<u32, String> {
    let most = MAX_SAMPLES as usize;
    within(text, LEAST_SPP, most).map(|samples| samples as u32)
}

fn csv(comparison: &Comparison) -> String {
    let mut text = String::from("l");
    for view in &comparison.views {
        let _ = write!(text, ",\"{}\"", view.name);
    }
    text.push('\n');
    for Row { l, relative_rms } in &comparison.rows {
        let _ = write!(text, "{l}");
        for value in relative_rms {
            let _ = write!(text, ",{value:e}");
        }
        text.push('\n');
    }
    text
}

impl Agreement {
    fn text(&self) -> String {
        let verdict = match self.agrees {
            Some(true) => "they agree within noise",
            Some(false) => "they differ by more than noise",
            None => {
                return format!(
                    "cannot tell: regions of the image with {LEAST_SAMPLES} samples of the object are {}, and {LEAST_REGIONS} are \
                     needed; choose a greater --size or --spp",
                    self.regions
                );
            }
        };
        // Without the sign of a zero.
        let mean = (self.mean_z * 100.0).round() / 100.0 + 0.0;
        format!(
            "z-scores of {} regions have mean {mean:.2}, variance {:.2}, greatest {:.1}: {verdict}",
            self.regions, self.variance_z, self.greatest_z
        )
    }
}

impl CompareReport {
    /// For people.
    fn text(&self) -> String {
        let mut text = format!(
            "{} on {} ({}): relative difference (rms) of the double sum from\n   L",
            self.light, self.shape, self.bsdf
        );
        let width = |found: &Found| found.name.len().max(10) + 2;
        for found in &self.estimators {
            let _ = write!(text, "{:>1$}", found.name, width(found));
        }
        text.push('\n');
        let mut row = |name: &str, values: &mut dyn Iterator<Item = f64>| {
            let _ = write!(text, "{name:>4}");
            for (value, found) in values.zip(&self.estimators) {
                let _ = write!(text, "{:>1$.6}", value, width(found));
            }
            text.push('\n');
        };
        for Row { l, relative_rms } in &self.by_degree {
            row(&l.to_string(), &mut relative_rms.iter().copied());
        }
        row(
            "ray",
            &mut self.estimators.iter().map(|found| found.relative_noise),
        );
        let _ = writeln!(
            text,
            "(ray: the noise of the rays, {} samples per pixel, {} pixel{})\nTo l = {} and {}: {}",
            self.spp,
            self.pixels,
            if self.pixels == 1 { "" } else { "s" },
            self.l_max,
            self.agreement.estimator,
            self.agreement.text()
        );
        if !self.outputs.is_empty() {
            let panels = self.estimators.iter().map(|found| {
                format!(
                    "{} | difference x {} (grey is 0)",
                    found.name, found.strip_gain
                )
            });
            let panels: Vec<String> = panels.collect();
            let _ = writeln!(
                text,
                "Wrote {} in {}\nstrip.png: double sum | {}",
                self.outputs.join(", "),
                seconds(self.seconds),
                panels.join(" | ")
            );
        }
        text
    }
}
