//! `ondine batch`, where there is something to render: what comes of each job is recorded as it ends.

use super::super::outputs::is_same;
use super::super::progress::{Progress, metric};
use super::super::report::{counted, seconds};
use super::super::target::target_features;
use super::super::{Outcome, interrupt, memory, print, print_json, say};
use super::{Batch, BatchArgs};
use crate::batch::plan::Job;
use crate::batch::record::{Events, Manifest};
use crate::batch::run::{self, Control, Ended};
use crate::batch::scenes::Scenes;
use crate::batch::standing::Standing;
use crate::error::{Error, Result};
use crate::film::remove_leftovers;
use crate::resume;
use crate::stats::peak_rss_bytes;
use serde::Serialize;
use std::sync::atomic::Ordering;
use std::time::Instant;

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
    peak_rss_bytes: Option<u64>,
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
pub(super) fn run(
    args: &BatchArgs,
    batch: Batch,
    scenes: &mut Scenes,
    mut manifest: Manifest,
) -> Result<Outcome> {
    let events = events(args, &manifest)?;
    let Batch {
        jobs,
        standings,
        chosen,
    } = batch;
    remove_leftovers(manifest.path());
    // Where nothing can be recorded, nothing is begun.
    manifest.write(&jobs, &standings)?;
    let mut record = Record {
        jobs: &jobs,
        standings,
        events,
        lost: None,
        report: Report {
            manifest: manifest.path().display().to_string(),
            ..Report::default()
        },
        manifest,
    };
    let begin = Instant::now();
    let waiting = record.begin(&chosen);
    let paths = waiting.iter().filter_map(|job| job.ready.as_ref().ok());
    let paths = paths.map(|ready| ready.paths()).sum();
    let progress = Progress::of_jobs(waiting.len(), paths, args.quiet);
    let stop = interrupt::listen();
    let mut ended = |job: &Job, ended: Ended| {
        // What was not traced of it is not waited for.
        let paths = job.ready.as_ref().map_or(0, |ready| ready.paths());
        progress.job(paths.saturating_sub(ended.paths));
        record.add(job, ended);
    };
    let control = Control {
        stop,
        progress: &|paths| progress.add(paths),
        threads: args.threads,
        checkpoint: Some(args.checkpoint.unwrap_or(resume::INTERVAL)),
        memory: memory::for_films(),
        target_features: &target_features(),
        fits: &|settings| memory::check(settings, 1, "choose a smaller size, or parts with crop"),
        warn: &|message| progress.say(format_args!("warning: {message}")),
        ended: &mut ended,
    };
    let ran = run::run(&waiting, scenes, control);
    progress.finish();
    let recorded = record.manifest.write(&jobs, &record.standings);
    ran?;
    let Record {
        mut report, lost, ..
    } = record;
    report.seconds = begin.elapsed().as_secs_f64();
    report.peak_rss_bytes = peak_rss_bytes();
    report.mpaths_per_s = report.paths as f64 / report.seconds.max(1e-9) / 1e6;
    report.remaining = report.jobs - report.done - report.skipped - report.failed;
    report.interrupted = report.remaining > 0 && stop.load(Ordering::Relaxed);
    let outcome = report.tell(args.json)?;
    // The images are there all the same.
    recorded?;
    match lost {
        Some(error) => Err(error),
        None => Ok(outcome),
    }
}

/// What is known of the jobs, and who is told.
struct Record<'a> {
    jobs: &'a [Job],
    standings: Vec<Standing>,
    events: Option<Events>,
    /// Why there are no further events.
    lost: Option<Error>,
    report: Report,
    manifest: Manifest,
}

impl<'a> Record<'a> {
    /// Takes note of those that are done and of those that cannot be rendered; the others.
    fn begin(&mut self, chosen: &[bool]) -> Vec<&'a Job> {
        let mut waiting = Vec::new();
        let chosen = self.jobs.iter().zip(chosen).filter(|(_, chosen)| **chosen);
        for (job, _) in chosen {
            self.report.jobs += 1;
            let ended = match (&job.ready, &self.standings[job.index]) {
                (Err(why), _) => failed(why),
                (_, Standing::Done { image_hash }) => skipped(image_hash),
                _ => {
                    waiting.push(job);
                    continue;
                }
            };
            self.add(job, ended);
        }
        waiting
    }

    /// A job ended.
    fn add(&mut self, job: &Job, ended: Ended) {
        if let Some(events) = &mut self.events
            && let Err(error) = events.add(job, &ended)
        {
            // Images matter more; but it is not passed over.
            (self.events, self.lost) = (None, Some(error));
        }
        self.report.add(job, &ended);
        if let Some(standing) = standing(ended) {
            self.standings[job.index] = standing;
        }
        // What fails now is tried again, and told of at the end.
        let _ = self.manifest.update(self.jobs, &self.standings);
    }
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
            say(format_args!(
                "warning: {} of {} samples were not finite or not below 2^32, and are kept out of the images; look for \
                 radiances or shapes of absurd size in the scenes",
                self.rejected_samples, self.paths
            ));
        }
        for failure in &self.failures {
            say(format_args!("failed: {}: {}", failure.name, failure.error));
        }
        if self.interrupted {
            say(format_args!(
                "interrupted after {}; {} of {} remain, and the same command goes on with them",
                seconds(self.seconds),
                self.remaining,
                counted(self.jobs, "job")
            ));
        }
        match json {
            true => print_json(self)?,
            false => print(&self.summary())?,
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
