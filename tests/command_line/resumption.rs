//! Renders that are killed, and go on.
#![cfg(target_os = "linux")]

use crate::small_disk::SmallDisk;
use crate::{command, folder, names, ondine};
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

#[test]
fn twenty_five_kills_lose_at_most_what_came_after_a_checkpoint() {
    let folder = folder();
    let dir = folder.path();
    let spp = 16 * 256;
    let line = format!("render {IMAGE} --spp {spp} --resume --checkpoint 0.02 -o image.exr");
    let once = format!("render {IMAGE} --spp {spp} -o once.exr");
    assert!(command(dir, &once).status().unwrap().success());

    let (mut kills, mut most) = (0, 0);
    let mut wait = 12_345_u64;
    loop {
        let mut child = command(dir, &line)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // 10 to 200 ms: in loading, tracing, a checkpoint, the last write.
        wait = wait
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        if kills < 25 {
            std::thread::sleep(Duration::from_millis(10 + (wait >> 33) % 190));
        }
        let ended = match kills < 25 {
            true => child.try_wait().unwrap(),
            false => Some(child.wait().unwrap()),
        };
        if let Some(status) = ended {
            assert!(status.success(), "after {kills} kills");
            if kills == 25 {
                break;
            }
            // It was quick: once more from the beginning.
            assert_eq!(hash(dir, "image.exr"), hash(dir, "once.exr"));
            fs::remove_file(dir.join("image.exr")).unwrap();
            most = 0;
            continue;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        for name in names(dir)
            .iter()
            .filter(|name| name.ends_with(".exr") && *name != "once.exr")
        {
            let held = blocks(dir, name);
            assert!(held >= most, "{name} had {most} blocks and has {held}");
            most = held;
        }
    }
    assert!(most > 0, "no checkpoint was ever written");
    assert_eq!(
        names(dir),
        ["image.exr", "once.exr"],
        "nothing is left of the kills"
    );
    assert_eq!(hash(dir, "image.exr"), hash(dir, "once.exr"));

    // And once more: there is nothing to do.
    let before = fs::metadata(dir.join("image.exr"))
        .unwrap()
        .modified()
        .unwrap();
    let run = ondine(&folder, &line);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.starts_with("image.exr has all of it already"),
        "{}",
        run.stdout
    );
    assert_eq!(
        fs::metadata(dir.join("image.exr"))
            .unwrap()
            .modified()
            .unwrap(),
        before
    );
}

#[test]
fn what_is_stopped_in_time_or_by_hand_goes_on() {
    let folder = folder();
    let render = |rest: &str| ondine(&folder, &format!("render {IMAGE} {rest}"));
    assert_eq!(render("--spp 256 -o once.exr").code, 0);
    let run = render("--spp 256 --time 0.001 -o image.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let first = blocks(folder.path(), "image.exr");
    assert!(first < 64 * 48 * 16, "{first} blocks in a millisecond");
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
