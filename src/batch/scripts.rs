//! The text files of a plan: command lines, and what submits them to Slurm.

use super::cluster::{Plan, PlannedImage};
use crate::render::{shell_line, shell_quoted};
use std::path::Path;

/// The files of a plan's folder, by name.
pub(super) fn files(plan: &Plan, program: &str) -> Vec<(&'static str, String)> {
    let folder = shell_quoted(&plan.folder.display().to_string());
    vec![
        ("commands.txt", commands(plan, program)),
        ("merges.txt", merges(plan, program)),
        ("array.sbatch", array(plan, &folder)),
        ("merge.sbatch", merge(plan, &folder)),
        ("submit.sh", submit(&folder)),
    ]
}

/// A command line for each shard.
fn commands(plan: &Plan, program: &str) -> String {
    let parts = plan.parts();
    let line = |words: Vec<String>| shell_line(&words) + "\n";
    plan.shards()
        .map(|(image, shard)| line(image.render_words(program, &parts, shard)))
        .collect()
}

/// A command line for each image.
fn merges(plan: &Plan, program: &str) -> String {
    let parts = plan.parts();
    let line = |image: &PlannedImage| {
        let folder = image.output.parent().unwrap_or(Path::new("/"));
        format!(
            "mkdir -p {} && {}\n",
            shell_quoted(&folder.display().to_string()),
            shell_line(&image.merge_words(program, &parts))
        )
    };
    plan.images.iter().map(line).collect()
}

fn array(plan: &Plan, folder: &str) -> String {
    let (tasks, lines) = (plan.tasks(), plan.lines_per_task);
    format!(
        r#"#!/bin/bash
#SBATCH --job-name=ondine
#SBATCH --array=1-{tasks}
#SBATCH --requeue
#SBATCH --output={log}
# Runs the lines of commands.txt that are its task's. A line that fails does not stop the others.
plan={folder}
first=$(( (SLURM_ARRAY_TASK_ID - 1) * {lines} + 1 ))
last=$(( first + {lines} - 1 ))
status=0
while IFS= read -r line; do
    bash -c "$line ${{SLURM_CPUS_PER_TASK:+--threads=$SLURM_CPUS_PER_TASK}}" < /dev/null || status=1
done < <(sed -n "$first,${{last}}p" "$plan/commands.txt")
exit $status
"#,
        log = log(plan, "shards-%A_%a.log")
    )
}

fn merge(plan: &Plan, folder: &str) -> String {
    format!(
        r#"#!/bin/bash
#SBATCH --job-name=ondine-merge
#SBATCH --requeue
#SBATCH --output={log}
# Puts the shards of each image together; those that are merged already are left alone.
plan={folder}
status=0
while IFS= read -r line; do
    bash -c "$line" < /dev/null || status=1
done < "$plan/merges.txt"
exit $status
"#,
        log = log(plan, "merge-%j.log")
    )
}

fn submit(folder: &str) -> String {
    format!(
        r#"#!/bin/bash
# Submits the shards and, for when all are there, their merging. Options go to both: submit.sh --partition=long --time=60
set -eu
plan={folder}
shards=$(sbatch --parsable "$@" "$plan/array.sbatch")
merge=$(sbatch --parsable "$@" --dependency="afterok:${{shards%%;*}}" --kill-on-invalid-dep=yes "$plan/merge.sbatch")
echo "shards are job ${{shards%%;*}}, merging is job ${{merge%%;*}}"
"#
    )
}

/// A file of logs as a line of `#SBATCH` names it: percent signs of the folder's own are doubled, as they begin patterns.
fn log(plan: &Plan, name: &str) -> String {
    let folder = plan.folder.display().to_string().replace('%', "%%");
    format!("\"{}/logs/{name}\"", folder.replace('"', "\\\""))
}
