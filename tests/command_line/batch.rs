//! `ondine batch`: what is rendered, what is left alone, and what it tells.

use crate::{Run, folder, names, ondine};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

const JOBS: &str = r#"version = 1
[defaults]
spp = 4
size = "16x12"
[[jobs]]
scene = "glossy"
set = { "materials.satin_copper.roughness" = [0.1, 0.4] }
seed = [0, 1]
output = "out/{scene}-r{roughness}-{seed}.exr"
"#;

/// A folder with a job file.
fn with_jobs(text: &str) -> TempDir {
    let folder = folder();
    fs::write(folder.path().join("jobs.toml"), text).unwrap();
    folder
}

fn manifest(folder: &TempDir) -> Value {
    let text = fs::read(folder.path().join("jobs.manifest.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

fn events(folder: &TempDir) -> Vec<Value> {
    let text = fs::read_to_string(folder.path().join("events.ndjson")).unwrap();
    let lines = text.lines().map(serde_json::from_str);
    lines.map(Result::unwrap).collect()
}

#[track_caller]
fn refuses(run: &Run, words: &[&str]) {
    assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "{}\nlacks {word}", run.stderr);
    }
}

#[test]
fn a_batch_renders_what_render_renders_and_then_nothing() {
    let folder = with_jobs(JOBS);
    let report = ondine(&folder, "batch jobs.toml --json --events events.ndjson").json();
    assert_eq!(report["done"], 4);
    assert_eq!(report["paths"], 4 * 16 * 12 * 4);
    let out = folder.path().join("out");
    assert_eq!(names(&out).len(), 8, "an image and a PNG each");

    let line = "render glossy --set materials.satin_copper.roughness=0.4 --seed 1 --spp 4 --size 16x12 --json";
    let single = ondine(&folder, line).json();
    let batch = ondine(&folder, "info out/glossy-r0.4-1.exr --json").json();
    for key in [
        "image_hash",
        "scene_hash",
        "camera",
        "seed",
        "spp",
        "sample_ranges",
        "scene",
    ] {
        let of_single = match key {
            "sample_ranges" => serde_json::json!([{ "start": 0, "end": 4 }]),
            _ => single[key].clone(),
        };
        assert_eq!(batch[key], of_single, "{key}");
    }
    let jobs = manifest(&folder);
    let job = &jobs["jobs"][3];
    assert_eq!(job["state"], "done");
    assert_eq!(job["image_hash"], single["image_hash"]);
    assert_eq!(job["set"]["materials.satin_copper.roughness"], "0.4");
    let ended = events(&folder);
    assert_eq!(ended.len(), 4);
    // In the order in which they end.
    let event = ended.iter().find(|event| event["index"] == 3).unwrap();
    assert_eq!(event["outcome"], "done");
    assert_eq!(event["image_hash"], single["image_hash"]);

    let before = fs::metadata(out.join("glossy-r0.4-1.exr"))
        .unwrap()
        .modified()
        .unwrap();
    let again = ondine(&folder, "batch jobs.toml --json --events events.ndjson").json();
    assert_eq!((&again["done"], &again["skipped"]), (&0.into(), &4.into()));
    let after = fs::metadata(out.join("glossy-r0.4-1.exr"))
        .unwrap()
        .modified()
        .unwrap();
    assert_eq!(before, after);
    assert_eq!(events(&folder).len(), 8, "events are added");
    assert_eq!(events(&folder)[7]["outcome"], "skipped");
}

#[test]
fn only_what_is_missing_or_changed_is_rendered() {
    let folder = with_jobs(JOBS);
    assert_eq!(ondine(&folder, "batch jobs.toml --status").code, 1);
    assert_eq!(ondine(&folder, "batch jobs.toml").code, 0);
    let status = ondine(&folder, "batch jobs.toml --status");
    assert_eq!(status.code, 0);
    assert_eq!(
        status.stdout,
        "4 jobs: 4 done, 0 missing, 0 changed, 0 failed\n"
    );

    let out = |name: &str| folder.path().join("out").join(name);
    fs::remove_file(out("glossy-r0.1-0.exr")).unwrap();
    fs::remove_file(out("glossy-r0.1-1.png")).unwrap();
    fs::write(out("glossy-r0.4-0.exr"), "no image").unwrap();
    // Of other settings.
    let line = "render glossy --size 16x12 --spp 8 --seed 1 -o out/glossy-r0.4-1.exr";
    assert_eq!(ondine(&folder, line).code, 0);
    let dry = ondine(&folder, "batch jobs.toml --dry-run");
    assert_eq!(dry.code, 0);
    let lines: Vec<&str> = dry.stdout.lines().collect();
    assert_eq!(lines[0], "missing  out/glossy-r0.1-0.exr");
    assert_eq!(
        lines[1],
        "changed  out/glossy-r0.1-1.exr: its PNG is missing"
    );
    assert!(
        lines[2].ends_with("it is not an OpenEXR image"),
        "{}",
        lines[2]
    );
    assert_eq!(lines[4], "4 jobs: 0 done, 1 missing, 3 changed, 0 failed");
    assert!(!out("glossy-r0.1-0.exr").exists(), "nothing is rendered");

    let report = ondine(&folder, "batch jobs.toml --json").json();
    assert_eq!(report["done"], 4);
    assert_eq!(
        report["paths"],
        3 * 16 * 12 * 4,
        "a PNG is made of its image"
    );
    assert_eq!(ondine(&folder, "batch jobs.toml --status").code, 0);

    // Another number of samples in the job file changes them all.
    fs::write(
        folder.path().join("jobs.toml"),
        JOBS.replace("spp = 4", "spp = 5"),
    )
    .unwrap();
    let status = ondine(&folder, "batch jobs.toml --status --json");
    let status: Value = serde_json::from_str(&status.stdout).unwrap();
    assert_eq!(status["changed"], 4);
    assert_eq!(
        status["jobs"][0]["reason"],
        "its samples per pixel were 4 and are 5"
    );
}

#[test]
fn a_change_of_each_setting_is_seen() {
    let folder = with_jobs(
        "version = 1\n[[jobs]]\nscene = \"cornell\"\nsize = \"16x12\"\nspp = 2\noutput = \"a.exr\"\n",
    );
    assert_eq!(ondine(&folder, "batch jobs.toml").code, 0);
    let original = fs::read_to_string(folder.path().join("jobs.toml")).unwrap();
    for (line, reason) in [
        ("seed = 3", "its seed was 0 and is 3"),
        ("strategy = \"light\"", "its strategy was mis and is light"),
        ("sampler = \"pcg\"", "its sampler was sobol and is pcg"),
        ("path_length = 2", "its path length was"),
        ("roulette = 2", "its roulette was none and is from edge 2"),
        (
            "crop = \"0,0,8,8\"",
            "its crop was 0,0,16,12 and is 0,0,8,8",
        ),
        (
            "aov = \"albedo\"",
            "its list of AOVs was none and is albedo",
        ),
        (
            "aov = \"bounces\"",
            "its list of AOVs was none and is bounces",
        ),
        (
            "set = { \"film.filter\" = \"tent\" }",
            "the scene has changed",
        ),
    ] {
        fs::write(
            folder.path().join("jobs.toml"),
            format!("{original}{line}\n"),
        )
        .unwrap();
        let run = ondine(&folder, "batch jobs.toml --status");
        assert_eq!(run.code, 1, "{line}");
        let expected = format!("changed  a.exr: {reason}");
        assert!(run.stdout.starts_with(&expected), "{line}: {}", run.stdout);
    }
    let bounces = format!("{original}aov = \"albedo,normal,depth,bounces\"\n");
    fs::write(folder.path().join("jobs.toml"), bounces).unwrap();
    assert_eq!(ondine(&folder, "batch jobs.toml").code, 0);
    assert_eq!(ondine(&folder, "batch jobs.toml --status").code, 0);
}

#[test]
fn a_job_that_fails_does_not_stop_the_others() {
    let text = r#"version = 1
[defaults]
spp = 1
size = "8x8"
[[jobs]]
scene = ["missing.toml", "cornell", "glossy"]
output = "{scene}/a.exr"
[[jobs]]
scene = "cornell"
camera = "back"
output = "b.exr"
"#;
    let folder = with_jobs(text);
    // No folder can be made there.
    fs::write(folder.path().join("glossy"), "").unwrap();
    let run = ondine(&folder, "batch jobs.toml --json --events events.ndjson");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((&report["done"], &report["failed"]), (&1.into(), &3.into()));
    assert!(folder.path().join("cornell/a.exr").exists());
    let failures: Vec<&str> = run.stderr.lines().collect();
    assert_eq!(failures.len(), 3, "{}", run.stderr);
    assert!(
        failures[0].starts_with("failed: missing/a.exr: there is no file"),
        "{}",
        failures[0]
    );
    assert!(
        failures[1].contains("no camera \"back\""),
        "{}",
        failures[1]
    );
    assert!(
        failures[2].starts_with("failed: glossy/a.exr: "),
        "{}",
        failures[2]
    );
    assert_eq!(
        events(&folder)
            .iter()
            .filter(|event| event["outcome"] == "failed")
            .count(),
        3
    );

    let status = ondine(&folder, "batch jobs.toml --status");
    assert_eq!(status.code, 1);
    assert!(
        status.stdout.contains("failed   glossy/a.exr: "),
        "{}",
        status.stdout
    );
    assert!(
        status
            .stdout
            .ends_with("4 jobs: 1 done, 0 missing, 0 changed, 3 failed\n")
    );
    fs::remove_file(folder.path().join("glossy")).unwrap();
    let report = ondine(&folder, "batch jobs.toml --only glossy/* --json").json();
    assert_eq!((&report["jobs"], &report["done"]), (&1.into(), &1.into()));
}

#[test]
fn patterns_choose_jobs() {
    let folder = with_jobs(JOBS);
    let run = ondine(
        &folder,
        "batch jobs.toml --only *r0.1* --only *-1.exr --dry-run",
    );
    assert_eq!(run.stdout.lines().count(), 4, "{}", run.stdout);
    assert!(
        run.stdout
            .ends_with("3 jobs: 0 done, 3 missing, 0 changed, 0 failed\n")
    );
    refuses(
        &ondine(&folder, "batch jobs.toml --only nothing"),
        &["--only nothing: none of 4 jobs", "--dry-run"],
    );
    refuses(
        &ondine(&folder, "batch jobs.toml --only a[b"),
        &["--only a[b: ", "[ab]"],
    );
}

#[test]
fn a_wrong_job_file_renders_nothing() {
    let folder = with_jobs(&JOBS.replace("-{seed}", ""));
    refuses(
        &ondine(&folder, "batch jobs.toml"),
        &["jobs.toml:9:10: ", "they differ in {seed}"],
    );
    refuses(
        &ondine(&folder, "batch none.toml"),
        &["none.toml: cannot read"],
    );
    fs::write(
        folder.path().join("jobs.toml"),
        JOBS.replace("spp = 4", "ssp = 4"),
    )
    .unwrap();
    refuses(
        &ondine(&folder, "batch jobs.toml"),
        &["did you mean \"spp\"?"],
    );
    fs::write(folder.path().join("jobs.toml"), JOBS).unwrap();
    refuses(
        &ondine(&folder, "batch jobs.toml --events jobs.toml"),
        &["--events jobs.toml: this file is used already"],
    );
    refuses(
        &ondine(&folder, "batch jobs.toml --events no/events"),
        &["no/events: cannot write"],
    );
    assert_eq!(names(folder.path()), ["jobs.toml"]);
    assert_eq!(
        fs::read_to_string(folder.path().join("jobs.toml")).unwrap(),
        JOBS
    );
}

#[test]
fn scenes_are_beside_the_job_file_wherever_the_program_runs() {
    let folder = folder();
    let at = |name: &str| folder.path().join("jobs").join(name);
    fs::create_dir(folder.path().join("jobs")).unwrap();
    let cornell = ondine(&folder, "scenes cornell").stdout;
    fs::write(at("room.toml"), cornell).unwrap();
    fs::write(
        at("j.toml"),
        "version = 1\n[[jobs]]\nscene = \"room.toml\"\nspp = 1\nsize = \"8x8\"\npng = false\n",
    )
    .unwrap();
    assert_eq!(ondine(&folder, "batch jobs/j.toml").code, 0);
    assert_eq!(
        names(&folder.path().join("jobs")),
        ["j.manifest.json", "j.toml", "room.exr", "room.toml"]
    );
}

#[test]
fn what_a_killed_batch_left_half_written_is_removed() {
    let folder = with_jobs(JOBS);
    let out = folder.path().join("out");
    assert_eq!(ondine(&folder, "batch jobs.toml").code, 0);
    // As a kill leaves it.
    let half = ".ondine-a1b2c3.tmp";
    fs::rename(out.join("glossy-r0.1-0.exr"), out.join(half)).unwrap();
    // And one that another program is writing.
    let other = fs::File::create(out.join(".ondine-d4e5f6.tmp")).unwrap();
    other.lock().unwrap();
    fs::write(folder.path().join(".ondine-g7h8i9.tmp"), "a manifest").unwrap();
    assert_eq!(ondine(&folder, "batch jobs.toml").code, 0);
    assert_eq!(names(&out).len(), 9, "{:?}", names(&out));
    assert!(out.join(".ondine-d4e5f6.tmp").exists());
    assert!(!folder.path().join(".ondine-g7h8i9.tmp").exists());
}

#[test]
fn events_are_added_to_events_alone() {
    let folder = with_jobs(JOBS);
    let at = |name: &str| folder.path().join(name);
    fs::write(
        at("scene.gltf"),
        "{ \"asset\": { \"version\": \"2.0\" } }\n",
    )
    .unwrap();
    fs::write(at("notes.txt"), "notes").unwrap();
    for name in ["scene.gltf", "notes.txt", "new.exr", "new.PNG"] {
        let before = fs::read(at(name)).ok();
        let run = ondine(&folder, &format!("batch jobs.toml --events {name}"));
        refuses(&run, &["--events", name, "name another"]);
        assert_eq!(fs::read(at(name)).ok(), before, "{name}");
    }
    fs::write(at("empty"), "").unwrap();
    for _ in 0..2 {
        assert_eq!(
            ondine(&folder, "batch jobs.toml --only *0.1-0* --events empty").code,
            0
        );
    }
    assert_eq!(fs::read_to_string(at("empty")).unwrap().lines().count(), 2);
}

#[test]
fn a_damaged_image_without_its_png_is_rendered_anew() {
    let folder = with_jobs(JOBS);
    assert_eq!(ondine(&folder, "batch jobs.toml --only *0.1-0*").code, 0);
    let image = folder.path().join("out/glossy-r0.1-0.exr");
    let whole = fs::read(&image).unwrap();
    let mut bytes = whole.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&image, &bytes).unwrap();
    fs::remove_file(image.with_extension("png")).unwrap();
    let run = ondine(&folder, "batch jobs.toml --only *0.1-0*");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(image.with_extension("png").exists());
    let info = ondine(
        &folder,
        "compare --json out/glossy-r0.1-0.exr out/glossy-r0.1-0.exr",
    );
    assert_eq!(info.code, 0, "{}", info.stderr);
    assert_eq!(fs::read(&image).unwrap().len(), whole.len());
}
