//! `ondine batch`: the jobs of a file, those that are not there yet rendered.

mod plan;

use super::args::{seconds as time_span, threads, within};
use super::outputs::is_same;
use super::progress::{Progress, metric};
use super::report::{counted, seconds};
use super::target::target_features;
use super::{Outcome, interrupt, memory};
use crate::batch::cluster::MOST_SHARDS;
use crate::batch::file::JobFile;
use crate::batch::plan::{Job, expand};
use crate::batch::record::{Entry, Events, Manifest};
use crate::batch::run::{self, Control, Ended};
use crate::batch::scenes::Scenes;
use crate::batch::standing::Standing;
use crate::error::{Error, Result};
use clap::Args;
use glob::Pattern;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples:
  ondine batch jobs.toml --dry-run             what would be rendered
  ondine batch jobs.toml                       renders what is missing or changed; again, it goes on where it ended
  ondine batch jobs.toml --only '*front*' --events events.ndjson
  ondine batch jobs.toml --status              what is done, and what is not
  ondine batch jobs.toml --plan cluster --shards 16    for several machines: a folder of scripts
  ondine batch --status cluster                which of its shards are missing, and what makes them

A job file:
  version = 1
  [defaults]                                   # any key of a job
  spp = 64
  [[jobs]]
  scene = \"ball.toml\"                          # beside the job file, or a built-in scene; or a list
  cameras = [\"front\", \"side\"]                  # or \"all\"; without it the first
  set = { \"materials.ball.roughness\" = [0.1, 0.2, 0.4] }
  seed = [0, 1]                                # each list is an axis: these are 12 images
  output = \"out/{scene}-{camera}-r{roughness}-{seed}.exr\"

Keys: scene cameras set output size spp seed path_length strategy sampler roulette crop aov png tonemap exposure.

Exit codes: 0 all is done, 1 a job failed (with --status: not all is done), 2 the job file is wrong, 130 interrupted.";

/// Render the jobs of a file: scenes, cameras, parameters
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct BatchArgs {
    /// The job file; with --status also the folder of a plan
    #[arg(value_name = "JOBS.toml")]
    jobs: PathBuf,

    /// Only jobs whose output or scene this matches, as in '*front*'; may be given several times
    #[arg(long, value_name = "PATTERN", help_heading = "Jobs")]
    only: Vec<String>,
    /// List the jobs, and render nothing
    #[arg(long, help_heading = "Jobs")]
    dry_run: bool,
    /// Tell what is done and what is not, and render nothing
    #[arg(long, help_heading = "Jobs", conflicts_with = "dry_run")]
    status: bool,

    /// Write command lines and Slurm scripts that render the jobs on several machines to this folder, and render nothing
    #[arg(long, value_name = "DIR", help_heading = "Several machines", conflicts_with_all = ["dry_run", "status"])]
    plan: Option<PathBuf>,
    /// Shards of each image
    #[arg(long, value_name = "N", help_heading = "Several machines", default_value_t = 1, requires = "plan",
          allow_negative_numbers = true, value_parser = shards)]
    shards: u32,

    /// Add a line of JSON to this file as each job ends
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with_all = ["dry_run", "status", "plan"])]
    events: Option<PathBuf>,
    /// Print one JSON object on stdout instead of a summary
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Show no progress bar
    #[arg(short, long, help_heading = "Output")]
    quiet: bool,

    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", help_heading = "Running",
          allow_negative_numbers = true, value_parser = threads)]
    threads: Option<usize>,
    /// Keep what there is of each image from time to time, to go on from after a crash
    #[arg(long, value_name = "SECONDS", help_heading = "Running",
          allow_negative_numbers = true, value_parser = time_span)]
    checkpoint: Option<Duration>,
}

fn shards(text: &str) -> std::result::Result<u32, String> {
    within(text, 1, MOST_SHARDS as usize).map(|shards| shards as u32)
}

pub(super) fn run(args: &BatchArgs) -> Result<Outcome> {
    if args.status && args.jobs.is_dir() {
        return plan::status(&args.jobs, args.json);
    }
    let file = JobFile::read(&args.jobs)?;
    let mut scenes = Scenes::default();
    let jobs = expand(&file, &mut |scene, changes| scenes.open(scene, changes))?;
    for warning in scenes.take_warnings() {
        super::say(format_args!("warning: {warning}"));
    }
    let manifest = Manifest::of(&args.jobs);
    let batch = Batch {
        chosen: chosen(&jobs, &args.only)?,
        standings: standings(&jobs, &manifest),
        jobs,
    };
    match &args.plan {
        Some(folder) => plan::write(&batch, folder, args.shards, args.json),
        None if args.dry_run || args.status => list(args, &batch),
        None => render(args, batch, &mut scenes, manifest),
    }
}

/// The jobs of a file, how far each is, and which of them are asked for.
struct Batch {
    jobs: Vec<Job>,
    standings: Vec<Standing>,
    chosen: Vec<bool>,
}

impl Batch {
    /// Those that are asked for.
    fn chosen(&self) -> impl Iterator<Item = (&Job, &Standing)> {
        let all = self.jobs.iter().zip(&self.standings).zip(&self.chosen);
        all.filter(|(_, chosen)| **chosen).map(|(job, _)| job)
    }

    fn count(&self, state: &str) -> usize {
        let of = |(_, standing): &(&Job, &Standing)| standing.name() == state;
        self.chosen().filter(of).count()
    }
}

/// Which jobs any of the patterns matches; all without one.
fn chosen(jobs: &[Job], only: &[String]) -> Result<Vec<bool>> {
    let pattern = |text: &String| {
        Pattern::new(text).map_err(|error| {
            Error::Usage(format!(
                "--only {text}: {}; write * for any text, ? for a letter, [ab] for one of some",
                error.msg
            ))
        })
    };
    let patterns = only.iter().map(pattern).collect::<Result<Vec<_>>>()?;
    let matches = |job: &Job| {
        let named = |pattern: &Pattern| pattern.matches(&job.name) || pattern.matches(&job.scene);
        patterns.is_empty() || patterns.iter().any(named)
    };
    let chosen: Vec<bool> = jobs.iter().map(matches).collect();
    match chosen.contains(&true) {
        true => Ok(chosen),
        false => Err(Error::Usage(format!(
            "--only {}: none of {} is called so; --dry-run lists them",
            only.join(" --only "),
            counted(jobs.len(), "job")
        ))),
    }
}

/// How far each job is; what failed the last time says why, until it is rendered.
fn standings(jobs: &[Job], manifest: &Manifest) -> Vec<Standing> {
    let failures = manifest.failures();
    let standing = |job: &Job| match (Standing::of(job), failures.get(&job.name)) {
        (Standing::Missing, Some(why)) => Standing::Failed(why.clone()),
        (standing, _) => standing,
    };
    jobs.iter().map(standing).collect()
}

/// What `--status` and `--dry-run` print with `--json`.
#[derive(Serialize)]
struct Listing<'a> {
    done: usize,
    missing: usize,
    changed: usize,
    failed: usize,
    jobs: Vec<Entry<'a>>,
}

/// Lists all jobs, or those that are not done, and renders nothing.
fn list(args: &BatchArgs, batch: &Batch) -> Result<Outcome> {
    let shown = || {
        let jobs = batch.chosen();
        jobs.filter(|(_, standing)| args.dry_run || standing.name() != "done")
    };
    let counts = ["done", "missing", "changed", "failed"].map(|state| batch.count(state));
    if args.json {
        let [done, missing, changed, failed] = counts;
        super::print_json(&Listing {
            done,
            missing,
            changed,
            failed,
            jobs: shown().map(|(job, of)| Entry::new(job, of)).collect(),
        })?;
    } else {
        let mut text = String::new();
        for (job, standing) in shown() {
            let why = standing.reason().map(|why| format!(": {why}"));
            let why = why.unwrap_or_default();
            let _ = writeln!(text, "{:<8} {}{why}", standing.name(), job.name);
        }
        let [done, missing, changed, failed] = counts;
        let _ = writeln!(
            text,
            "{}: {done} done, {missing} missing, {changed} changed, {failed} failed",
            counted(counts.iter().sum::<usize>(), "job")
        );
        super::print(&text)?;
    }
    let all_is_done = counts[1..].iter().all(|&count| count == 0);
    Ok(match args.status && !all_is_done {
        true => Outcome::Differs,
        false => Outcome::Done,
    })
}

/// What `batch --json` prints.
#[derive(Debug, Default, Serialize)]
struct Report {
    jobs: usize,
    done: usize,
    skipped: usize,
    failed: usize,
    /// Not begun or not finished, as it was interrupted.
    remaining: usize,
    seconds: f64,
    paths: u64,
    rays: u64,
    mpaths_per_s: f64,
    rejected_samples: u64,
    failures: Vec<Failure>,
    manifest: String,
    interrupted: bool,
}

/// A job that failed.
#[derive(Debug, Serialize)]
struct Failure {
    index: usize,
    name: String,
    error: String,
}

/// Renders what is missing or changed.
fn render(
    args: &BatchArgs,
    batch: Batch,
    scenes: &mut Scenes,
    mut manifest: Manifest,
) -> Result<Outcome> {
    let mut events = events(args, &manifest)?;
    let Batch {
        jobs,
        mut standings,
        chosen,
    } = batch;
    // Where nothing can be recorded, nothing is begun.
    manifest.write(&jobs, &standings)?;
    let mut report = Report {
        manifest: manifest.path().display().to_string(),
        ..Report::default()
    };
    let mut waiting = Vec::new();
    let mut ended_at_once = Vec::new();
    for (job, _) in jobs.iter().zip(&chosen).filter(|(_, chosen)| **chosen) {
        report.jobs += 1;
        match (&job.ready, &standings[job.index]) {
            (Err(why), _) => ended_at_once.push((job, failed(why))),
            (_, Standing::Done { image_hash }) => ended_at_once.push((job, skipped(image_hash))),
            _ => waiting.push(job),
        }
    }
    let paths = waiting.iter().filter_map(|job| job.ready.as_ref().ok());
    let paths = paths.map(|ready| ready.paths()).sum();
    let progress = Progress::of_jobs(waiting.len(), paths, args.quiet);
    let begin = Instant::now();
    let mut ended = |job: &Job, ended: Ended| {
        if let Some(events) = &mut events {
            events.add(job, &ended)?;
        }
        // What was not traced of it is not waited for.
        if let Ok(ready) = &job.ready
            && ended.outcome != run::Outcome::Skipped
        {
            progress.job(ready.paths().saturating_sub(ended.paths));
        }
        report.add(job, &ended);
        if let Some(standing) = standing(ended) {
            standings[job.index] = standing;
        }
        manifest.update(&jobs, &standings)
    };
    let listened = ended_at_once
        .into_iter()
        .try_for_each(|(job, of)| ended(job, of));
    let stop = interrupt::listen();
    let ran = listened.and_then(|()| {
        let control = Control {
            stop,
            progress: &|paths| progress.add(paths),
            threads: args.threads,
            checkpoint: args.checkpoint,
            target_features: &target_features(),
            fits: &|settings| {
                memory::check(settings, 1, "choose a smaller size, or parts with crop")
            },
            ended: &mut ended,
        };
        run::run(&waiting, scenes, control)
    });
    progress.finish();
    // What is done is done, whatever ended the batch.
    let recorded = manifest.write(&jobs, &standings);
    ran.and(recorded)?;
    report.seconds = begin.elapsed().as_secs_f64();
    report.mpaths_per_s = report.paths as f64 / report.seconds.max(1e-9) / 1e6;
    report.remaining = report.jobs - report.done - report.skipped - report.failed;
    report.interrupted = report.remaining > 0 && stop.load(Ordering::Relaxed);
    report.tell(args.json)
}

/// The file of events, open.
fn events(args: &BatchArgs, manifest: &Manifest) -> Result<Option<Events>> {
    let Some(path) = &args.events else {
        return Ok(None);
    };
    if is_same(path, &args.jobs) || is_same(path, manifest.path()) {
        return Err(Error::Usage(format!(
            "--events {}: this file is used already; name another",
            path.display()
        )));
    }
    Events::append_to(path).map(Some)
}

fn skipped(image_hash: &str) -> Ended {
    Ended {
        outcome: run::Outcome::Skipped,
        image_hash: Some(image_hash.to_owned()),
        ..Ended::default()
    }
}

fn failed(why: &str) -> Ended {
    Ended {
        outcome: run::Outcome::Failed(why.to_owned()),
        ..Ended::default()
    }
}

/// How far a job is once it ended; as it was, where it was interrupted.
fn standing(ended: Ended) -> Option<Standing> {
    match ended.outcome {
        run::Outcome::Done | run::Outcome::Skipped => Some(Standing::Done {
            image_hash: ended.image_hash.unwrap_or_default(),
        }),
        run::Outcome::Failed(why) => Some(Standing::Failed(why)),
        run::Outcome::Interrupted => None,
    }
}

impl Report {
    fn add(&mut self, job: &Job, ended: &Ended) {
        self.paths += ended.paths;
        self.rays += ended.rays;
        self.rejected_samples += ended.rejected;
        match &ended.outcome {
            run::Outcome::Done => self.done += 1,
            run::Outcome::Skipped => self.skipped += 1,
            run::Outcome::Interrupted => {}
            run::Outcome::Failed(why) => {
                self.failed += 1;
                self.failures.push(Failure {
                    index: job.index,
                    name: job.name.clone(),
                    error: why.clone(),
                });
            }
        }
    }

    /// What came of it, and the exit code of that.
    fn tell(&self, json: bool) -> Result<Outcome> {
        if self.rejected_samples > 0 {
            super::say(format_args!(
                "warning: {} of {} samples were not finite or not below 2^32, and are kept out of the images; look for \
                 radiances or shapes of absurd size in the scenes",
                self.rejected_samples, self.paths
            ));
        }
        for failure in &self.failures {
            super::say(format_args!("failed: {}: {}", failure.name, failure.error));
        }
        if self.interrupted {
            super::say(format_args!(
                "interrupted after {}; {} of {} remain, and the same command goes on with them",
                seconds(self.seconds),
                self.remaining,
                counted(self.jobs, "job")
            ));
        }
        match json {
            true => super::print_json(self)?,
            false => super::print(&self.summary())?,
        }
        Ok(match (self.interrupted, self.failed) {
            (true, _) => Outcome::Interrupted,
            (false, 0) => Outcome::Done,
            (false, _) => Outcome::Differs,
        })
    }

    /// For people.
    fn summary(&self) -> String {
        let speed = match self.paths {
            0 => String::new(),
            _ => format!(", {} paths/s", metric(self.mpaths_per_s * 1e6)),
        };
        format!(
            "{}: {} rendered, {} done before, {} failed, in {}{speed}\n",
            counted(self.jobs, "job"),
            self.done,
            self.skipped,
            self.failed,
            seconds(self.seconds),
        )
    }
}
