//! What an image file says of the render that made it: header attributes whose names begin with `ondine.`.

use super::{BLOCK, Coverage, Region, Shard};
use exr::meta::attribute::{AttributeValue, Text};
use std::collections::HashMap;
use std::ops::Range;
use std::str::FromStr;

/// The settings and the course of a render. The size and the pixels that are stored are the file's windows, AOVs its
/// channels, and the film itself knows its rejected samples.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Metadata {
    /// Name of the scene as the user gave it.
    pub scene: String,
    /// Hash of what the scene says, hexadecimal.
    pub scene_hash: String,
    /// Name of the camera.
    pub camera: String,
    /// The pixels that were asked for; a shard may store fewer.
    #[serde(rename = "asked")]
    pub crop: Region,
    /// Seed.
    pub seed: u64,
    /// Samples per pixel of the whole image, of which this file may hold a part.
    pub spp: u32,
    /// Which of several parts of the image it is, if it was rendered as one.
    pub shard: Option<Shard>,
    /// The sample blocks that it holds.
    pub blocks: Coverage,
    /// Greatest number of edges of a path.
    pub path_length: u32,
    /// Estimator.
    pub strategy: String,
    /// Source of random numbers.
    pub sampler: String,
    /// First path edge after which Russian roulette may end a path; none without it, and then the file says nothing.
    pub roulette: Option<u32>,
    /// Version of the program.
    pub version: String,
    /// The instruction sets it was compiled for.
    pub target_features: String,
    /// Seconds of rendering, all parts together.
    pub seconds: f64,
    /// Rays traced: closest hit and shadow.
    pub rays: u64,
    /// Whether the render was stopped before its last sample.
    pub interrupted: bool,
}

/// What the film knows of itself and its channels do not say.
pub(super) struct FilmFacts {
    /// Samples kept out.
    pub rejected: u64,
    /// [`image_hash`](super::Film::image_hash).
    pub image_hash: String,
    /// Of all channels: whoever reads can see that no byte was lost.
    pub checksum: String,
}

/// Attributes of an EXR header.
pub(super) type Attributes = HashMap<Text, AttributeValue>;

impl Metadata {
    /// Every sample block of the whole image.
    pub fn all_blocks(&self) -> Coverage {
        Coverage::of_samples(0..self.spp, self.crop.pixels() as u64)
    }

    /// The sample indices that were traced for every pixel; more than one range after a merge of parts that are not
    /// neighbours.
    pub fn sample_ranges(&self) -> Vec<Range<u32>> {
        self.blocks
            .sample_ranges(self.crop.pixels() as u64, self.spp)
    }

    /// The least and the greatest number of samples of any pixel that was asked for.
    pub fn samples(&self) -> (u32, u32) {
        self.blocks.samples(self.crop.pixels() as u64, self.spp)
    }

    /// The first thing, beside the number of samples, in which another image is not a part of this one: what it is, this
    /// image's value and the other's. The file that a scene was read from may have any name.
    pub fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let roulette = |metadata: &Self| match metadata.roulette {
            Some(edge) => format!("from edge {edge}"),
            None => "none".to_owned(),
        };
        let scene = |metadata: &Self| {
            let hash: String = metadata.scene_hash.chars().take(12).collect();
            format!("{} ({hash}...)", metadata.scene)
        };
        type Setting<'a> = (&'static str, &'a dyn Fn(&Metadata) -> String);
        let settings: [Setting; 9] = [
            ("camera", &|m| m.camera.clone()),
            ("crop", &|m| m.crop.to_string()),
            ("seed", &|m| m.seed.to_string()),
            ("path length", &|m| m.path_length.to_string()),
            ("strategy", &|m| m.strategy.clone()),
            ("sampler", &|m| m.sampler.clone()),
            ("roulette", &roulette),
            ("program version", &|m| m.version.clone()),
            ("target features", &|m| m.target_features.clone()),
        ];
        if self.scene_hash != other.scene_hash {
            return Some(("scene", scene(self), scene(other)));
        }
        settings
            .iter()
            .map(|(name, of)| (*name, of(self), of(other)))
            .find(|(_, mine, theirs)| mine != theirs)
    }

    /// Whether its samples are the first ones of an image of so many: a last block of fewer than 16 is not the beginning
    /// of a whole one.
    pub fn continues_to(&self, spp: u32) -> bool {
        self.spp == spp || (self.spp < spp && self.spp.is_multiple_of(BLOCK))
    }

    /// As attributes, with those of the film.
    pub(super) fn to_attributes(&self, facts: &FilmFacts) -> Attributes {
        let ranges: Vec<_> = self
            .sample_ranges()
            .iter()
            .map(|r| format!("{}..{}", r.start, r.end))
            .collect();
        [
            ("scene", text(&self.scene)),
            ("scene_hash", text(&self.scene_hash)),
            ("camera", text(&self.camera)),
            ("crop", text(&self.crop.to_string())),
            ("seed", whole(self.seed)),
            ("spp", whole(self.spp.into())),
            ("sample_ranges", text(&ranges.join(","))),
            ("blocks", text(&self.blocks.to_string())),
            ("path_length", whole(self.path_length.into())),
            ("strategy", text(&self.strategy)),
            ("sampler", text(&self.sampler)),
            ("version", text(&self.version)),
            ("target_features", text(&self.target_features)),
            ("seconds", AttributeValue::F64(self.seconds)),
            ("rays", whole(self.rays)),
            ("interrupted", whole(self.interrupted.into())),
            ("rejected_samples", whole(facts.rejected)),
            ("image_hash", text(&facts.image_hash)),
            ("checksum", text(&facts.checksum)),
        ]
        .into_iter()
        .chain(self.roulette.map(|edge| ("roulette", whole(edge.into()))))
        .chain(self.shard.map(|shard| ("shard", text(&shard.to_string()))))
        .map(|(key, value)| (name(key), value))
        .collect()
    }

    /// What a checksum is taken of: all that a file says of its render, but for the checksum itself.
    pub(super) fn checked_bytes(all: &Attributes) -> Vec<u8> {
        let mut own: Vec<_> = all
            .iter()
            .filter(|(key, _)| key.as_slice().starts_with(b"ondine.") && **key != name("checksum"))
            .collect();
        own.sort_by(|(a, _), (b, _)| a.as_slice().cmp(b.as_slice()));
        let mut bytes = Vec::new();
        for (key, value) in own {
            bytes.extend_from_slice(key.as_slice());
            match value {
                AttributeValue::Text(text) => bytes.extend_from_slice(text.as_slice()),
                AttributeValue::I32(number) => bytes.extend_from_slice(&number.to_le_bytes()),
                AttributeValue::F64(number) => bytes.extend_from_slice(&number.to_le_bytes()),
                // None that this program writes.
                _ => {}
            }
        }
        bytes
    }

    /// The version of this program that wrote a file; none where it was another program.
    pub(super) fn version_of(all: &Attributes) -> Option<String> {
        Reader(all).text("version").ok()
    }

    /// From attributes, with those of the film; the name of the attribute that is missing or wrong.
    pub(super) fn from_attributes(all: &Attributes) -> Result<(Self, FilmFacts), String> {
        let read = Reader(all);
        let metadata = Self {
            scene: read.text("scene")?,
            scene_hash: read.text("scene_hash")?,
            camera: read.text("camera")?,
            crop: read.parsed("crop")?,
            seed: read.whole("seed")?,
            spp: read.whole("spp")?,
            shard: read
                .has("shard")
                .then(|| read.parsed("shard"))
                .transpose()?,
            blocks: read.parsed("blocks")?,
            path_length: read.whole("path_length")?,
            strategy: read.text("strategy")?,
            sampler: read.text("sampler")?,
            roulette: read
                .has("roulette")
                .then(|| read.whole("roulette"))
                .transpose()?,
            version: read.text("version")?,
            target_features: read.text("target_features")?,
            seconds: read.seconds("seconds")?,
            rays: read.whole("rays")?,
            interrupted: read.whole::<u8>("interrupted")? != 0,
        };
        if !metadata.all_blocks().contains(&metadata.blocks) {
            return Err("the attribute ondine.blocks names samples beyond its image".to_owned());
        }
        let facts = FilmFacts {
            rejected: read.whole("rejected_samples")?,
            image_hash: read.text("image_hash")?,
            checksum: read.text("checksum")?,
        };
        Ok((metadata, facts))
    }
}

fn name(key: &str) -> Text {
    Text::from_slice_unchecked(format!("ondine.{key}").as_bytes())
}

/// UTF-8, as other OpenEXR programs write it.
fn text(value: &str) -> AttributeValue {
    AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()))
}

/// OpenEXR's integers have 32 bits; what does not fit is text.
fn whole(value: u64) -> AttributeValue {
    i32::try_from(value).map_or_else(|_| text(&value.to_string()), AttributeValue::I32)
}

struct Reader<'a>(&'a Attributes);

impl Reader<'_> {
    fn has(&self, key: &str) -> bool {
        self.0.contains_key(&name(key))
    }

    fn get<T>(&self, key: &str, read: impl Fn(&AttributeValue) -> Option<T>) -> Result<T, String> {
        let attribute = format!("ondine.{key}");
        match self.0.get(&name(key)) {
            None => Err(format!("the attribute {attribute} is missing")),
            Some(value) => read(value)
                .ok_or_else(|| format!("the attribute {attribute} is not what it should be")),
        }
    }

    fn text(&self, key: &str) -> Result<String, String> {
        self.get(key, |value| match value {
            AttributeValue::Text(text) => {
                Some(String::from_utf8_lossy(text.as_slice()).into_owned())
            }
            _ => None,
        })
    }

    fn whole<T: TryFrom<u64>>(&self, key: &str) -> Result<T, String> {
        self.get(key, |value| {
            let value = match value {
                AttributeValue::I32(value) => u64::try_from(*value).ok()?,
                AttributeValue::Text(text) => {
                    std::str::from_utf8(text.as_slice()).ok()?.parse().ok()?
                }
                _ => return None,
            };
            T::try_from(value).ok()
        })
    }

    fn seconds(&self, key: &str) -> Result<f64, String> {
        self.get(key, |value| match value {
            AttributeValue::F64(value) => Some(*value),
            AttributeValue::F32(value) => Some(f64::from(*value)),
            _ => None,
        })
    }

    fn parsed<T: FromStr>(&self, key: &str) -> Result<T, String> {
        let text = self.text(key)?;
        text.parse()
            .map_err(|_| format!("the attribute ondine.{key} is not what it should be"))
    }
}
