//! What is called faster and slower.

use crate::{plan, right};
use ondine::bench::against::{Change, Figure, NOISE, check, compare, read};
use ondine::bench::report::Scaling;
use ondine::bench::series::Series;
use ondine::bench::{Plan, Report, report};

/// A report whose times are made up: nine of each, within half a percent, times a factor.
fn made_up(report: &Report, factor: f64) -> Report {
    let mut made = report.clone();
    let times = |median: f64| -> Series {
        let part = |i: i32| 1.0 + 0.001 * f64::from((i * 7) % 9 - 4);
        (0..9).map(|i| median * factor * part(i)).collect()
    };
    for case in &mut made.cases {
        case.render_s = times(0.5);
        case.build_s = times(0.1);
        for stage in &mut case.stages {
            stage.thread_s = times(0.2);
        }
    }
    let scalings = made
        .threads_scaling
        .iter_mut()
        .chain(&mut made.wave_scaling);
    for Scaling { points, .. } in scalings {
        points
            .iter_mut()
            .for_each(|point| point.render_s = times(0.5));
    }
    made
}

#[track_caller]
fn all_are(figures: &[Figure], change: Change) {
    assert!(figures.len() > 5);
    for figure in figures {
        assert_eq!(figure.change, change, "{figure:?}");
    }
}

#[test]
fn more_than_noise_is_a_change() {
    let measured = right();
    let old = made_up(measured, 1.0);
    for (factor, change) in [
        (1.0, Change::Same),
        (1.02, Change::Same),
        (0.98, Change::Same),
        (1.05, Change::Slower),
        (0.95, Change::Faster),
    ] {
        let figures = compare(&old, &made_up(measured, factor), NOISE);
        all_are(&figures, change);
        assert!((figures[0].ratio - factor).abs() < 1e-9);
    }
    let figures = compare(&old, &made_up(measured, 1.02), 0.01);
    all_are(&figures, Change::Slower);
    // One measurement alone is no proof, however far off.
    let figures = compare(measured, &made_up(measured, 3.0), NOISE);
    assert!(figures.iter().all(|figure| figure.change == Change::Same));

    // The machine itself was a tenth slower: so much is not called a change, but more is.
    let mut slow = made_up(measured, 1.1);
    slow.pace_gbytes = old
        .pace_gbytes
        .samples()
        .iter()
        .map(|pace| pace / 1.1)
        .collect();
    all_are(&compare(&old, &slow, NOISE), Change::Same);
    let mut slower = made_up(measured, 1.2);
    slower.pace_gbytes = slow.pace_gbytes.clone();
    all_are(&compare(&old, &slower, NOISE), Change::Slower);
    // It was faster, and the program not.
    let mut fast = made_up(measured, 1.05);
    fast.pace_gbytes = old
        .pace_gbytes
        .samples()
        .iter()
        .map(|pace| pace * 1.1)
        .collect();
    all_are(&compare(&old, &fast, NOISE), Change::Slower);
}

#[test]
fn only_equal_work_is_compared_and_often_enough() {
    let mut old = right().clone();
    old.repeats = 9;
    let plan = Plan {
        repeats: 9,
        ..plan(false)
    };
    check(&old, &plan).unwrap();
    let refusal = |change: &dyn Fn(&mut Report)| {
        let mut old = old.clone();
        change(&mut old);
        check(&old, &plan).unwrap_err().to_string()
    };
    assert!(refusal(&|old| old.suite = "full".to_owned()).contains("suite full"));
    assert!(refusal(&|old| old.threads = 64).contains("threads of 64"));
    assert!(refusal(&|old| old.repeats = 7).contains("--repeat 8"));
    assert!(refusal(&|old| old.cases.clear()).contains("other scenes"));
}

#[test]
fn what_is_no_report_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("old.json");
    let refusal = |text: &str| {
        std::fs::write(&file, text).unwrap();
        read(&file).unwrap_err().to_string()
    };
    for (text, words) in [
        ("", "no JSON"),
        ("[1, 2]", "no report of a suite"),
        ("{\"version\": 99}", "version 99"),
        ("{\"version\": 1, \"suite\": 3}", "damaged"),
    ] {
        let refused = refusal(text);
        assert!(
            refused.contains(words) && refused.contains("old.json"),
            "{refused}"
        );
    }
    assert_eq!(report::VERSION, 1, "the texts above are of this version");
    let gone = read(&folder.path().join("none.json"))
        .unwrap_err()
        .to_string();
    assert!(gone.contains("cannot read"), "{gone}");
}
