//! What a suite measured: written as JSON, read again for comparisons.

use super::machine::Machine;
use super::peaks::Peaks;
use super::scenes::{Case, PATH_LENGTH, Suite};
use super::series::Series;
use crate::stats::Stats;
use crate::wavefront::Stage;
use serde::{Deserialize, Serialize};

/// Changes whenever a scene, a setting or the way of measuring does: reports of other versions are not compared.
pub const VERSION: u32 = 1;

/// A run of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// [`VERSION`].
    pub version: u32,
    /// `quick` or `full`.
    pub suite: String,
    /// Threads of all that is not said to have others.
    pub threads: usize,
    /// Times that each thing was measured, after one to warm up.
    pub repeats: usize,
    /// Where.
    pub machine: Machine,
    /// 10⁹ cycles per second, as seen before each measurement.
    pub clock_ghz: Series,
    /// 10⁹ bytes per second that all threads read from their first caches, before each measurement: slower where others share
    /// the cores, as on a virtual machine.
    pub pace_gbytes: Series,
    /// Measurements that were taken again, for others kept the processors busy meanwhile.
    pub disturbed: usize,
    /// Measurements that were kept although others did.
    pub accepted: usize,
    /// What the machine can do.
    pub peaks: Peaks,
    /// The scenes.
    pub cases: Vec<CaseReport>,
    /// Some scenes on other numbers of threads.
    pub threads_scaling: Vec<Scaling>,
    /// Some scenes with waves of other sizes.
    pub wave_scaling: Vec<Scaling>,
    /// Bytes of the records that pass between stages.
    pub records: Vec<Record>,
    /// The most memory that the program had resident, bytes.
    pub peak_rss_bytes: Option<u64>,
    /// The figure for the whole.
    pub score: Score,
}

/// The geometric mean of the scenes' rates, 10⁶ camera paths per second; only with a proof that all images are right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// None where it is withheld.
    pub value: Option<f64>,
    /// Why it is withheld, a line for each reason.
    pub withheld: Vec<String>,
}

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseReport {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// Pixels on a side.
    pub side: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Greatest number of edges of a path.
    pub path_length: u32,
    /// Triangles; 0 where there are none.
    pub triangles: usize,
    /// Bytes of the trees, for each triangle.
    pub bytes_per_triangle: Option<f64>,
    /// Camera paths.
    pub paths: u64,
    /// Rays: closest hit, last edge and shadow.
    pub rays: u64,
    /// Bytes that pass through queues, written and read, for each ray.
    pub queue_bytes_per_ray: f64,
    /// Seconds to compile the scene: trees, tables.
    pub build_s: Series,
    /// Seconds of the render loop.
    pub render_s: Series,
    /// 10⁶ camera paths per second, by the median.
    pub mpaths_per_s: f64,
    /// 10⁶ rays per second, by the median.
    pub mrays_per_s: f64,
    /// The stages of the loop.
    pub stages: Vec<StageSeries>,
    /// The edges of the paths, from the first.
    pub bounces: Vec<Bounce>,
    /// The image.
    pub proof: Proof,
}

/// A stage in one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSeries {
    /// `generate`, `intersect`, `shade`, `nee` or `accumulate`.
    pub name: String,
    /// Records that it was given.
    pub items: u64,
    /// Mean part of the lanes that were live, 0 to 1.
    pub lane_use: f64,
    /// Seconds of all threads together.
    pub thread_s: Series,
    /// 10⁶ records per second and thread while in the stage, by the median.
    pub mitems_per_s: f64,
}

/// A path edge in one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounce {
    /// From 1.
    pub edge: u32,
    /// Rays alive at its beginning: the queue's size, over all waves.
    pub rays: u64,
    /// Shadow rays from its end.
    pub shadow_rays: u64,
    /// Mean number of rays in a wave's queue.
    pub queue: f64,
    /// 10⁶ rays per second and thread while they are intersected.
    pub mrays_per_s: f64,
    /// Mean part of the lanes that were live, over all stages.
    pub lane_use: f64,
    /// Its stages.
    pub stages: Vec<BounceStage>,
}

/// A stage on one path edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BounceStage {
    /// The stage.
    pub name: String,
    /// Records that it was given.
    pub items: u64,
    /// Mean part of the lanes that were live.
    pub lane_use: f64,
    /// Seconds of all threads together, the median over the repeats.
    pub thread_s: f64,
}

/// Whether an image is right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Proof {
    /// Whether all images of the scene had the same bits: each repeat, on any number of threads, with any wave.
    pub same_bits: bool,
    /// Whether it is consistent with its reference.
    pub consistent: bool,
    /// Whether it is clear enough for that to mean something.
    pub is_telling: bool,
    /// What the comparison says.
    pub summary: String,
    /// The least uniform relative bias that would have been found.
    pub detectable: Option<f64>,
    /// Samples that were not finite.
    pub rejected: u64,
    /// The bits.
    pub image_hash: String,
}

/// One scene by a number that changes its speed alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// The scene.
    pub case: String,
    /// Ascending.
    pub points: Vec<Point>,
}

/// One of these numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Threads, or paths of a wave.
    pub at: usize,
    /// Seconds of the render loop.
    pub render_s: Series,
    /// 10⁶ camera paths per second, by the median.
    pub mpaths_per_s: f64,
}

/// A record that passes between stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// What it is.
    pub name: String,
    /// Bytes of one lane.
    pub bytes: f64,
}

impl CaseReport {
    /// Before anything is measured.
    pub fn new(case: &Case, suite: Suite) -> Self {
        Self {
            name: case.name.to_owned(),
            title: case.title.to_owned(),
            side: case.side,
            spp: suite.spp(case),
            path_length: PATH_LENGTH,
            triangles: 0,
            bytes_per_triangle: None,
            paths: 0,
            rays: 0,
            queue_bytes_per_ray: 0.0,
            build_s: Series::default(),
            render_s: Series::default(),
            mpaths_per_s: 0.0,
            mrays_per_s: 0.0,
            stages: Vec::new(),
            bounces: Vec::new(),
            proof: Proof::default(),
        }
    }

    /// Why its image is no proof, if it is none.
    pub fn fault(&self) -> Option<String> {
        let proof = &self.proof;
        let fault = match (proof.same_bits, proof.consistent, proof.rejected) {
            (false, _, _) => "its images differ from one run to the next".to_owned(),
            (_, false, _) => proof.summary.clone(),
            _ if !proof.is_telling => format!("it is no proof: {}", proof.summary),
            (_, _, 0) => return None,
            (_, _, rejected) => format!("{rejected} samples are not finite"),
        };
        Some(format!("{}: {fault}", self.name))
    }

    /// Takes in what its repeats took.
    pub fn fill(&mut self, runs: &[Stats]) {
        let Some(first) = runs.first() else { return };
        self.paths = first.paths();
        self.rays = first.rays();
        self.render_s = runs.iter().map(|run| run.render.as_secs_f64()).collect();
        let seconds = self.render_s.median();
        self.mpaths_per_s = self.paths as f64 / seconds / 1e6;
        self.mrays_per_s = self.rays as f64 / seconds / 1e6;
        let stage = |stage: &Stage| {
            let sums = first.tally.stage(*stage);
            let times = runs
                .iter()
                .map(|run| run.tally.stage(*stage).time.as_secs_f64());
            let thread_s: Series = times.collect();
            StageSeries {
                name: stage.name().to_owned(),
                items: sums.items,
                lane_use: sums.lane_use(),
                mitems_per_s: sums.items as f64 / thread_s.median().max(1e-9) / 1e6,
                thread_s,
            }
        };
        self.stages = Stage::ALL.iter().map(stage).collect();
        self.bounces = (0..first.tally.edges().len())
            .map(|edge| bounce(edge, runs))
            .collect();
    }
}

fn bounce(edge: usize, runs: &[Stats]) -> Bounce {
    let tally = &runs[0].tally.edges()[edge];
    let stages: Vec<BounceStage> = Stage::ALL
        .iter()
        .filter(|&&stage| tally.stages[stage as usize].items > 0)
        .map(|&stage| {
            let sums = &tally.stages[stage as usize];
            // Images that differ from run to run may have fewer edges: that is found elsewhere.
            let edges = runs.iter().filter_map(|run| run.tally.edges().get(edge));
            let times: Series = edges
                .map(|tally| tally.stages[stage as usize].time.as_secs_f64())
                .collect();
            BounceStage {
                name: stage.name().to_owned(),
                items: sums.items,
                lane_use: sums.lane_use(),
                thread_s: times.median(),
            }
        })
        .collect();
    let all = tally.stages.iter();
    let (items, lanes) = all.fold((0, 0), |(items, lanes), sums| {
        (items + sums.items, lanes + sums.lanes)
    });
    let intersect = stages
        .iter()
        .find(|stage| stage.name == Stage::Intersect.name());
    let seconds = intersect.map_or(0.0, |stage| stage.thread_s);
    Bounce {
        edge: edge as u32 + 1,
        rays: tally.alive,
        shadow_rays: tally.shadow_rays,
        queue: tally.alive as f64 / runs[0].tally.waves().max(1) as f64,
        mrays_per_s: (tally.alive + tally.shadow_rays) as f64 / seconds.max(1e-9) / 1e6,
        lane_use: items as f64 / lanes.max(1) as f64,
        stages,
    }
}

impl Report {
    /// Gives the score, or says why there is none.
    pub(super) fn judge(&mut self, suite: Suite) {
        let mut withheld: Vec<String> = self.cases.iter().filter_map(CaseReport::fault).collect();
        let has = |case: &Case| self.cases.iter().any(|report| report.name == case.name);
        if !suite.cases().all(has) {
            withheld.push("not all scenes of the suite were run".to_owned());
        }
        let logs = self.cases.iter().map(|case| libm::log(case.mpaths_per_s));
        let mean = libm::exp(logs.sum::<f64>() / self.cases.len() as f64);
        self.score = Score {
            value: withheld.is_empty().then_some(mean),
            withheld,
        };
    }

    /// Whether an image is wrong.
    pub fn is_wrong(&self) -> bool {
        self.cases.iter().any(|case| case.fault().is_some())
    }

    /// Every time that was measured, by a name for people: seconds.
    pub fn figures(&self) -> Vec<(String, &Series)> {
        let mut all = Vec::new();
        for case in &self.cases {
            let name = &case.name;
            all.push((format!("{name}: render"), &case.render_s));
            if case.triangles > 0 {
                all.push((format!("{name}: build"), &case.build_s));
            }
            let stages = case.stages.iter();
            all.extend(stages.map(|stage| (format!("{name}: {}", stage.name), &stage.thread_s)));
        }
        for (what, scalings) in [
            ("threads", &self.threads_scaling),
            ("paths a wave", &self.wave_scaling),
        ] {
            for Scaling { case, points } in scalings {
                let points = points.iter();
                all.extend(
                    points.map(|point| (format!("{case}: {} {what}", point.at), &point.render_s)),
                );
            }
        }
        all
    }
}
