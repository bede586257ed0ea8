//! `ondine batch`: the jobs of a file, those that are not there yet rendered.

mod plan;
mod render;

use super::Outcome;
use super::args::{seconds as time_span, threads, within};
use super::report::counted;
use crate::batch::cluster::MOST_SHARDS;
use crate::batch::file::JobFile;
use crate::batch::plan::{Job, expand};
use crate::batch::record::{Entry, Manifest};
use crate::batch::scenes::Scenes;
use crate::batch::standing::Standing;
use crate::error::{Error, Result};
use clap::Args;
use glob::Pattern;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

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
    #[arg(long, value_name = "N", help_heading = "Running", conflicts_with_all = ["dry_run", "status", "plan"],
          allow_negative_numbers = true, value_parser = threads)]
    threads: Option<usize>,
    /// Keep what there is of each image under way that often, to go on from after a crash [default: 60]
    #[arg(long, value_name = "SECONDS", help_heading = "Running", conflicts_with_all = ["dry_run", "status", "plan"],
          allow_negative_numbers = true, value_parser = time_span)]
    checkpoint: Option<Duration>,
}

fn shards(text: &str) -> std::result::Result<u32, String> {
    within(text, 1, MOST_SHARDS as usize).map(|shards| shards as u32)
}

pub(super) fn run(args: &BatchArgs) -> Result<Outcome> {
    if args.status && args.jobs.is_dir() {
        if !args.only.is_empty() {
            return Err(Error::Usage(
                "--only: the status of a plan's folder is that of all of it; leave it out, or name the job file"
                    .to_owned(),
            ));
        }
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
        None => render::run(args, batch, &mut scenes, manifest),
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
