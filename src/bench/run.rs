//! Runs a suite: everything by turns, so that a machine that slows down slows down everything.

use super::machine::{Machine, Watch, clock};
use super::peaks::{self, Pace};
use super::proof;
use super::report::{CaseReport, Point, Record, Report, Scaling, Score, VERSION};
use super::scenes::{Case, PATH_LENGTH, Suite};
use super::series::Series;
use crate::bvh::Quality;
use crate::compare::Verdict;
use crate::error::Result;
use crate::film::Film;
use crate::render::{Control, DEFAULT_WAVE, Frame, Settings, camera_of, render_frame_by, workers};
use crate::scene::Scene;
use crate::scene::description::{Description, SamplerKind, Strategy};
use crate::stats::{Stats, peak_rss_bytes};
use crate::wavefront::queues::{EncounterX8, MeshVertexX8, PathRayX8, ShadowRayX8, VertexX8};
use crate::wavefront::{Context, Stage, Tally, Wave, Workspace};
use rayon::ThreadPool;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How often a measurement is taken again where they did; altogether, half as often as there are measurements.
const AGAIN: usize = 3;
/// A comparison that would miss a uniform bias of this size is no proof.
const TELLING: f64 = 0.05;
/// Scenes that are also measured on other numbers of threads and with other waves.
const SCALED: [&str; 2] = ["box", "mesh-1e5"];

/// What is run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How much work.
    pub suite: Suite,
    /// The scenes: for a score, all of the suite's.
    pub cases: Vec<&'static Case>,
    /// Whether some scenes are also measured on other numbers of threads and with other waves.
    pub scaling: bool,
    /// Numbers of threads, ascending; all that is not said to have others is measured on the last. At least one.
    pub threads: Vec<usize>,
    /// Times that each thing is measured, after one to warm up; at least 1.
    pub repeats: usize,
    /// What the program was compiled for.
    pub target_features: String,
}

/// Who looks on.
pub struct Look<'a> {
    /// Once true, nothing further is begun.
    pub stop: &'a AtomicBool,
    /// Is told what is done now, and which part of all was done before: 0 to 1.
    pub progress: &'a dyn Fn(&str, f64),
}

/// A scene under way.
struct Course {
    case: &'static Case,
    report: CaseReport,
    description: Description,
    settings: Settings,
    scene: Option<Arc<Scene>>,
    build: Series,
    runs: Vec<Stats>,
}

/// What is counted over all measurements.
struct Bench<'a, T> {
    trace: &'a T,
    look: &'a Look<'a>,
    done: usize,
    steps: usize,
    clock: Series,
    pace: Pace<'a>,
    paces: Series,
    disturbed: usize,
    accepted: usize,
}

/// Runs a suite; none where it was stopped. `trace` is [`wavefront::trace`](crate::wavefront::trace), or what is to be held
/// against it.
///
/// # Errors
/// [`Error::Usage`](crate::error::Error::Usage) where workers cannot be started.
pub fn run(
    plan: &Plan,
    trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync),
    look: &Look,
) -> Result<Option<Report>> {
    let (threads, waves) = match plan.scaling {
        true => (plan.threads.clone(), waves(plan.suite)),
        false => (Vec::new(), Vec::new()),
    };
    let cases = plan.cases.len();
    let scaled = plan.cases.iter().filter(|case| SCALED.contains(&case.name));
    let scalings = scaled.count() * (threads.len() + waves.len());
    let most = plan.threads.last().copied().unwrap_or(1);
    let pool = workers(most)?;
    let mut bench = Bench {
        trace,
        look,
        done: 0,
        steps: (cases + scalings) * (plan.repeats + 1) + cases,
        clock: Series::default(),
        pace: Pace::new(&pool),
        paces: Series::default(),
        disturbed: 0,
        accepted: 0,
    };

    let mut courses = Vec::new();
    for &case in &plan.cases {
        if !bench.step(&format!("making {}", case.name)) {
            return Ok(None);
        }
        courses.push(Course::new(case, plan.suite, &pool)?);
    }
    for round in 0..=plan.repeats {
        for course in &mut courses {
            if !bench.step(course.case.name) {
                return Ok(None);
            }
            let (build, stats) = bench.measure(|bench| course.measure(&pool, bench.trace))?;
            if round > 0 {
                course.build.push(build);
                course.runs.push(stats);
            }
        }
    }
    let by_threads = bench.scale(plan.repeats, &mut courses, &threads, |settings, at| {
        settings.threads = Some(at);
    })?;
    let by_wave = bench.scale(plan.repeats, &mut courses, &waves, |settings, at| {
        settings.threads = Some(most);
        settings.wave = at as u32;
    })?;
    let (Some(threads_scaling), Some(wave_scaling)) = (by_threads, by_wave) else {
        return Ok(None);
    };
    let mut report = Report {
        version: VERSION,
        suite: plan.suite.to_string(),
        threads: most,
        repeats: plan.repeats,
        machine: Machine::here(plan.target_features.clone()),
        clock_ghz: bench.clock,
        pace_gbytes: bench.paces,
        disturbed: bench.disturbed,
        accepted: bench.accepted,
        peaks: peaks::measure(&pool),
        cases: courses.into_iter().map(Course::end).collect(),
        threads_scaling,
        wave_scaling,
        records: records(),
        peak_rss_bytes: peak_rss_bytes(),
        score: Score::default(),
    };
    report.judge(plan.suite);
    Ok(Some(report))
}

/// Sizes of waves, paths.
fn waves(suite: Suite) -> Vec<usize> {
    match suite {
        Suite::Quick => vec![256, DEFAULT_WAVE as usize, 16_384],
        Suite::Full => vec![
            64,
            256,
            512,
            1024,
            DEFAULT_WAVE as usize,
            4096,
            8192,
            16_384,
            65_536,
        ],
    }
}

impl Course {
    fn new(case: &'static Case, suite: Suite, pool: &ThreadPool) -> Result<Self> {
        let description = pool.install(|| case.description())?;
        let mut settings = Settings::of(&description);
        settings.set_size(case.side, case.side);
        settings.spp = suite.spp(case);
        settings.path_length = PATH_LENGTH;
        settings.strategy = Strategy::Mis;
        settings.sampler = SamplerKind::Sobol;
        settings.threads = Some(pool.current_num_threads());
        let mut report = CaseReport::new(case, suite);
        report.triangles = description
            .meshes
            .iter()
            .map(|mesh| mesh.triangles.len())
            .sum();
        report.proof.same_bits = true;
        Ok(Self {
            scene: None,
            case,
            report,
            description,
            settings,
            build: Series::default(),
            runs: Vec::new(),
        })
    }

    /// Compiles the scene and renders it: seconds of the first, and what the second took.
    fn measure(
        &mut self,
        pool: &ThreadPool,
        trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync),
    ) -> Result<(f64, Stats)> {
        // Two of the largest would be too many.
        self.scene = None;
        let begin = Instant::now();
        self.scene = Some(self.compile(pool));
        let build = begin.elapsed().as_secs_f64();
        let settings = self.settings.clone();
        Ok((build, self.render(&settings, pool, trace)?))
    }

    fn compile(&self, pool: &ThreadPool) -> Arc<Scene> {
        let compile = || Scene::compile_with(&self.description, Quality::Fast);
        Arc::new(pool.install(compile))
    }

    /// Renders the scene, and holds the image to its reference and to the images before; what it took.
    fn render(
        &mut self,
        settings: &Settings,
        pool: &ThreadPool,
        trace: &(impl Fn(&Context, &Wave, &mut Workspace) + Sync),
    ) -> Result<Stats> {
        let camera = camera_of(&self.description, settings)?;
        let scene = self.scene.clone().unwrap_or_else(|| self.compile(pool));
        let frame = Frame::new(settings, camera, scene, None)?;
        let control = Control {
            stop: &AtomicBool::new(false),
            progress: &|_| (),
        };
        let rendered = render_frame_by(trace, frame, pool, &control);
        self.check(&rendered.film)?;
        Ok(rendered.stats)
    }

    /// The first image is proved, the others are to have its bits.
    fn check(&mut self, film: &Film) -> Result<()> {
        let proof = &mut self.report.proof;
        let hash = film.image_hash();
        if !proof.image_hash.is_empty() {
            proof.same_bits &= proof.image_hash == hash;
            return Ok(());
        }
        let found = proof::prove(self.case, film)?;
        proof.consistent = found.verdict != Verdict::Biased;
        proof.is_telling = found.detectable.is_some_and(|bias| bias < TELLING);
        proof.summary = found.summary;
        proof.detectable = found.detectable;
        proof.rejected = film.rejected();
        proof.image_hash = hash;
        Ok(())
    }

    fn end(self) -> CaseReport {
        let mut report = self.report;
        report.fill(&self.runs);
        report.build_s = self.build;
        if let Some(meshes) = self.scene.as_ref().and_then(|scene| scene.meshes.as_ref()) {
            let [opaque, masked] = [&meshes.opaque, &meshes.masked].map(|layer| layer.tree.bytes());
            let bytes = opaque.0 + opaque.1 + masked.0 + masked.1;
            report.bytes_per_triangle = Some(bytes as f64 / report.triangles.max(1) as f64);
        }
        if let Some(run) = self.runs.first() {
            report.queue_bytes_per_ray =
                queue_bytes(&run.tally, report.triangles > 0) / report.rays.max(1) as f64;
        }
        report
    }
}

impl<T: Fn(&Context, &Wave, &mut Workspace) + Sync> Bench<'_, T> {
    /// Says what is next; false where it is not to be.
    fn step(&mut self, what: &str) -> bool {
        (self.look.progress)(what, self.done as f64 / self.steps as f64);
        self.done += 1;
        !self.look.stop.load(Ordering::Relaxed)
    }

    /// Measures, and again where others were busy meanwhile.
    fn measure<R>(&mut self, mut work: impl FnMut(&Self) -> Result<R>) -> Result<R> {
        let mut again = AGAIN;
        loop {
            self.clock.push(clock());
            self.paces.push(self.pace.now());
            let watch = Watch::start();
            let result = work(self)?;
            if watch.is_quiet() {
                return Ok(result);
            }
            if again == 0 || 2 * self.disturbed >= self.steps {
                self.accepted += 1;
                return Ok(result);
            }
            again -= 1;
            self.disturbed += 1;
        }
    }

    /// Some scenes by a number that changes their speed alone; none where it was stopped.
    fn scale(
        &mut self,
        repeats: usize,
        courses: &mut [Course],
        numbers: &[usize],
        set: impl Fn(&mut Settings, usize),
    ) -> Result<Option<Vec<Scaling>>> {
        if numbers.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let scaled = |course: &&mut Course| SCALED.contains(&course.case.name);
        let mut all = Vec::new();
        for course in courses.iter_mut().filter(scaled) {
            let settings = numbers.iter().map(|&at| {
                let mut settings = course.settings.clone();
                set(&mut settings, at);
                settings
            });
            let settings: Vec<Settings> = settings.collect();
            let pools = settings
                .iter()
                .map(|settings| workers(settings.threads.unwrap_or(1)));
            let pools = pools.collect::<Result<Vec<_>>>()?;
            let mut series = vec![Series::default(); numbers.len()];
            for round in 0..=repeats {
                for (place, settings) in settings.iter().enumerate() {
                    if !self.step(&format!("{} by {}", course.case.name, numbers[place])) {
                        return Ok(None);
                    }
                    let stats =
                        self.measure(|bench| course.render(settings, &pools[place], bench.trace))?;
                    if round > 0 {
                        series[place].push(stats.render.as_secs_f64());
                    }
                }
            }
            let pixels = f64::from(course.case.side).powi(2);
            let paths = pixels * f64::from(course.settings.spp);
            let points = numbers.iter().zip(series).map(|(&at, render_s)| Point {
                at,
                mpaths_per_s: paths / render_s.median() / 1e6,
                render_s,
            });
            all.push(Scaling {
                case: course.case.name.to_owned(),
                points: points.collect(),
            });
        }
        Ok(Some(all))
    }
}

/// Bytes of a record of eight lanes, a lane.
fn lane<B>() -> f64 {
    size_of::<B>() as f64 / 8.0
}

fn records() -> Vec<Record> {
    [
        ("path ray", lane::<PathRayX8>()),
        ("vertex on a shape", lane::<VertexX8>()),
        ("vertex on a mesh", lane::<MeshVertexX8>()),
        ("encounter with light", lane::<EncounterX8>()),
        ("shadow ray", lane::<ShadowRayX8>()),
    ]
    .map(|(name, bytes)| Record {
        name: name.to_owned(),
        bytes,
    })
    .into()
}

/// Bytes that went through the queues: each record is written once, and read by each stage that it is given to. Vertices are
/// taken to be on meshes where there are any.
fn queue_bytes(tally: &Tally, meshes: bool) -> f64 {
    let vertex = if meshes {
        lane::<MeshVertexX8>()
    } else {
        lane::<VertexX8>()
    };
    let edges = tally.edges().iter().map(|edge| {
        let items = |stage: Stage| edge.stages[stage as usize].items as f64;
        let (shaded, lit) = (items(Stage::Shade), items(Stage::Nee));
        // What was accumulated beside shadow rays are encounters.
        let encounters = items(Stage::Accumulate) - edge.shadow_rays as f64;
        // Written and read; a vertex is read by either stage; a shadow ray by intersect and by accumulate.
        edge.alive as f64 * 2.0 * lane::<PathRayX8>()
            + (shaded.max(lit) + shaded + lit) * vertex
            + encounters * 2.0 * lane::<EncounterX8>()
            + edge.shadow_rays as f64 * 3.0 * lane::<ShadowRayX8>()
    });
    edges.sum()
}
