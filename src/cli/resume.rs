//! Where a render goes on from: its checkpoint, or the image itself.

use super::outputs::Outputs;
use crate::error::{Error, Result};
use crate::film::exr::{self, ImageHeader};
use crate::film::{Film, Metadata, remove_leftovers};
use std::path::{Path, PathBuf};

/// What there is already of an image.
#[derive(Debug)]
pub(super) struct Before {
    /// The file that it is in.
    pub path: PathBuf,
    pub film: Film,
    pub metadata: Metadata,
}

/// The checkpoint of an image, beside it.
pub(super) fn checkpoint(exr: &Path) -> PathBuf {
    exr.with_extension("checkpoint.exr")
}

/// What there is of the image that is `wanted`: in its checkpoint or its own file, whichever has more. What a killed render
/// left half-written is removed.
///
/// # Errors
/// [`Error::Format`] where a file holds another image: it would be lost. A damaged one is told of and left out.
pub(super) fn find(outputs: &Outputs, wanted: &ImageHeader) -> Result<Option<Before>> {
    let checkpoint = checkpoint(&outputs.exr);
    let files = [outputs.exr.as_path(), &checkpoint];
    for path in outputs.paths().chain([checkpoint.as_path()]) {
        remove_leftovers(path);
    }
    let mut best: Option<(&Path, ImageHeader)> = None;
    for path in files.into_iter().filter(|path| path.exists()) {
        let header = match exr::read_header(path) {
            Err(error @ Error::Format { .. }) => {
                left_out(&error);
                continue;
            }
            other => other?,
        };
        belongs(path, &header, wanted)?;
        let blocks = |header: &ImageHeader| header.metadata.blocks.len();
        if best
            .as_ref()
            .is_none_or(|(_, best)| blocks(&header) > blocks(best))
        {
            best = Some((path, header));
        }
    }
    let Some((path, _)) = best else {
        return Ok(None);
    };
    match exr::read(path) {
        Ok((film, metadata)) => Ok(Some(Before {
            path: path.to_owned(),
            film,
            metadata,
        })),
        Err(error @ Error::Format { .. }) => {
            left_out(&error);
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn left_out(error: &Error) {
    super::say(format_args!(
        "warning: {error}; its samples are rendered anew"
    ));
}

/// Makes sure that an image is a beginning of the one that is wanted.
fn belongs(path: &Path, found: &ImageHeader, wanted: &ImageHeader) -> Result<()> {
    let refuse = |why: String| {
        let remedy = "name another output, or delete this file to begin anew";
        Err(Error::format(
            path,
            format!("cannot be resumed: {why}; {remedy}"),
        ))
    };
    if let Some((what, theirs, mine)) = found.difference(wanted) {
        return refuse(format!("its {what} is {theirs}, and {mine} is asked for"));
    }
    let (has, asked) = (found.metadata.spp, wanted.metadata.spp);
    if !found.metadata.continues_to(asked) {
        return refuse(format!(
            "it has {has} samples per pixel, and {asked} are asked for (16, 32, 48... can be continued)"
        ));
    }
    if found.metadata.shard != wanted.metadata.shard {
        let name = |header: &ImageHeader| match header.metadata.shard {
            Some(shard) => format!("shard {shard}"),
            None => "the whole image".to_owned(),
        };
        return refuse(format!(
            "it is of {}, and {} is asked for",
            name(found),
            name(wanted)
        ));
    }
    Ok(())
}
