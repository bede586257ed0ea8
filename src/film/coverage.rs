//! Which samples of an image are there, exactly: what a shard is cut by, and what a merge checks.

use super::{BLOCK, Region, Shard};
use std::collections::BTreeMap;
use std::ops::Range;

/// A set of sample blocks, as sorted ranges that neither meet nor touch.
///
/// The [blocks](BLOCK) of an image are numbered pass by pass, a pass being a block of every pixel of the region that was
/// asked for: number = pass · pixels + pixel, pixels row after row. The numbers do not depend on how many samples are
/// wanted, so an image with more samples has the same blocks first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coverage(Vec<Range<u64>>);

/// A rectangle of pixels, and which passes over it; a pass is [`BLOCK`] samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Passes {
    /// The pixels.
    pub tile: Region,
    /// Numbers of passes.
    pub passes: Range<u64>,
}

impl Coverage {
    /// Of blocks in any order; ranges may be empty, meet and overlap.
    pub fn of(blocks: impl IntoIterator<Item = Range<u64>>) -> Self {
        let mut ranges: Vec<_> = blocks
            .into_iter()
            .filter(|range| !range.is_empty())
            .collect();
        ranges.sort_by_key(|range| range.start);
        let mut joined: Vec<Range<u64>> = Vec::with_capacity(ranges.len());
        for range in ranges {
            match joined.last_mut() {
                Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
                _ => joined.push(range),
            }
        }
        Self(joined)
    }

    /// The blocks that hold these samples of every one of so many pixels. A block that is begun counts.
    pub fn of_samples(samples: Range<u32>, pixels: u64) -> Self {
        let block = u64::from(BLOCK);
        let first = u64::from(samples.start) / block;
        let end = u64::from(samples.end).div_ceil(block);
        Self::of(std::iter::once(
            first.saturating_mul(pixels)..end.saturating_mul(pixels),
        ))
    }

    /// The blocks of some passes over a rectangle of the region.
    pub fn of_passes(region: Region, part: &Passes) -> Self {
        let pixels = region.pixels() as u64;
        let (tile, width) = (part.tile, u64::from(region.width()));
        let passes =
            part.passes.start.saturating_mul(pixels)..part.passes.end.saturating_mul(pixels);
        if tile == region {
            return Self::of([passes]);
        }
        let row = move |y: u32| {
            let first = u64::from(y - region.y0) * width + u64::from(tile.x0 - region.x0);
            first..first + u64::from(tile.width())
        };
        let rows = part.passes.clone().flat_map(|pass| {
            (tile.y0..tile.y1)
                .map(row)
                .map(move |row| row.start + pass * pixels..row.end + pass * pixels)
        });
        Self::of(rows)
    }

    /// The ranges, ascending.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.0
    }

    /// Number of blocks.
    pub fn len(&self) -> u64 {
        self.0.iter().map(|range| range.end - range.start).sum()
    }

    /// Whether it has no block.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The blocks of either.
    pub fn union(&self, other: &Self) -> Self {
        Self::of(self.0.iter().chain(&other.0).cloned())
    }

    /// The blocks that `other` does not have.
    pub fn without(&self, other: &Self) -> Self {
        let mut left = Vec::new();
        let mut others = other.0.iter().peekable();
        for range in &self.0 {
            let mut start = range.start;
            while let Some(cut) = others.peek() {
                if cut.start >= range.end {
                    break;
                }
                left.push(start..cut.start.max(start));
                start = start.max(cut.end);
                if cut.end > range.end {
                    break;
                }
                others.next();
            }
            left.push(start.min(range.end)..range.end);
        }
        Self::of(left)
    }

    /// The blocks of both.
    pub fn intersection(&self, other: &Self) -> Self {
        self.without(&self.without(other))
    }

    /// Whether it has every block of `other`.
    pub fn contains(&self, other: &Self) -> bool {
        other.without(self).is_empty()
    }

    /// The blocks of a shard: those of all shards of a number are disjoint, and as many as each other up to one.
    pub fn part(&self, shard: Shard) -> Self {
        let total = u128::from(self.len());
        // Below `total`, which has 64 bits.
        let cut = |k: u32| (total * u128::from(k) / u128::from(shard.of())) as u64;
        let wanted = cut(shard.number() - 1)..cut(shard.number());
        let mut before = 0;
        Self::of(self.0.iter().map(|range| {
            let length = range.end - range.start;
            let from = wanted.start.saturating_sub(before).min(length);
            let to = wanted.end.saturating_sub(before).min(length);
            before += length;
            range.start + from..range.start + to
        }))
    }

    /// Paths that it takes to trace it where each of `pixels` pixels has `spp` samples: the last block may have fewer.
    pub fn paths(&self, pixels: u64, spp: u32) -> u64 {
        let full = Self::of(std::iter::once(
            0..u64::from(spp / BLOCK).saturating_mul(pixels),
        ));
        let whole = self.intersection(&full).len();
        let rest = Self::of_samples(0..spp, pixels).without(&full);
        let last = self.intersection(&rest).len();
        whole * u64::from(BLOCK) + last * u64::from(spp % BLOCK)
    }

    /// The samples that every pixel has, as ranges of their indices below `spp`.
    pub fn sample_ranges(&self, pixels: u64, spp: u32) -> Vec<Range<u32>> {
        let sample = |pass: u64| {
            let sample = pass.saturating_mul(u64::from(BLOCK));
            u32::try_from(sample).map_or(spp, |sample| sample.min(spp))
        };
        self.0
            .iter()
            .map(|range| sample(range.start.div_ceil(pixels))..sample(range.end / pixels))
            .filter(|samples| !samples.is_empty())
            .collect()
    }

    /// The least and the greatest number of samples of any pixel, of `spp`.
    pub fn samples(&self, pixels: u64, spp: u32) -> (u32, u32) {
        let last = u64::from(spp / BLOCK);
        // A pixel's samples change along the image where a range begins or ends.
        let mut steps: BTreeMap<u64, i64> = BTreeMap::new();
        let mut add = |pixel: Range<u64>, pass: u64| {
            let samples = match pass {
                pass if pass < last => i64::from(BLOCK),
                pass if pass == last => i64::from(spp % BLOCK),
                _ => 0,
            };
            *steps.entry(pixel.start).or_default() += samples;
            *steps.entry(pixel.end).or_default() -= samples;
        };
        let mut everywhere = 0;
        for range in &self.0 {
            let (first, end) = (range.start / pixels, range.end / pixels);
            let (from, to) = (range.start % pixels, range.end % pixels);
            if first == end {
                add(from..to, first);
                continue;
            }
            add(from..pixels, first);
            add(0..to, end);
            let whole = |pass: u64| pass.saturating_mul(u64::from(BLOCK)).min(u64::from(spp));
            everywhere += whole(end) - whole(first + 1);
        }
        steps.entry(0).or_default();
        let mut here = i64::try_from(everywhere).unwrap_or(i64::MAX);
        let mut range = (i64::MAX, i64::MIN);
        for (&pixel, step) in &steps {
            here += step;
            if pixel < pixels {
                range = (range.0.min(here), range.1.max(here));
            }
        }
        let samples = |count: i64| u32::try_from(count).unwrap_or(spp).min(spp);
        (samples(range.0), samples(range.1))
    }

    /// The rectangles of the region that it is made of, in the order of their blocks: at most seven for each range.
    pub fn rectangles(&self, region: Region) -> Vec<Passes> {
        let pixels = region.pixels() as u64;
        let mut all = Vec::new();
        for range in &self.0 {
            let (first, end) = (range.start / pixels, range.end / pixels);
            let (from, to) = (range.start % pixels, range.end % pixels);
            if first == end {
                all.extend(runs(region, from..to, first));
                continue;
            }
            let whole = first + u64::from(from > 0);
            if from > 0 {
                all.extend(runs(region, from..pixels, first));
            }
            if whole < end {
                all.push(Passes {
                    tile: region,
                    passes: whole..end,
                });
            }
            all.extend(runs(region, 0..to, end));
        }
        all
    }

    /// The smallest region that holds every pixel of which it has a block; none where it has none.
    pub fn bounds(&self, region: Region) -> Option<Region> {
        self.rectangles(region)
            .into_iter()
            .map(|part| part.tile)
            .reduce(Region::bounding)
    }
}

/// Consecutive pixels of a region, by number, in one pass: the rest of a row, whole rows and the beginning of a row.
fn runs(region: Region, pixels: Range<u64>, pass: u64) -> impl Iterator<Item = Passes> {
    let width = u64::from(region.width());
    let (first, end) = (pixels.start / width, pixels.end / width);
    let (from, to) = (pixels.start % width, pixels.end % width);
    let rows = match first == end {
        true => [(from..to, first..first + 1), (0..0, 0..0), (0..0, 0..0)],
        false => {
            let whole = first + u64::from(from > 0);
            let rest = if from > 0 { from..width } else { 0..0 };
            [
                (rest, first..first + 1),
                (0..width, whole..end),
                (0..to, end..end + 1),
            ]
        }
    };
    // Numbers of pixels in a region, so of columns and rows, have 32 bits.
    let tile = move |(columns, rows): (Range<u64>, Range<u64>)| Region {
        x0: region.x0 + columns.start as u32,
        x1: region.x0 + columns.end as u32,
        y0: region.y0 + rows.start as u32,
        y1: region.y0 + rows.end as u32,
    };
    rows.into_iter()
        .map(tile)
        .filter(|tile| !tile.is_empty())
        .map(move |tile| Passes {
            tile,
            passes: pass..pass + 1,
        })
}

impl std::fmt::Display for Coverage {
    /// `0..7,9..12`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, range) in self.0.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{}..{}", range.start, range.end)?;
        }
        Ok(())
    }
}

impl std::str::FromStr for Coverage {
    type Err = ();

    /// From what [`Display`](std::fmt::Display) writes; refused where ranges are empty, meet, or are not ascending.
    fn from_str(text: &str) -> Result<Self, ()> {
        let ranges: Vec<Range<u64>> = text
            .split(',')
            .filter(|part| !part.is_empty())
            .map(|part| {
                let (start, end) = part.split_once("..").ok_or(())?;
                Ok(start.parse().map_err(drop)?..end.parse().map_err(drop)?)
            })
            .collect::<Result<_, ()>>()?;
        let coverage = Self::of(ranges.iter().cloned());
        match coverage.0 == ranges {
            true => Ok(coverage),
            false => Err(()),
        }
    }
}

impl serde::Serialize for Coverage {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
