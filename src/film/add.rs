//! Adding the samples of a wave: the one part of the film that runs for every sample of an image.

use super::exact::{LIMIT_BITS, MAX_SAMPLES, Square, Sum, accepts};
use super::{AovSample, BAND_ROWS, BLOCK, Band, Film, Region};
use std::sync::atomic::Ordering;
use wide::f64x4;

/// What a block of samples of one pixel adds up to, in `f64`.
struct BlockSum {
    kept: u32,
    sum: f64x4,
    square: f64x4,
}

impl Film {
    /// Adds one sample block to every pixel of a tile.
    ///
    /// `tile` is in absolute coordinates and within the region. `radiance` holds `samples` (1 to [`BLOCK`]) consecutive
    /// samples for each pixel of the tile, row after row: slot = pixel in tile · samples + sample. RGB, the fourth
    /// number is not looked at. `aovs` has the same slots and must be there where the film holds AOVs.
    ///
    /// A sample with a channel that is not finite, or 2³² and more, is kept out (its AOVs too) and counted in
    /// [`Film::rejected`]. For equal bits, every pixel's samples must be cut into the same blocks in every run.
    ///
    /// # Panics
    /// Where the shapes do not fit, or a pixel would exceed [`MAX_SAMPLES`]: a fault of the caller, who checks settings.
    pub fn add(
        &self,
        tile: Region,
        samples: u32,
        radiance: &[[f32; 4]],
        aovs: Option<&[AovSample]>,
    ) {
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
        let aovs = if self.aovs.is_empty() { None } else { aovs };
        assert!(
            aovs.map_or(self.aovs.is_empty(), |a| a.len() == radiance.len()),
            "one AOV per sample where the film holds AOVs"
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
                rejected += band.add_row(pixel, block, &radiance[slots.clone()]);
                if let Some(aovs) = aovs {
                    self.add_aov_row(
                        &mut band,
                        pixel,
                        block,
                        &radiance[slots.clone()],
                        &aovs[slots],
                    );
                }
            }
            y = end;
        }
        if rejected > 0 {
            self.rejected.fetch_add(rejected, Ordering::Relaxed);
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
            let (sum, square) = (added.sum.to_array(), added.square.to_array());
            for c in 0..3 {
                sums.sum[c] += Sum::from_f64(sum[c]);
                sums.square[c] += Square::from_f64(square[c]);
            }
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
}

#[inline(always)]
fn widen([r, g, b, padding]: [f32; 4]) -> f64x4 {
    f64x4::new([r.into(), g.into(), b.into(), padding.into()])
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
