//! What says that two images are the same to the bit.

use super::{Film, PixelSums, Region, hexadecimal};
use crate::error::{Error, Result};
use sha2::{Digest, Sha256};

/// Bytes of a pixel: its place, its sample count and six sums.
const PIXEL: usize = 3 * 4 + 6 * 16;

impl Film {
    /// SHA-256, in hexadecimal, of the exact pixels: for each of the region, row after row, its coordinates in the full
    /// image, its sample count (each `u32`), three sums and three sums of squares (each `i128`), all little-endian.
    pub fn image_hash(&self) -> String {
        self.hash(self.region)
    }

    /// The [`image_hash`](Self::image_hash) of a film that stores only `region` of this one.
    /// [`Error::Usage`] where the film does not hold it.
    pub fn image_hash_of(&self, region: Region) -> Result<String> {
        if region.is_empty() || !self.region.contains(region) {
            return Err(Error::Usage(format!(
                "the region {region} is not within the image's {}",
                self.region
            )));
        }
        Ok(self.hash(region))
    }

    fn hash(&self, region: Region) -> String {
        let mut hash = ImageHash::default();
        for y in region.y0..region.y1 {
            let (band, first) = self.band(y);
            let first = first + (region.x0 - self.region.x0) as usize;
            let pixels = first..first + region.width() as usize;
            let (counts, sums) = (&band.counts[pixels.clone()], &band.sums[pixels]);
            hash.row(region.x0, y, counts, sums);
        }
        hash.finish()
    }
}

/// An [`image_hash`](Film::image_hash) in the making.
#[derive(Default)]
pub(super) struct ImageHash {
    sha: Sha256,
    row: Vec<u8>,
}

impl ImageHash {
    /// Adds the next row, of pixels from column `x` of the full image on.
    pub fn row(&mut self, x: u32, y: u32, counts: &[u32], sums: &[PixelSums]) {
        self.row.resize(counts.len() * PIXEL, 0);
        let bytes = self.row.as_chunks_mut::<PIXEL>().0;
        for (((bytes, x), count), sums) in bytes.iter_mut().zip(x..).zip(counts).zip(sums) {
            let (place, exact) = bytes.split_at_mut(3 * 4);
            for (bytes, word) in place.as_chunks_mut().0.iter_mut().zip([x, y, *count]) {
                *bytes = word.to_le_bytes();
            }
            let [r, g, b] = sums.sum.map(|sum| sum.0);
            let squares = sums.square.map(|square| square.0);
            let words = [r, g, b, squares[0], squares[1], squares[2]];
            for (bytes, word) in exact.as_chunks_mut().0.iter_mut().zip(words) {
                *bytes = word.to_le_bytes();
            }
        }
        self.sha.update(&self.row);
    }

    /// In hexadecimal.
    pub fn finish(self) -> String {
        hexadecimal(&self.sha.finalize())
    }
}
