//! Jobs become images, several at a time.

use super::image;
use super::plan::{Job, Ready};
use super::scenes::Scenes;
use super::standing::Standing;
use crate::bvh::Quality;
use crate::error::{Error, Result};
use crate::film::{Metadata, remove_leftovers};
use crate::render::{self, Frame, Jobs, Rendered, Settings, all_processors, camera_of, many};
use crate::resume::{self, Before, Other};
use crate::scene::Scene;
use crate::scene::description::Description;
use crate::scene::trees::Trees;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How a batch is watched and stopped, and what it has of the machine.
pub struct Control<'a> {
    /// Once true, no further wave begins.
    pub stop: &'a AtomicBool,
    /// Called by workers after each wave with the number of its paths.
    pub progress: &'a (dyn Fn(u64) + Sync),
    /// Workers; as many as the machine has cores without it.
    pub threads: Option<usize>,
    /// While films under way take so many bytes, no further image is begun.
    pub memory: u64,
    /// Time from one checkpoint of an image to the next; none without it.
    pub checkpoint: Option<Duration>,
    /// The instruction sets that the program was compiled for, which images name.
    pub target_features: &'a str,
    /// Whether an image fits in memory.
    pub fits: &'a (dyn Fn(&Settings) -> Result<()> + Sync),
    /// Told of what goes wrong and loses nothing.
    pub warn: &'a (dyn Fn(&str) + Sync),
    /// Called as each job ends.
    pub ended: &'a mut Told<'a>,
}

/// Who is told of jobs that end.
pub type Told<'a> = dyn FnMut(&Job, Ended) + Send + 'a;

/// A job that came to an end.
#[derive(Clone, Debug, Default)]
pub struct Ended {
    /// What came of it.
    pub outcome: Outcome,
    /// Seconds from opening its scene until its files were there; other jobs may have been under way.
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
    /// It was stopped; the samples traced until then are in its checkpoint.
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
/// [`Error::Usage`] where threads cannot be started.
pub fn run(jobs: &[&Job], scenes: &mut Scenes, control: Control) -> Result<()> {
    let threads = control.threads.unwrap_or_else(all_processors);
    let queue = Queue {
        desk: Mutex::new(Desk {
            waiting: jobs.iter(),
            scenes,
            compiled: None,
            trees: Trees::default(),
            tidied: HashSet::new(),
        }),
        ended: Mutex::new(control.ended),
        warn: control.warn,
        stop: control.stop,
        checkpoint: control.checkpoint,
        target_features: control.target_features,
        fits: control.fits,
    };
    let watch = render::Control {
        stop: control.stop,
        progress: control.progress,
    };
    many(&queue, threads, control.memory, &watch)
}

/// The jobs that wait, and who is told of those that end.
struct Queue<'a> {
    desk: Mutex<Desk<'a>>,
    ended: Mutex<&'a mut Told<'a>>,
    warn: &'a (dyn Fn(&str) + Sync),
    stop: &'a AtomicBool,
    checkpoint: Option<Duration>,
    target_features: &'a str,
    fits: &'a (dyn Fn(&Settings) -> Result<()> + Sync),
}

struct Desk<'a> {
    waiting: std::slice::Iter<'a, &'a Job>,
    scenes: &'a mut Scenes,
    /// The last scene, compiled: jobs of one scene follow each other.
    compiled: Option<(Arc<Description>, Arc<Scene>)>,
    /// Those of its meshes, which scenes with other materials share.
    trees: Trees,
    /// Folders of images in which nothing is left of killed programs.
    tidied: HashSet<PathBuf>,
}

/// A job under way.
struct Current<'a> {
    job: &'a Job,
    ready: &'a Ready,
    begin: Instant,
    /// What its image will say, but for what is in it.
    wanted: Metadata,
    /// What it goes on from.
    before: Option<Metadata>,
}

/// What a job comes to before it is traced.
enum Made<'a> {
    Frame(Box<(Current<'a>, Frame)>),
    /// There was nothing to trace.
    Ended(Ended),
}

impl<'a> Jobs for Queue<'a> {
    type Job = Current<'a>;

    fn next(&self) -> Option<(Current<'a>, Frame)> {
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return None;
            }
            let mut desk = lock(&self.desk);
            let job = *desk.waiting.next()?;
            let begin = Instant::now();
            let made = self.make(job, begin, &mut desk);
            drop(desk);
            match made {
                Ok(Made::Frame(framed)) => return Some(*framed),
                Ok(Made::Ended(ended)) => self.tell(job, begin, ended),
                Err(error) => self.tell(job, begin, failed(&error)),
            }
        }
    }

    fn keep(&self, current: &Current<'a>, so_far: Rendered) {
        let kept = image::keep(current.ready, &so_far.film, &current.metadata_of(&so_far));
        if let Err(error) = kept {
            (self.warn)(&format!("no checkpoint this time: {error}"));
        }
    }

    fn finish(&self, current: &Current<'a>, rendered: Rendered) {
        let ended = image::finish(current.ready, &rendered, &current.metadata_of(&rendered));
        let ended = ended.unwrap_or_else(|error| failed(&error));
        self.tell(current.job, current.begin, ended);
    }
}

impl<'a> Queue<'a> {
    /// Makes a job ready to be traced.
    fn make(&self, job: &'a Job, begin: Instant, desk: &mut Desk) -> Result<Made<'a>> {
        let ready = job
            .ready
            .as_ref()
            .map_err(|why| Error::Usage(why.clone()))?;
        let standing = Standing::of_image(ready);
        if standing == Standing::WithoutPng {
            match image::develop(ready) {
                // Damaged in its pixels, it is rendered anew.
                Err(Error::Format { .. }) => {}
                ended => return ended.map(Made::Ended),
            }
        }
        let description = desk.scenes.open(&job.scene, &job.changes)?;
        if description.hash != ready.scene_hash() {
            return Err(Error::Usage(format!(
                "{}: the scene was changed while the batch ran; run it again",
                job.scene
            )));
        }
        (self.fits)(&ready.settings)?;
        image::create_folder(&ready.exr)?;
        let wanted = resume::wanted(&description, &ready.settings, self.target_features);
        desk.tidy(&ready.exr);
        let is_new = standing == Standing::Missing && !resume::checkpoint(&ready.exr).exists();
        let before = match is_new {
            true => None,
            // What is damaged, or another image, is replaced.
            false => resume::find(&ready.exr, &wanted, Other::Replace, &|_| ())?,
        };
        let (film, before) = match before {
            Some(Before { film, metadata, .. }) => {
                (Some((film, metadata.blocks.clone())), Some(metadata))
            }
            None => (None, None),
        };
        let camera = camera_of(&description, &ready.settings)?;
        let scene = desk.compiled(description);
        let frame = Frame::new(&ready.settings, camera, scene, film)?;
        let current = Current {
            job,
            ready,
            begin,
            wanted: wanted.metadata,
            before,
        };
        let frame = frame.checkpoint_every(self.checkpoint);
        Ok(Made::Frame(Box::new((current, frame))))
    }

    fn tell(&self, job: &Job, begin: Instant, mut ended: Ended) {
        ended.seconds = begin.elapsed().as_secs_f64();
        lock(&self.ended)(job, ended);
    }
}

impl Desk<'_> {
    /// Removes what killed programs left in the folder of a file: of each folder once, for that takes as long as there are
    /// files.
    fn tidy(&mut self, file: &Path) {
        let folder = file.parent().unwrap_or(Path::new(""));
        if self.tidied.insert(folder.to_owned()) {
            remove_leftovers(file);
        }
    }

    fn compiled(&mut self, description: Arc<Description>) -> Arc<Scene> {
        match &self.compiled {
            Some((of, scene)) if Arc::ptr_eq(of, &description) => scene.clone(),
            _ => {
                // The one before is not needed while the next is built.
                self.compiled = None;
                let quality = Quality::default();
                let scene = Scene::compile_sharing(&description, quality, &mut self.trees);
                let scene = Arc::new(scene);
                self.compiled = Some((description, scene.clone()));
                scene
            }
        }
    }
}

impl Current<'_> {
    /// What the image says as it is now.
    fn metadata_of(&self, rendered: &Rendered) -> Metadata {
        resume::reached(&self.wanted, rendered, self.before.as_ref())
    }
}

fn failed(error: &Error) -> Ended {
    Ended {
        outcome: Outcome::Failed(error.to_string()),
        ..Ended::default()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
