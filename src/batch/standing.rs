//! What is there of a job already: its image's own header says what it is of.

use super::plan::{Job, Ready};
use crate::film::{self, AovSet, Part};
use serde_json::Value;
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
        let description = match film::describe(&ready.exr) {
            Ok(description) => description,
            Err(error) => return Self::Changed(error.to_string()),
        };
        let [part] = &description.parts[..] else {
            return Self::Changed("its image is of another program".to_owned());
        };
        match difference(ready, part) {
            Some(what) => Self::Changed(what),
            None if ready.png.is_some() && !exists(&ready.png_path()) => Self::WithoutPng,
            None => Self::Done {
                image_hash: attribute(part, "image_hash"),
            },
        }
    }
}

/// Whether there is anything of that name.
fn exists(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// The first thing in which an image is not what the job asks for.
fn difference(ready: &Ready, part: &Part) -> Option<String> {
    let settings = &ready.settings;
    if attribute(part, "image_hash").is_empty() {
        return Some("its image is of another program".to_owned());
    }
    if attribute(part, "scene_hash") != *ready.scene_hash {
        return Some("the scene has changed".to_owned());
    }
    let r = settings.region;
    let window = |[x0, y0, x1, y1]: [i64; 4]| format!("{x0},{y0},{x1},{y1}");
    let corners = |x0: u32, y0: u32, x1: u32, y1: u32| window([x0, y0, x1, y1].map(i64::from));
    let roulette = |edge: Option<u32>| edge.map_or(String::new(), |edge| edge.to_string());
    let expected = [
        ("camera", settings.camera.clone().unwrap_or_default()),
        ("seed", settings.seed.to_string()),
        ("spp", settings.spp.to_string()),
        ("path_length", settings.path_length.to_string()),
        ("strategy", settings.strategy.to_string()),
        ("sampler", settings.sampler.to_string()),
        ("roulette", roulette(settings.roulette)),
        ("sample_ranges", format!("0..{}", settings.spp)),
    ];
    let of_header = expected
        .into_iter()
        .map(|(name, wanted)| (name, attribute(part, name), wanted));
    let of_windows = [
        (
            "size",
            window(part.display_window),
            corners(0, 0, settings.width, settings.height),
        ),
        (
            "crop",
            window(part.data_window),
            corners(r.x0, r.y0, r.x1, r.y1),
        ),
        (
            "aov",
            layers(part).to_string(),
            settings.layers().to_string(),
        ),
        (
            "path lengths of the layer bounces",
            layers(part).lengths.to_string(),
            settings.layers().lengths.to_string(),
        ),
    ];
    let or_none = |text: String| {
        if text.is_empty() {
            "none".to_owned()
        } else {
            text
        }
    };
    of_header
        .chain(of_windows)
        .find(|(_, found, wanted)| found != wanted)
        .map(|(name, found, wanted)| {
            format!("{name} was {} and is {}", or_none(found), or_none(wanted))
        })
}

/// An attribute as text; empty where there is none.
fn attribute(part: &Part, name: &str) -> String {
    match part.attributes.get(&format!("ondine.{name}")) {
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
        None => String::new(),
    }
}

/// The extra layers that an image has.
fn layers(part: &Part) -> AovSet {
    let has = |name: &str| part.channels.iter().any(|channel| channel.name == name);
    let lengths = part.channels.iter().filter(|channel| {
        let name = channel.name.strip_prefix("length.");
        name.is_some_and(|name| name.ends_with(".R"))
    });
    AovSet {
        albedo: has("albedo.R"),
        normal: has("normal.X"),
        depth: has("depth.Z"),
        lengths: u32::try_from(lengths.count()).unwrap_or(u32::MAX),
    }
}
