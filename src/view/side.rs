//! One image of the view: coarse pictures first, then whole passes in one film, and what is known of it.

use super::look::Balance;
use super::picture::Shown;
use crate::error::{Error, Result};
use crate::film::{BLOCK, Coverage, Film, Region};
use crate::render::{Control, FirstHit, Frame, Rendered, Settings, render_frame};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::description;
use crate::stats::{self, Stats};
use crate::wavefront::Stage;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// How long a round is, if a pass is not longer.
const ROUND: Duration = Duration::from_millis(100);
/// How long the first coarse picture may take, as far as is known how fast the scene is.
const FIRST: Duration = Duration::from_millis(25);
/// Finer pictures come before the image where its first pass is expected to take so long.
const PATIENCE: Duration = Duration::from_millis(300);
/// The coarsest picture has a pixel for so many by so many of the image's.
const COARSEST: u32 = 32;
/// Samples grow by this factor from one point of a curve of errors to the next.
const CURVE_STEP: f64 = 1.15;

/// What traces: the workers, what may stop them, and how many paths per second they were last seen to trace.
pub struct Tracers<'a> {
    /// The workers.
    pub pool: &'a rayon::ThreadPool,
    /// Once true, no further wave begins.
    pub stop: &'a AtomicBool,
    /// Called by workers with the number of paths of each wave.
    pub progress: &'a (dyn Fn(u64) + Sync),
    /// Paths per second.
    pub speed: &'a mut f64,
}

/// One image.
pub struct Side {
    /// How it is rendered, to the view's limit.
    pub settings: Settings,
    scene: Arc<Scene>,
    lens: description::Camera,
    filter: description::Filter,
    film: Option<Arc<Film>>,
    coverage: Coverage,
    /// Samples that every pixel has.
    samples: u32,
    coarse: Option<Coarse>,
    stats: Stats,
    curve: Vec<[f64; 3]>,
}

struct Coarse {
    /// A pixel is so many of the image's, across and down.
    scale: u32,
    film: Arc<Film>,
}

/// What a side has come to.
#[derive(Clone, Debug, Serialize)]
pub struct SideReport {
    samples: u32,
    /// Of rendering the image; coarse pictures are not counted.
    seconds: f64,
    paths: u64,
    rays: u64,
    paths_per_s: f64,
    rays_per_s: f64,
    rejected: u64,
    stages: Vec<StageReport>,
    /// Seconds, samples, error: root mean square of the pixels' standard errors over mean radiance.
    curve: Vec<[f64; 3]>,
}

#[derive(Clone, Debug, Serialize)]
struct StageReport {
    name: &'static str,
    #[serde(flatten)]
    report: stats::StageReport,
}

impl SideReport {
    /// The same in the middle of a round, of which so many paths were traced in so long.
    pub fn with(&self, paths: u64, time: Duration) -> Self {
        let seconds = self.seconds + time.as_secs_f64();
        let paths = self.paths + paths;
        Self {
            seconds,
            paths,
            paths_per_s: paths as f64 / seconds.max(1e-9),
            ..self.clone()
        }
    }
}

impl Side {
    /// An image of which nothing is rendered yet.
    pub fn new(
        settings: Settings,
        lens: description::Camera,
        filter: description::Filter,
        scene: Arc<Scene>,
    ) -> Self {
        Self {
            settings,
            scene,
            lens,
            filter,
            film: None,
            coverage: Coverage::default(),
            samples: 0,
            coarse: None,
            stats: Stats::default(),
            curve: Vec::new(),
        }
    }

    /// Samples that every pixel has.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Seconds that it was rendered.
    pub fn seconds(&self) -> f64 {
        self.stats.render.as_secs_f64()
    }

    /// Whether it has all samples that it shall have.
    pub fn is_done(&self) -> bool {
        self.samples >= self.settings.spp && self.missing().is_none()
    }

    /// What there is to be seen of it.
    pub fn shown(&self) -> Shown {
        Shown {
            film: self.film.clone(),
            coarse: self.coarse.as_ref().map(|coarse| coarse.film.clone()),
        }
    }

    /// The image as a render of so many samples would give it; none while a pass is under way or none is done.
    pub fn whole(&self) -> Option<(Settings, Rendered)> {
        let film = self.film.as_ref().filter(|_| self.missing().is_none())?;
        let settings = Settings {
            spp: self.samples,
            ..self.settings.clone()
        };
        let rendered = Rendered {
            film: film.clone(),
            coverage: self.coverage.clone(),
            stats: self.stats.clone(),
            interrupted: false,
        };
        Some((settings, rendered))
    }

    /// The number of samples at which every pixel has as many as any has now, and at least a pass; none where it is so.
    pub fn missing(&self) -> Option<u32> {
        let pixels = self.settings.region.pixels() as u64;
        let (_, most) = self.coverage.samples(pixels, u32::MAX / BLOCK * BLOCK);
        let target = most.max(BLOCK);
        (self.samples < target).then_some(target)
    }

    /// The scale of the next coarse picture, if there is to be one.
    pub fn next_coarse(&self, speed: f64) -> Option<u32> {
        if self.film.is_some() {
            return None;
        }
        let pixels = self.settings.region.pixels() as f64;
        let seconds = |scale: u32| pixels / f64::from(scale * scale) / speed;
        match &self.coarse {
            None => {
                let scales = (0..).map(|power| 1 << power);
                let fast =
                    |&scale: &u32| scale >= COARSEST || seconds(scale) <= FIRST.as_secs_f64();
                scales.into_iter().find(fast)
            }
            Some(coarse) => {
                let pass = seconds(1) * f64::from(BLOCK);
                let finer = coarse.scale > 1 && pass > PATIENCE.as_secs_f64();
                finer.then_some(coarse.scale / 2)
            }
        }
    }

    /// How coarse its picture is: the greater, the coarser.
    pub fn coarseness(&self) -> u32 {
        self.coarse.as_ref().map_or(u32::MAX, |coarse| coarse.scale)
    }

    /// Renders a coarse picture: one sample for each of its pixels.
    pub fn render_coarse(&mut self, scale: u32, tracers: &mut Tracers) -> Result<()> {
        let mut settings = self.settings.clone();
        let (width, height) = (settings.width, settings.height);
        settings.set_size(width.div_ceil(scale), height.div_ceil(scale));
        settings.spp = 1;
        let camera = self.camera(&settings, self.lens);
        let frame = Frame::new(&settings, camera, self.scene.clone(), None)?;
        let rendered = trace(frame, tracers);
        if !rendered.interrupted {
            self.coarse = Some(Coarse {
                scale,
                film: rendered.film,
            });
        }
        Ok(())
    }

    /// Makes room for the image, if there is none.
    pub fn make_room(&mut self) -> Result<()> {
        let settings = &self.settings;
        if self.film.is_none() {
            let (width, height) = (settings.width, settings.height);
            let film = Film::new(width, height, settings.region, settings.layers())?;
            self.film = Some(Arc::new(film));
        }
        Ok(())
    }

    /// How many samples the image shall have after the next round.
    pub fn next_round(&self, speed: f64) -> u32 {
        let settings = &self.settings;
        let pass = settings.region.pixels() as f64 * f64::from(BLOCK);
        // Short ones at first, so that the curve of errors has its points.
        let growth = f64::from(self.samples / BLOCK) * (CURVE_STEP - 1.0);
        let passes = (speed * ROUND.as_secs_f64() / pass).min(growth).max(1.0);
        let target = self.samples.saturating_add(passes as u32 * BLOCK);
        // A limit that was lowered in the middle of a pass does not leave it so.
        target.min(settings.spp).max(self.missing().unwrap_or(0))
    }

    /// Renders until every pixel has so many samples.
    pub fn render(&mut self, samples: u32, tracers: &mut Tracers) -> Result<()> {
        let Some(film) = self.film.clone() else {
            return Ok(());
        };
        let begin = Instant::now();
        let settings = Settings {
            spp: samples,
            ..self.settings.clone()
        };
        let coverage = std::mem::take(&mut self.coverage);
        let (camera, scene) = (self.camera(&settings, self.lens), self.scene.clone());
        let frame = Frame::on(&settings, camera, scene, film.clone(), coverage)?;
        let rendered = trace(frame, tracers);
        self.coverage = rendered.coverage;
        self.stats.threads = rendered.stats.threads;
        self.stats.tally.merge(&rendered.stats.tally);
        if rendered.interrupted {
            self.stats.render += begin.elapsed();
            return Ok(());
        }
        self.samples = samples;
        self.coarse = None;
        let last = self.curve.last().map_or(0.0, |point| point[1]);
        let due = f64::from(samples) >= last * CURVE_STEP || self.is_done();
        let noise = due.then(|| tracers.pool.install(|| film.noise()));
        self.stats.render += begin.elapsed();
        if let Some(noise) = noise.filter(|noise| noise.mean > 0.0) {
            let error = noise.error / noise.mean;
            self.curve.push([self.seconds(), samples.into(), error]);
        }
        Ok(())
    }

    /// What is at a pixel; none where that is nothing. The lens has no part in it: what is out of focus can be picked too.
    ///
    /// # Errors
    /// [`Error::Usage`] where the pixel is not in the image.
    pub fn first_hit(&self, x: u32, y: u32) -> Result<Option<FirstHit>> {
        let mut settings = self.settings.clone();
        if !settings.region.has(x, y) {
            return Err(Error::Usage(format!(
                "the pixel {x},{y} is not in the image of {}x{}",
                settings.width, settings.height
            )));
        }
        settings.region = Region {
            x0: x,
            y0: y,
            x1: x + 1,
            y1: y + 1,
        };
        settings.spp = 1;
        let lens = description::Camera {
            aperture_radius: 0.0,
            ..self.lens
        };
        let camera = self.camera(&settings, lens);
        let frame = Frame::new(&settings, camera, self.scene.clone(), None)?;
        Ok(frame.first_hit())
    }

    fn camera(&self, settings: &Settings, lens: description::Camera) -> Camera {
        Camera::new(&lens, settings.width, settings.height, self.filter)
    }

    /// What it has come to.
    pub fn report(&self) -> SideReport {
        let per_second = |count: u64| self.stats.millions_per_second(count) * 1e6;
        let (paths, rays) = (self.stats.paths(), self.stats.rays());
        let mut stages = self.stats.stages();
        let in_order = Stage::ALL.iter().map(|stage| stage.name());
        SideReport {
            samples: self.samples,
            seconds: self.seconds(),
            paths,
            rays,
            paths_per_s: per_second(paths),
            rays_per_s: per_second(rays),
            rejected: self.film.as_ref().map_or(0, |film| film.rejected()),
            stages: in_order
                .filter_map(|name| {
                    let report = stages.remove(name)?;
                    Some(StageReport { name, report })
                })
                .collect(),
            curve: self.curve.clone(),
        }
    }
}

impl Balance {
    /// The side whose turn it is: the one that has had less.
    pub fn turn(self, sides: &[Side]) -> Option<usize> {
        let open = || sides.iter().enumerate().filter(|(_, side)| !side.is_done());
        match self {
            Self::Samples => open()
                .min_by_key(|(_, side)| side.samples())
                .map(|(i, _)| i),
            // Where one has all its samples, the other gets no more time.
            Self::Time if sides.iter().any(Side::is_done) => None,
            Self::Time => open()
                .min_by(|(_, a), (_, b)| a.seconds().total_cmp(&b.seconds()))
                .map(|(i, _)| i),
        }
    }
}

fn trace(frame: Frame, tracers: &mut Tracers) -> Rendered {
    let control = Control {
        stop: tracers.stop,
        progress: tracers.progress,
    };
    let rendered = render_frame(frame, tracers.pool, &control);
    let (paths, seconds) = (rendered.stats.paths(), rendered.stats.render.as_secs_f64());
    // Of a few paths it is not known how long they take.
    if paths >= 4096 {
        *tracers.speed = paths as f64 / seconds.max(1e-9);
    }
    rendered
}
