//! A dump as a folder that is whole or not there: written beside its place, then renamed into it.

use super::manifest::{FILE, FORMAT, File, Manifest};
use crate::error::{Error, Result};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What the scene's materials, lights and primitives are, by the ids in the records.
pub const SCENE: &str = "scene.json";

/// Writes the manifest, `scene` as [`SCENE`], and the files. An empty folder and an older dump are replaced, if nothing is
/// in it that its manifest does not list, and the current directory is not.
///
/// # Errors
/// [`Error::Usage`] where something else is at `folder`, [`Error::Write`] where it cannot be written; then what was there
/// stays.
pub fn write(
    folder: &Path,
    manifest: &Manifest,
    scene: &impl serde::Serialize,
    files: &[File],
) -> Result<()> {
    let json = |value: serde_json::Result<String>| {
        let text = value.map_err(|error| Error::Usage(format!("no JSON can be made: {error}")))?;
        Ok(text.into_bytes())
    };
    let texts = [
        (
            FILE.to_owned(),
            json(serde_json::to_string_pretty(manifest))?,
        ),
        (SCENE.to_owned(), json(serde_json::to_string_pretty(scene))?),
    ];
    check(folder)?;
    let cannot_write = |source| Error::Write {
        path: folder.to_owned(),
        source,
    };
    replace(folder, files.iter().chain(&texts)).map_err(cannot_write)
}

/// Makes sure that [`write()`] may write there.
///
/// # Errors
/// As [`write()`], but for those that only writing shows.
pub fn check(folder: &Path) -> Result<()> {
    let refuse = |what: &str| {
        let folder = folder.display();
        Err(Error::Usage(format!(
            "{folder} {what}; name a folder that is new, empty or a dump"
        )))
    };
    let found = match fs::metadata(folder) {
        Err(_) if folder.is_symlink() => return refuse("is a link to what does not exist"),
        Err(_) => return Ok(()),
        Ok(found) => found,
    };
    if !found.is_dir() {
        return refuse("is no folder");
    }
    let cannot_read = |source| Error::Read {
        path: folder.to_owned(),
        source,
    };
    if fs::read_dir(folder).map_err(cannot_read)?.next().is_some() {
        let manifest = fs::read_to_string(folder.join(FILE)).unwrap_or_default();
        let manifest: Value = serde_json::from_str(&manifest).unwrap_or_default();
        if manifest["format"] != FORMAT {
            return refuse("is no dump");
        }
        if let Some(other) = stranger(folder, &manifest).map_err(cannot_read)? {
            return refuse(&format!("holds {other:?}, which its {FILE} does not list"));
        }
    }
    // A shell in it would be left in a folder that is no more.
    let real = |path: &Path| fs::canonicalize(path).ok();
    if let (Some(current), Some(target)) = (real(Path::new(".")), real(folder))
        && current.starts_with(target)
    {
        return Err(Error::Usage(format!(
            "{} holds the current directory and would be replaced under it; run this from another folder, or name a new one",
            folder.display()
        )));
    }
    Ok(())
}

/// A file or folder below `folder` that is not of the dump whose manifest it is.
fn stranger(folder: &Path, manifest: &Value) -> io::Result<Option<String>> {
    let list = |of: &Value, key: &str| of[key].as_array().cloned().unwrap_or_default();
    let fields = list(manifest, "queues")
        .into_iter()
        .flat_map(|queue| list(&queue, "fields"));
    let arrays = fields.filter_map(|field| Some(PathBuf::from(field["file"].as_str()?)));
    let files: BTreeSet<PathBuf> = arrays.chain([FILE, SCENE].map(PathBuf::from)).collect();
    let folders: BTreeSet<&Path> = files
        .iter()
        .flat_map(|file| file.ancestors().skip(1))
        .collect();
    let mut left = vec![PathBuf::new()];
    while let Some(place) = left.pop() {
        for entry in fs::read_dir(folder.join(&place))? {
            let entry = entry?;
            let path = place.join(entry.file_name());
            // Of a link this is false: what it leads to is another's.
            let is_folder = entry.file_type()?.is_dir();
            if is_folder && folders.contains(&*path) {
                left.push(path);
            } else if is_folder || !files.contains(&path) {
                return Ok(Some(path.display().to_string()));
            }
        }
    }
    Ok(None)
}

fn replace<'a>(folder: &Path, files: impl Iterator<Item = &'a File>) -> io::Result<()> {
    // Where it is a link, the folder it leads to is replaced.
    let target = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let parent = match target.parent() {
        None => return Err(io::Error::other("it is the root of the file system")),
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
    };
    if !parent.is_dir() {
        let parent = parent.display();
        let message =
            format!("the folder {parent} does not exist; create it first (mkdir -p {parent})");
        return Err(io::Error::new(io::ErrorKind::NotFound, message));
    }
    // Private, but what is made in it is for all whom the umask allows. Holds the new dump before, the old one after.
    let temporary = tempfile::Builder::new()
        .prefix(".ondine-")
        .suffix(".tmp")
        .tempdir_in(parent)
        .map_err(|error| {
            let message = format!(
                "cannot create a folder in {}: {}",
                parent.display(),
                error.kind()
            );
            io::Error::new(error.kind(), message)
        })?;
    let (new, old) = (temporary.path().join("new"), temporary.path().join("old"));
    fs::create_dir(&new)?;
    let mut made = PathBuf::new();
    for (name, bytes) in files {
        let path = new.join(name);
        if let Some(folder) = path.parent().filter(|folder| **folder != made) {
            fs::create_dir_all(folder)?;
            made = folder.to_owned();
        }
        fs::write(&path, bytes)?;
    }
    let had = fs::exists(&target)?;
    if had {
        fs::rename(&target, &old)?;
    }
    fs::rename(&new, &target).inspect_err(|_| {
        if had {
            // Back where it was; the first error is the one that is told.
            let _ = fs::rename(&old, &target);
        }
    })
}
