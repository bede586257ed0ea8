//! What a batch leaves for other programs: a line for each job as it ends, and a manifest of them all.

use super::plan::{Job, Ready};
use super::run::{Ended, Outcome};
use super::standing::Standing;
use crate::error::{Error, Result};
use crate::film::write_whole;
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A job that came to an end: a line of `--events`.
#[derive(Debug, Serialize)]
struct Event<'a> {
    /// Seconds since 1970-01-01 00:00 UTC.
    time: f64,
    index: usize,
    name: &'a str,
    output: Option<&'a Path>,
    /// `done`, `skipped`, `failed` or `interrupted`.
    outcome: &'static str,
    seconds: f64,
    paths: u64,
    rays: u64,
    image_hash: Option<&'a str>,
    error: Option<&'a str>,
}

/// Bytes of a line of events, at most: names and reasons are shorter.
const LONGEST_EVENT: u64 = 1 << 20;

/// A file that grows by a line for each job that ends.
#[derive(Debug)]
pub struct Events {
    path: PathBuf,
    file: File,
}

impl Events {
    /// Opens the file to add to what is in it.
    ///
    /// # Errors
    /// [`Error::Usage`] where it has something else in it, or its name is that of an image; [`Error::Write`] where it cannot be
    /// opened.
    pub fn append_to(path: &Path) -> Result<Self> {
        let is_image = path.extension().is_some_and(|ending| {
            ["exr", "png"]
                .iter()
                .any(|image| ending.eq_ignore_ascii_case(image))
        });
        if is_image || !has_events(path) {
            return Err(Error::Usage(format!(
                "--events {}: this file is one of something else; name another, as in events.ndjson",
                path.display()
            )));
        }
        let file = OpenOptions::new().create(true).append(true).open(path);
        Ok(Self {
            file: file.map_err(|source| cannot_write(path, source))?,
            path: path.to_owned(),
        })
    }

    /// Adds a line, at once.
    ///
    /// # Errors
    /// [`Error::Write`] where the file does not take it.
    pub fn add(&mut self, job: &Job, ended: &Ended) -> Result<()> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let event = Event {
            time: now.unwrap_or_default().as_secs_f64(),
            index: job.index,
            name: &job.name,
            output: job.ready.as_ref().ok().map(|ready| ready.exr.as_path()),
            outcome: ended.outcome.name(),
            seconds: ended.seconds,
            paths: ended.paths,
            rays: ended.rays,
            image_hash: ended.image_hash.as_deref(),
            error: match &ended.outcome {
                Outcome::Failed(why) => Some(why),
                _ => None,
            },
        };
        let line = serde_json::to_string(&event).map_err(io::Error::other);
        // One call, so that lines of two programs do not mix.
        line.and_then(|line| self.file.write_all((line + "\n").as_bytes()))
            .map_err(|source| cannot_write(&self.path, source))
    }
}

fn cannot_write(path: &Path, source: io::Error) -> Error {
    Error::Write {
        path: path.to_owned(),
        source,
    }
}

/// A job of the manifest.
#[derive(Debug, Serialize)]
pub struct Entry<'a> {
    index: usize,
    name: &'a str,
    output: Option<&'a Path>,
    png: Option<PathBuf>,
    scene: &'a str,
    /// What is changed in it: TOML, by key.
    set: BTreeMap<&'a str, &'a str>,
    #[serde(flatten)]
    image: Option<Image<'a>>,
    /// `done`, `missing`, `changed` or `failed`.
    state: &'static str,
    reason: Option<&'a str>,
    image_hash: Option<&'a str>,
}

/// What a job's image is of.
#[derive(Debug, Serialize)]
struct Image<'a> {
    scene_hash: &'a str,
    camera: Option<&'a str>,
    width: u32,
    height: u32,
    /// x0, y0, x1, y1.
    region: [u32; 4],
    spp: u32,
    seed: u64,
    path_length: u32,
    strategy: String,
    sampler: String,
    roulette: Option<u32>,
    aovs: String,
}

impl<'a> Entry<'a> {
    /// Of a job and how far it is.
    pub fn new(job: &'a Job, standing: &'a Standing) -> Self {
        let ready = job.ready.as_ref().ok();
        let changes = job.changes.iter();
        Self {
            index: job.index,
            name: &job.name,
            output: ready.map(|ready| ready.exr.as_path()),
            png: ready.filter(|r| r.png.is_some()).map(Ready::png_path),
            scene: &job.scene,
            set: changes
                .map(|change| (change.key.as_str(), change.value.as_str()))
                .collect(),
            image: ready.map(Image::new),
            state: standing.name(),
            reason: standing.reason(),
            image_hash: match standing {
                Standing::Done { image_hash } => Some(image_hash),
                _ => None,
            },
        }
    }
}

impl<'a> Image<'a> {
    fn new(ready: &'a Ready) -> Self {
        let settings = &ready.settings;
        let r = settings.region;
        Self {
            scene_hash: ready.scene_hash(),
            camera: settings.camera.as_deref(),
            width: settings.width,
            height: settings.height,
            region: [r.x0, r.y0, r.x1, r.y1],
            spp: settings.spp,
            seed: settings.seed,
            path_length: settings.path_length,
            strategy: settings.strategy.to_string(),
            sampler: settings.sampler.to_string(),
            roulette: settings.roulette,
            aovs: settings.aovs.to_string(),
        }
    }
}

/// Whether a file is one of events, as far as its first line tells; one that is not there or empty becomes one, and what is no
/// plain file is not asked.
fn has_events(path: &Path) -> bool {
    let Some(file) = File::open(path).ok().filter(|_| path.is_file()) else {
        return true;
    };
    let mut line = Vec::new();
    let read = BufReader::new(file.take(LONGEST_EVENT)).read_until(b'\n', &mut line);
    let event: Option<Value> = serde_json::from_slice(&line).ok();
    read.is_ok() && (line.is_empty() || event.is_some_and(|event| event["outcome"].is_string()))
}

/// The manifest, beside the job file.
#[derive(Debug)]
pub struct Manifest {
    path: PathBuf,
    /// Not before then, unless it is the last time.
    next: Instant,
}

/// How often the manifest is written, at most.
const INTERVAL: Duration = Duration::from_secs(1);
/// A manifest of many jobs takes long to write: that is at most this part of the time.
const SHARE: u32 = 20;

impl Manifest {
    /// `jobs.manifest.json` of `jobs.toml`.
    pub fn of(jobs: &Path) -> Self {
        Self {
            path: jobs.with_extension("manifest.json"),
            next: Instant::now(),
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What went wrong with jobs the last time, by their names.
    pub fn failures(&self) -> HashMap<String, String> {
        // A manifest that is missing or damaged is no loss: images say themselves what they are.
        let read =
            || -> Option<Value> { serde_json::from_slice(&std::fs::read(&self.path).ok()?).ok() };
        let manifest = read().unwrap_or_default();
        let jobs = manifest["jobs"].as_array();
        let failure = |job: &Value| {
            let failed = job["state"] == "failed";
            let text = |key: &str| job[key].as_str().map(str::to_owned);
            Some((text("name")?, text("reason")?)).filter(|_| failed)
        };
        jobs.into_iter().flatten().filter_map(failure).collect()
    }

    /// Writes it, unless that was done a moment ago.
    ///
    /// # Errors
    /// [`Error::Write`] where it cannot be; what was there stays.
    pub fn update(&mut self, jobs: &[Job], standings: &[Standing]) -> Result<()> {
        match Instant::now() < self.next {
            true => Ok(()),
            false => self.write(jobs, standings),
        }
    }

    /// Writes it.
    ///
    /// # Errors
    /// [`Error::Write`] where it cannot be; what was there stays.
    pub fn write(&mut self, jobs: &[Job], standings: &[Standing]) -> Result<()> {
        let begin = Instant::now();
        write_whole(&self.path, |file| {
            write!(
                file,
                "{{\"version\":1,\"program\":\"ondine {}\",\"jobs\":[",
                env!("CARGO_PKG_VERSION")
            )?;
            for (number, (job, standing)) in jobs.iter().zip(standings).enumerate() {
                file.write_all(if number == 0 { b"\n" } else { b",\n" })?;
                serde_json::to_writer(&mut *file, &Entry::new(job, standing))?;
            }
            file.write_all(b"\n]}\n")
        })?;
        self.next = Instant::now() + INTERVAL.max(begin.elapsed() * SHARE);
        Ok(())
    }
}
