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
