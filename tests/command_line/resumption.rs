//! Renders that are killed, and go on.
#![cfg(target_os = "linux")]

use crate::small_disk::SmallDisk;
use crate::{command, folder, names, ondine};
use std::cell::Cell;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

const IMAGE: &str = "cornell --size 64x48 --no-png --quiet";

fn hash(folder: &Path, file: &str) -> Option<String> {
    let output = command(folder, &format!("info {file} --json"))
        .output()
        .unwrap();
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
    Some(info["image_hash"].as_str()?.to_owned())
}

fn blocks(folder: &Path, file: &str) -> u64 {
    let output = command(folder, &format!("info {file} --json"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{file} is whole: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let blocks: ondine::film::Coverage = info["blocks"].as_str().unwrap().parse().unwrap();
    blocks.len()
}

/// Kills the program with -9 at random moments until it has been killed so often, then lets it end. What there is after each
/// kill is for `look` to judge; where it was quick and ended by itself, `again` makes it begin anew.
fn kill(dir: &Path, line: &str, times: u32, mut look: impl FnMut(), mut again: impl FnMut()) {
    let mut kills = 0;
    let mut random = 12_345_u64;
    while kills < times {
        let mut child = command(dir, line)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // 10 to 200 ms: in loading, tracing, a checkpoint, the last write.
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        std::thread::sleep(Duration::from_millis(10 + (random >> 33) % 190));
        let ended = child.try_wait().unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
        look();
        match ended {
            Some(status) => {
                assert!(status.success(), "after {kills} kills");
                again();
            }
            None => kills += 1,
        }
    }
    let run = command(dir, line).output().unwrap();
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
}

#[test]
fn twenty_five_kills_lose_at_most_what_came_after_a_checkpoint() {
    let folder = folder();
    let dir = folder.path();
    let spp = 16 * 256;
    let line = format!("render {IMAGE} --spp {spp} --resume --checkpoint 0.02 -o image.exr");
    let once = format!("render {IMAGE} --spp {spp} -o once.exr");
    assert!(command(dir, &once).output().unwrap().status.success());

    // The most blocks that were ever in a file.
    let most = Cell::new(0);
    let begun = Cell::new(0);
    let look = || {
        let images = names(dir).into_iter();
        for name in images.filter(|name| name.ends_with(".exr") && name != "once.exr") {
            let held = blocks(dir, &name);
            assert!(
                held >= most.get(),
                "{name} has {held} blocks, and {} were there",
                most.get()
            );
            most.set(held);
            begun.set(begun.get().max(held));
        }
    };
    let again = || {
        assert_eq!(hash(dir, "image.exr"), hash(dir, "once.exr"));
        fs::remove_file(dir.join("image.exr")).unwrap();
        most.set(0);
    };
    kill(dir, &line, 25, look, again);
    assert!(begun.get() > 0, "no checkpoint was ever written");
    assert_eq!(
        names(dir),
        ["image.exr", "once.exr"],
        "nothing is left of the kills"
    );
    assert_eq!(hash(dir, "image.exr"), hash(dir, "once.exr"));

    // And once more: there is nothing to do.
    let written = || {
        fs::metadata(dir.join("image.exr"))
            .unwrap()
            .modified()
            .unwrap()
    };
    let before = written();
    let run = ondine(&folder, &line);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.starts_with("image.exr has all of it already"),
        "{}",
        run.stdout
    );
    assert_eq!(written(), before);
}

#[test]
fn twenty_five_kills_of_a_batch_leave_whole_files_and_the_same_images() {
    let folder = folder();
    let dir = folder.path();
    // Some are short, some long enough for checkpoints.
    let jobs = r#"version = 1
[defaults]
size = "32x24"
output = "out/{scene}-{spp}-{seed}.exr"
[[jobs]]
scene = ["cornell", "glossy"]
spp = [16, 2048]
seed = [0, 1, 2]
"#;
    fs::write(dir.join("jobs.toml"), jobs).unwrap();
    let line = "batch jobs.toml --checkpoint 0.02 --events events.ndjson --quiet";
    let look = || {
        let out = names(&dir.join("out")).into_iter();
        for name in out.filter(|name| name.ends_with(".exr")) {
            assert!(blocks(&dir.join("out"), &name) > 0, "{name} is whole");
        }
        let manifest = fs::read(dir.join("jobs.manifest.json")).unwrap_or(b"{}".to_vec());
        serde_json::from_slice::<serde_json::Value>(&manifest).expect("a whole manifest");
    };
    fs::create_dir(dir.join("out")).unwrap();
    let again = || {
        fs::remove_dir_all(dir.join("out")).unwrap();
        fs::create_dir(dir.join("out")).unwrap();
    };
    kill(dir, line, 25, look, again);

    let mut expected = Vec::new();
    for scene in ["cornell", "glossy"] {
        for (spp, seed) in [16, 2048]
            .into_iter()
            .flat_map(|spp| (0..3).map(move |seed| (spp, seed)))
        {
            let options =
                format!("--size 32x24 --spp {spp} --seed {seed} --no-png --quiet -o once.exr");
            let once = command(dir, &format!("render {scene} {options}"))
                .output()
                .unwrap();
            assert!(once.status.success());
            let name = format!("{scene}-{spp}-{seed}");
            let image = hash(dir, &format!("out/{name}.exr"));
            assert!(image.is_some() && image == hash(dir, "once.exr"), "{name}");
            expected.extend([format!("{name}.exr"), format!("{name}.png")]);
        }
    }
    expected.sort();
    assert_eq!(
        names(&dir.join("out")),
        expected,
        "nothing is left of the kills"
    );
    let status = command(dir, "batch jobs.toml --status").output().unwrap();
    assert!(
        status.status.success(),
        "{}",
        String::from_utf8_lossy(&status.stdout)
    );
    // Lines that a kill cut off aside, each event is an object.
    let events = fs::read_to_string(dir.join("events.ndjson")).unwrap();
    let whole = events
        .lines()
        .filter(|line| serde_json::from_str::<serde_json::Value>(line).is_ok());
    assert!(whole.count() >= 12);
}

#[test]
fn what_is_stopped_in_time_or_by_hand_goes_on() {
    let folder = folder();
    let render = |rest: &str| ondine(&folder, &format!("render {IMAGE} {rest}"));
    assert_eq!(render("--spp 256 -o once.exr").code, 0);
    let run = render("--spp 256 --time 0.05 -o image.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let first = blocks(folder.path(), "image.exr");
    assert!(first < 64 * 48 * 16, "{first} blocks in so short a time");
    let run = render("--spp 256 --resume -o image.exr --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.json();
    let paths = (64 * 48 * 16 - first) * 16;
    assert_eq!(report["paths"], paths, "only what was missing");
    assert_eq!(
        hash(folder.path(), "image.exr"),
        hash(folder.path(), "once.exr")
    );
    let seconds =
        |file: &str| ondine(&folder, &format!("info {file} --json")).json()["rays"].clone();
    assert_eq!(
        seconds("image.exr"),
        seconds("once.exr"),
        "rays of both runs"
    );
}

#[test]
fn another_image_is_not_resumed_and_not_lost() {
    let folder = folder();
    let render = |rest: &str| {
        let size = if rest.contains("--size") {
            ""
        } else {
            "--size 64x48"
        };
        ondine(
            &folder,
            &format!("render cornell --no-png --quiet {size} {rest}"),
        )
    };
    assert_eq!(render("--spp 32 --strategy light -o image.exr").code, 0);
    fs::rename(
        folder.path().join("image.exr"),
        folder.path().join("image.checkpoint.exr"),
    )
    .unwrap();
    let before = fs::read(folder.path().join("image.checkpoint.exr")).unwrap();
    for (options, words) in [
        ("--spp 64", "its strategy is light, and mis is asked for"),
        (
            "--spp 64 --strategy light --seed 3",
            "its seed is 0, and 3 is asked for",
        ),
        (
            "--spp 64 --strategy light --shard 1/2",
            "it is of the whole image, and shard 1/2 is asked for",
        ),
        (
            "--spp 16 --strategy light",
            "it has 32 samples per pixel, and 16 are asked for",
        ),
        (
            "--spp 64 --strategy light --size 65x48",
            "its size is 64x48, and 65x48 is asked for",
        ),
    ] {
        let run = render(&format!("{options} --resume -o image.exr"));
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{options}");
        let place = "image.checkpoint.exr: cannot be resumed: ";
        assert!(
            run.stderr.contains(place) && run.stderr.contains(words),
            "{}",
            run.stderr
        );
        assert!(run.stderr.contains("delete this file"), "{}", run.stderr);
    }
    assert_eq!(
        fs::read(folder.path().join("image.checkpoint.exr")).unwrap(),
        before
    );
    assert_eq!(names(folder.path()), ["image.checkpoint.exr"]);

    // A damaged one is of no use, and in no way.
    fs::write(
        folder.path().join("image.checkpoint.exr"),
        &before[..before.len() / 2],
    )
    .unwrap();
    let run = render("--spp 64 --resume -o image.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr.starts_with("warning: image.checkpoint.exr: "),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("rendered anew"), "{}", run.stderr);
    assert_eq!(names(folder.path()), ["image.exr"]);
}

#[test]
fn a_full_disk_keeps_the_old_checkpoint() {
    let Some(disk) = SmallDisk::new() else {
        eprintln!("not tested: this machine mounts no file system for a test");
        return;
    };
    let dir = disk.0.path();
    let image = "cornell --size 16x12 --no-png --quiet";
    let line = format!("render {image} --spp 64 -o old.exr");
    assert!(command(dir, &line).status().unwrap().success());
    fs::rename(dir.join("old.exr"), dir.join("image.checkpoint.exr")).unwrap();
    let old = hash(dir, "image.checkpoint.exr");
    assert!(old.is_some());
    // No room for a second.
    let filler = vec![1_u8; 1 << 16];
    let mut length = filler.len();
    while fs::write(dir.join("filler"), &filler[..length]).is_err() {
        length -= 1024;
    }
    let line =
        format!("render {image} --spp 4000000 --resume --checkpoint 0.05 --time 0.4 -o image.exr");
    let output = command(dir, &line).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(
        stderr.contains("warning: no checkpoint this time: "),
        "{stderr}"
    );
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("error: image.exr: cannot write"),
        "{stderr}"
    );
    assert_eq!(names(dir), ["filler", "image.checkpoint.exr"], "{stderr}");
    assert_eq!(hash(dir, "image.checkpoint.exr"), old);
}

#[test]
fn a_checkpoint_is_lost_to_no_render_that_does_not_go_on_from_it() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let render = |rest: &str| ondine(&folder, &format!("render {IMAGE} {rest} -o image.exr"));
    assert_eq!(render("--spp 128").code, 0);
    fs::rename(at("image.exr"), at("image.checkpoint.exr")).unwrap();
    let before = fs::read(at("image.checkpoint.exr")).unwrap();

    let run = render("--spp 16");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let note = "note: image.checkpoint.exr is the checkpoint of an earlier render, and stays";
    assert!(run.stderr.starts_with(note), "{}", run.stderr);
    let run = render("--spp 16 --checkpoint 1");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("add --resume"), "{}", run.stderr);
    assert_eq!(fs::read(at("image.checkpoint.exr")).unwrap(), before);

    // The image has fewer samples, the checkpoint more: the most counts, and then neither is needed but the whole.
    let run = render("--spp 256 --resume --json");
    let report = run.json();
    assert_eq!(report["paths"], 64 * 48 * 128, "{}", run.stderr);
    assert_eq!(names(folder.path()), ["image.exr"]);
}

#[test]
fn where_the_better_file_is_damaged_the_other_counts() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let render = |rest: &str| ondine(&folder, &format!("render {IMAGE} {rest}"));
    assert_eq!(render("--spp 64 -o image.exr").code, 0);
    assert_eq!(render("--spp 128 -o image.checkpoint.exr").code, 0);
    let mut bytes = fs::read(at("image.checkpoint.exr")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(at("image.checkpoint.exr"), bytes).unwrap();
    let run = render("--spp 256 --resume --json -o image.exr");
    assert!(
        run.stderr.starts_with("warning: image.checkpoint.exr: "),
        "{}",
        run.stderr
    );
    assert_eq!(run.json()["paths"], 64 * 48 * 192);
    assert_eq!(render("--spp 256 -o once.exr").code, 0);
    assert_eq!(
        hash(folder.path(), "image.exr"),
        hash(folder.path(), "once.exr")
    );
}
