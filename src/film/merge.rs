//! Adding films up: exact, so that the order does not matter.

use super::{AovSet, Band, Film, MAX_SAMPLES};
use crate::error::{Error, Result};
use std::ops::AddAssign;
use std::sync::atomic::Ordering;

impl Film {
    /// Adds what another film of the same image holds. Exact: in whatever order films are merged, the bits are the same.
    ///
    /// Where the regions differ, this film grows to the smallest region that holds both; pixels that neither holds have
    /// no samples. [`Error::Usage`], and nothing is added, where the images differ in size or AOVs, or a pixel would
    /// hold more than [`MAX_SAMPLES`].
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(Error::Usage(format!(
                "cannot merge an image of {}x{} pixels into one of {}x{}",
                other.width, other.height, self.width, self.height
            )));
        }
        if self.aovs != other.aovs {
            let [one, two] = [self.aovs, other.aovs].map(|aovs| match aovs.lengths {
                0 => format!("\"{aovs}\""),
                lengths => format!("\"{aovs}\" of {lengths} path lengths"),
            });
            return Err(Error::Usage(format!(
                "cannot merge images with different AOVs: one has {one}, the other {two}"
            )));
        }
        let shared = |x, y| self.region.has(x, y) && other.region.has(x, y);
        if let Some((x, y)) = other
            .region
            .coordinates()
            .find(|&(x, y)| shared(x, y) && self.count(x, y) + other.count(x, y) > MAX_SAMPLES)
        {
            return Err(too_many(x, y));
        }
        if !self.region.contains(other.region) {
            let region = self.region.bounding(other.region);
            let mut grown = Self::new(self.width, self.height, region, self.aovs)?;
            grown.add_film(self);
            *self = grown;
        }
        self.add_film(other);
        Ok(())
    }

    /// `other` lies within, and all counts were checked.
    fn add_film(&mut self, other: &Self) {
        let width = other.region.width() as usize;
        for y in other.region.y0..other.region.y1 {
            let (from, i) = other.band(y);
            let (mut to, first) = self.band(y);
            let j = first + (other.region.x0 - self.region.x0) as usize;
            to.add(j, &from, i, width, self.aovs);
        }
        self.add_rejected(other.rejected());
    }

    /// Adds a row of pixels from column `x` on, absolute as `y`; it lies within, has the film's AOVs, and its numbers are
    /// [possible](super::planes::is_possible). [`Error::Usage`] where a pixel would hold more than [`MAX_SAMPLES`].
    pub(super) fn add_row(&self, x: u32, y: u32, row: &Band) -> Result<()> {
        let (mut band, first) = self.band(y);
        let width = row.counts.len();
        let j = first + (x - self.region.x0) as usize;
        let mut counts = band.counts[j..j + width].iter().zip(&row.counts);
        if let Some(i) = counts.position(|(a, b)| a + b > MAX_SAMPLES) {
            return Err(too_many(x + i as u32, y));
        }
        band.add(j, row, 0, width, self.aovs);
        Ok(())
    }

    /// Counts samples that were kept out elsewhere.
    pub(super) fn add_rejected(&self, rejected: u64) {
        let add = |before: u64| Some(before.saturating_add(rejected));
        // Never refused.
        let _ = self
            .rejected
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
    }
}

fn too_many(x: u32, y: u32) -> Error {
    Error::Usage(format!(
        "cannot merge: pixel {x},{y} would hold more than {MAX_SAMPLES} samples"
    ))
}

impl Band {
    /// Adds `width` pixels of another band, from its pixel `i` on, to those from `j` on.
    fn add(&mut self, j: usize, other: &Self, i: usize, width: usize, aovs: AovSet) {
        fn add<T: Copy + AddAssign>(to: &mut [T], from: &[T]) {
            to.iter_mut().zip(from).for_each(|(a, &b)| *a += b);
        }
        let (stride, lengths) = (aovs.components(), aovs.lengths as usize);
        let end = j + width;
        add(&mut self.counts[j..end], &other.counts[i..]);
        add(&mut self.sums[j..end], &other.sums[i..]);
        add(
            &mut self.aovs[j * stride..end * stride],
            &other.aovs[i * stride..],
        );
        add(
            &mut self.lengths[j * lengths..end * lengths],
            &other.lengths[i * lengths..],
        );
    }
}
