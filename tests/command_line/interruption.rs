//! Ctrl-C: what there is gets written.
#![cfg(target_os = "linux")]

use crate::{Run, command, folder, names, ondine};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A render that goes on for hours, once it has traced for a while.
fn start(folder: &Path, line: &str) -> Child {
    let child = command(folder, line)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while ticks(&child) < 30 {
        assert!(
            begin.elapsed() < Duration::from_secs(60),
            "it does not work"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// Processor time in user mode, in hundredths of a second: field 14 of `proc_pid_stat(5)`.
fn ticks(child: &Child) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    let after_name = stat.rsplit_once(") ").unwrap().1;
    after_name.split(' ').nth(11).unwrap().parse().unwrap()
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    let status = Command::new("kill").args([name, &id]).status().unwrap();
    assert!(status.success());
}

fn end(child: Child) -> Run {
    child.wait_with_output().unwrap().into()
}

#[test]
fn an_interrupted_render_writes_what_it_has_and_says_so() {
    for name in ["-INT", "-TERM"] {
        let folder = folder();
        let line = "render cornell --size 48x48 --spp 10000000 --wave 256 --json";
        let child = start(folder.path(), line);
        signal(&child, name);
        let run = end(child);
        assert_eq!(run.code, 130, "{}", run.stderr);
        assert!(
            run.stderr.starts_with("interrupted after "),
            "{}",
            run.stderr
        );
        assert!(
            run.stderr.contains("of 10000000 samples per pixel"),
            "{}",
            run.stderr
        );
        assert_eq!(run.stderr.lines().count(), 1);
        assert_eq!(names(folder.path()), ["cornell.exr", "cornell.png"]);

        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(json["interrupted"], true);
        assert_eq!(json["spp"], 10_000_000);
        let info = ondine(&folder, "info cornell.exr --json").json();
        assert_eq!(info["interrupted"], true);
        assert_eq!(info["samples"], json["samples"], "what the film counted");
        assert_eq!(info["image_hash"], json["image_hash"]);
        let range = &info["sample_ranges"][0];
        assert_eq!(
            (&range["start"], &range["end"]),
            (&0.into(), &info["samples"]["min"])
        );
        assert!(
            ondine(&folder, "info cornell.exr")
                .stdout
                .contains("interrupted")
        );
    }
}

#[test]
fn a_second_interrupt_ends_at_once() {
    let folder = folder();
    // In a closed room no path ends, so this wave takes hours.
    let line = "render furnace --size 256x256 --spp 16 --wave 1048576 --path-length 10000";
    let mut child = start(folder.path(), line);
    signal(&child, "-INT");
    std::thread::sleep(Duration::from_millis(200));
    assert!(child.try_wait().unwrap().is_none(), "it waits for its wave");
    signal(&child, "-INT");
    let run = end(child);
    assert_eq!((run.code, run.stdout.as_str()), (130, ""));
    assert!(names(folder.path()).is_empty());
}

#[test]
fn an_interrupted_batch_keeps_what_is_done_and_goes_on() {
    let folder = folder();
    let seeds: Vec<String> = (0..100).map(|seed| seed.to_string()).collect();
    let jobs = format!(
        "version = 1\n[[jobs]]\nscene = \"cornell\"\nsize = \"48x48\"\nspp = 64\npng = false\nseed = [{}]\noutput = \"out/{{seed}}.exr\"\n",
        seeds.join(", ")
    );
    std::fs::write(folder.path().join("jobs.toml"), jobs).unwrap();
    let line = "batch jobs.toml --json --events events.ndjson";
    let mut child = command(folder.path(), line)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let events = folder.path().join("events.ndjson");
    let ended = || std::fs::read_to_string(&events).map_or(0, |text| text.lines().count());
    while ended() < 3 {
        assert!(child.try_wait().unwrap().is_none(), "it ends too early");
        std::thread::sleep(Duration::from_millis(5));
    }
    signal(&child, "-INT");
    let run = end(child);
    assert_eq!(run.code, 130, "{}", run.stderr);
    assert!(
        run.stderr.starts_with("interrupted after "),
        "{}",
        run.stderr
    );
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let done = report["done"].as_u64().unwrap();
    assert!(done >= 3, "{report}");
    assert_eq!(done + report["remaining"].as_u64().unwrap(), 100);
    let is_image = |name: &String| !name.contains("checkpoint");
    let out = folder.path().join("out");
    assert_eq!(
        names(&out).iter().filter(|name| is_image(name)).count() as u64,
        done
    );

    let again = ondine(&folder, line).json();
    assert_eq!(again["skipped"], done);
    assert_eq!(again["done"], 100 - done);
    assert_eq!(names(&out).len(), 100, "no checkpoint is left");
    let hash = |line: &str| ondine(&folder, line).json()["image_hash"].clone();
    // The first that was under way, and one that was not begun.
    for seed in [done, 99] {
        let alone = hash(&format!(
            "render cornell --size 48x48 --spp 64 --seed {seed} --json"
        ));
        assert_eq!(hash(&format!("info out/{seed}.exr --json")), alone);
    }
}
