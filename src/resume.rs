//! Floor 5: where a render goes on from: its checkpoint, or the image itself.

use crate::error::{Error, Result};
use crate::film::exr::{self, ImageHeader};
use crate::film::{Coverage, Film, Metadata};
use crate::render::{Rendered, Settings};
use crate::scene::description::Description;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Time from one checkpoint to the next, unless asked otherwise.
pub const INTERVAL: Duration = Duration::from_secs(60);

/// What the file of the image that is asked for will say, before it has any sample. `target_features` are those that the
/// program was compiled for.
pub fn wanted(scene: &Description, settings: &Settings, target_features: &str) -> ImageHeader {
    let first = || scene.cameras.first().map(|camera| camera.name.clone());
    ImageHeader {
        width: settings.width,
        height: settings.height,
        region: settings.region,
        aovs: settings.layers(),
        image_hash: String::new(),
        metadata: Metadata {
            scene: scene.name.clone(),
            scene_hash: scene.hash.clone(),
            camera: settings.camera.clone().or_else(first).unwrap_or_default(),
            crop: settings.region,
            seed: settings.seed,
            spp: settings.spp,
            shard: settings.shard,
            blocks: Coverage::default(),
            path_length: settings.path_length,
            strategy: settings.strategy.to_string(),
            sampler: settings.sampler.to_string(),
            roulette: settings.roulette,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            target_features: target_features.to_owned(),
            seconds: 0.0,
            rays: 0,
            interrupted: false,
        },
    }
}

/// What the file of an image says once it is rendered; `before` is what it goes on from.
pub fn reached(wanted: &Metadata, rendered: &Rendered, before: Option<&Metadata>) -> Metadata {
    let stats = &rendered.stats;
    Metadata {
        blocks: rendered.coverage.clone(),
        seconds: before.map_or(0.0, |before| before.seconds) + stats.render.as_secs_f64(),
        rays: before
            .map_or(0, |before| before.rays)
            .saturating_add(stats.rays()),
        interrupted: rendered.interrupted,
        ..wanted.clone()
    }
}

/// What there is already of an image.
#[derive(Debug)]
pub struct Before {
    /// The file that it is in.
    pub path: PathBuf,
    /// Its pixels.
    pub film: Film,
    /// What is known of its render.
    pub metadata: Metadata,
}

/// The checkpoint of an image, beside it.
pub fn checkpoint(exr: &Path) -> PathBuf {
    exr.with_extension("checkpoint.exr")
}

/// What is made of a file that holds another image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Other {
    /// It would be lost: an error.
    Refuse,
    /// It will be replaced.
    Replace,
}

/// What there is of the image that is `wanted`: in its checkpoint or its own file, whichever has more. A file that is
/// damaged is left out, and `damaged` told why.
///
/// # Errors
/// [`Error::Format`] where a file holds another image and that is refused; [`Error::Read`] where the system refuses.
pub fn find(
    exr: &Path,
    wanted: &ImageHeader,
    other: Other,
    damaged: &dyn Fn(&Error),
) -> Result<Option<Before>> {
    let mut found: Vec<(PathBuf, ImageHeader)> = Vec::new();
    for path in [exr.to_owned(), checkpoint(exr)] {
        if !path.exists() {
            continue;
        }
        let header = match exr::read_header(&path) {
            Err(error @ Error::Format { .. }) => {
                damaged(&error);
                continue;
            }
            header => header?,
        };
        match (belongs(&path, &header, wanted), other) {
            (Ok(()), _) => found.push((path, header)),
            (Err(error), Other::Refuse) => return Err(error),
            (Err(_), Other::Replace) => {}
        }
    }
    found.sort_by_key(|(_, header)| std::cmp::Reverse(header.metadata.blocks.len()));
    for (path, _) in found {
        match exr::read(&path) {
            Err(error @ Error::Format { .. }) => damaged(&error),
            read => {
                let (film, metadata) = read?;
                return Ok(Some(Before {
                    path,
                    film,
                    metadata,
                }));
            }
        }
    }
    Ok(None)
}

/// Removes the checkpoint of an image that is written, where the image has all that it had; and one that is damaged.
pub fn discard_checkpoint(exr: &Path, written: &Metadata) {
    let path = checkpoint(exr);
    let spent = match exr::read_header(&path) {
        Ok(header) => {
            let old = header.metadata;
            old.difference(written).is_none() && written.blocks.contains(&old.blocks)
        }
        Err(error) => matches!(error, Error::Format { .. }),
    };
    if spent {
        // Left there, it does no harm.
        let _ = std::fs::remove_file(path);
    }
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
    let (has, asked) = (found.metadata.spp, wanted.metadata.spp);
    if wanted.metadata.shard.is_some() && has != asked {
        return refuse(format!(
            "it is a shard of {has} samples per pixel, and one of {asked} has other pixels (merge the shards, then go on from that)"
        ));
    }
    if !found.metadata.continues_to(asked) {
        return refuse(format!(
            "it has {has} samples per pixel, and {asked} are asked for (16, 32, 48... can be continued)"
        ));
    }
    Ok(())
}
