//! A report as tables.

use crate::bench::Report;
use crate::bench::against::{self, Change, Figure};
use crate::bench::report::{CaseReport, Scaling};
use crate::wavefront::Stage;
use std::fmt::Write;

/// Everything, for people.
pub(super) fn text(report: &Report) -> String {
    let mut text = machine(report);
    text += &scenes(report);
    text += &stages(report);
    text += &scaling("threads", &report.threads_scaling);
    text += &scaling("paths of a wave", &report.wave_scaling);
    text += &score(report);
    text
}

fn machine(report: &Report) -> String {
    let machine = &report.machine;
    let clock = report.clock_ghz.median();
    let memory = machine.memory_bytes.map_or(String::new(), |bytes| {
        format!(", {:.0} GiB", bytes as f64 / (1u64 << 30) as f64)
    });
    let caches = match machine.caches.as_str() {
        "" => String::new(),
        caches => format!(", {caches}"),
    };
    let threads = super::super::report::counted(report.threads, "thread");
    let reads = report.peaks.read.iter();
    let reads: Vec<String> = reads
        .map(|read| format!("{} {:.0}", read.level, read.gbytes.greatest()))
        .collect();
    format!(
        "{program}, suite {suite} (version {version}), {threads}, medians of {repeats}\n\
         {cpu}, {processors} processors at {clock:.2} GHz{caches}{memory}; {system}\n\
         Compiled for {features} by {compiler}, {flags}\n\
         Peaks: {gflops:.0} GFLOP/s; reads {reads} GB/s; before each measurement L1 {pace:.0}, spread {spread:.1} %\n\n",
        program = machine.program,
        suite = report.suite,
        version = report.version,
        repeats = report.repeats,
        cpu = machine.cpu,
        processors = machine.processors,
        system = machine.system,
        features = machine.target_features,
        compiler = machine.compiler,
        flags = machine.flags,
        gflops = report.peaks.gflops.greatest(),
        reads = reads.join(", "),
        pace = report.pace_gbytes.median(),
        spread = 100.0 * report.pace_gbytes.spread(),
    )
}

fn scenes(report: &Report) -> String {
    let mut text = format!(
        "{:10} {:>9} {:>8} {:>7} {:>8} {:>9} {:>6} {:>7} {:>7}  image\n",
        "scene",
        "Mpaths/s",
        "spread",
        "Mrays/s",
        "build ms",
        "triangles",
        "B/tri",
        "B/ray",
        "lanes"
    );
    for case in &report.cases {
        let (build, triangles, bytes) = match case.triangles {
            0 => ["-"; 3].map(str::to_owned).into(),
            n => (
                format!("{:.1}", 1e3 * case.build_s.median()),
                n.to_string(),
                case.bytes_per_triangle
                    .map_or("-".to_owned(), |bytes| format!("{bytes:.0}")),
            ),
        };
        let _ = writeln!(
            text,
            "{:10} {:>9.2} {:>6.1} % {:>7.1} {build:>8} {triangles:>9} {bytes:>6} {:>7.0} {:>5.1} %  {}",
            case.name,
            case.mpaths_per_s,
            100.0 * case.render_s.spread(),
            case.mrays_per_s,
            case.queue_bytes_per_ray,
            100.0 * lane_use(case),
            image(case)
        );
    }
    text + "\n"
}

/// Mean part of the lanes that were live, all stages together.
pub(super) fn lane_use(case: &CaseReport) -> f64 {
    let items: f64 = case.stages.iter().map(|stage| stage.items as f64).sum();
    let lanes: f64 = case
        .stages
        .iter()
        .map(|stage| stage.items as f64 / stage.lane_use.max(1e-9))
        .sum();
    items / lanes.max(1.0)
}

fn image(case: &CaseReport) -> String {
    match (case.fault(), case.proof.detectable) {
        (Some(_), _) => "WRONG".to_owned(),
        (None, Some(bias)) => format!("right within {:.1} %", 100.0 * bias),
        (None, None) => "right".to_owned(),
    }
}

fn stages(report: &Report) -> String {
    let mut text = format!("{:10}", "ns a path");
    for stage in Stage::ALL {
        let _ = write!(text, " {:>10}", stage.name());
    }
    text += "      other   (of one thread)\n";
    for case in &report.cases {
        let _ = write!(text, "{:10}", case.name);
        let paths = case.paths.max(1) as f64;
        let mut all = 0.0;
        for stage in &case.stages {
            let ns = 1e9 * stage.thread_s.median() / paths;
            all += ns;
            let _ = write!(text, " {ns:>10.1}");
        }
        let whole = 1e9 * case.render_s.median() * report.threads as f64 / paths;
        let _ = writeln!(text, " {:>10.1}", (whole - all).max(0.0));
    }
    text + "\n"
}

fn scaling(unit: &str, all: &[Scaling]) -> String {
    let mut text = String::new();
    for Scaling { case, points } in all {
        let Some(first) = points.first() else {
            continue;
        };
        let _ = write!(text, "{case:10}");
        for point in points {
            let ratio = point.mpaths_per_s / first.mpaths_per_s;
            let _ = write!(
                text,
                "  {}: {:.2} ({ratio:.2}x)",
                point.at, point.mpaths_per_s
            );
        }
        text += "\n";
    }
    match text.is_empty() {
        true => text,
        false => format!("Mpaths/s by {unit}\n{text}\n"),
    }
}

fn score(report: &Report) -> String {
    let mut text = String::new();
    if report.accepted > 0 {
        let _ = writeln!(
            text,
            "Other programs kept the processors busy: {} measurements were taken again, and {} kept although they did.",
            report.disturbed, report.accepted
        );
    }
    match report.score.value {
        Some(score) => {
            let _ = writeln!(
                text,
                "Score {score:.3}: the geometric mean of the scenes, Mpaths/s; all images are right."
            );
        }
        None => {
            let _ = writeln!(text, "No score:\n  {}", report.score.withheld.join("\n  "));
        }
    }
    text
}

/// What became of each figure.
pub(super) fn against(old: &Report, new: &Report, figures: &[Figure], noise: f64) -> String {
    let mut text = String::from("\nAgainst the old report, seconds:\n");
    if old.machine.differs(&new.machine) {
        let _ = writeln!(
            text,
            "  another machine: {:?}, {} processors",
            old.machine.cpu, old.machine.processors
        );
    }
    for (what, old, new) in [
        ("compiler", &old.machine.compiler, &new.machine.compiler),
        (
            "target",
            &old.machine.target_features,
            &new.machine.target_features,
        ),
        ("flags", &old.machine.flags, &new.machine.flags),
    ] {
        if old != new {
            let _ = writeln!(text, "  another {what}: {old:?}");
        }
    }
    if old.is_wrong() {
        text += "  an image of the old run was wrong: its times may be those of other work\n";
    }
    let pace = against::pace(old, new);
    if (pace - 1.0).abs() > 0.01 {
        let percent = 100.0 * (pace - 1.0);
        let _ = writeln!(
            text,
            "  the machine itself was {:.0} % {}: others share its cores, or its clock changed; so much is not called a change",
            percent.abs(),
            if percent > 0.0 { "faster" } else { "slower" },
        );
    }
    let count = |change| {
        figures
            .iter()
            .filter(|figure| figure.change == change)
            .count()
    };
    for figure in figures
        .iter()
        .filter(|figure| figure.change != Change::Same)
    {
        let word = match figure.change {
            Change::Slower => "SLOWER",
            _ => "faster",
        };
        let [then, now] = figure.seconds;
        let percent = 100.0 * (figure.ratio - 1.0);
        let name = &figure.name;
        let _ = writeln!(
            text,
            "  {word} {name:32} {then:.5} -> {now:.5}  {percent:+.1} %"
        );
    }
    let _ = writeln!(
        text,
        "  {} faster, {} slower, {} the same within noise ({noise} %, and ranks of p < 0.001)",
        count(Change::Faster),
        count(Change::Slower),
        count(Change::Same)
    );
    text
}
