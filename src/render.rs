//! Floor 5: a whole image, or light probes. Tiles go to rayon workers, one workspace each; nothing but the film is shared.

pub mod double_sum;
pub mod probes;

mod crew;
mod frame;
mod many;
mod plan;
mod settings;
mod words;

pub use frame::{FirstHit, Frame};
pub use many::{Jobs, many};
pub use settings::Settings;
pub use words::{shell_line, shell_quoted};

use crate::error::{Error, Result};
use crate::film::{Coverage, Film};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::description::{Description, NamedCamera};
use crate::stats::Stats;
use crate::wavefront::{self, Context, Wave, Workspace};
use crew::Crew;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Paths of a wave unless asked otherwise: with one material kind its queues take 600 KB, which a core's cache holds.
pub const DEFAULT_WAVE: u32 = 2048;

/// How a render is watched and stopped.
pub struct Control<'a> {
    /// Once true, no further wave begins.
    pub stop: &'a AtomicBool,
    /// Called by workers after each wave with the number of its paths.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

/// What a render goes on from, and leaves behind on its way.
#[derive(Default)]
pub struct Continuation<'a> {
    /// An image of the same settings, and which sample blocks it has.
    pub before: Option<(Film, Coverage)>,
    /// What is done with the image from time to time.
    pub checkpoint: Option<Checkpoint<'a>>,
}

/// What is done with an image from time to time, while no wave of it is under way.
#[derive(Clone, Copy)]
pub struct Checkpoint<'a> {
    /// Time from one to the next.
    pub every: Duration,
    /// Is given the image as it is then.
    pub keep: &'a (dyn Fn(&Rendered) + Sync),
}

/// A finished (or stopped) render.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The pixels.
    pub film: Arc<Film>,
    /// The sample blocks that the film holds.
    pub coverage: Coverage,
    /// What it took.
    pub stats: Stats,
    /// Whether [`Control::stop`] ended it before its last sample.
    pub interrupted: bool,
}

/// Renders a scene.
///
/// # Errors
/// [`Error::Usage`] for a setting out of its range, an unknown camera, or when workers cannot be started.
pub fn render(
    description: &Description,
    settings: &Settings,
    control: &Control,
) -> Result<Rendered> {
    render_by(wavefront::trace, description, settings, control)
}

/// The same, with another way from a wave to the radiance of its paths.
///
/// # Errors
/// As [`render`].
pub fn render_by(
    trace: impl Fn(&Context, &Wave, &mut Workspace) + Sync,
    description: &Description,
    settings: &Settings,
    control: &Control,
) -> Result<Rendered> {
    let alone = Continuation::default();
    render_on(trace, description, settings, alone, control)
}

/// The same, from where another render stopped: the image has the bits of one that was rendered at once.
///
/// # Errors
/// As [`render`]; and [`Error::Usage`] where what it goes on from is another image.
pub fn render_on(
    trace: impl Fn(&Context, &Wave, &mut Workspace) + Sync,
    description: &Description,
    settings: &Settings,
    continuation: Continuation,
    control: &Control,
) -> Result<Rendered> {
    settings.check()?;
    let begin = Instant::now();
    let threads = settings.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let Continuation { before, checkpoint } = continuation;
    let scene = || Arc::new(Scene::compile_with(description, settings.bvh));
    let camera = camera_of(description, settings)?;
    let frame = Frame::new(settings, camera, pool.install(scene), before)?
        .checkpoint_every(checkpoint.map(|checkpoint| checkpoint.every));
    let build = begin.elapsed();

    let begin = Instant::now();
    let deadline = settings.time.and_then(|time| begin.checked_add(time));
    let stopped = || {
        control.stop.load(Ordering::Relaxed) || deadline.is_some_and(|end| Instant::now() >= end)
    };
    let timed = |mut rendered: Rendered| {
        rendered.stats.build = build;
        rendered.stats.render = begin.elapsed();
        rendered.interrupted &= control.stop.load(Ordering::Relaxed);
        rendered
    };
    let keep = |so_far: Rendered| {
        if let Some(checkpoint) = checkpoint {
            (checkpoint.keep)(&timed(so_far));
        }
    };
    let rendered = work(&trace, frame, &pool, &stopped, &keep, control.progress);
    Ok(timed(rendered))
}

/// Renders what a frame lacks, on workers that the caller keeps.
pub fn render_frame(frame: Frame, pool: &rayon::ThreadPool, control: &Control) -> Rendered {
    render_frame_by(&wavefront::trace, frame, pool, control)
}

/// The same, with another way from a wave to the radiance of its paths.
pub fn render_frame_by(
    trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync),
    frame: Frame,
    pool: &rayon::ThreadPool,
    control: &Control,
) -> Rendered {
    let begin = Instant::now();
    let stopped = || control.stop.load(Ordering::Relaxed);
    let mut rendered = work(trace, frame, pool, &stopped, &drop, control.progress);
    rendered.stats.render = begin.elapsed();
    rendered
}

/// Has every worker of a pool trace waves of one image until it has all of them, or is stopped.
fn work(
    trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync),
    frame: Frame,
    pool: &rayon::ThreadPool,
    stopped: &(dyn Fn() -> bool + Sync),
    keep: &(impl Fn(Rendered) + Sync),
    progress: &(dyn Fn(u64) + Sync),
) -> Rendered {
    let crew = Crew::new(pool.current_num_threads(), stopped);
    crew.open(frame, ());
    crew.close();
    let result = OnceLock::new();
    let keep = |(): &(), so_far: Rendered| keep(so_far);
    let end = |_: Arc<()>, rendered: Rendered| {
        // There is one image, and so one end.
        let _ = result.set(rendered);
    };
    pool.broadcast(|_| crew.work(trace, &keep, &end, progress));
    result.into_inner().expect("a crew ends what was opened")
}

/// A thread for each processor.
pub fn all_processors() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Starts worker threads.
///
/// # Errors
/// [`Error::Usage`] where the system does not let so many be started.
pub fn workers(threads: usize) -> Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| {
            Error::Usage(format!(
                "cannot start {threads} threads: {error}; ask for fewer with --threads"
            ))
        })
}

/// The camera of that name; the first without one.
///
/// # Errors
/// [`Error::Usage`] where the scene has none of that name.
pub(crate) fn find_camera<'a>(
    description: &'a Description,
    name: Option<&str>,
) -> Result<&'a NamedCamera> {
    let mut cameras = description.cameras.iter();
    let named = match name {
        None => cameras.next(),
        Some(name) => cameras.find(|camera| camera.name == name),
    };
    named.ok_or_else(|| {
        let cameras = description.cameras.iter();
        let names: Vec<&str> = cameras.map(|camera| camera.name.as_str()).collect();
        Error::Usage(format!(
            "{} has no camera {:?}; it has {}",
            description.name,
            name.unwrap_or_default(),
            names.join(", ")
        ))
    })
}

/// The camera that the settings ask for, for their size.
///
/// # Errors
/// As [`find_camera`].
pub(crate) fn camera_of(description: &Description, settings: &Settings) -> Result<Camera> {
    let named = find_camera(description, settings.camera.as_deref())?;
    Ok(Camera::new(
        &named.camera,
        settings.width,
        settings.height,
        description.film.filter,
    ))
}
