//! Adding the samples of a wave: the one part of the film that runs for every sample of an image.

use super::exact::{LIMIT_BITS, MAX_SAMPLES, Square, Sum, accepts};
use super::{AovSample, BAND_ROWS, BLOCK, Band, Film, PixelSums, Region};
use std::sync::atomic::Ordering;
use wide::f64x4;

/// What samples are beside their radiance, each in the slots of [`Film::add`]; empty where the film does not hold it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Layers<'a> {
    /// What their first rays met.
    pub first_hits: &'a [AovSample],
    /// Their radiance on paths of 1 edge, of 2 and so on, in the form of all radiance; slots past the last are not looked at.
    /// What is not finite, or 2³² and more, counts as 0.
    pub by_length: &'a [Vec<[f32; 4]>],
}

/// What a block of samples of one pixel adds up to, in `f64`.
#[derive(Clone, Copy, Debug)]
pub struct BlockSum {
    /// Samples that are in it.
    pub kept: u32,
    /// RGB; the fourth number means nothing.
    pub sum: f64x4,
    /// RGB likewise, of squares.
    pub square: f64x4,
}

impl Film {
    /// Adds one sample block to every pixel of a tile.
    ///
    /// `tile` is in absolute coordinates and within the region. `radiance` holds `samples` (1 to [`BLOCK`]) consecutive
    /// samples for each pixel of the tile, row after row: slot = pixel in tile · samples + sample. RGB, the fourth
    /// number is not looked at. `layers` have the same slots and must be there where the film holds them.
    ///
    /// A sample with a channel that is not finite, or 2³² and more, is kept out (its layers too) and counted in
    /// [`Film::rejected`]. For equal bits, every pixel's samples must be cut into the same blocks in every run.
    ///
    /// # Panics
    /// Where the shapes do not fit, or a pixel would exceed [`MAX_SAMPLES`]: a fault of the caller, who checks settings.
    pub fn add(&self, tile: Region, samples: u32, radiance: &[[f32; 4]], layers: Layers) {
        let block = samples as usize;
        assert!(
            (1..=BLOCK).contains(&samples),
            "{samples} samples in a block"
        );
        assert!(
            self.region.contains(tile),
            "the tile {tile} reaches outside the region {}",
            self.region
        );
        assert_eq!(radiance.len(), tile.pixels() * block, "one slot per sample");
        let first_hits = self.aovs.has_first_hits().then_some(layers.first_hits);
        let by_length = layers.by_length.get(..self.aovs.lengths as usize);
        let by_length = by_length.expect("a layer for each path length that the film holds");
        let fits = |slots: usize| slots == radiance.len();
        assert!(
            first_hits.is_none_or(|hits| fits(hits.len()))
                && by_length
                    .iter()
                    .all(|length| length.len() >= radiance.len()),
            "one slot per sample in each layer that the film holds"
        );

        let width = tile.width() as usize;
        let mut rejected = 0;
        let mut y = tile.y0;
        while y < tile.y1 {
            let (mut band, first) = self.band(y);
            let rows_left = BAND_ROWS - (y - self.region.y0) % BAND_ROWS;
            let end = tile.y1.min(y + rows_left);
            for row in 0..(end - y) as usize {
                let slot = ((y - tile.y0) as usize + row) * width * block;
                let slots = slot..slot + width * block;
                let pixel = first
                    + row * self.region.width() as usize
                    + (tile.x0 - self.region.x0) as usize;
                let samples = &radiance[slots.clone()];
                rejected += band.add_row(pixel, block, samples);
                for (length, of_length) in by_length.iter().enumerate() {
                    let of_length = &of_length[slots.clone()];
                    self.add_length_row(&mut band, (pixel, length), block, samples, of_length);
                }
                if let Some(first_hits) = first_hits {
                    self.add_aov_row(&mut band, pixel, block, samples, &first_hits[slots]);
                }
            }
            y = end;
        }
        if rejected > 0 {
            self.rejected.fetch_add(rejected, Ordering::Relaxed);
        }
    }

    fn add_length_row(
        &self,
        band: &mut Band,
        (first, length): (usize, usize),
        block: usize,
        radiance: &[[f32; 4]],
        of_length: &[[f32; 4]],
    ) {
        let stride = self.aovs.lengths as usize;
        let pixels = band.lengths[first * stride..].chunks_exact_mut(stride);
        let blocks = radiance
            .chunks_exact(block)
            .zip(of_length.chunks_exact(block));
        for (pixel, (radiance, of_length)) in pixels.zip(blocks) {
            let mut total = BlockSum::EMPTY;
            for (radiance, sample) in radiance.iter().zip(of_length) {
                if accepts_all(radiance) && accepts_all(sample) {
                    total.add(widen(*sample));
                }
            }
            pixel[length] += total.exact();
        }
    }

    fn add_aov_row(
        &self,
        band: &mut Band,
        first: usize,
        block: usize,
        radiance: &[[f32; 4]],
        aovs: &[AovSample],
    ) {
        let stride = self.aovs.components();
        let pixels = band.aovs[first * stride..].chunks_exact_mut(stride);
        let blocks = radiance.chunks_exact(block).zip(aovs.chunks_exact(block));
        for (pixel, (radiance, aovs)) in pixels.zip(blocks) {
            let mut sum = [0.0; 7];
            for (radiance, aov) in radiance.iter().zip(aovs) {
                if accepts_all(radiance) {
                    for (s, v) in sum.iter_mut().zip(aov.to_array()) {
                        *s += if accepts(v) { f64::from(v) } else { 0.0 };
                    }
                }
            }
            for (total, component) in pixel.iter_mut().zip(self.aovs.present()) {
                *total += Sum::from_f64(sum[component.index]);
            }
        }
    }
}

impl Band {
    /// Adds a row of blocks from pixel `first` on; the number of samples kept out.
    #[inline(always)]
    fn add_row(&mut self, first: usize, block: usize, radiance: &[[f32; 4]]) -> u64 {
        let mut rejected = 0;
        let blocks = radiance.chunks_exact(block);
        let pixels = first..first + blocks.len();
        let pixels = self.counts[pixels.clone()]
            .iter_mut()
            .zip(&mut self.sums[pixels]);
        for ((count, sums), samples) in pixels.zip(blocks) {
            let added = sum_block(samples);
            rejected += (block as u32 - added.kept) as u64;
            let full = *count + added.kept > MAX_SAMPLES;
            assert!(!full, "more than {MAX_SAMPLES} samples in a pixel");
            *count += added.kept;
            *sums += added.exact();
        }
        rejected
    }
}

fn accepts_all(radiance: &[f32; 4]) -> bool {
    radiance[..3].iter().all(|&x| accepts(x))
}

impl BlockSum {
    const EMPTY: Self = Self {
        kept: 0,
        sum: f64x4::ZERO,
        square: f64x4::ZERO,
    };

    /// Squares of `f32` are exact in `f64`, so fusing them into the sum changes no bit.
    #[inline(always)]
    fn add(&mut self, sample: f64x4) {
        self.kept += 1;
        self.sum += sample;
        self.square = sample.mul_add(sample, self.square);
    }

    #[inline(always)]
    fn exact(&self) -> PixelSums {
        let (sum, square) = (self.sum.to_array(), self.square.to_array());
        PixelSums {
            sum: std::array::from_fn(|c| Sum::from_f64(sum[c])),
            square: std::array::from_fn(|c| Square::from_f64(square[c])),
        }
    }
}

#[inline(always)]
fn widen([r, g, b, padding]: [f32; 4]) -> f64x4 {
    f64x4::new([r.into(), g.into(), b.into(), padding.into()])
}

/// Sums the samples of a pixel, at most [`BLOCK`], in their order, less those that are kept out. The fourth number of each is
/// not looked at.
pub fn block_sum(samples: &[[f32; 4]]) -> BlockSum {
    sum_block(samples)
}

/// Sums in the order of the samples; as if none were to be kept out, as almost always, and again if one was.
#[inline(always)]
fn sum_block(samples: &[[f32; 4]]) -> BlockSum {
    let limit = f64x4::splat(f64::from(f32::from_bits(LIMIT_BITS)));
    let mut total = BlockSum::EMPTY;
    // A comparison with NaN is false.
    let mut accepted = f64x4::splat(f64::from_bits(u64::MAX));
    for &sample in samples {
        let sample = widen(sample);
        total.add(sample);
        accepted &= sample.abs().simd_lt(limit);
    }
    if accepted.to_bitmask() & 0b111 != 0b111 {
        return sum_accepted(samples);
    }
    total
}

#[cold]
fn sum_accepted(samples: &[[f32; 4]]) -> BlockSum {
    let mut total = BlockSum::EMPTY;
    for sample in samples.iter().filter(|sample| accepts_all(sample)) {
        total.add(widen(*sample));
    }
    total
}
