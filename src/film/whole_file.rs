//! Files that are whole or not there: written beside their place, then renamed into it.

use crate::error::{Error, Result};
use std::fs::{self, File, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes a file by way of a temporary one in the same folder, flushed to the disk and renamed over `path`.
///
/// Where `path` is a link to a file, that is replaced, and a link to nothing itself; a file that is replaced keeps its permissions, a new one
/// has those that the umask gives. On any error ([`Error::Write`]) nothing is left behind, and what was at `path` stays.
pub fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<()> {
    write(path, fill).map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })
}

fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let old = fs::metadata(&target).ok();
    // Renaming over a device or a pipe would put a plain file in its place.
    if let Some(old) = old.as_ref().filter(|old| !old.is_file()) {
        let what = if old.is_dir() {
            "a folder"
        } else {
            "no plain file"
        };
        return Err(other(format!(
            "it is {what}; name a file to create or replace"
        )));
    }
    let folder = folder_of(&target)?;
    let mut temporary = create(&folder)?;
    let mut writer = BufWriter::with_capacity(1 << 18, temporary.as_file_mut());
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    if let Some(old) = old {
        temporary.as_file().set_permissions(old.permissions())?;
    }
    temporary.as_file().sync_all()?;
    temporary.persist(&target).map_err(|e| e.error)?;
    Ok(())
}

/// What the names of temporary files begin with.
const PREFIX: &str = ".ondine-";
/// What they end with.
const SUFFIX: &str = ".tmp";

/// A temporary file, locked while it is there: so who looks for leftovers knows that it is none.
fn create(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    if let Some(permissions) = shared_permissions() {
        builder.permissions(permissions);
    }
    loop {
        let temporary = builder.tempfile_in(folder).map_err(|e| {
            // Without the random name of the temporary file, which tells the user nothing.
            let message = format!("cannot create a file in {}: {}", folder.display(), e.kind());
            io::Error::new(e.kind(), message)
        })?;
        // Where the file system has no locks, there is none.
        let _ = temporary.as_file().lock();
        // Between its creation and its lock, someone may have taken it for a leftover.
        if temporary.path().exists() {
            return Ok(temporary);
        }
    }
}

/// Removes what killed programs left half-written in the folder of a file; what is being written now stays.
pub fn remove_leftovers(beside: &Path) {
    let target = fs::canonicalize(beside).unwrap_or_else(|_| beside.to_owned());
    let Ok(entries) = folder_of(&target).and_then(fs::read_dir) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !name.starts_with(PREFIX) || !name.ends_with(SUFFIX) {
            continue;
        }
        let path = entry.path();
        // Whose lock nobody holds, that nobody writes. Where the file system has no locks, it stays.
        if File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
            // Left there, it does no harm.
            let _ = fs::remove_file(path);
        }
    }
}

/// The folder of a file to write.
fn folder_of(path: &Path) -> io::Result<PathBuf> {
    let folder = match path.parent() {
        None => return Err(other("it names no file".to_owned())),
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
    };
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => Ok(folder.to_owned()),
        Ok(_) => Err(other(format!("{} is no folder", folder.display()))),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!(
                "the folder {0} does not exist; create it first (mkdir -p {0})",
                folder.display()
            ),
        )),
        Err(e) => Err(e),
    }
}

/// Temporary files are private by default; an image is for all whom the umask allows.
fn shared_permissions() -> Option<Permissions> {
    #[cfg(unix)]
    return Some(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    #[cfg(not(unix))]
    None
}

fn other(message: String) -> io::Error {
    io::Error::other(message)
}
