//! A report as a page with plots.

use super::plots;
use super::roofline::Roofline;
use super::text::lane_use;
use crate::bench::Report;
use crate::bench::against::{Change, Figure};
use crate::bench::report::CaseReport;
use crate::cli::page::{self, escape, policy};
use crate::error::Result;
use crate::film::write_whole;
use std::path::Path;

const PAGE: &str = include_str!("page/report.html");
const STYLE: &str = include_str!("page/report.css");

/// Writes the page: whole, or nothing.
///
/// # Errors
/// [`Error::Write`](crate::error::Error::Write).
pub(super) fn write(path: &Path, report: &Report, figures: Option<&[Figure]>) -> Result<()> {
    let roofline = Roofline::of(report);
    write_whole(path, |file| {
        page::fill(file, PAGE, |name| part(name, report, figures, &roofline))
    })
}

fn style() -> String {
    page::STYLE.to_owned() + STYLE
}

/// One part of the page.
fn part(name: &str, report: &Report, figures: Option<&[Figure]>, roofline: &Roofline) -> String {
    match name {
        "style" => style(),
        "style_hash" => policy(&style()),
        "headline" => headline(report),
        "class" => class(report).to_owned(),
        "summary" => summary(report),
        "suite" => format!("{} (version {})", report.suite, report.version),
        "threads" => report.threads.to_string(),
        "repeats" => report.repeats.to_string(),
        "cpu" => escape(&report.machine.cpu),
        "program" => escape(&report.machine.program),
        "figures" => key_figures(report),
        "against" => figures.map_or(String::new(), against),
        "scenes" => scenes(report),
        "stages" => stages(report),
        "stage_plot" => plots::stages(report),
        "bounces" => bounces(report),
        "queue_plot" => plots::queues(report),
        "bounce_plot" => plots::bounces(report),
        "scaling_plots" => plots::scaling(report),
        "roofline_plot" => roofline.plot(),
        "roofline" => roofline.table(),
        "roofline_note" => escape(&roofline.note),
        "records" => records(report),
        "machine" => machine(report),
        _ => String::new(),
    }
}

/// As the style sheet has verdicts.
fn class(report: &Report) -> &'static str {
    match (report.score.value, report.is_wrong()) {
        (Some(_), _) => "consistent",
        (None, true) => "biased",
        (None, false) => "bit-equal",
    }
}

fn headline(report: &Report) -> String {
    match report.score.value {
        Some(score) => format!("Score {score:.2}"),
        None => "No score".to_owned(),
    }
}

fn summary(report: &Report) -> String {
    match report.score.withheld.as_slice() {
        [] => "The geometric mean of the scenes’ rates, millions of camera paths a second. All images are right.".to_owned(),
        faults => {
            let faults: Vec<String> = faults.iter().map(|fault| escape(fault)).collect();
            format!("There is no score: {}.", faults.join("; "))
        }
    }
}

fn key_figures(report: &Report) -> String {
    let mut all = vec![(
        "Clock seen",
        format!("{:.2} GHz", report.clock_ghz.median()),
    )];
    all.push((
        "Peak",
        format!("{:.0} GFLOP/s", report.peaks.gflops.greatest()),
    ));
    for read in &report.peaks.read {
        if read.level == "memory" {
            all.push(("Memory", format!("{:.1} GB/s", read.gbytes.greatest())));
        }
    }
    if let Some(case) = report.cases.iter().find(|case| case.name == "box") {
        all.push(("The box", format!("{:.1} M rays/s", case.mrays_per_s)));
    }
    let figure =
        |(name, value): (&str, String)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>");
    all.into_iter().map(figure).collect()
}

/// A row of a table: its name, and cells.
fn row(name: &str, cells: &[String]) -> String {
    let cells: String = cells
        .iter()
        .map(|cell| format!("<td>{cell}</td>"))
        .collect();
    format!("<tr><th scope=\"row\">{}</th>{cells}</tr>", escape(name))
}

fn head(names: &[&str]) -> String {
    let cells: String = names
        .iter()
        .map(|name| format!("<th scope=\"col\">{name}</th>"))
        .collect();
    format!("<thead><tr>{cells}</tr></thead>")
}

fn against(figures: &[Figure]) -> String {
    let count = |change| {
        figures
            .iter()
            .filter(|figure| figure.change == change)
            .count()
    };
    let rows = figures
        .iter()
        .filter(|figure| figure.change != Change::Same)
        .map(|figure| {
            let (word, class) = match figure.change {
                Change::Slower => ("slower", "slower"),
                _ => ("faster", "faster"),
            };
            let [then, now] = figure.seconds;
            let percent = format!("{:+.1} %", 100.0 * (figure.ratio - 1.0)).replace('-', "−");
            row(
                &figure.name,
                &[
                    format!("{:.2}", 1e3 * then),
                    format!("{:.2}", 1e3 * now),
                    percent,
                    format!("<span class=\"{class}\">{word}</span>"),
                ],
            )
        });
    let rows: String = rows.collect();
    let table = match rows.is_empty() {
        true => String::new(),
        false => format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"against\"><table>{}<tbody>{rows}</tbody></table></div>",
            head(&["", "before, ms", "now, ms", "time", ""])
        ),
    };
    format!(
        "<section aria-labelledby=\"against\"><h2 id=\"against\">Against the earlier run</h2><p>{} faster, {} slower, {} the same \
         within noise.</p>{table}</section>",
        count(Change::Faster),
        count(Change::Slower),
        count(Change::Same)
    )
}

fn scenes(report: &Report) -> String {
    let rows = report.cases.iter().map(|case| {
        let on_meshes = |text: String| match case.triangles {
            0 => "–".to_owned(),
            _ => text,
        };
        let cells = [
            format!("{:.2}", case.mpaths_per_s),
            format!("{:.1} %", 100.0 * case.render_s.spread()),
            format!("{:.1}", case.mrays_per_s),
            on_meshes(case.triangles.to_string()),
            on_meshes(format!("{:.1}", 1e3 * case.build_s.median())),
            on_meshes(
                case.bytes_per_triangle
                    .map_or(String::new(), |bytes| format!("{bytes:.0}")),
            ),
            format!("{:.0}", case.queue_bytes_per_ray),
            format!("{:.1} %", 100.0 * lane_use(case)),
            image(case),
        ];
        let title = format!("<small>{}</small></th>", escape(&case.title));
        row(&case.name, &cells).replacen("</th>", &title, 1)
    });
    let names = [
        "",
        "M paths/s",
        "spread",
        "M rays/s",
        "triangles",
        "build, ms",
        "bytes a triangle",
        "bytes a ray",
        "lanes live",
        "image",
    ];
    format!(
        "{}<tbody>{}</tbody>",
        head(&names),
        rows.collect::<String>()
    )
}

fn image(case: &CaseReport) -> String {
    match (case.fault(), case.proof.detectable) {
        (Some(_), _) => "<span class=\"wrong\">wrong</span>".to_owned(),
        (None, Some(bias)) => format!(
            "<span class=\"right\">right within {:.1} %</span>",
            100.0 * bias
        ),
        (None, None) => "<span class=\"right\">right</span>".to_owned(),
    }
}

fn stages(report: &Report) -> String {
    let mut rows = String::new();
    for case in &report.cases {
        for (place, stage) in case.stages.iter().enumerate() {
            let cells = [
                stage.name.clone(),
                stage.items.to_string(),
                format!(
                    "{:.2}",
                    1e9 * stage.thread_s.median() / stage.items.max(1) as f64
                ),
                format!("{:.1}", stage.mitems_per_s),
                format!("{:.1} %", 100.0 * stage.lane_use),
                format!("{:.1} %", 100.0 * stage.thread_s.spread()),
            ];
            let name = if place == 0 { &case.name } else { "" };
            let line = row(name, &cells).replacen("<td>", "<td class=\"text\">", 1);
            rows += &match place {
                0 => line.replacen("<tr>", "<tr class=\"first\">", 1),
                _ => line,
            };
        }
    }
    let names = [
        "",
        "stage",
        "records",
        "ns a record",
        "M records/s a thread",
        "lanes live",
        "spread",
    ];
    format!("{}<tbody>{rows}</tbody>", head(&names))
}

fn bounces(report: &Report) -> String {
    let mut rows = String::new();
    for case in &report.cases {
        for bounce in &case.bounces {
            let time: f64 = bounce.stages.iter().map(|stage| stage.thread_s).sum();
            let cells = [
                bounce.edge.to_string(),
                bounce.rays.to_string(),
                bounce.shadow_rays.to_string(),
                format!("{:.0}", bounce.queue),
                format!("{:.1}", bounce.mrays_per_s),
                format!("{:.1}", 1e9 * time / case.paths.max(1) as f64),
                format!("{:.1} %", 100.0 * bounce.lane_use),
            ];
            let is_first = bounce.edge == 1;
            let line = row(if is_first { &case.name } else { "" }, &cells);
            rows += &match is_first {
                true => line.replacen("<tr>", "<tr class=\"first\">", 1),
                false => line,
            };
        }
    }
    let names = [
        "",
        "edge",
        "rays",
        "shadow rays",
        "rays in a wave’s queue",
        "M rays/s a thread",
        "ns a path",
        "lanes live",
    ];
    format!("{}<tbody>{rows}</tbody>", head(&names))
}

fn records(report: &Report) -> String {
    let rows = report.records.iter();
    let rows: String = rows
        .map(|record| row(&record.name, &[format!("{:.0}", record.bytes)]))
        .collect();
    format!("{}<tbody>{rows}</tbody>", head(&["", "bytes"]))
}

fn machine(report: &Report) -> String {
    let machine = &report.machine;
    let gibibytes = |bytes: u64| format!("{:.1} GiB", bytes as f64 / (1u64 << 30) as f64);
    let clocks = report.clock_ghz.samples().iter();
    let (low, high) = clocks.fold((f64::INFINITY, 0.0_f64), |(low, high), &clock| {
        (low.min(clock), high.max(clock))
    });
    let reads = report.peaks.read.iter();
    let reads: Vec<String> = reads
        .map(|read| format!("{} {:.1} GB/s", read.level, read.gbytes.greatest()))
        .collect();
    let rows = [
        ("Processor", machine.cpu.clone()),
        ("Processors", machine.processors.to_string()),
        (
            "Clock seen",
            format!(
                "{:.2} GHz, {low:.2} to {high:.2}",
                report.clock_ghz.median()
            ),
        ),
        ("Caches", machine.caches.clone()),
        (
            "Memory",
            machine.memory_bytes.map_or(String::new(), gibibytes),
        ),
        (
            "Most of it used",
            report.peak_rss_bytes.map_or(String::new(), gibibytes),
        ),
        ("System", machine.system.clone()),
        ("Compiled for", machine.target_features.clone()),
        ("Compiler", machine.compiler.clone()),
        ("Flags", machine.flags.clone()),
        (
            "Peak",
            format!(
                "{:.0} GFLOP/s; reads: {}",
                report.peaks.gflops.greatest(),
                reads.join(", ")
            ),
        ),
        (
            "Disturbed",
            format!(
                "{} measurements were taken again, {} kept although other programs were busy",
                report.disturbed, report.accepted
            ),
        ),
    ];
    let rows = rows.iter().map(|(name, value)| row(name, &[escape(value)]));
    format!("<tbody>{}</tbody>", rows.collect::<String>())
}
