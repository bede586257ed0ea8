//! The files of a job: what is there of its image before, on the way, and at its end.

use super::plan::Ready;
use super::run::{Ended, Outcome};
use crate::error::{Error, Result};
use crate::film::{Film, Metadata, exr, png};
use crate::render::Rendered;
use crate::resume;
use std::path::Path;

/// Keeps what there is of an image.
pub(super) fn keep(ready: &Ready, film: &Film, metadata: &Metadata) -> Result<()> {
    exr::write(&resume::checkpoint(&ready.exr), film, metadata).map(drop)
}

/// Writes the files of an image that is whole; keeps what there is of one that was stopped.
pub(super) fn finish(ready: &Ready, rendered: &Rendered, metadata: &Metadata) -> Result<Ended> {
    let film = &rendered.film;
    let mut ended = Ended {
        outcome: Outcome::Interrupted,
        paths: rendered.stats.paths(),
        rays: rendered.stats.rays(),
        rejected: film.rejected(),
        ..Ended::default()
    };
    if rendered.interrupted {
        if ended.paths > 0 {
            keep(ready, film, metadata)?;
        }
        return Ok(ended);
    }
    // The image last: where it is, the job is done.
    write_png(ready, film)?;
    ended.image_hash = Some(exr::write(&ready.exr, film, metadata)?);
    // The image has all that the checkpoint had.
    let _ = std::fs::remove_file(resume::checkpoint(&ready.exr));
    ended.outcome = Outcome::Done;
    Ok(ended)
}

/// The picture of an image that is there.
pub(super) fn develop(ready: &Ready) -> Result<Ended> {
    let (film, _) = exr::read(&ready.exr)?;
    write_png(ready, &film)?;
    Ok(Ended {
        image_hash: Some(film.image_hash()),
        ..Ended::default()
    })
}

fn write_png(ready: &Ready, film: &Film) -> Result<()> {
    match ready.png {
        Some(tonemap) => png::write(&ready.png_path(), film, tonemap),
        None => Ok(()),
    }
}

/// Makes the folder of a file.
pub(super) fn create_folder(file: &Path) -> Result<()> {
    let Some(folder) = file.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|source| Error::Write {
        path: folder.to_owned(),
        source,
    })
}
