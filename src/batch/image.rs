//! The files of a job: what is there of its image before, on the way, and at its end.

use super::plan::Ready;
use super::run::{Ended, Outcome};
use crate::error::{Error, Result};
use crate::film::exr::{self, ImageHeader};
use crate::film::{Film, Metadata, png, remove_leftovers};
use crate::render::Rendered;
use std::path::Path;

/// What there is of the image that `wanted` describes: in its checkpoint or its own file, whichever has more. What a killed
/// program left half-written is removed.
pub(super) fn before(ready: &Ready, wanted: &ImageHeader) -> Option<(Film, Metadata)> {
    let checkpoint = ready.checkpoint_path();
    for path in [&ready.exr, &checkpoint, &ready.png_path()] {
        remove_leftovers(path);
    }
    let usable = |path: &Path| {
        let found = exr::read_header(path).ok()?;
        let metadata = &found.metadata;
        let fits = metadata.shard.is_none()
            && metadata.continues_to(wanted.metadata.spp)
            && found.difference(wanted).is_none();
        fits.then(|| metadata.blocks.len())
    };
    let best = [&ready.exr, &checkpoint]
        .into_iter()
        .filter_map(|path| Some((usable(path)?, path)))
        .max_by_key(|&(blocks, _)| blocks);
    // Damaged, it is rendered anew.
    best.and_then(|(_, path)| exr::read(path).ok())
}

/// Keeps what there is of an image.
pub(super) fn keep(ready: &Ready, film: &Film, metadata: &Metadata) -> Result<()> {
    exr::write(&ready.checkpoint_path(), film, metadata)
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
    exr::write(&ready.exr, film, metadata)?;
    // The image has all that the checkpoint had.
    let _ = std::fs::remove_file(ready.checkpoint_path());
    ended.image_hash = Some(film.image_hash());
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
