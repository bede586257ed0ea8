//! The command lines of a plan: each is one line, of a length that a system takes, and may be run again.
#![cfg(unix)]

use super::plans::{script, status};
use crate::{Run, folder, ondine};
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn an_image_that_was_replaced_is_merged_again() {
    let folder = folder();
    let render = |spp: u32| {
        let text = format!(
            "version = 1\n[[jobs]]\nscene = \"cornell\"\nsize = \"8x6\"\nspp = {spp}\noutput = \"m.exr\"\n"
        );
        fs::write(folder.path().join("jobs.toml"), text).unwrap();
        assert_eq!(ondine(&folder, "batch jobs.toml --plan plan").code, 0);
        assert_eq!(script(&folder, "array.sbatch", Some(1)).code, 0);
        let run = script(&folder, "merge.sbatch", None);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let run = status(&folder);
        assert_eq!(
            (run.code, run.stdout.as_str()),
            (0, "1 of 1 shard, 1 of 1 image merged\n"),
            "{spp}"
        );
    };
    for spp in [16, 32, 16] {
        render(spp);
    }
    // What is merged is left alone, whatever the clock says; a picture that is missing is made.
    let (image, picture) = (folder.path().join("m.exr"), folder.path().join("m.png"));
    let written = || fs::metadata(&image).unwrap().modified().unwrap();
    let before = written();
    fs::remove_file(&picture).unwrap();
    let run = script(&folder, "merge.sbatch", None);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.starts_with("Left alone "), "{}", run.stdout);
    assert_eq!(written(), before);
    assert!(picture.exists());
    // One that is damaged is not.
    let mut bytes = fs::read(&image).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&image, bytes).unwrap();
    let run = script(&folder, "merge.sbatch", None);
    assert!(run.stdout.starts_with("Wrote "), "{}", run.stdout);
    let merges = fs::read_to_string(folder.path().join("plan/merges.txt")).unwrap();
    let line = format!("{} --json", merges.trim_end());
    let run: Run = Command::new("bash")
        .args(["-c", &line])
        .output()
        .unwrap()
        .into();
    assert_eq!(run.json()["skipped"], true);
    let none = ondine(&folder, "merge plan/parts/*.png -o m.exr");
    assert_eq!(none.code, 2);
    assert!(
        none.stderr
            .contains("plan/parts/*.png: no file matches this pattern; name a file"),
        "{}",
        none.stderr
    );
}

#[test]
fn a_plan_writes_no_line_that_another_could_hide_in() {
    let folder = folder();
    let scene = ondine(&folder, "scenes cornell").stdout;
    let hidden = scene.replace("[camera]", "[cameras.\"a\\ntouch PWN #\"]");
    assert_ne!(scene, hidden);
    fs::write(folder.path().join("room.toml"), &hidden).unwrap();
    let jobs = "version = 1\n[[jobs]]\nscene = \"room.toml\"\nsize = \"8x6\"\noutput = \"a.exr\"\n";
    fs::write(folder.path().join("jobs.toml"), jobs).unwrap();
    let refused = |folder: &Path, plan: &str, words: &str| {
        let mut command = crate::command(folder, "batch jobs.toml --plan");
        let run: Run = command.arg(plan).output().unwrap().into();
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{}", run.stderr);
        assert!(run.stderr.contains(words), "{}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        assert!(!folder.join(plan).exists());
    };
    refused(
        folder.path(),
        "plan",
        "room.toml: the camera \"a\\ntouch PWN #\" has a line break",
    );
    fs::write(folder.path().join("room.toml"), &scene).unwrap();
    refused(folder.path(), "pl\nan", "pl\\nan\" has a line break");
    let inner = folder.path().join("in\nner");
    fs::create_dir(&inner).unwrap();
    fs::write(inner.join("room.toml"), &scene).unwrap();
    fs::write(inner.join("jobs.toml"), jobs).unwrap();
    refused(&inner, "plan", "in\\nner");
    let several = jobs.replace("size", "set = { \"film.spp\" = [[1,\n2]] }\nsize");
    fs::write(folder.path().join("jobs.toml"), several).unwrap();
    // No such value: that is said before there is a line.
    let run = ondine(&folder, "batch jobs.toml --plan plan");
    assert_eq!(run.code, 2, "{}", run.stderr);
    let albedo = "set = { \"materials.white.albedo\" = [[0.5,\n0.5, 0.5]] }\nsize";
    fs::write(
        folder.path().join("jobs.toml"),
        jobs.replace("size", albedo),
    )
    .unwrap();
    refused(
        folder.path(),
        "plan",
        "set materials.white.albedo has a line break",
    );
}

#[test]
fn names_of_shards_are_short_however_long_an_output_is_called() {
    let folder = folder();
    let long = "a\u{e9}".repeat(40);
    let text = format!(
        "version = 1\n[[jobs]]\nscene = \"cornell\"\nsize = \"8x6\"\nspp = [1, 2]\noutput = \"{long}/{long}/{long}-{{spp}}.exr\"\n"
    );
    fs::write(folder.path().join("jobs.toml"), text).unwrap();
    assert_eq!(ondine(&folder, "batch jobs.toml --plan plan").code, 0);
    for task in [1, 2] {
        let run = script(&folder, "array.sbatch", Some(task));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    assert_eq!(script(&folder, "merge.sbatch", None).code, 0);
    assert_eq!(status(&folder).code, 0);
}

#[test]
fn thousands_of_shards_are_merged_by_one_line() {
    let folder = folder();
    let text = "version = 1\n[[jobs]]\nscene = \"cornell\"\nsize = \"64x64\"\nspp = 16\npng = false\noutput = \"m.exr\"\n";
    fs::write(folder.path().join("jobs.toml"), text).unwrap();
    assert_eq!(
        ondine(&folder, "batch jobs.toml --plan [plan] --shards 65536").code,
        0
    );
    let merges = fs::read_to_string(folder.path().join("[plan]/merges.txt")).unwrap();
    assert!(merges.len() < 4096, "{merges}");
    assert!(merges.contains(".*-of-4096.exr'"), "{merges}");
    // The folder's brackets are its own.
    let run: Run = Command::new("bash")
        .arg(folder.path().join("[plan]/merge.sbatch"))
        .output()
        .unwrap()
        .into();
    assert!(run.stderr.contains("no file matches"), "{}", run.stderr);
    let commands = fs::read_to_string(folder.path().join("[plan]/commands.txt")).unwrap();
    let first = commands.lines().next().unwrap();
    assert!(
        Command::new("bash")
            .args(["-c", first])
            .status()
            .unwrap()
            .success()
    );
    let run: Run = Command::new("bash")
        .arg(folder.path().join("[plan]/merge.sbatch"))
        .output()
        .unwrap()
        .into();
    assert!(
        run.stderr
            .contains("parts of the image are missing: shards 2/4096, 3/4096"),
        "{}",
        run.stderr
    );
}
