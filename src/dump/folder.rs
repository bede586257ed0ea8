//! A dump as a folder that is whole or not there: written beside its place, then renamed into it.

use super::manifest::{FILE, FORMAT, File, Manifest};
use crate::error::{Error, Result};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What the scene's materials, lights and primitives are, by the ids in the records.
pub const SCENE: &str = "scene.json";

/// Writes the manifest, `scene` as [`SCENE`], and the files. An empty folder and an older dump are replaced, if nothing else
/// is in them.
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
        Err(_) => return Ok(()),
        Ok(found) => found,
    };
    if !found.is_dir() {
        return refuse("is no folder");
    }
    let entries = fs::read_dir(folder).map_err(|source| Error::Read {
        path: folder.to_owned(),
        source,
    })?;
    let names: Vec<String> = entries
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    if names.is_empty() {
        return Ok(());
    }
    let manifest = fs::read_to_string(folder.join(FILE)).unwrap_or_default();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap_or_default();
    if manifest["format"] != FORMAT {
        return refuse("is no dump");
    }
    let of_dump = |name: &str| {
        let edge = name.strip_prefix("edge").unwrap_or_default();
        let edge = !edge.is_empty() && edge.bytes().all(|byte| byte.is_ascii_digit());
        edge || [FILE, SCENE, "paths", "film"].contains(&name)
    };
    match names.iter().find(|name| !of_dump(name)) {
        Some(other) => refuse(&format!("holds {other:?}, which is of no dump")),
        None => Ok(()),
    }
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
