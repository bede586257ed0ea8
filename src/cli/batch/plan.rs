//! `ondine batch --plan` and `--status` of a plan's folder.

use super::super::report::counted;
use super::super::{Outcome, print, print_json, say};
use super::Batch;
use crate::batch::cluster::Plan;
use crate::batch::progress::Progress;
use crate::error::{Error, Result};
use crate::render::shell_quoted;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// What `--plan --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    folder: &'a Path,
    images: usize,
    shards: usize,
    tasks: usize,
    /// Jobs whose images are there already.
    done: usize,
    /// Jobs that cannot be rendered.
    failed: usize,
}

/// Writes the plan of what is missing or changed.
pub(super) fn write(batch: &Batch, folder: &Path, shards: u32, json: bool) -> Result<Outcome> {
    let waiting = batch
        .chosen()
        .filter(|(_, standing)| standing.name() != "done")
        .filter_map(|(job, _)| Some((job, job.ready.as_ref().ok()?)));
    let plan = Plan::new(waiting, folder, shards)?;
    if plan.images.is_empty() {
        return Err(Error::Usage(
            "--plan: there is nothing to render; `ondine batch JOBS.toml --status` says why"
                .to_owned(),
        ));
    }
    let program = std::env::current_exe().map_err(|error| {
        Error::Usage(format!(
            "--plan: cannot tell where this program is: {error}"
        ))
    })?;
    plan.write(&program)?;
    let mut failed = 0;
    for (job, _) in batch.chosen() {
        if let Err(why) = &job.ready {
            say(format_args!("failed: {}: {why}", job.name));
            failed += 1;
        }
    }
    let report = Report {
        folder: &plan.folder,
        images: plan.images.len(),
        shards: plan.shards().count(),
        tasks: plan.tasks(),
        done: batch.count("done"),
        failed,
    };
    match json {
        true => print_json(&report)?,
        false => print(&report.summary())?,
    }
    Ok(match failed {
        0 => Outcome::Done,
        _ => Outcome::Differs,
    })
}

impl Report<'_> {
    fn summary(&self) -> String {
        let folder = self.folder.display();
        let shell = |path: &Path| shell_quoted(&path.display().to_string());
        format!(
            "Wrote {folder}: {} of {}, in {} of a job array; {} done before\n\
             Slurm: bash {} [OPTIONS OF SBATCH]\n\
             Others run the lines of {folder}/commands.txt, then bash {}\n\
             ondine batch --status {} says what is there\n",
            counted(self.shards, "shard"),
            counted(self.images, "image"),
            counted(self.tasks, "task"),
            self.done,
            shell(&self.folder.join("submit.sh")),
            shell(&self.folder.join("merge.sbatch")),
            shell(self.folder),
        )
    }
}

/// What `--status` of a folder prints with `--json`.
#[derive(Serialize)]
struct Status<'a> {
    #[serde(flatten)]
    progress: &'a Progress,
    images: usize,
    /// What makes what is lacking; none where that takes another plan.
    command: Option<String>,
}

/// Tells what there is of a plan, and what makes the rest.
pub(super) fn status(folder: &Path, json: bool) -> Result<Outcome> {
    let plan = Plan::read(folder)?;
    let progress = Progress::of(&plan);
    let script = |options: &str, name: &str| {
        let path = plan.folder.join(name);
        format!(
            "sbatch {options}{}",
            shell_quoted(&path.display().to_string())
        )
    };
    let is_done = progress.lacking.is_empty() && progress.unmerged.is_empty();
    let command = match (progress.lacking.is_empty(), progress.unmerged.is_empty()) {
        (false, _) => Some(script(&format!("-a {} ", progress.tasks()), "array.sbatch")),
        (true, false) => Some(script("", "merge.sbatch")),
        (true, true) => None,
    };
    let command = command.filter(|_| progress.obsolete.is_none());
    if json {
        print_json(&Status {
            progress: &progress,
            images: plan.images.len(),
            command,
        })?;
    } else {
        let mut text = String::new();
        for lacking in &progress.lacking {
            let (name, shard, what) = (&lacking.name, &lacking.shard, &lacking.what);
            let _ = writeln!(
                text,
                "{name}: shard {shard} (task {}): {what}",
                lacking.task
            );
        }
        let there = progress.shards - progress.lacking.len();
        let merged = plan.images.len() - progress.unmerged.len();
        let _ = writeln!(
            text,
            "{there} of {}, {merged} of {} merged",
            counted(progress.shards, "shard"),
            counted(plan.images.len(), "image")
        );
        match (&progress.obsolete, command) {
            (_, Some(command)) => {
                let _ = writeln!(text, "{command}");
            }
            (Some(why), None) if !is_done => {
                let _ = writeln!(
                    text,
                    "{why}: plan again, with --plan {}; shards that are of the same images are used",
                    shell_quoted(&plan.folder.display().to_string())
                );
            }
            _ => {}
        }
        print(&text)?;
    }
    Ok(match is_done {
        true => Outcome::Done,
        false => Outcome::Differs,
    })
}
