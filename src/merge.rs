//! Floor 5: parts of an image, put together: bit for bit what one render would have made, in whatever order they come.

use crate::error::{Error, Result};
use crate::film::exr::{self, ImageHeader};
use crate::film::{AovSet, BLOCK, Coverage, Film, Metadata, Region, Shard};
use rayon::prelude::*;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Parts of one image, of which no block of samples is there twice.
#[derive(Clone, Debug)]
pub struct Parts {
    /// In the order of their samples, whatever order they were named in: sums of seconds depend on it.
    parts: Vec<(PathBuf, ImageHeader)>,
    /// The pixels that any of them stores.
    region: Region,
    /// What the merged image says of itself.
    metadata: Metadata,
}

impl Parts {
    /// Reads the headers of these files, and makes sure that they belong together.
    ///
    /// # Errors
    /// [`Error::Usage`] without files; [`Error::Format`] where one is no part of the image that the first belongs to, or holds
    /// samples that another holds too; and those of [`exr::read_header`].
    pub fn open(paths: &[PathBuf]) -> Result<Self> {
        let mut parts = paths
            .iter()
            .map(|path| Ok((path.clone(), exr::read_header(path)?)))
            .collect::<Result<Vec<_>>>()?;
        // The one with the most samples says how many there shall be.
        let largest = parts
            .iter()
            .rev()
            .max_by_key(|(_, header)| header.metadata.spp);
        let Some((model_path, model)) = largest else {
            return Err(Error::Usage("no parts are given to merge".to_owned()));
        };
        for (path, header) in &parts {
            belongs(path, header, model_path, model)?;
        }
        let (spp, crop) = (model.metadata.spp, model.metadata.crop);
        parts.sort_by_key(|(path, header)| {
            let first = header.metadata.blocks.ranges().first();
            (first.map_or(0, |range| range.start), path.clone())
        });
        apart(&parts, crop)?;
        let of = |field: fn(&Metadata) -> f64| {
            parts
                .iter()
                .map(|(_, header)| field(&header.metadata))
                .sum()
        };
        let rays = parts.iter().map(|(_, header)| header.metadata.rays);
        let held = parts
            .iter()
            .flat_map(|(_, header)| header.metadata.blocks.ranges());
        let blocks = Coverage::of(held.cloned());
        let all = Coverage::of_samples(0..spp, crop.pixels() as u64);
        let metadata = Metadata {
            spp,
            shard: None,
            seconds: of(|metadata| metadata.seconds),
            rays: rays.fold(0, u64::saturating_add),
            interrupted: !blocks.contains(&all),
            blocks,
            ..parts[0].1.metadata.clone()
        };
        let regions = parts.iter().map(|(_, header)| header.region);
        Ok(Self {
            region: regions.reduce(Region::bounding).unwrap_or(crop),
            metadata,
            parts,
        })
    }

    /// What the merged image says of itself.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The pixels that any part stores.
    pub fn region(&self) -> Region {
        self.region
    }

    /// The AOVs that all parts store.
    pub fn aovs(&self) -> AovSet {
        self.parts
            .first()
            .map(|(_, header)| header.aovs)
            .unwrap_or_default()
    }

    /// What the whole image has beyond these parts.
    pub fn missing(&self) -> Missing {
        let whole = self.metadata.all_blocks();
        let blocks = whole.without(&self.metadata.blocks);
        let numbers = self.parts.iter().filter_map(|(_, header)| {
            let shard = header.metadata.shard?;
            // A shard of some samples alone is none of the whole image.
            (whole.part(shard) == header.metadata.blocks).then_some(shard.of())
        });
        let number = numbers.max();
        let lacking = |of| {
            Shard::all(of).filter(|&shard| !blocks.intersection(&whole.part(shard)).is_empty())
        };
        let shards: Vec<Shard> = match number {
            Some(of) if of <= MOST_SHARDS => lacking(of).collect(),
            _ => Vec::new(),
        };
        let pixels = self.metadata.crop.pixels() as u64;
        let samples = blocks.sample_ranges(pixels, self.metadata.spp);
        let passes = samples.iter().cloned();
        let passes = passes.map(|samples| Coverage::of_samples(samples, pixels));
        let is_passes = passes.fold(Coverage::default(), |all, pass| all.union(&pass)) == blocks;
        Missing {
            samples: if is_passes { samples } else { Vec::new() },
            all: whole.len(),
            blocks,
            shards,
        }
    }

    /// Whether an image is the one that they belong to, and has all of their samples.
    pub fn are_all_in(&self, image: &ImageHeader) -> bool {
        let first = self.parts.first();
        first.is_some_and(|(_, part)| image.difference(part).is_none())
            && image.metadata.spp == self.metadata.spp
            && image.metadata.blocks.contains(&self.metadata.blocks)
    }

    /// Reads the parts, and adds them up: several at once on the rayon pool that the caller runs in.
    ///
    /// # Errors
    /// Those of [`exr::read`], and [`Error::Format`] where a file changed since its header was read.
    pub fn merge(&self) -> Result<Film> {
        let Some((_, first)) = self.parts.first() else {
            return Err(Error::Usage("no parts are given to merge".to_owned()));
        };
        let sum = Film::new(first.width, first.height, self.region, first.aovs)?;
        self.parts.par_iter().try_for_each(|(path, header)| {
            if exr::add_to(path, &sum)? != header.metadata {
                let message = "this file was replaced while it was merged; merge again";
                return Err(Error::format(path, message));
            }
            Ok(())
        })?;
        Ok(sum)
    }
}

/// Shards beyond which they are not looked for one by one.
const MOST_SHARDS: u32 = 1 << 12;

/// Whether a part is one of the image that the model belongs to.
fn belongs(path: &Path, part: &ImageHeader, model_path: &Path, model: &ImageHeader) -> Result<()> {
    let other = model_path.display();
    if let Some((what, theirs, mine)) = model.difference(part) {
        return Err(Error::format(
            path,
            format!(
                "is no part of the image of {other}: its {what} is {mine}, and there it is {theirs}"
            ),
        ));
    }
    let (spp, whole) = (part.metadata.spp, model.metadata.spp);
    if !part.metadata.continues_to(whole) {
        return Err(Error::format(
            path,
            format!(
                "was rendered with {spp} samples per pixel, and {other} has {whole}; only a multiple of {BLOCK} can be \
                 continued"
            ),
        ));
    }
    Ok(())
}

/// Whether no sample block is there twice; parts are sorted by their first block.
fn apart(parts: &[(PathBuf, ImageHeader)], crop: Region) -> Result<()> {
    let mut ranges: Vec<_> = parts
        .iter()
        .enumerate()
        .flat_map(|(i, (_, header))| {
            let ranges = header.metadata.blocks.ranges().iter();
            ranges.map(move |range| (range.clone(), i))
        })
        .collect();
    ranges.sort_by_key(|(range, i)| (range.start, *i));
    // Of sorted ranges, the one that reaches furthest so far is the one to meet.
    let mut furthest: Option<(u64, usize)> = None;
    for (range, i) in ranges {
        if let Some((end, j)) = furthest.filter(|&(end, _)| range.start < end) {
            let shared = range.start..range.end.min(end);
            let pixels = crop.pixels() as u64;
            let (pixel, first) = (
                shared.start % pixels,
                shared.start / pixels * u64::from(BLOCK),
            );
            let width = u64::from(crop.width());
            let (x, y) = (
                u64::from(crop.x0) + pixel % width,
                u64::from(crop.y0) + pixel / width,
            );
            return Err(Error::format(
                &parts[i].0,
                format!(
                    "holds samples that {} holds too (from sample {first} of pixel {x},{y} on); leave one of them out",
                    parts[j].0.display(),
                ),
            ));
        }
        if furthest.is_none_or(|(end, _)| range.end > end) {
            furthest = Some((range.end, i));
        }
    }
    Ok(())
}

/// What an image lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// The sample blocks.
    pub blocks: Coverage,
    /// How many sample blocks the whole image has.
    pub all: u64,
    /// The shards that they are in, where the parts are shards.
    pub shards: Vec<Shard>,
    /// The samples of every pixel that they are, if they are that.
    pub samples: Vec<Range<u32>>,
}

impl Missing {
    /// Whether nothing is.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

impl std::fmt::Display for Missing {
    /// `shards 3/16 and 7/16 (12.5 % of the samples)`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        const MOST: usize = 12;
        let percent = self.blocks.len() as f64 / self.all.max(1) as f64 * 100.0;
        let names: Vec<String> = self.shards.iter().map(Shard::to_string).collect();
        match &names[..] {
            [] if self.samples.is_empty() => write!(f, "{percent:.3} % of the samples"),
            [] => {
                let range = |samples: &Range<u32>| format!("{}..{}", samples.start, samples.end);
                let ranges: Vec<String> = self.samples.iter().map(range).collect();
                write!(
                    f,
                    "the samples {} of each pixel ({percent:.1} %)",
                    ranges.join(", ")
                )
            }
            [one] => write!(f, "shard {one} ({percent:.1} % of the samples)"),
            [first @ .., last] if names.len() <= MOST => {
                let first = first.join(", ");
                write!(
                    f,
                    "shards {first} and {last} ({percent:.1} % of the samples)"
                )
            }
            _ => {
                let (first, more) = (names[..MOST].join(", "), names.len() - MOST);
                write!(
                    f,
                    "shards {first} and {more} more ({percent:.1} % of the samples)"
                )
            }
        }
    }
}
