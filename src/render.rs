//! Floor 5: a whole image, or light probes. Tiles go to rayon workers, one workspace each; nothing but the film is shared.

pub mod double_sum;
pub mod probes;

use crate::bvh::Quality;
use crate::error::{Error, Result};
use crate::film::{AovSet, BLOCK, Film, Layers, MAX_SAMPLES, Region};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::description::{Description, MAX_EDGES, MAX_SIDE, SamplerKind, Strategy};
use crate::scene::sensor::Sensor;
use crate::stats::Stats;
use crate::wavefront::{self, Context, Stage, Tally, Wave, Workspace};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Paths of a wave unless asked otherwise: with one material kind its queues take 600 KB, which a core's cache holds.
pub const DEFAULT_WAVE: u32 = 2048;

/// Everything that decides what is rendered and how. All but `threads`, `wave` and `bvh` (and `time`, by how far it lets the
/// samples get) decide the image's bits.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The part of the image that is rendered.
    pub region: Region,
    /// Name of the camera; the scene's first without it.
    pub camera: Option<String>,
    /// Samples per pixel, at least 1.
    pub spp: u32,
    /// Greatest number of edges of a path, at least 1.
    pub path_length: u32,
    /// How light is looked for.
    pub strategy: Strategy,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Seed.
    pub seed: u64,
    /// First path edge at which Russian roulette may end a path, at least 1; none without it.
    pub roulette: Option<u32>,
    /// Extra layers.
    pub aovs: AovSet,
    /// Workers; as many as the machine has cores without it.
    pub threads: Option<usize>,
    /// Paths of a wave, at least [`BLOCK`].
    pub wave: u32,
    /// How trees of triangles are built.
    pub bvh: Quality,
    /// No wave begins later than this.
    pub time: Option<Duration>,
}

impl Settings {
    /// What a scene asks for, the program's defaults elsewhere.
    pub fn of(scene: &Description) -> Self {
        let (film, wishes) = (&scene.film, &scene.render);
        Self {
            width: film.width,
            height: film.height,
            region: Region::full(film.width, film.height),
            camera: None,
            spp: wishes.spp.unwrap_or(64),
            path_length: wishes.path_length.unwrap_or(5),
            strategy: wishes.strategy.unwrap_or_default(),
            sampler: wishes.sampler.unwrap_or_default(),
            seed: wishes.seed.unwrap_or(0),
            roulette: wishes.roulette,
            aovs: AovSet::default(),
            threads: None,
            wave: DEFAULT_WAVE,
            bvh: Quality::default(),
            time: None,
        }
    }

    /// Changes the size, and the region to all of it.
    pub fn set_size(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width, height);
        self.region = Region::full(width, height);
    }

    /// The extra layers, one for each path length that there can be.
    pub fn layers(&self) -> AovSet {
        self.aovs.up_to(self.path_length)
    }

    /// Where random numbers come from.
    pub(crate) fn random_numbers(&self) -> Sampler {
        match self.sampler {
            SamplerKind::Pcg => Sampler::pcg(self.seed, self.path_length),
            SamplerKind::Sobol => Sampler::sobol(self.seed, self.path_length),
        }
    }

    /// What the stages read.
    pub(crate) fn context<'a>(
        &self,
        scene: &'a Scene,
        sensor: Sensor<'a>,
        sampler: &'a Sampler,
    ) -> Context<'a> {
        let origins = sensor.origins();
        Context {
            scene,
            sensor,
            enclosed: origins.iter().all(|&origin| scene.encloses(origin)),
            sampler,
            strategy: self.strategy,
            path_length: self.path_length,
            roulette: self.roulette,
            aovs: self.layers(),
        }
    }

    /// What [`render`] asks of its settings before it begins.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the first setting out of its range.
    pub fn check(&self) -> Result<()> {
        let wrong = |message: String| Err(Error::Usage(message));
        let within = |what: &str, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            wrong(format!("{what} is {value}; it can be {low} to {high}"))
        };
        within("the width", self.width, 1, MAX_SIDE)?;
        within("the height", self.height, 1, MAX_SIDE)?;
        within(
            "the number of samples per pixel (spp)",
            self.spp,
            1,
            MAX_SAMPLES,
        )?;
        within("the path length", self.path_length, 1, MAX_EDGES)?;
        self.layers().check()?;
        within("the wave size", self.wave, BLOCK, 1 << 20)?;
        if let Some(first) = self.roulette {
            within("the first edge of Russian roulette", first, 1, MAX_EDGES)?;
        }
        if let Some(threads) = self.threads {
            within(
                "the number of threads",
                threads.try_into().unwrap_or(u32::MAX),
                1,
                1024,
            )?;
        }
        let all = Region::full(self.width, self.height);
        if self.region.is_empty() || !all.contains(self.region) {
            return wrong(format!(
                "the crop {} is empty or reaches outside the {}x{} image; give x0,y0,x1,y1 with x0 < x1 <= {} and y0 < y1 <= {}",
                self.region, self.width, self.height, self.width, self.height
            ));
        }
        Ok(())
    }
}

/// How a render is watched and stopped.
pub struct Control<'a> {
    /// Once true, no further wave begins.
    pub stop: &'a AtomicBool,
    /// Called by workers after each wave with the number of its paths.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

/// A finished (or stopped) render.
#[derive(Debug)]
pub struct Rendered {
    /// The pixels.
    pub film: Film,
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
    settings.check()?;
    let begin = Instant::now();
    let camera = find_camera(description, settings)?;
    let threads = settings.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let scene = pool.install(|| Scene::compile_with(description, settings.bvh));
    let sampler = settings.random_numbers();
    let film = Film::new(
        settings.width,
        settings.height,
        settings.region,
        settings.layers(),
    )?;
    let build = begin.elapsed();

    let ctx = settings.context(&scene, Sensor::Camera(&camera), &sampler);
    let plan = Plan::new(settings);
    let next = AtomicU64::new(0);
    let begin = Instant::now();
    let deadline = settings.time.and_then(|time| begin.checked_add(time));
    let stopped = || {
        control.stop.load(Ordering::Relaxed) || deadline.is_some_and(|end| Instant::now() >= end)
    };
    let tallies = pool.broadcast(|_| {
        let mut ws = Workspace::new(plan.largest_wave(), &scene, ctx.aovs);
        while !stopped() {
            let Some(wave) = plan.wave(next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            trace(&ctx, &wave, &mut ws);
            let paths = wave.paths();
            let layers = Layers {
                first_hits: ws.first_hits.get(..paths).unwrap_or_default(),
                by_length: &ws.by_length,
            };
            film.add(wave.tile(), wave.samples, &ws.radiance[..paths], layers);
            ws.tally.end(Stage::Accumulate, 0);
            (control.progress)(wave.paths() as u64);
        }
        ws.tally
    });
    let seconds = begin.elapsed();

    let mut tally = Tally::default();
    tallies.iter().for_each(|each| tally.merge(each));
    let complete = tally.alive.first().copied().unwrap_or(0) == plan.paths();
    Ok(Rendered {
        stats: Stats {
            threads,
            build,
            render: seconds,
            tally,
        },
        film,
        interrupted: !complete && control.stop.load(Ordering::Relaxed),
    })
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

/// The camera that the settings ask for.
///
/// # Errors
/// [`Error::Usage`] where the scene has none of that name.
pub(crate) fn find_camera(description: &Description, settings: &Settings) -> Result<Camera> {
    let cameras = &description.cameras;
    let named = match &settings.camera {
        None => cameras.first(),
        Some(name) => cameras.iter().find(|camera| camera.name == *name),
    };
    let Some(named) = named else {
        let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        return Err(Error::Usage(format!(
            "{} has no camera {:?}; it has {}",
            description.name,
            settings.camera.as_deref().unwrap_or_default(),
            names.join(", ")
        )));
    };
    Ok(Camera::new(
        &named.camera,
        settings.width,
        settings.height,
        description.film.filter,
    ))
}

/// The waves of an image, numbered: block after block of samples, and in each the tiles row by row.
#[derive(Clone, Debug)]
struct Plan {
    region: Region,
    spp: u32,
    /// Pixels on a side of a tile.
    tile: u32,
    columns: u64,
    rows: u64,
}

impl Plan {
    fn new(settings: &Settings) -> Self {
        let region = settings.region;
        let pixels = settings.wave / settings.spp.min(BLOCK);
        let tile = pixels.isqrt().max(1);
        Self {
            region,
            spp: settings.spp,
            tile,
            columns: region.width().div_ceil(tile).into(),
            rows: region.height().div_ceil(tile).into(),
        }
    }

    fn paths(&self) -> u64 {
        self.region.pixels() as u64 * u64::from(self.spp)
    }

    fn largest_wave(&self) -> usize {
        let side = |pixels: u32| self.tile.min(pixels) as usize;
        side(self.region.width()) * side(self.region.height()) * self.spp.min(BLOCK) as usize
    }

    /// Wave `number`, or none past the last.
    fn wave(&self, number: u64) -> Option<Wave> {
        let tiles = self.columns * self.rows;
        let first_sample = u32::try_from(number / tiles * u64::from(BLOCK)).ok()?;
        let samples = self.spp.checked_sub(first_sample)?.min(BLOCK);
        let (row, column) = (number % tiles / self.columns, number % tiles % self.columns);
        let x = self.region.x0 + column as u32 * self.tile;
        let y = self.region.y0 + row as u32 * self.tile;
        (samples > 0).then_some(Wave {
            x,
            y,
            width: self.tile.min(self.region.x1 - x),
            height: self.tile.min(self.region.y1 - y),
            first_sample,
            samples,
        })
    }
}
