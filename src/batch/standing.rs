//! What is there of a job already: its image's own header says what it is of.

use super::plan::{Job, Ready};
use crate::film::exr::{self, ImageHeader};
use std::path::Path;

/// How far a job is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Its image is there, of this scene and these settings.
    Done {
        /// The image's hash.
        image_hash: String,
    },
    /// The image is, and the PNG beside it is not.
    WithoutPng,
    /// There is no image.
    Missing,
    /// There is an image, of something else: of what.
    Changed(String),
    /// It could not be rendered, and why.
    Failed(String),
}

impl Standing {
    /// `done`, `missing`, `changed` or `failed`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Done { .. } => "done",
            Self::Missing => "missing",
            Self::WithoutPng | Self::Changed(_) => "changed",
            Self::Failed(_) => "failed",
        }
    }

    /// What there is to say beyond the name.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Done { .. } | Self::Missing => None,
            Self::WithoutPng => Some("its PNG is missing"),
            Self::Changed(why) | Self::Failed(why) => Some(why),
        }
    }

    /// That of a job, from its files.
    pub fn of(job: &Job) -> Self {
        match &job.ready {
            Ok(ready) => Self::of_image(ready),
            Err(why) => Self::Failed(why.clone()),
        }
    }

    /// That of a job that can be rendered.
    pub fn of_image(ready: &Ready) -> Self {
        if !exists(&ready.exr) {
            return Self::Missing;
        }
        let found = match exr::read_header(&ready.exr) {
            Ok(found) => found,
            Err(error) => return Self::Changed(error.to_string()),
        };
        match difference(ready, &found) {
            Some(what) => Self::Changed(what),
            None if ready.png.is_some() && !exists(&ready.png_path()) => Self::WithoutPng,
            None => Self::Done {
                image_hash: found.image_hash,
            },
        }
    }
}

/// Whether there is anything of that name.
fn exists(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// The first thing in which an image is not what the job asks for. What program made it is none of these.
fn difference(ready: &Ready, found: &ImageHeader) -> Option<String> {
    let mut wanted = ready.header.clone();
    let had = &found.metadata;
    wanted.metadata.version.clone_from(&had.version);
    wanted
        .metadata
        .target_features
        .clone_from(&had.target_features);
    match found.difference(&wanted) {
        Some(("scene", ..)) => return Some("the scene has changed".to_owned()),
        Some((what, old, new)) => return Some(format!("its {what} was {old} and is {new}")),
        None => {}
    }
    let has = &wanted.metadata;
    if had.spp != has.spp {
        return Some(format!(
            "its samples per pixel were {} and are {}",
            had.spp, has.spp
        ));
    }
    let (least, _) = had.samples();
    let whole = had.blocks.contains(&had.all_blocks());
    (!whole).then(|| format!("it has {least} of {} samples per pixel", had.spp))
}
