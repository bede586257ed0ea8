//! What is called faster and slower.

use crate::right;
use ondine::bench::against::{Change, Figure, NOISE, compare, read};
use ondine::bench::report::Scaling;
use ondine::bench::series::Series;
use ondine::bench::{Report, report};

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
        let figures = compare(&old, &made_up(measured, factor), NOISE).unwrap();
        all_are(&figures, change);
        assert!((figures[0].ratio - factor).abs() < 1e-9);
    }
    let figures = compare(&old, &made_up(measured, 1.02), 0.01).unwrap();
    all_are(&figures, Change::Slower);
    // One measurement alone is no proof, however far off.
    let figures = compare(measured, &made_up(measured, 3.0), NOISE).unwrap();
    assert!(figures.iter().all(|figure| figure.change == Change::Same));

    let other = |change: &dyn Fn(&mut Report)| {
        let mut new = old.clone();
        change(&mut new);
        compare(&old, &new, NOISE).unwrap_err().to_string()
    };
    assert!(other(&|new| new.suite = "full".to_owned()).contains("suite"));
    assert!(other(&|new| new.threads = 64).contains("threads of 2"));
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
