//! `ondine render`: arguments to settings, the render, and what becomes of it.

use super::args::{PictureArgs, RenderArgs, SettingsArgs, WorkerArgs};
use super::outputs::{Outputs, spare_inputs};
use super::progress::Progress;
use super::report::{Report, Samples, counted, seconds};
use super::target::target_features;
use super::{Outcome, interrupt, memory};
use crate::error::{Error, Result};
use crate::film::tonemap::Tonemap;
use crate::film::{Film, MAX_SAMPLES, Metadata, exr, png, remove_leftovers};
use crate::render::{
    Checkpoint, Continuation, Control, Rendered, Settings, all_processors, render_on, workers,
};
use crate::resume::{self, Before, Other};
use crate::scene::description::Description;
use crate::stats::Stats;
use crate::wavefront;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub(super) fn run(args: &RenderArgs) -> Result<Outcome> {
    let begin = Instant::now();
    let scene = args.changes.open(&args.scene)?;
    let load = begin.elapsed();
    for warning in &scene.warnings {
        super::say(format_args!("warning: {warning}"));
    }
    if let Some(hash) = args.scene_hash.as_ref().filter(|hash| **hash != scene.hash) {
        return Err(Error::Usage(format!(
            "{}: the scene or a file it names was changed: its hash is {}, and {hash} is asked for with --scene-hash",
            scene.name, scene.hash
        )));
    }
    let settings = settings(args, &scene);
    settings.check()?;
    if settings.shard.is_some() && !args.asks_spp() {
        return Err(Error::Usage(
            "--shard is a part of a number of samples, and --time sets none; add --spp".to_owned(),
        ));
    }
    memory::check(
        &settings,
        1,
        "choose a smaller --size, or render parts with --crop or --shard",
    )?;
    let wanted = resume::wanted(&scene, &settings, &target_features());
    // The picture of a shard shows little.
    let png = !args.picture.no_png && settings.shard.is_none();
    let outputs = Outputs::new(args.output.as_deref(), png, &scene, settings.shard)?;
    check_checkpoint(args, &outputs, &scene)?;
    let mut before = match args.resume {
        true => {
            remove_leftovers(&outputs.exr);
            resume::find(&outputs.exr, &wanted, Other::Refuse, &|error| {
                let then = "its samples are rendered anew";
                super::say(format_args!("warning: {error}; {then}"));
            })?
        }
        false => None,
    };
    let whole = |before: &mut Before| before.metadata.blocks.contains(&settings.coverage());
    if let Some(before) = before.take_if(whole) {
        return already(before, args, &settings, &outputs, load);
    }
    let earlier = before.as_ref().map(|before| before.metadata.clone());
    let reached = |rendered: &Rendered| {
        let mut metadata = resume::reached(&wanted.metadata, rendered, earlier.as_ref());
        if !args.asks_spp() {
            // Without an end of its own, a render's samples are as many as there was time for.
            metadata.spp = metadata.samples().1.max(1);
        }
        metadata
    };
    let rendered = go_on(args, &scene, &settings, &outputs, before, &reached)?;

    let metadata = reached(&rendered);
    let mut report = Report::new(&metadata, &settings, &rendered, load);
    if !rendered.coverage.is_empty() {
        write(&report, &rendered.film, &metadata, &outputs, args)?;
        report.wrote(&outputs);
        if args.keeps_checkpoints() {
            resume::discard_checkpoint(&outputs.exr, &metadata);
        }
    }
    if rendered.interrupted {
        super::say(interruption(&report, args.asks_spp()));
    } else if report.samples.min == 0 && settings.shard.is_none() {
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

/// Makes sure that no checkpoint of an earlier render, and no file of the scene, is lost to this one's.
fn check_checkpoint(args: &RenderArgs, outputs: &Outputs, scene: &Description) -> Result<()> {
    let path = resume::checkpoint(&outputs.exr);
    if args.keeps_checkpoints() {
        spare_inputs(&path, scene)?;
    }
    match (path.exists() && !args.resume, args.checkpoint) {
        (true, Some(_)) => Err(Error::format(
            &path,
            "an earlier render left this checkpoint; add --resume to go on from it, or delete it to begin anew",
        )),
        (true, None) => {
            let path = path.display();
            super::say(format_args!(
                "note: {path} is the checkpoint of an earlier render, and stays; --resume would go on from it"
            ));
            Ok(())
        }
        (false, _) => Ok(()),
    }
}

/// Renders what is not there before, with checkpoints if they are asked for.
fn go_on(
    args: &RenderArgs,
    scene: &Description,
    settings: &Settings,
    outputs: &Outputs,
    before: Option<Before>,
    reached: &(dyn Fn(&Rendered) -> Metadata + Sync),
) -> Result<Rendered> {
    let stop = interrupt::listen();
    let all = settings.coverage();
    let todo = match &before {
        Some(before) => all.without(&before.metadata.blocks),
        None => all,
    };
    let paths = todo.paths(settings.region.pixels() as u64, settings.spp);
    if let Some(Before { path, metadata, .. }) = &before {
        let (min, max) = metadata.samples();
        super::say(format_args!(
            "going on from {} with {} per pixel",
            path.display(),
            counted(Samples { min, max }, "sample")
        ));
    }
    let progress = Progress::new(&scene.name, paths, settings.time, args.quiet);
    let control = Control {
        stop,
        progress: &|paths| progress.add(paths),
    };
    let checkpoint = resume::checkpoint(&outputs.exr);
    // Those who trace wait meanwhile.
    let writers = workers(settings.threads.unwrap_or_else(all_processors))?;
    let keep = |so_far: &Rendered| {
        let write = || exr::write(&checkpoint, &so_far.film, &reached(so_far));
        if let Err(error) = writers.install(write) {
            progress.say(format_args!("warning: no checkpoint this time: {error}"));
        }
    };
    let every = args.checkpoint.or(args.resume.then_some(resume::INTERVAL));
    let continuation = Continuation {
        before: before.map(|before| (before.film, before.metadata.blocks)),
        checkpoint: every.map(|every| Checkpoint { every, keep: &keep }),
    };
    let rendered = render_on(wavefront::trace, scene, settings, continuation, &control);
    progress.finish();
    rendered
}

/// There is nothing to render: the image is whole already.
fn already(
    before: Before,
    args: &RenderArgs,
    settings: &Settings,
    outputs: &Outputs,
    load: Duration,
) -> Result<Outcome> {
    let rendered = Rendered {
        film: Arc::new(before.film),
        coverage: before.metadata.blocks.clone(),
        stats: Stats::default(),
        interrupted: false,
    };
    let mut report = Report::new(&before.metadata, settings, &rendered, load);
    if before.path != outputs.exr {
        write(&report, &rendered.film, &before.metadata, outputs, args)?;
    } else if let Some(png) = &outputs.png {
        // Its curve and exposure may be others.
        args.picture.write(png, &outputs.exr, &rendered.film)?;
    }
    resume::discard_checkpoint(&outputs.exr, &before.metadata);
    report.wrote(outputs);
    match args.json {
        true => super::print_json(&report)?,
        false => super::print(&format!(
            "{} has all of it already\nImage hash {}\n",
            outputs.exr.display(),
            report.image_hash
        ))?,
    }
    Ok(Outcome::Done)
}

impl RenderArgs {
    /// Whether there are checkpoints.
    fn keeps_checkpoints(&self) -> bool {
        self.resume || self.checkpoint.is_some()
    }

    /// Whether the number of samples ends the render; time alone does otherwise.
    fn asks_spp(&self) -> bool {
        self.spp.is_some() || self.samples.is_some() || self.time.is_none()
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

impl WorkerArgs {
    /// The settings with these arguments.
    pub fn of(&self, settings: Settings) -> Settings {
        Settings {
            threads: self.threads.or(settings.threads),
            wave: self.wave,
            bvh: self.bvh,
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
    let samples = args.samples.clone().unwrap_or(0..settings.spp);
    args.workers.of(Settings {
        spp: args.spp.unwrap_or(samples.end),
        first_sample: samples.start,
        shard: args.shard,
        aovs: args.aov.unwrap_or(settings.aovs),
        time: args.time,
        ..settings
    })
}

/// Writes the files on as many threads as the render had: the image first, which holds everything.
fn write(
    report: &Report,
    film: &Film,
    metadata: &Metadata,
    outputs: &Outputs,
    args: &RenderArgs,
) -> Result<()> {
    let workers = workers(report.threads)?;
    workers.install(|| exr::write(&outputs.exr, film, metadata))?;
    match &outputs.png {
        Some(path) => args.picture.write(path, &outputs.exr, film),
        None => Ok(()),
    }
}

impl PictureArgs {
    /// Writes the picture beside an image that is written.
    ///
    /// # Errors
    /// [`Error::Write`](crate::error::Error::Write).
    pub fn write(&self, path: &Path, image: &Path, film: &Film) -> Result<()> {
        let tonemap = Tonemap {
            operator: self.tonemap,
            exposure: self.exposure,
        };
        png::write(path, film, tonemap).inspect_err(|_| {
            super::say(format_args!(
                "{} is written, and holds everything",
                image.display()
            ));
        })
    }
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
        report.samples
    )
}
