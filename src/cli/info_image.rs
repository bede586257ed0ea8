//! What an OpenEXR image holds.

use super::report::Samples;
use crate::error::{Error, Result};
use crate::film::{self, Coverage, ExrDescription, Film, Metadata, Part, Region, exr};
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

/// What `info` says of an image.
#[derive(Debug, Serialize)]
pub(super) struct ImageInfo {
    kind: &'static str,
    file: String,
    #[serde(flatten)]
    description: ExrDescription,
    #[serde(flatten)]
    exact: Option<Exact>,
}

/// What an image of this program has beyond any other.
#[derive(Debug, Serialize)]
struct Exact {
    width: u32,
    height: u32,
    /// x0, y0, x1, y1.
    region: [u32; 4],
    /// The pixels that `image_hash` is of, where it is not of all.
    crop: Option<[u32; 4]>,
    /// From the exact sums, not from what the header says.
    image_hash: String,
    /// Samples that pixels hold.
    samples: Samples,
    rejected_samples: u64,
    /// The samples that every pixel has.
    sample_ranges: Vec<std::ops::Range<u32>>,
    /// The sample blocks that the whole image has and this file lacks.
    missing_blocks: Coverage,
    #[serde(flatten)]
    metadata: Metadata,
}

/// Reads an image: its header whoever wrote it, and its pixels where this program did.
pub(super) fn read(path: &Path, crop: Option<Region>) -> Result<ImageInfo> {
    let description = film::describe(path)?;
    let ours = description.parts.iter().any(|part| {
        part.attributes
            .keys()
            .any(|name| name.starts_with("ondine."))
    });
    // With a crop, an image of another program is an error, and reading it says which.
    let exact = (ours || crop.is_some())
        .then(|| exr::read(path))
        .transpose()?
        .map(|(film, metadata)| Exact::of(&film, metadata, crop))
        .transpose()?;
    Ok(ImageInfo {
        kind: "image",
        file: path.display().to_string(),
        description,
        exact,
    })
}

impl Exact {
    fn of(film: &Film, metadata: Metadata, crop: Option<Region>) -> Result<Self> {
        let image_hash = match crop {
            None => film.image_hash(),
            Some(crop) => film.image_hash_of(crop).map_err(|error| match error {
                Error::Usage(message) => Error::Usage(format!("--crop: {message}")),
                other => other,
            })?,
        };
        let counts = || film.region().coordinates().map(|(x, y)| film.count(x, y));
        let corners = |r: Region| [r.x0, r.y0, r.x1, r.y1];
        Ok(Self {
            width: film.width(),
            height: film.height(),
            region: corners(film.region()),
            crop: crop.map(corners),
            image_hash,
            samples: Samples {
                min: counts().min().unwrap_or(0),
                max: counts().max().unwrap_or(0),
            },
            rejected_samples: film.rejected(),
            sample_ranges: metadata.sample_ranges(),
            missing_blocks: metadata.all_blocks().without(&metadata.blocks),
            metadata,
        })
    }
}

impl ImageInfo {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = format!("{:<13}{}\n", "image", self.file);
        for part in &self.description.parts {
            describe(&mut text, part);
        }
        if let Some(exact) = &self.exact {
            exact.describe(&mut text);
        }
        text
    }
}

fn line(text: &mut String, name: &str, value: impl std::fmt::Display) {
    let _ = writeln!(text, "{name:<13}{value}");
}

fn describe(text: &mut String, part: &Part) {
    if let Some(name) = &part.name {
        line(text, "part", name);
    }
    let [x0, y0, x1, y1] = part.data_window;
    let size = format!("{}x{}", x1 - x0, y1 - y0);
    match part.data_window == part.display_window {
        true => line(text, "pixels", size),
        false => {
            let [fx0, fy0, fx1, fy1] = part.display_window;
            let place = format!("{size}: {x0},{y0},{x1},{y1} of {fx0},{fy0},{fx1},{fy1}");
            line(text, "pixels", place);
        }
    }
    line(
        text,
        "storage",
        format!("{}, {} compression", part.storage, part.compression),
    );
    for kind in ["half", "float", "uint"] {
        let names: Vec<_> = part
            .channels
            .iter()
            .filter(|channel| channel.kind == kind)
            .map(|channel| channel.name.as_str())
            .collect();
        if !names.is_empty() {
            line(text, kind, wrapped(&short(&names)));
        }
    }
    for (name, value) in &part.attributes {
        // Ours are told in their own words, and how a file is laid out tells nobody anything.
        const LAYOUT: [&str; 3] = ["chunkCount", "lineOrder", "type"];
        if !name.starts_with("ondine.") && !LAYOUT.contains(&name.as_str()) {
            let value = match value {
                Value::String(value) => value.escape_debug().to_string(),
                other => other.to_string(),
            };
            let _ = writeln!(text, "  {name} = {value}");
        }
    }
}

/// The names, a layer of many channels as `exact.* (25 channels)`.
fn short(names: &[&str]) -> Vec<String> {
    const MANY: usize = 8;
    let layer = |name: &str| name.split_once('.').map(|(layer, _)| layer.to_owned());
    let size = |of: &Option<String>| names.iter().filter(|name| layer(name) == *of).count();
    let mut all: Vec<String> = names
        .iter()
        .map(|name| match layer(name) {
            Some(layer) if size(&Some(layer.clone())) > MANY => {
                format!("{layer}.* ({} channels)", size(&Some(layer.clone())))
            }
            _ => (*name).to_owned(),
        })
        .collect();
    all.dedup();
    all
}

/// Names with spaces, on as many lines as they take.
fn wrapped(names: &[String]) -> String {
    const WIDTH: usize = 87;
    let mut text = String::new();
    let mut length = 0;
    for name in names {
        if length > 0 && length + name.len() + 1 > WIDTH {
            text += "\n             ";
            length = 0;
        } else if length > 0 {
            text += " ";
            length += 1;
        }
        text += name;
        length += name.len();
    }
    text
}

impl Exact {
    fn describe(&self, text: &mut String) {
        let m = &self.metadata;
        line(text, "scene", format!("{}, camera {}", m.scene, m.camera));
        line(text, "scene hash", &m.scene_hash);
        let roulette = m
            .roulette
            .map_or(String::new(), |edge| format!(", roulette from edge {edge}"));
        line(
            text,
            "settings",
            format!(
                "{} spp, path length {}, {}, {}, seed {}{roulette}",
                m.spp, m.path_length, m.strategy, m.sampler, m.seed
            ),
        );
        let Samples { min, max } = self.samples;
        let held = match min == max {
            true => format!("{max} in each pixel"),
            false => format!("{min} to {max} in a pixel"),
        };
        let stopped = if m.interrupted { ", interrupted" } else { "" };
        line(text, "samples", format!("{held}{stopped}"));
        if !self.missing_blocks.is_empty() {
            let all = m.all_blocks().len();
            let percent = m.blocks.len() as f64 / all as f64 * 100.0;
            let shard = m
                .shard
                .map(|shard| format!("shard {shard}: "))
                .unwrap_or_default();
            let held = m.blocks.len();
            line(
                text,
                "part",
                format!("{shard}{held} of {all} sample blocks ({percent:.1} %)"),
            );
        }
        line(text, "rejected", self.rejected_samples);
        line(
            text,
            "made by",
            format!(
                "Ondine {} ({}) in {:.2} s with {} rays",
                m.version, m.target_features, m.seconds, m.rays
            ),
        );
        match self.crop {
            None => line(text, "image hash", &self.image_hash),
            Some([x0, y0, x1, y1]) => line(
                text,
                "image hash",
                format!("{} (of {x0},{y0},{x1},{y1})", self.image_hash),
            ),
        }
    }
}
