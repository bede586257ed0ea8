//! The plots of the page.

use crate::bench::Report;
use crate::bench::report::{Bounce, CaseReport, Scaling};
use crate::cli::bars::Bars;
use crate::cli::plot::{Axis, Line, Plot, Scale, Style};
use crate::wavefront::Stage;

/// Lines that are still told apart.
const MOST: usize = crate::cli::plot::MOST_LINES;

/// A drawing, or in its place why there is none.
pub(super) fn drawn(svg: std::result::Result<String, Box<dyn std::error::Error>>) -> String {
    svg.unwrap_or_else(|error| crate::cli::page::escape(&error.to_string()))
}

/// Where the time of a path goes, scene by scene.
pub(super) fn stages(report: &Report) -> String {
    let row = |case: &CaseReport| {
        let ns = |seconds: f64| 1e9 * seconds / case.paths.max(1) as f64;
        let parts = case.stages.iter().map(|stage| ns(stage.thread_s.median()));
        (case.name.clone(), parts.collect())
    };
    let bars = Bars {
        title: "Where the time goes".to_owned(),
        label: "nanoseconds of a thread for each camera path".to_owned(),
        parts: Stage::ALL
            .iter()
            .map(|stage| stage.name().to_owned())
            .collect(),
        rows: report.cases.iter().map(row).collect(),
    };
    drawn(bars.svg())
}

/// A line for each scene, over the edges of its paths.
fn by_edge(
    report: &Report,
    title: &str,
    label: &str,
    y: impl Fn(&CaseReport, &Bounce) -> f64,
) -> String {
    let line = |(place, case): (usize, &CaseReport)| Line {
        name: case.name.clone(),
        colour: place % MOST,
        style: if place < MOST {
            Style::Dotted
        } else {
            Style::Dashed
        },
        points: case
            .bounces
            .iter()
            .map(|bounce| (f64::from(bounce.edge), y(case, bounce)))
            .collect(),
    };
    let plot = Plot {
        title: title.to_owned(),
        x: Axis::new("path edge", Scale::Whole),
        y: Axis::from_zero(label),
        lines: report.cases.iter().enumerate().map(line).collect(),
    };
    drawn(plot.svg())
}

/// How many rays are alive at each edge.
pub(super) fn queues(report: &Report) -> String {
    by_edge(
        report,
        "Rays alive",
        "part of the camera paths",
        |case, bounce| bounce.rays as f64 / case.paths.max(1) as f64,
    )
}

/// How fast rays are intersected at each edge.
pub(super) fn bounces(report: &Report) -> String {
    by_edge(
        report,
        "Rays intersected",
        "million a second and thread",
        |_, bounce| bounce.mrays_per_s,
    )
}

/// Over threads, wave sizes and triangles.
pub(super) fn scaling(report: &Report) -> String {
    let by_number = |title: &str, label: &str, all: &[Scaling], scale: Scale| {
        let line = |(place, scaling): (usize, &Scaling)| Line {
            name: scaling.case.clone(),
            colour: place,
            style: Style::Dotted,
            points: scaling
                .points
                .iter()
                .map(|point| (point.at as f64, point.mpaths_per_s))
                .collect(),
        };
        Plot {
            title: title.to_owned(),
            x: Axis::new(label, scale),
            y: Axis::from_zero("million camera paths a second"),
            lines: all.iter().enumerate().map(line).collect(),
        }
    };
    let threads = by_number("Threads", "threads", &report.threads_scaling, Scale::Whole);
    let waves = by_number(
        "Size of waves",
        "paths that a worker carries",
        &report.wave_scaling,
        Scale::Logarithmic,
    );
    let plots = [threads, waves, triangles(report), builds(report)];
    let has_line = |plot: &&Plot| plot.lines.iter().any(|line| line.points.len() > 1);
    plots
        .iter()
        .filter(has_line)
        .map(|plot| format!("<figure class=\"plot\">{}</figure>", drawn(plot.svg())))
        .collect()
}

/// The scenes that differ in their number of triangles alone.
fn meshes(report: &Report) -> impl Iterator<Item = &CaseReport> {
    report
        .cases
        .iter()
        .filter(|case| case.name.starts_with("mesh-"))
}

fn triangles(report: &Report) -> Plot {
    let point = |case: &CaseReport| (case.triangles as f64, case.mrays_per_s);
    Plot {
        title: "Rays, by triangles".to_owned(),
        x: Axis::new("triangles", Scale::Logarithmic),
        y: Axis::from_zero("million rays a second"),
        lines: vec![Line {
            name: "mountains".to_owned(),
            colour: 0,
            style: Style::Dotted,
            points: meshes(report).map(point).collect(),
        }],
    }
}

fn builds(report: &Report) -> Plot {
    let point = |case: &CaseReport| (case.triangles as f64, case.build_s.median());
    Plot {
        title: "Building, by triangles".to_owned(),
        x: Axis::new("triangles", Scale::Logarithmic),
        y: Axis::new("seconds", Scale::Logarithmic),
        lines: vec![Line {
            name: "mountains".to_owned(),
            colour: 0,
            style: Style::Dotted,
            points: meshes(report).map(point).collect(),
        }],
    }
}
