//! `ondine sh probe`: the light that arrives at points of a scene, as coefficients.

use super::super::args::{choice, threads, whole, within};
use super::super::outputs;
use super::super::progress::{Progress, metric};
use super::super::report::{counted, seconds};
use super::super::{Outcome, interrupt, print, print_json, say};
use super::bands;
use crate::error::{Error, Result};
use crate::film::{MAX_SAMPLES, write_whole};
use crate::render::probes::{Baked, BakedProbes, SETS, bake};
use crate::render::{Control, Settings};
use crate::scene::builtin;
use crate::scene::description::{Description, SamplerKind, Strategy};
use crate::sh::{CONVENTION, GRID_FORMAT, coefficients, is_csv};
use crate::stats::StageReport;
use clap::{ArgGroup, Args};
use glam::Vec3;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  ondine sh probe cornell --at 0,0,0
  ondine sh probe cornell --at 0,0,0 --bands 4 --spp 65536 -o probe.json
  ondine sh probe cornell --grid -0.8,-0.8,-0.8:0.8,0.8,2.5:5,5,9 -o probes.json

A probe's file is what `[environment] sh = \"probe.json\"` and the other commands read; a grid's file holds a list of \
probes, each with its position, x fastest. The coefficients depend on scene, settings and seed alone: threads do not \
change a bit of them.";

/// Bake light probes: the light that arrives at points of a scene
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, group(ArgGroup::new("place").required(true).args(["at", "grid"])))]
pub(in crate::cli) struct ProbeArgs {
    /// A scene (.toml, .gltf, .glb, .pbrt), meshes (.obj, .ply), or the name of a built-in scene
    pub scene: String,
    /// Where the probe is, world space
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = point)]
    pub at: Option<Vec3>,
    /// A grid of probes between two corners, and how many along each axis
    #[arg(long, value_name = "x0,y0,z0:x1,y1,z1:nx,ny,nz", allow_hyphen_values = true, value_parser = grid)]
    pub grid: Option<Grid>,
    /// Greatest degree L: (L + 1)² coefficients
    #[arg(long, value_name = "L", default_value_t = 2, allow_negative_numbers = true, value_parser = bands)]
    pub bands: usize,
    /// Samples of each probe; rounded up to a multiple of 16, for they come in 16 independent sets
    #[arg(long, value_name = "N", default_value_t = 4096, allow_negative_numbers = true, value_parser = samples)]
    pub spp: u32,
    /// Seed of the random numbers [default: the scene's, or 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub seed: Option<u64>,
    /// Greatest number of edges of a path, from the probe on: 1 sees lights only [default: the scene's, or 5]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub path_length: Option<u32>,
    /// How light is looked for [default: the scene's, or mis]
    #[arg(long, value_parser = choice::<Strategy>(&["uniform", "cosine", "light", "mis"]))]
    pub strategy: Option<Strategy>,
    /// Where random numbers come from [default: the scene's, or sobol]
    #[arg(long, value_parser = choice::<SamplerKind>(&["pcg", "sobol"]))]
    pub sampler: Option<SamplerKind>,
    /// Write a probe as JSON or CSV, a grid as JSON
    #[arg(short, long, value_name = "PROBE.json")]
    pub output: Option<PathBuf>,
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Print one JSON object on stdout, with all coefficients
    #[arg(long)]
    pub json: bool,
    /// Show no progress bar
    #[arg(short, long)]
    pub quiet: bool,
}

/// Points at equal distances between two corners, both of which belong to it.
#[derive(Clone, Copy, Debug, Serialize)]
pub(in crate::cli) struct Grid {
    from: [f32; 3],
    to: [f32; 3],
    counts: [u32; 3],
}

/// A probe, as JSON has it.
#[derive(Debug, Serialize)]
struct Listed<'a> {
    position: [f32; 3],
    coefficients: &'a [[f64; 3]],
    standard_errors: Option<&'a [[f64; 3]]>,
}

/// The file of a grid.
#[derive(Debug, Serialize)]
struct GridFile<'a> {
    format: &'static str,
    version: u32,
    convention: &'static str,
    quantity: &'static str,
    unit: &'static str,
    source: &'a str,
    l_max: usize,
    grid: Grid,
    /// x fastest.
    probes: Vec<Listed<'a>>,
}

/// What `sh probe --json` prints.
#[derive(Debug, Serialize)]
struct ProbeReport<'a> {
    scene: &'a str,
    scene_hash: &'a str,
    convention: &'static str,
    l_max: usize,
    coefficients: usize,
    spp: u32,
    sets: u32,
    path_length: u32,
    strategy: String,
    sampler: String,
    seed: u64,
    threads: usize,
    paths: u64,
    rays: u64,
    build_s: f64,
    render_s: f64,
    mpaths_per_s: f64,
    mrays_per_s: f64,
    stages: BTreeMap<&'static str, StageReport>,
    rejected_samples: u64,
    outputs: Vec<String>,
    probes: Vec<Listed<'a>>,
}

pub(super) fn run(args: &ProbeArgs) -> Result<Outcome> {
    let scene = builtin::open(&args.scene)?;
    for warning in &scene.warnings {
        say(format_args!("warning: {warning}"));
    }
    let settings = args.settings(&scene);
    let positions = match (args.at, &args.grid) {
        (Some(at), _) => vec![at],
        (None, Some(grid)) => grid.points(),
        (None, None) => Vec::new(),
    };
    if args.grid.is_some()
        && let Some(path) = args.output.as_deref().filter(|path| is_csv(path))
    {
        return Err(Error::Usage(format!(
            "-o {}: a grid is written as JSON; use -o {}",
            path.display(),
            path.with_extension("json").display()
        )));
    }
    if let Some(path) = &args.output {
        outputs::spare_inputs(path, &scene)?;
        outputs::writable(path, &[Path::new(&args.scene)])?;
    }

    let paths = positions.len() as u64 * u64::from(settings.spp.next_multiple_of(SETS));
    let progress = Progress::new(&scene.name, paths, None, args.quiet);
    let control = Control {
        stop: interrupt::listen(),
        progress: &|paths| progress.add(paths),
    };
    let baked = bake(&scene, &positions, args.bands, &settings, &control);
    progress.finish();
    let baked = baked?;
    if baked.probes.len() < positions.len() {
        say("interrupted before the last probe; nothing was written");
        return Ok(Outcome::Interrupted);
    }
    if baked.rejected > 0 {
        say(format_args!(
            "warning: {} of {paths} samples were not finite or not below 2^32, and are kept out of the probes",
            baked.rejected
        ));
    }

    if let Some(path) = &args.output {
        let text = args.file(path, &scene, &baked)?;
        write_whole(path, |file| file.write_all(text.as_bytes()))?;
    }
    match args.json {
        true => print_json(&args.report(&scene, &settings, &baked))?,
        false => print(&args.text(&settings, &baked))?,
    }
    Ok(Outcome::Done)
}

impl ProbeArgs {
    fn settings(&self, scene: &Description) -> Settings {
        let settings = Settings::of(scene);
        Settings {
            spp: self.spp,
            seed: self.seed.unwrap_or(settings.seed),
            path_length: self.path_length.unwrap_or(settings.path_length),
            strategy: self.strategy.unwrap_or(settings.strategy),
            sampler: self.sampler.unwrap_or(settings.sampler),
            threads: self.threads,
            ..settings
        }
    }

    /// What `-o` writes.
    fn file(&self, path: &Path, scene: &Description, baked: &BakedProbes) -> Result<String> {
        let Some(grid) = self.grid else {
            let probe = baked.probes.first();
            return probe.map_or(Ok(String::new()), |baked| baked.probe.to_text(path));
        };
        let file = GridFile {
            format: GRID_FORMAT,
            version: 1,
            convention: CONVENTION,
            quantity: "radiance",
            unit: "W sr^-1 m^-2",
            source: &scene.name,
            l_max: self.bands,
            grid,
            probes: listed(baked),
        };
        let text = serde_json::to_string(&file)
            .map_err(|error| Error::Usage(format!("no JSON can be made: {error}")))?;
        // A line for each probe.
        Ok(text.replace("{\"position\"", "\n{\"position\"") + "\n")
    }

    fn report<'a>(
        &self,
        scene: &'a Description,
        settings: &Settings,
        baked: &'a BakedProbes,
    ) -> ProbeReport<'a> {
        let stats = &baked.stats;
        ProbeReport {
            scene: &scene.name,
            scene_hash: &scene.hash,
            convention: CONVENTION,
            l_max: self.bands,
            coefficients: coefficients(self.bands),
            spp: baked.spp,
            sets: SETS,
            path_length: settings.path_length,
            strategy: settings.strategy.to_string(),
            sampler: settings.sampler.to_string(),
            seed: settings.seed,
            threads: stats.threads,
            paths: stats.paths(),
            rays: stats.rays(),
            build_s: stats.build.as_secs_f64(),
            render_s: stats.render.as_secs_f64(),
            mpaths_per_s: stats.millions_per_second(stats.paths()),
            mrays_per_s: stats.millions_per_second(stats.rays()),
            stages: stats.stages(),
            rejected_samples: baked.rejected,
            outputs: self
                .output
                .iter()
                .map(|path| path.display().to_string())
                .collect(),
            probes: listed(baked),
        }
    }

    /// For people: the coefficients, unless they are in a file.
    fn text(&self, settings: &Settings, baked: &BakedProbes) -> String {
        let mut text = String::new();
        if self.output.is_none() {
            for baked in &baked.probes {
                table(&mut text, baked);
            }
        }
        let (count, stats) = (baked.probes.len(), &baked.stats);
        if let Some(path) = &self.output {
            let _ = write!(text, "Wrote {}: ", path.display());
        }
        let _ = writeln!(
            text,
            "{} to l = {} ({}), {} samples each, path length {}",
            counted(count, "probe"),
            self.bands,
            counted(coefficients(self.bands), "coefficient"),
            baked.spp,
            settings.path_length,
        );
        let _ = writeln!(
            text,
            "Traced {}paths and {}rays in {} on {}: {}paths/s",
            unit(stats.paths() as f64),
            unit(stats.rays() as f64),
            seconds(stats.render.as_secs_f64()),
            counted(stats.threads, "thread"),
            unit(stats.millions_per_second(stats.paths()) * 1e6),
        );
        text
    }
}

/// A number with its prefix, ready for a unit.
fn unit(value: f64) -> String {
    let text = metric(value);
    if text.contains(' ') { text } else { text + " " }
}

/// Coefficients and their standard errors, a line each.
fn table(text: &mut String, Baked { position, probe }: &Baked) {
    let [x, y, z] = position.to_array();
    let _ = writeln!(
        text,
        "Probe at {x}, {y}, {z}: radiance, W sr^-1 m^-2\n   l    m {:>23} {:>23} {:>23}",
        "red", "green", "blue"
    );
    let errors = probe.standard_errors.iter().flatten();
    let mut rows = probe.coefficients.iter().zip(errors);
    for l in 0..=probe.degree {
        let order = l.cast_signed();
        for m in -order..=order {
            let Some((rgb, errors)) = rows.next() else {
                return;
            };
            let _ = write!(text, "{l:>4} {m:>4}");
            for (value, error) in rgb.iter().zip(errors) {
                let _ = write!(text, " {value:>12.6} ± {error:.6}");
            }
            text.push('\n');
        }
    }
}

fn listed(baked: &BakedProbes) -> Vec<Listed<'_>> {
    let probes = baked.probes.iter();
    probes
        .map(|Baked { position, probe }| Listed {
            position: position.to_array(),
            coefficients: &probe.coefficients,
            standard_errors: probe.standard_errors.as_deref(),
        })
        .collect()
}

impl Grid {
    /// Its points, x fastest.
    fn points(&self) -> Vec<Vec3> {
        let [nx, ny, nz] = self.counts;
        let axis = |axis: usize, place: u32| match self.counts[axis] {
            1 => self.from[axis],
            count => {
                let part = f64::from(place) / f64::from(count - 1);
                let (from, to) = (f64::from(self.from[axis]), f64::from(self.to[axis]));
                ((1.0 - part) * from + part * to) as f32
            }
        };
        (0..nx * ny * nz)
            .map(|i| {
                Vec3::new(
                    axis(0, i % nx),
                    axis(1, i / nx % ny),
                    axis(2, i / (nx * ny)),
                )
            })
            .collect()
    }
}

fn samples(text: &str) -> std::result::Result<u32, String> {
    let most = MAX_SAMPLES as usize;
    within(text, 1, most).map(|samples| samples as u32)
}

/// Three numbers between commas.
fn three<T: std::str::FromStr>(text: &str) -> Option<[T; 3]> {
    let numbers: Option<Vec<T>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    numbers?.try_into().ok()
}

fn point(text: &str) -> std::result::Result<Vec3, String> {
    three::<f32>(text)
        .map(Vec3::from)
        .filter(|point| point.is_finite())
        .ok_or_else(|| "write three finite numbers, as in 0,1.5,-2".to_owned())
}

fn grid(text: &str) -> std::result::Result<Grid, String> {
    /// As many as sensors have rows.
    const MOST: u64 = 65_535;
    let wrong = "write two corners and how many along each axis, as in -1,0,-1:1,2,1:5,3,5";
    let parts: Vec<&str> = text.split(':').collect();
    let [from, to, counts] = parts[..] else {
        return Err(wrong.to_owned());
    };
    let (from, to) = (point(from), point(to));
    let (Ok(from), Ok(to), Some(counts)) = (from, to, three::<u32>(counts)) else {
        return Err(wrong.to_owned());
    };
    let count = counts
        .iter()
        .try_fold(1, |product: u64, &count| product.checked_mul(count.into()));
    match count {
        Some(1..=MOST) => Ok(Grid {
            from: from.to_array(),
            to: to.to_array(),
            counts,
        }),
        _ => Err(format!("a grid has 1 to {MOST} probes; {wrong}")),
    }
}
