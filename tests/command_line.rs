//! The program as its users meet it: what it prints, what it leaves behind, and what it exits with.

#[cfg(target_os = "linux")]
#[path = "common/small_disk.rs"]
mod small_disk;

mod command_line {
    mod batch;
    mod bench;
    mod comparison;
    mod comparison_page;
    mod dump;
    mod environments;
    mod harmonics;
    mod information;
    mod interruption;
    mod light_probes;
    mod plan_lines;
    mod plans;
    mod refusals;
    mod renders;
    mod resumption;
    mod shards;
}

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// What a run of the program came to.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().expect("an exit code, not a signal"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

impl Run {
    /// Stdout as the one JSON object that it must be.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        assert_eq!(self.code, 0, "{}", self.stderr);
        serde_json::from_str(&self.stdout).unwrap()
    }
}

/// The program in `folder` with the words of `line`.
pub(crate) fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ondine"));
    command.current_dir(folder).args(line.split_whitespace());
    command
}

pub(crate) fn ondine(folder: &TempDir, line: &str) -> Run {
    command(folder.path(), line).output().unwrap().into()
}

pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// The names in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
