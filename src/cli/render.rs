//! `ondine render`: arguments to settings, the render, and what becomes of it.

use super::args::{RenderArgs, SettingsArgs};
use super::outputs::Outputs;
use super::progress::Progress;
use super::report::{Report, seconds};
use super::{Outcome, interrupt, memory};
use crate::error::Result;
use crate::film::tonemap::Tonemap;
use crate::film::{MAX_SAMPLES, exr, png};
use crate::render::{Control, Settings, render, workers};
use crate::scene::description::Description;
use std::time::Instant;

pub(super) fn run(args: &RenderArgs) -> Result<Outcome> {
    let begin = Instant::now();
    let scene = args.changes.open(&args.scene)?;
    let load = begin.elapsed();
    for warning in &scene.warnings {
        super::say(format_args!("warning: {warning}"));
    }
    let settings = settings(args, &scene);
    settings.check()?;
    memory::check(
        &settings,
        1,
        "choose a smaller --size, or render parts with --crop",
    )?;
    let outputs = Outputs::new(args.output.as_deref(), !args.no_png, &scene)?;

    let stop = interrupt::listen();
    let paths = settings.region.pixels() as u64 * u64::from(settings.spp);
    let progress = Progress::new(&scene.name, paths, settings.time, args.quiet);
    let control = Control {
        stop,
        progress: &|paths| progress.add(paths),
    };
    let rendered = render(&scene, &settings, &control);
    progress.finish();
    let rendered = rendered?;

    let mut report = Report::new(&scene, &settings, &rendered, load, args.asks_spp());
    if report.paths > 0 {
        write(&report, &rendered.film, &outputs, args)?;
        report.wrote(&outputs);
    }
    if rendered.interrupted {
        super::say(interruption(&report, args.asks_spp()));
    } else if report.samples.min == 0 {
        super::say(
            "warning: time was up before every pixel had a sample; give more --time or a smaller --size",
        );
    }
    if let Some(warning) = report.warning() {
        super::say(warning);
    }
    if args.json {
        super::print_json(&report)?;
    } else if !report.outputs.is_empty() {
        super::print(&report.summary())?;
    }
    Ok(match rendered.interrupted {
        true => Outcome::Interrupted,
        false => Outcome::Done,
    })
}

impl RenderArgs {
    /// Whether the number of samples ends the render; time alone does otherwise.
    fn asks_spp(&self) -> bool {
        self.spp.is_some() || self.time.is_none()
    }
}

impl SettingsArgs {
    /// The scene's settings, with what these arguments change.
    pub fn of(&self, scene: &Description) -> Settings {
        let mut settings = Settings::of(scene);
        if let Some((width, height)) = self.size {
            settings.set_size(width, height);
        }
        Settings {
            camera: self.camera.clone(),
            seed: self.seed.unwrap_or(settings.seed),
            path_length: self.path_length.unwrap_or(settings.path_length),
            strategy: self.strategy.unwrap_or(settings.strategy),
            sampler: self.sampler.unwrap_or(settings.sampler),
            roulette: self.roulette.or(settings.roulette),
            ..settings
        }
    }
}

/// The settings of a render.
fn settings(args: &RenderArgs, scene: &Description) -> Settings {
    let mut settings = args.settings.of(scene);
    if let Some(region) = args.crop {
        settings.region = region;
    }
    if !args.asks_spp() {
        settings.spp = MAX_SAMPLES;
    }
    Settings {
        spp: args.spp.unwrap_or(settings.spp),
        aovs: args.aov.unwrap_or(settings.aovs),
        threads: args.threads.or(settings.threads),
        wave: args.wave,
        bvh: args.bvh,
        time: args.time,
        ..settings
    }
}

/// Writes the files on as many threads as the render had: the image first, which holds everything.
fn write(
    report: &Report,
    film: &crate::film::Film,
    outputs: &Outputs,
    args: &RenderArgs,
) -> Result<()> {
    let metadata = report.metadata();
    let workers = workers(report.threads)?;
    workers.install(|| exr::write(&outputs.exr, film, &metadata))?;
    if let Some(path) = &outputs.png {
        let tonemap = Tonemap {
            operator: args.tonemap,
            exposure: args.exposure,
        };
        png::write(path, film, tonemap).inspect_err(|_| {
            super::say(format_args!(
                "{} is written, and holds everything",
                outputs.exr.display()
            ));
        })?;
    }
    Ok(())
}

fn interruption(report: &Report, spp_asked: bool) -> String {
    let after = seconds(report.render_s);
    if report.outputs.is_empty() {
        return format!("interrupted after {after}, before the first sample; nothing was written");
    }
    let of = match spp_asked {
        true => format!(" of {}", report.spp),
        false => String::new(),
    };
    format!(
        "interrupted after {after}; wrote {} with {}{of} samples per pixel",
        report.outputs.join(" and "),
        report.samples_per_pixel()
    )
}
