//! Floor 2: exact pixels, and the files they become.
//!
//! A [`Film`] adds samples so that the sums do not depend on the order of adding: the samples of a block are summed in
//! their order in `f64`, and block sums enter wide fixed-point integers ([`exact`]). A merge of shards, in any order, is
//! therefore bit for bit the single run. Squares are summed beside the values, for the variance of each pixel.

mod add;
pub mod exact;
pub mod exr;
pub mod png;
pub mod tonemap;

mod aov;
mod coverage;
mod describe;
mod hash;
mod merge;
mod metadata;
mod planes;
mod raster;
mod region;
mod shard;
mod whole_file;

pub use add::{BlockSum, Layers, block_sum};
pub use aov::{AovSample, AovSet};
pub use coverage::{Coverage, Passes};
pub use describe::{Channel, ExrDescription, Part, describe};
pub use exact::MAX_SAMPLES;
pub use metadata::Metadata;
pub use raster::Raster;
pub use region::{Region, parse_size};
pub use shard::Shard;
pub use whole_file::{remove_leftovers, write_whole};

use crate::error::{Error, Result};
use exact::{Square, Sum};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The most samples of a pixel that [`Film::add`] takes at once: one sample block. Block sums are what is rounded, so
/// the bits of an image depend on where blocks begin: at multiples of this.
pub const BLOCK: u32 = 16;

/// Rows behind one lock: few enough that workers on different tiles seldom meet.
const BAND_ROWS: u32 = 8;

/// Exact sums of a pixel's radiance, W·sr⁻¹·m⁻², linear RGB.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct PixelSums {
    /// Of each channel.
    pub sum: [Sum; 3],
    /// Of each channel's square.
    pub square: [Square; 3],
}

impl std::ops::AddAssign for PixelSums {
    fn add_assign(&mut self, other: Self) {
        for c in 0..3 {
            self.sum[c] += other.sum[c];
            self.square[c] += other.square[c];
        }
    }
}

impl PixelSums {
    /// Mean of `count` samples; 0 without samples.
    pub fn mean(&self, count: u32) -> [f32; 3] {
        std::array::from_fn(|c| self.mean_of(c, count))
    }

    /// Variance of the mean of `count` samples: the unbiased sample variance over their number. 0 with fewer than two.
    pub fn variance(&self, count: u32) -> [f32; 3] {
        std::array::from_fn(|c| self.variance_of(c, count))
    }

    /// [`mean`](Self::mean) of one channel.
    fn mean_of(&self, channel: usize, count: u32) -> f32 {
        exact::mean(self.sum[channel], count) as f32
    }

    /// [`variance`](Self::variance) of one channel.
    fn variance_of(&self, channel: usize, count: u32) -> f32 {
        exact::variance_of_mean(self.sum[channel], self.square[channel], count) as f32
    }
}

/// How much noise an image has, as its own samples tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Mean radiance.
    pub mean: f64,
    /// Root mean square of the pixels' standard errors, in the unit of radiance; 0 with fewer than two samples.
    pub error: f64,
}

/// Some rows of the film.
#[derive(Clone, Default)]
struct Band {
    counts: Vec<u32>,
    sums: Vec<PixelSums>,
    /// [`AovSet::components`] for each pixel.
    aovs: Vec<Sum>,
    /// [`AovSet::lengths`] for each pixel.
    lengths: Vec<PixelSums>,
}

/// An image as exact sums. Workers add to it through `&self`.
pub struct Film {
    width: u32,
    height: u32,
    region: Region,
    aovs: AovSet,
    bands: Vec<Mutex<Band>>,
    rejected: AtomicU64,
}

impl Film {
    /// A film without samples: an image of `width` × `height` pixels of which only `region` is stored.
    ///
    /// [`Error::Usage`] where the region is empty or reaches outside the image, a side exceeds 2³⁰ pixels, or more than
    /// [`AovSet::MAX_LENGTHS`] path lengths are to be kept apart.
    pub fn new(width: u32, height: u32, region: Region, aovs: AovSet) -> Result<Self> {
        if width.max(height) > 1 << 30 {
            return Err(Error::Usage(format!(
                "an image of {width}x{height} pixels is too large; a side can have 2^30"
            )));
        }
        if region.is_empty() || !Region::full(width, height).contains(region) {
            return Err(Error::Usage(format!(
                "the region {region} (x0,y0,x1,y1) holds no pixel of an image of {width}x{height}, or reaches outside; \
                 choose 0 <= x0 < x1 <= {width} and 0 <= y0 < y1 <= {height}"
            )));
        }
        aovs.check()?;
        let bands = (region.y0..region.y1)
            .step_by(BAND_ROWS as usize)
            .map(|y| {
                let rows = BAND_ROWS.min(region.y1 - y) as usize;
                let pixels = rows * region.width() as usize;
                Mutex::new(Band::new(pixels, aovs))
            })
            .collect();
        Ok(Self {
            width,
            height,
            region,
            aovs,
            bands,
            rejected: AtomicU64::new(0),
        })
    }

    /// Columns of the full image.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of the full image.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pixels that are stored.
    pub fn region(&self) -> Region {
        self.region
    }

    /// The AOVs that are stored.
    pub fn aovs(&self) -> AovSet {
        self.aovs
    }

    /// Memory that the sums take.
    pub fn bytes(&self) -> u64 {
        let sums = |number: usize| number * size_of::<Sum>();
        let pixel = size_of::<u32>()
            + size_of::<PixelSums>() * (1 + self.aovs.lengths as usize)
            + sums(self.aovs.components());
        self.region.pixels() as u64 * pixel as u64
    }

    /// Samples kept out because a channel was not finite, or 2³² and more.
    pub fn rejected(&self) -> u64 {
        self.rejected.load(Ordering::Relaxed)
    }

    /// The band of a row, and the index in it of the row's first pixel.
    fn band(&self, y: u32) -> (MutexGuard<'_, Band>, usize) {
        let row = y - self.region.y0;
        let first = (row % BAND_ROWS) as usize * self.region.width() as usize;
        // `add` panics only between two pixels, so a band is whole even then.
        let band = self.bands[(row / BAND_ROWS) as usize]
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        (band, first)
    }

    /// Panics outside the region.
    fn with_pixel<T>(&self, x: u32, y: u32, read: impl FnOnce(&Band, usize) -> T) -> T {
        assert!(
            self.region.has(x, y),
            "pixel {x},{y} lies outside the region {}",
            self.region
        );
        let (band, first) = self.band(y);
        read(&band, first + (x - self.region.x0) as usize)
    }

    /// Samples that a pixel holds. Absolute coordinates; panics outside the region, as all accessors do.
    pub fn count(&self, x: u32, y: u32) -> u32 {
        self.with_pixel(x, y, |band, i| band.counts[i])
    }

    /// The exact sums of a pixel.
    pub fn sums(&self, x: u32, y: u32) -> PixelSums {
        self.with_pixel(x, y, |band, i| band.sums[i])
    }

    /// Mean radiance of a pixel, linear RGB; 0 without samples.
    pub fn mean(&self, x: u32, y: u32) -> [f32; 3] {
        self.with_pixel(x, y, Band::mean)
    }

    /// Variance of the mean of a pixel, each channel: the unbiased sample variance over the number of samples.
    /// 0 with fewer than two samples.
    pub fn variance(&self, x: u32, y: u32) -> [f32; 3] {
        self.with_pixel(x, y, Band::variance)
    }

    /// Mean AOVs of a pixel; 0 where the film does not hold them, or has no samples.
    pub fn aov(&self, x: u32, y: u32) -> AovSample {
        let stride = self.aovs.components();
        self.with_pixel(x, y, |band, i| {
            let mut all = [0.0; 7];
            for (k, component) in self.aovs.present().enumerate() {
                all[component.index] =
                    exact::mean(band.aovs[i * stride + k], band.counts[i]) as f32;
            }
            let [r, g, b, nx, ny, nz, depth] = all;
            AovSample {
                albedo: [r, g, b],
                normal: [nx, ny, nz],
                depth,
            }
        })
    }

    /// The exact sums of the radiance that reaches a pixel on paths of `length` edges, 1 to [`AovSet::lengths`]; panics
    /// at other lengths.
    pub fn sums_of_length(&self, length: u32, x: u32, y: u32) -> PixelSums {
        let stride = self.aovs.lengths as usize;
        assert!(
            (1..=self.aovs.lengths).contains(&length),
            "path length {length} of {stride}"
        );
        self.with_pixel(x, y, |band, i| {
            band.lengths[i * stride + length as usize - 1]
        })
    }

    /// Mean radiance of every pixel of the region, row after row.
    pub fn means(&self) -> Vec<[f32; 3]> {
        self.collect(Band::mean)
    }

    /// Variance of the mean of every pixel of the region, row after row.
    pub fn variances(&self) -> Vec<[f32; 3]> {
        self.collect(Band::variance)
    }

    /// Samples of every pixel of the region, row after row.
    pub fn counts(&self) -> Vec<u32> {
        self.collect(|band, i| band.counts[i])
    }

    /// How much noise is left, over all pixels and channels of the region; on the threads of the current rayon pool.
    pub fn noise(&self) -> Noise {
        let of_band = |band: &Mutex<Band>| {
            let band = band.lock().unwrap_or_else(PoisonError::into_inner);
            let mut sums = [0.0; 2];
            for i in 0..band.counts.len() {
                let (mean, variance) = (band.mean(i), band.variance(i));
                for c in 0..3 {
                    sums[0] += f64::from(mean[c]);
                    sums[1] += f64::from(variance[c]);
                }
            }
            sums
        };
        let of_bands: Vec<[f64; 2]> = self.bands.par_iter().map(of_band).collect();
        let values = (self.region.pixels() * 3) as f64;
        let mean = |k: usize| of_bands.iter().map(|sums| sums[k]).sum::<f64>() / values;
        Noise {
            mean: mean(0),
            error: mean(1).sqrt(),
        }
    }

    fn collect<T>(&self, read: impl Fn(&Band, usize) -> T) -> Vec<T> {
        let mut all = Vec::with_capacity(self.region.pixels());
        for y in self.region.y0..self.region.y1 {
            let (band, first) = self.band(y);
            all.extend((first..first + self.region.width() as usize).map(|i| read(&band, i)));
        }
        all
    }

    /// Samples of all pixels together.
    pub fn total_samples(&self) -> u64 {
        self.collect(|band, i| u64::from(band.counts[i]))
            .iter()
            .sum()
    }
}

/// The digits of a hash.
pub(crate) fn hexadecimal(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Band {
    /// Pixels without samples.
    fn new(pixels: usize, aovs: AovSet) -> Self {
        Self {
            counts: vec![0; pixels],
            sums: vec![PixelSums::default(); pixels],
            aovs: vec![Sum::default(); pixels * aovs.components()],
            lengths: vec![PixelSums::default(); pixels * aovs.lengths as usize],
        }
    }

    fn mean(&self, i: usize) -> [f32; 3] {
        self.sums[i].mean(self.counts[i])
    }

    fn variance(&self, i: usize) -> [f32; 3] {
        self.sums[i].variance(self.counts[i])
    }
}

impl std::fmt::Debug for Film {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Film")
            .field("width", &self.width)
            .field("height", &self.height)
            .field("region", &self.region)
            .field("aovs", &self.aovs)
            .field("rejected", &self.rejected())
            .finish_non_exhaustive()
    }
}
