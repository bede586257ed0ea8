//! `ondine bench`.

use super::refusals::refuses;
use crate::{folder, names, ondine};

#[test]
fn a_scene_is_measured_and_held_against_another_run() {
    let folder = folder();
    let quick = "bench --scenes mesh-1e4 --threads 2 --repeat 8 --no-scaling --quiet";
    let run = ondine(
        &folder,
        &format!("{quick} --json old.json --html page.html"),
    );
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("right within"), "{}", run.stdout);
    assert!(run.stdout.contains("not all scenes of the suite were run"));
    assert_eq!(names(folder.path()), ["old.json", "page.html"]);

    // Whatever the machine does meanwhile, it is less than a hundred times as slow.
    let old = folder.path().join("old.json");
    let text = std::fs::read_to_string(&old).unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["cases"][0]["triangles"], 10_082);
    let times = &report["cases"][0]["render_s"]["samples"];
    let mut quicker = report.clone();
    let part = |time: &serde_json::Value| serde_json::json!(time.as_f64().unwrap() / 100.0);
    quicker["cases"][0]["render_s"]["samples"] =
        times.as_array().unwrap().iter().map(part).collect();
    std::fs::write(&old, quicker.to_string()).unwrap();
    let run = ondine(&folder, &format!("{quick} --json - --compare old.json"));
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    assert!(
        run.stderr.contains("SLOWER mesh-1e4: render"),
        "{}",
        run.stderr
    );
    let printed: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(printed["cases"][0]["proof"]["same_bits"], true);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let folder = folder();
    std::fs::write(folder.path().join("empty.json"), "{}").unwrap();
    let cases: &[(&str, &[&str])] = &[
        (
            "--scenes bix",
            &["did you mean \"box\"", "mesh-1e7, lights"],
        ),
        (
            "--scenes mesh-1e7",
            &["not in the suite quick", "--suite full"],
        ),
        ("--suite big", &["quick, full"]),
        ("--threads 0", &["from 1 to 1024"]),
        ("--threads 1,x", &["from 1 to 1024"]),
        ("--repeat 0", &["from 1 to"]),
        ("--noise -4", &["from 0 to 100"]),
        ("--compare none.json", &["none.json", "cannot read"]),
        (
            "--compare empty.json",
            &["empty.json", "ondine bench --json"],
        ),
        ("--json x.json --html x.json", &["x.json", "two outputs"]),
        ("--json gone/x.json", &["gone/x.json", "does not exist"]),
        ("--export empty.json", &["empty.json", "cannot write"]),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("bench {arguments}"), words);
    }
}
