//! What says that two images are the same to the bit.

use super::{Film, Region, hexadecimal};
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
        let mut hasher = Sha256::new();
        let mut row = vec![0; region.width() as usize * PIXEL];
        for y in region.y0..region.y1 {
            let (band, first) = self.band(y);
            let first = first + (region.x0 - self.region.x0) as usize;
            let pixels = band.counts[first..].iter().zip(&band.sums[first..]);
            let bytes = row.as_chunks_mut::<PIXEL>().0;
            for ((bytes, x), (count, sums)) in bytes.iter_mut().zip(region.x0..).zip(pixels) {
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
            drop(band);
            hasher.update(&row);
        }
        hexadecimal(&hasher.finalize())
    }
}
