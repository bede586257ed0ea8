//! `ondine batch --plan`: the scripts do without Slurm what they do with it.
#![cfg(unix)]

use crate::{Run, folder, names, ondine};
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const JOBS: &str = r#"version = 1
[[jobs]]
scene = "room's.toml"
set = { "render.strategy" = ["mis", "light"], "camera.vertical_fov" = 40 }
size = "20x12"
spp = 40
aov = "albedo"
tonemap = "aces"
output = "my images/{scene}-{strategy}.exr"
"#;

/// A job file, its scene, and a plan of them.
pub(crate) fn planned(shards: u32) -> TempDir {
    let folder = folder();
    let scene = ondine(&folder, "scenes cornell").stdout;
    fs::write(folder.path().join("room's.toml"), scene).unwrap();
    fs::write(folder.path().join("jobs.toml"), JOBS).unwrap();
    let run = ondine(
        &folder,
        &format!("batch jobs.toml --plan plan --shards {shards}"),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    folder
}

/// A script of the plan, from anywhere; as a task of an array, if it is one.
pub(crate) fn script(folder: &TempDir, name: &str, task: Option<usize>) -> Run {
    let mut command = Command::new("bash");
    command
        .arg(folder.path().join("plan").join(name))
        .current_dir("/")
        .env("SLURM_CPUS_PER_TASK", "2");
    if let Some(task) = task {
        command.env("SLURM_ARRAY_TASK_ID", task.to_string());
    }
    command.output().unwrap().into()
}

pub(crate) fn status(folder: &TempDir) -> Run {
    ondine(folder, "batch --status plan")
}

fn hash(folder: &TempDir, image: &Path) -> String {
    let mut info = crate::command(folder.path(), "info --json");
    let run: Run = info.arg(image).output().unwrap().into();
    run.json()["image_hash"].as_str().unwrap().to_owned()
}

#[test]
fn shards_of_a_plan_merge_to_the_bits_of_a_batch() {
    let folder = planned(3);
    let plan = folder.path().join("plan");
    assert_eq!(
        names(&plan),
        [
            "array.sbatch",
            "commands.txt",
            "logs",
            "merge.sbatch",
            "merges.txt",
            "parts",
            "plan.json",
            "submit.sh"
        ]
    );
    let array = fs::read_to_string(plan.join("array.sbatch")).unwrap();
    assert!(array.contains("#SBATCH --array=1-6\n"), "{array}");
    let before = status(&folder);
    assert_eq!(before.code, 1);
    assert!(
        before
            .stdout
            .contains("0 of 6 shards, 0 of 2 images merged\nsbatch -a 1-6 "),
        "{}",
        before.stdout
    );

    for task in (1..=6).rev() {
        let run = script(&folder, "array.sbatch", Some(task));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let rendered = status(&folder);
    assert_eq!(rendered.code, 1);
    assert!(
        rendered
            .stdout
            .starts_with("6 of 6 shards, 0 of 2 images merged\nsbatch /"),
        "{}",
        rendered.stdout
    );
    for _ in 0..2 {
        let run = script(&folder, "merge.sbatch", None);
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let merged = status(&folder);
    assert_eq!(
        (merged.code, merged.stdout.as_str()),
        (0, "6 of 6 shards, 2 of 2 images merged\n")
    );
    assert_eq!(
        ondine(&folder, "batch jobs.toml --status").code,
        0,
        "the batch has them"
    );
    let images = folder.path().join("my images");
    assert_eq!(
        names(&images),
        [
            "room-s-light.exr",
            "room-s-light.png",
            "room-s-mis.exr",
            "room-s-mis.png"
        ]
    );

    let sharded =
        ["light", "mis"].map(|name| hash(&folder, &images.join(format!("room-s-{name}.exr"))));
    fs::remove_dir_all(&images).unwrap();
    assert_eq!(ondine(&folder, "batch jobs.toml").code, 0);
    let whole =
        ["light", "mis"].map(|name| hash(&folder, &images.join(format!("room-s-{name}.exr"))));
    assert_eq!(sharded, whole);
    let again = ondine(&folder, "batch jobs.toml --plan other");
    assert_eq!(again.code, 2);
    assert!(
        again.stderr.contains("there is nothing to render"),
        "{}",
        again.stderr
    );
}

#[test]
fn shards_that_are_missing_or_damaged_are_told_with_the_tasks_that_make_them() {
    let folder = planned(4);
    for task in 1..=8 {
        assert_eq!(script(&folder, "array.sbatch", Some(task)).code, 0);
    }
    let parts = folder.path().join("plan/parts");
    let files = names(&parts);
    assert_eq!(files.len(), 8, "{files:?}");
    // Of the second image, whose strategy is `light`.
    let file = |ending: &str| {
        let name = files
            .iter()
            .find(|name| name.contains("light") && name.ends_with(ending));
        parts.join(name.unwrap())
    };
    fs::remove_file(file("1-of-4.exr")).unwrap();
    fs::write(file("2-of-4.exr"), "nothing").unwrap();
    let cut = fs::read(file("4-of-4.exr")).unwrap();
    fs::write(file("4-of-4.exr"), &cut[..cut.len() - 100]).unwrap();
    let run = status(&folder);
    assert_eq!(run.code, 1);
    let lines: Vec<&str> = run.stdout.lines().collect();
    assert!(
        lines[0].ends_with("shard 1/4 (task 5): missing"),
        "{}",
        lines[0]
    );
    assert!(
        lines[1].contains("shard 2/4 (task 6): damaged: "),
        "{}",
        lines[1]
    );
    assert!(
        lines[2].contains("shard 4/4 (task 8): damaged: "),
        "{}",
        lines[2]
    );
    let repeat = format!(
        "sbatch -a 5-6,8 {}",
        folder
            .path()
            .canonicalize()
            .unwrap()
            .join("plan/array.sbatch")
            .display()
    );
    assert_eq!(lines[4], repeat);
    let json = ondine(&folder, "batch --status plan --json");
    let json: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["command"], repeat.as_str());
    assert_eq!(json["lacking"][0]["task"], 5);

    for task in [5, 6, 8] {
        let run = script(&folder, "array.sbatch", Some(task));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }

    // Damage that only the pixels have: the merging finds it, and so must the status.
    let mut bytes = fs::read(file("3-of-4.exr")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(file("3-of-4.exr"), bytes).unwrap();
    let merging = script(&folder, "merge.sbatch", None);
    assert_eq!(merging.code, 1);
    assert!(
        merging.stderr.contains("3-of-4.exr: "),
        "{}",
        merging.stderr
    );
    let run = status(&folder);
    let lines: Vec<&str> = run.stdout.lines().collect();
    assert!(
        lines[0].contains("light.exr: shard 3/4 (task 7): damaged: "),
        "{}",
        lines[0]
    );
    assert!(lines[2].starts_with("sbatch -a 7 "), "{}", lines[2]);
    assert_eq!(script(&folder, "array.sbatch", Some(7)).code, 0);
    assert_eq!(script(&folder, "merge.sbatch", None).code, 0);
    assert_eq!(status(&folder).code, 0);
}

#[test]
fn shards_of_changed_jobs_are_not_mistaken() {
    let folder = planned(1);
    assert_eq!(script(&folder, "array.sbatch", Some(1)).code, 0);
    fs::write(
        folder.path().join("jobs.toml"),
        JOBS.replace("spp = 40", "spp = 16"),
    )
    .unwrap();
    assert_eq!(ondine(&folder, "batch jobs.toml --plan plan").code, 0);
    assert!(
        status(&folder).stdout.contains("0 of 2 shards"),
        "{}",
        status(&folder).stdout
    );
    let refused = |line: &str, words: &str| {
        let run = ondine(&folder, line);
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.stderr.contains(words), "{}", run.stderr);
    };
    refused("batch --status plan --only x", "--only");
    refused("batch --status plan --threads 3", "--threads");
    refused(
        "batch jobs.toml --plan .",
        "this folder has other files, and no plan",
    );
    refused("batch jobs.toml --shards 2", "--plan");
    refused("batch jobs.toml --plan p --shards 0", "from 1 to 65536");
    fs::write(folder.path().join("plan/plan.json"), "{}").unwrap();
    refused("batch --status plan", "this is no plan of this program");
    refused("batch --status my", "cannot read");
}

#[test]
fn an_image_has_no_more_shards_than_blocks_of_samples() {
    let folder = folder();
    let text = "version = 1\n[[jobs]]\nscene = \"cornell\"\nsize = \"2x1\"\nspp = 20\n";
    fs::write(folder.path().join("jobs.toml"), text).unwrap();
    let run = ondine(&folder, "batch jobs.toml --plan plan --shards 64 --json").json();
    assert_eq!(run["shards"], 4);
    for task in 1..=4 {
        assert_eq!(script(&folder, "array.sbatch", Some(task)).code, 0);
    }
    assert_eq!(script(&folder, "merge.sbatch", None).code, 0);
    assert_eq!(status(&folder).code, 0);
}

#[test]
fn a_plan_that_was_moved_is_planned_again() {
    let folder = planned(1);
    assert_eq!(script(&folder, "array.sbatch", Some(2)).code, 0);
    let at = |name: &str| folder.path().join(name);
    fs::rename(at("plan"), at("my plan")).unwrap();
    let status = || -> Run {
        let mut command = crate::command(folder.path(), "batch --status");
        command.arg("my plan").output().unwrap().into()
    };
    let run = status();
    assert_eq!(run.code, 1);
    assert!(run.stdout.contains("1 of 2 shards"), "{}", run.stdout);
    assert!(!run.stdout.contains("sbatch"), "{}", run.stdout);
    let remedy = format!(
        "where it was: plan again, with --plan '{}'; shards that are of the same images are used\n",
        folder
            .path()
            .canonicalize()
            .unwrap()
            .join("my plan")
            .display()
    );
    assert!(run.stdout.ends_with(&remedy), "{}", run.stdout);
    let mut plan = crate::command(folder.path(), "batch jobs.toml --plan");
    let planned: Run = plan.arg("my plan").output().unwrap().into();
    assert!(
        planned.stdout.contains("my plan/submit.sh' [OPTIONS"),
        "{}",
        planned.stdout
    );
    let run = status();
    assert!(run.stdout.contains("1 of 2 shards"), "{}", run.stdout);
    assert!(
        run.stdout.ends_with("/my plan/array.sbatch'\n"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_scene_that_was_changed_since_is_planned_again_and_not_rendered() {
    let folder = planned(2);
    assert_eq!(script(&folder, "array.sbatch", Some(1)).code, 0);
    let scene = folder.path().join("room's.toml");
    let text = fs::read_to_string(&scene).unwrap();
    fs::write(
        &scene,
        format!("{text}\n[materials.more]\ntype = \"mirror\"\nreflectance = [0.5, 0.5, 0.5]\n"),
    )
    .unwrap();
    let run = script(&folder, "array.sbatch", Some(2));
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stderr.contains("--scene-hash"), "{}", run.stderr);
    assert_eq!(names(&folder.path().join("plan/parts")).len(), 1);
    let run = status(&folder);
    assert_eq!(run.code, 1);
    assert!(
        run.stdout
            .contains("room's.toml was changed since: plan again, with --plan /"),
        "{}",
        run.stdout
    );
    assert!(!run.stdout.contains("sbatch"), "{}", run.stdout);
    let json = ondine(&folder, "batch --status plan --json");
    let json: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert!(
        json["command"].is_null() && json["obsolete"].is_string(),
        "{json}"
    );
    fs::write(&scene, text).unwrap();
    assert!(status(&folder).stdout.contains("sbatch -a 2-4 "));
}
