//! Jobs become images, one after the other.

use super::plan::{Job, Ready};
use super::scenes::Scenes;
use super::standing::Standing;
use crate::error::{Error, Result};
use crate::film::{Film, Metadata, exr, png};
use crate::render::{self, Rendered, Settings, workers};
use crate::scene::description::Description;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How a batch is watched and stopped, and what it has of the machine.
pub struct Control<'a> {
    /// Once true, no further wave begins.
    pub stop: &'a AtomicBool,
    /// Called by workers after each wave with the number of its paths.
    pub progress: &'a (dyn Fn(u64) + Sync),
    /// Workers; as many as the machine has cores without it.
    pub threads: Option<usize>,
    /// The instruction sets that the program was compiled for, which images name.
    pub target_features: &'a str,
    /// Whether an image fits in memory.
    pub fits: &'a dyn Fn(&Settings) -> Result<()>,
    /// Called as each job ends. An error of it ends the batch.
    pub ended: &'a mut dyn FnMut(&Job, Ended) -> Result<()>,
}

/// A job that came to an end.
#[derive(Clone, Debug, Default)]
pub struct Ended {
    /// What came of it.
    pub outcome: Outcome,
    /// How long it took: opening the scene, rendering, writing.
    pub seconds: f64,
    /// Camera paths traced.
    pub paths: u64,
    /// Rays traced.
    pub rays: u64,
    /// Samples that were not finite, or too large, and were kept out of the image.
    pub rejected: u64,
    /// The image's hash, if there is one.
    pub image_hash: Option<String>,
}

/// What came of a job.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// Its files are there.
    #[default]
    Done,
    /// They were before.
    Skipped,
    /// Why there are none.
    Failed(String),
    /// It was stopped; nothing of it is there.
    Interrupted,
}

impl Outcome {
    /// `done`, `skipped`, `failed` or `interrupted`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Skipped => "skipped",
            Self::Failed(_) => "failed",
            Self::Interrupted => "interrupted",
        }
    }
}

/// Renders jobs and writes their files. What fails is told to [`Control::ended`], and the others go on.
///
/// # Errors
/// That of [`Control::ended`].
pub fn run(jobs: &[&Job], scenes: &mut Scenes, control: &mut Control) -> Result<()> {
    for job in jobs {
        if control.stop.load(Ordering::Relaxed) {
            break;
        }
        let begin = Instant::now();
        let mut ended = make(job, scenes, control).unwrap_or_else(|error| Ended {
            outcome: Outcome::Failed(error.to_string()),
            ..Ended::default()
        });
        ended.seconds = begin.elapsed().as_secs_f64();
        (control.ended)(job, ended)?;
    }
    Ok(())
}

/// Makes the files of a job.
fn make(job: &Job, scenes: &mut Scenes, control: &Control) -> Result<Ended> {
    let ready = job
        .ready
        .as_ref()
        .map_err(|why| Error::Usage(why.clone()))?;
    if Standing::of_image(ready) == Standing::WithoutPng {
        return develop(ready);
    }
    let scene = scenes.open(&job.scene, &job.changes)?;
    if *scene.hash != *ready.scene_hash {
        return Err(Error::Usage(format!(
            "{}: the scene was changed while the batch ran; run it again",
            job.scene
        )));
    }
    let settings = Settings {
        threads: control.threads,
        ..ready.settings.clone()
    };
    (control.fits)(&settings)?;
    create_folder(&ready.exr)?;
    let rendered = render::render(
        &scene,
        &settings,
        &render::Control {
            stop: control.stop,
            progress: control.progress,
        },
    )?;
    let mut ended = Ended {
        outcome: Outcome::Interrupted,
        paths: rendered.stats.paths(),
        rays: rendered.stats.rays(),
        rejected: rendered.film.rejected(),
        ..Ended::default()
    };
    if !rendered.interrupted {
        let metadata = metadata(&scene, &settings, &rendered, control.target_features);
        let pool = workers(rendered.stats.threads)?;
        pool.install(|| write(ready, &rendered.film, &metadata))?;
        ended.image_hash = Some(rendered.film.image_hash());
        ended.outcome = Outcome::Done;
    }
    Ok(ended)
}

/// The picture of an image that is there.
fn develop(ready: &Ready) -> Result<Ended> {
    let (film, _) = exr::read(&ready.exr)?;
    if let Some(tonemap) = ready.png {
        png::write(&ready.png_path(), &film, tonemap)?;
    }
    Ok(Ended {
        image_hash: Some(film.image_hash()),
        ..Ended::default()
    })
}

/// The image last: where it is, the job is done.
fn write(ready: &Ready, film: &Film, metadata: &Metadata) -> Result<()> {
    if let Some(tonemap) = ready.png {
        png::write(&ready.png_path(), film, tonemap)?;
    }
    exr::write(&ready.exr, film, metadata)
}

fn create_folder(file: &Path) -> Result<()> {
    let Some(folder) = file.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|source| Error::Write {
        path: folder.to_owned(),
        source,
    })
}

/// What the image says of a render that came to its end.
fn metadata(
    scene: &Description,
    settings: &Settings,
    rendered: &Rendered,
    target_features: &str,
) -> Metadata {
    Metadata {
        scene: scene.name.clone(),
        scene_hash: scene.hash.clone(),
        camera: settings.camera.clone().unwrap_or_default(),
        seed: settings.seed,
        spp: settings.spp,
        sample_ranges: std::iter::once(0..settings.spp).collect(),
        path_length: settings.path_length,
        strategy: settings.strategy.to_string(),
        sampler: settings.sampler.to_string(),
        roulette: settings.roulette,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        target_features: target_features.to_owned(),
        seconds: rendered.stats.render.as_secs_f64(),
        rays: rendered.stats.rays(),
        interrupted: false,
    }
}
