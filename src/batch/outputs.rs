//! Where the files of all jobs go: no two of them to one place, and none to where a scene is read from.

use super::file::Grid;
use super::plan::{Job, Ready};
use super::template::{FIELDS, Field};
use crate::error::{Error, Result};
use crate::resume;
use crate::scene::description::Description;
use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};

/// The files that a scene is read from and that an image could be called like, each by its place.
pub(super) fn inputs(path: &str, scene: &Description) -> impl Iterator<Item = PathBuf> {
    let files: Vec<PathBuf> = std::iter::once(path)
        .chain(scene.pictures().map(|(_, file)| file))
        .filter_map(|file| Path::new(file).canonicalize().ok())
        .collect();
    files.into_iter()
}

/// A file that a job writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Image,
    Picture,
    /// What there is of the image while it is rendered; it is removed at the end.
    Checkpoint,
}

/// Refuses two jobs that write one file, and one that writes a file that is read.
///
/// # Errors
/// [`Error::Scene`] where the job file names the output.
pub(super) fn check(jobs: &[Job], grids: &[&Grid], inputs: &HashSet<PathBuf>) -> Result<()> {
    let mut places = Places::default();
    let mut seen: HashMap<PathBuf, (&Job, Kind)> = HashMap::with_capacity(jobs.len());
    for job in jobs {
        let Ok(ready) = &job.ready else { continue };
        let wrong = |message| {
            Err(Error::Scene {
                place: grids[job.index].output_place.clone(),
                message,
            })
        };
        for (path, kind) in files(ready) {
            let place = places.of(&path);
            if inputs.contains(&place) {
                return wrong(format!(
                    "the output {}{} is a file that the batch reads; name another",
                    path.display(),
                    kind.of_what()
                ));
            }
            let Some((other, its)) = seen.insert(place, (job, kind)) else {
                continue;
            };
            let remedy = match kind == its {
                true => telling_apart(other, job, grids[job.index]),
                false => "name another".to_owned(),
            };
            // The one of the two that is not the image says why they meet.
            let kind = if kind == Kind::Image { its } else { kind };
            return wrong(format!(
                "jobs {} ({}) and {} ({}) have the same output {}{}; {remedy}",
                other.index,
                other.title(),
                job.index,
                job.title(),
                path.display(),
                kind.of_what(),
            ));
        }
    }
    Ok(())
}

impl Kind {
    /// Said after a path, where it is not what the job file names.
    fn of_what(self) -> &'static str {
        match self {
            Self::Image => "",
            Self::Picture => " (the PNG beside an image)",
            Self::Checkpoint => " (the checkpoint of an image)",
        }
    }
}

/// Every file that a job writes.
fn files(ready: &Ready) -> impl Iterator<Item = (PathBuf, Kind)> {
    let png = ready.png.map(|_| (ready.png_path(), Kind::Picture));
    let checkpoint = (resume::checkpoint(&ready.exr), Kind::Checkpoint);
    std::iter::once((ready.exr.clone(), Kind::Image))
        .chain(png)
        .chain([checkpoint])
}

/// Finds out which file a path leads to, however it is spelt. Folders are looked up once: jobs share them.
#[derive(Debug, Default)]
struct Places {
    folders: HashMap<PathBuf, PathBuf>,
}

impl Places {
    /// The path without links and detours, of a file that is there or is yet to be written.
    fn of(&mut self, path: &Path) -> PathBuf {
        let folder = path.parent().unwrap_or(Path::new(""));
        let folder = match self.folders.get(folder) {
            Some(found) => found,
            None => self
                .folders
                .entry(folder.to_owned())
                .or_insert(place_of(folder)),
        };
        let file = folder.join(path.file_name().unwrap_or(OsStr::new("")));
        file.canonicalize().unwrap_or(file)
    }
}

/// Step by step, so that what is there is followed and what is not is made up as it will be.
fn place_of(folder: &Path) -> PathBuf {
    let mut place = PathBuf::from(".").canonicalize().unwrap_or_default();
    for component in folder.components() {
        match component {
            Component::ParentDir => {
                place.pop();
            }
            Component::CurDir => {}
            other => place.push(other),
        }
        place = place.canonicalize().unwrap_or(place);
    }
    place
}

/// What to do with two jobs of one output.
fn telling_apart(one: &Job, other: &Job, grid: &Grid) -> String {
    let changes = grid.changes.iter().enumerate();
    let keys = changes.map(|(place, axis)| (axis[0].key.as_str(), Field::Change(place)));
    let known = FIELDS.iter().map(|&name| (name, Field::Known(name)));
    // Each has an index of its own, and width and height are the size.
    let fields: Vec<String> = known
        .chain(keys)
        .filter(|(name, _)| !["index", "width", "height"].contains(name))
        .filter(|&(_, field)| !grid.output.has(field) && one.value(field) != other.value(field))
        .map(|(name, _)| format!("{{{name}}}"))
        .collect();
    match fields.is_empty() {
        false => format!(
            "they differ in {}: put that in output",
            fields.join(" and ")
        ),
        true => "name another output for one of them, or remove it".to_owned(),
    }
}
