//! The box on this machine's roofline: operations and bytes of each kernel, counted once by an instruction counter, against
//! the time that each stage took here.
//!
//! Williams, Waterman & Patterson 2009, "Roofline: an insightful visual performance model", Communications of the ACM 52.

use super::plots::drawn;
use crate::bench::Report;
use crate::bench::report::{Bounce, CaseReport};
use crate::cli::page::escape;
use crate::cli::plot::{Axis, Line, Plot, Scale, Style};
use crate::wavefront::Stage;
use serde::Deserialize;
use std::collections::BTreeMap;

/// What tools/count_instructions.py counted.
const COUNTS: &str = include_str!("../../../benches/instructions.json");
/// The scene whose kernels were counted.
const SCENE: &str = "box";

#[derive(Deserialize)]
struct Counts {
    rustc: String,
    cases: BTreeMap<String, Count>,
}

/// What a kernel took for all of its elements.
#[derive(Clone, Copy, Deserialize)]
struct Count {
    elements: f64,
    flops: f64,
    loaded_bytes: f64,
    stored_bytes: f64,
}

/// Operations and bytes, of an element or altogether.
#[derive(Clone, Copy, Default)]
struct Work {
    flops: f64,
    bytes: f64,
}

/// Where a stage lies.
struct Place {
    name: String,
    work: Work,
    /// Wall-clock seconds, as if all threads had done it at once.
    seconds: f64,
}

/// Stages below the roofs.
pub(super) struct Roofline {
    /// 10⁹ operations per second.
    peak: f64,
    /// Name and 10⁹ bytes per second of each roof that slopes.
    slopes: Vec<(String, f64)>,
    places: Vec<Place>,
    /// What was assumed.
    pub note: String,
}

impl Roofline {
    /// That of a report.
    pub fn of(report: &Report) -> Self {
        let reads = report.peaks.read.iter();
        let mut roofline = Self {
            peak: report.peaks.gflops.greatest(),
            slopes: reads
                .map(|read| (read.level.clone(), read.gbytes.greatest()))
                .collect(),
            places: Vec::new(),
            note: String::new(),
        };
        let counts = serde_json::from_str::<Counts>(COUNTS);
        let case = report.cases.iter().find(|case| case.name == SCENE);
        let (Ok(counts), Some(case)) = (counts, case) else {
            roofline.note = "There are no counts of the box's kernels.".to_owned();
            return roofline;
        };
        roofline.note = format!(
            "Operations are single-precision additions, multiplications, quotients, roots, minima and maxima, a fused \
             multiply-add as two, counted of a build by {} on the box; comparisons and bit operations are none. Bytes are all that \
             instructions load and store, most of it from the first cache. Random numbers and the sorting of rays into \
             queues are bit operations, so a stage can be at its limit far below the roof.",
            counts.rustc
        );
        let work = |stage: &str| counts.work(stage, case);
        for stage in &case.stages {
            if let Some(work) = work(&stage.name) {
                roofline.places.push(Place {
                    name: stage.name.clone(),
                    work,
                    seconds: stage.thread_s.median() / report.threads as f64,
                });
            }
        }
        roofline
    }

    /// The drawing: logarithmic both ways.
    pub fn plot(&self) -> String {
        const LEAST: f64 = 0.05;
        const MOST: f64 = 20.0;
        let mut lines: Vec<Line> = self
            .places
            .iter()
            .enumerate()
            .map(|(colour, place)| Line {
                name: place.name.clone(),
                colour,
                style: Style::Dotted,
                points: vec![(place.intensity(), place.gflops())],
            })
            .collect();
        for (k, (level, slope)) in self.slopes.iter().enumerate() {
            let ridge = self.peak / slope;
            let roof = |x: f64| (x, (x * slope).min(self.peak));
            lines.push(Line {
                name: format!("roof: {level} {slope:.0} GB/s"),
                colour: k,
                style: Style::Dashed,
                points: [LEAST, ridge.clamp(LEAST, MOST), MOST].map(roof).into(),
            });
        }
        let plot = Plot {
            title: format!("The box’s stages below {:.0} GFLOP/s", self.peak),
            x: Axis::new(
                "operations for each byte that is loaded or stored",
                Scale::Logarithmic,
            ),
            y: Axis::new("10⁹ operations a second", Scale::Logarithmic),
            lines,
        };
        drawn(plot.svg())
    }

    /// The numbers in it.
    pub fn table(&self) -> String {
        let near = self
            .slopes
            .first()
            .map_or(f64::INFINITY, |(_, slope)| *slope);
        let rows = self.places.iter().map(|place| {
            let gbytes = place.work.bytes / place.seconds / 1e9;
            format!(
                "<tr><th scope=\"row\">{}</th><td>{:.2}</td><td>{:.1}</td><td>{:.1} %</td><td>{gbytes:.1}</td><td>{:.1} %</td></tr>",
                escape(&place.name),
                place.intensity(),
                place.gflops(),
                100.0 * place.gflops() / self.peak,
                100.0 * gbytes / near,
            )
        });
        format!(
            "<thead><tr><th scope=\"col\">stage</th><th scope=\"col\">operations a byte</th><th scope=\"col\">GFLOP/s</th>\
             <th scope=\"col\">of the peak</th><th scope=\"col\">GB/s</th><th scope=\"col\">of the first cache’s</th></tr></thead>\
             <tbody>{}</tbody>",
            rows.collect::<String>()
        )
    }
}

impl Place {
    fn intensity(&self) -> f64 {
        self.work.flops / self.work.bytes.max(1.0)
    }

    fn gflops(&self) -> f64 {
        self.work.flops / self.seconds / 1e9
    }
}

impl Counts {
    /// What a kernel takes for each element.
    fn each(&self, kernel: &str) -> Option<Work> {
        let count = self.cases.get(kernel)?;
        Some(Work {
            flops: count.flops / count.elements,
            bytes: (count.loaded_bytes + count.stored_bytes) / count.elements,
        })
    }

    /// What a stage takes in the scene: each of its kernels, as often as it ran.
    fn work(&self, stage: &str, case: &CaseReport) -> Option<Work> {
        let mut sum = Work::default();
        for (kernel, items) in kernels(stage, case) {
            let each = self.each(kernel)?;
            sum.flops += items * each.flops;
            sum.bytes += items * each.bytes;
        }
        Some(sum)
    }
}

/// The kernels that a stage consists of in a room of matte walls, and how many records each was given.
fn kernels(stage: &str, case: &CaseReport) -> Vec<(&'static str, f64)> {
    let paths = case.paths as f64;
    let last = case.path_length;
    let on = |edges: &dyn Fn(u32) -> bool, count: &dyn Fn(&Bounce) -> u64| -> f64 {
        let bounces = case.bounces.iter().filter(|bounce| edges(bounce.edge));
        bounces.map(|bounce| count(bounce) as f64).sum()
    };
    let items = |name: Stage| {
        move |bounce: &Bounce| {
            let stage = bounce.stages.iter().find(|stage| stage.name == name.name());
            stage.map_or(0, |stage| stage.items)
        }
    };
    let shadow_rays = on(&|_| true, &|bounce| bounce.shadow_rays);
    // What is accumulated on an edge: what rays met there, and its shadow rays.
    let met = |bounce: &Bounce| items(Stage::Accumulate)(bounce).saturating_sub(bounce.shadow_rays);
    match stage {
        "generate" => vec![("stages/generate/sobol", paths)],
        "intersect" => vec![
            ("stages/intersect/closest/camera", paths),
            (
                "stages/intersect/closest/bounce",
                on(&|edge| edge > 1 && edge < last, &|bounce| bounce.rays),
            ),
            (
                "stages/intersect/lights",
                on(&|edge| edge == last, &|bounce| bounce.rays),
            ),
            ("stages/intersect/shadow", shadow_rays),
        ],
        "shade" => vec![(
            "stages/shade/lambert/sobol",
            on(&|_| true, &items(Stage::Shade)),
        )],
        "nee" => vec![(
            "stages/nee/lambert/sobol",
            on(&|_| true, &items(Stage::Nee)),
        )],
        "accumulate" => vec![
            ("stages/accumulate/shadow-rays", shadow_rays),
            (
                "stages/accumulate/encounters",
                on(&|edge| edge < last, &met),
            ),
            (
                "stages/accumulate/last-edge",
                on(&|edge| edge == last, &met),
            ),
            ("stages/accumulate/film", paths),
        ],
        _ => Vec::new(),
    }
}
