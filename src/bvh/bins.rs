//! Where to split a run of items: the surface area heuristic on binned centres (Wald 2007, "On fast Construction of
//! SAH-based Bounding Volume Hierarchies", section 3).

use super::item::{CHUNK, Extent, Hull, Item, PARALLEL};
use crate::lanes::{f32x8, u32x8};
use rayon::prelude::*;

/// Runs longer than this are parted by several threads.
const PIECE: usize = 1 << 17;

/// Which bins a centre falls into.
#[derive(Clone, Copy)]
struct BinOf {
    origin: f32x8,
    scale: f32x8,
}

impl BinOf {
    fn new(centers: Hull, bins: usize) -> Self {
        let size = centers.size();
        // A hair less than the number of bins, so that the last centre is in the last one; 0 where there is no extent.
        let scale = f32x8::splat(bins as f32 * (1.0 - 1e-5)) / size;
        let some = size.simd_gt(f32x8::splat(f32::MIN_POSITIVE)) & scale.is_finite();
        Self {
            origin: centers.low(),
            scale: scale & some,
        }
    }

    /// Places among the bins, whole numbers from 0 on when cut off; in the lanes of the high corner.
    #[inline(always)]
    fn places(&self, center: Hull) -> f32x8 {
        (center.corners() - self.origin) * self.scale
    }
}

/// The cheapest split of items, where any parts them; few items need few bins.
pub(super) fn best_split(items: &[Item], extent: &Extent, leaf: usize) -> Option<Best> {
    match items.len() {
        ..=32 => Bins::<4>::fill(items, extent).best(leaf),
        33..=128 => Bins::<8>::fill(items, extent).best(leaf),
        _ => Bins::<16>::fill(items, extent).best(leaf),
    }
}

/// Boxes and numbers of items, by axis and bin.
struct Bins<const BINS: usize> {
    hulls: [[Hull; BINS]; 3],
    counts: [[u32; BINS]; 3],
    bin_of: BinOf,
}

/// Where to split: items whose bin on `axis` is below `bin` from the others.
pub(super) struct Best {
    pub axis: usize,
    bin: i32,
    /// Around the items of each part.
    pub low: Hull,
    pub high: Hull,
    bin_of: BinOf,
}

impl<const BINS: usize> Bins<BINS> {
    fn fill(items: &[Item], extent: &Extent) -> Self {
        let bin_of = BinOf::new(extent.centers, BINS);
        let empty = || Self {
            hulls: [[Hull::empty(); BINS]; 3],
            counts: [[0; BINS]; 3],
            bin_of,
        };
        // By turns from both halves: neighbours fall into the same bin, where each would wait for the one before.
        let one = |items: &[Item]| {
            let mut bins = empty();
            let (a, b) = items.split_at(items.len() / 2);
            for (a, b) in a.iter().zip(b) {
                bins.add(a);
                bins.add(b);
            }
            if a.len() < b.len() {
                bins.add(&b[a.len()]);
            }
            bins
        };
        if items.len() < PARALLEL {
            return one(items);
        }
        items.par_chunks(CHUNK).map(one).reduce(empty, Self::union)
    }

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        let places = self.bin_of.places(item.center());
        let places = places.fast_trunc_int().to_array();
        for axis in 0..3 {
            let bin = places[Hull::HIGH + axis] as usize & (BINS - 1);
            self.hulls[axis][bin].add(item.hull());
            self.counts[axis][bin] += 1;
        }
    }

    fn union(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.hulls[axis][bin] = self.hulls[axis][bin].union(other.hulls[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The cheapest split by the surface area heuristic, where any parts the items.
    fn best(&self, leaf: usize) -> Option<Best> {
        // A leaf is met as a whole: it costs the same however full it is.
        let cost = |hull: Hull, count: u32| hull.area() * count.div_ceil(leaf as u32) as f32;
        let mut cheapest = f32::INFINITY;
        let mut best = None;
        for axis in 0..3 {
            let (hulls, counts) = (&self.hulls[axis], &self.counts[axis]);
            let mut above = [(f32::INFINITY, Hull::empty()); BINS];
            let (mut hull, mut count) = (Hull::empty(), 0);
            for bin in (1..BINS).rev() {
                hull = hull.union(hulls[bin]);
                count += counts[bin];
                if count > 0 {
                    above[bin] = (cost(hull, count), hull);
                }
            }
            let (mut hull, mut count) = (Hull::empty(), 0);
            for bin in 1..BINS {
                hull = hull.union(hulls[bin - 1]);
                count += counts[bin - 1];
                let (above, high) = above[bin];
                let sum = cost(hull, count) + above;
                if count > 0 && sum < cheapest {
                    cheapest = sum;
                    best = Some(Best {
                        axis,
                        bin: bin as i32,
                        low: hull,
                        high,
                        bin_of: self.bin_of,
                    });
                }
            }
        }
        best
    }
}

/// Items that are `low` first; how many those are, and the boxes around both parts' centres. Pieces of a long run are parted
/// side by side, and then change places: how they lie does not depend on the number of threads.
pub(super) fn partition(items: &mut [Item], best: &Best) -> (usize, Hull, Hull) {
    if items.len() <= PIECE {
        return partition_run(items, best);
    }
    let (a, b) = items.split_at_mut(items.len() / 2);
    let (in_a, in_b) = rayon::join(|| partition(a, best), || partition(b, best));
    let (middle, low) = (in_a.0, in_b.0);
    let misplaced = low.min(a.len() - middle);
    a[middle..middle + misplaced].swap_with_slice(&mut b[low - misplaced..low]);
    (middle + low, in_a.1.union(in_b.1), in_a.2.union(in_b.2))
}

/// The same of a short run, by one thread.
///
/// Every item goes to both boxes' sums, masked, and is swapped whatever it is: which part it belongs to is anybody's guess,
/// and a branch on it would cost more.
fn partition_run(items: &mut [Item], best: &Best) -> (usize, Hull, Hull) {
    let lane = u32x8::splat((Hull::HIGH + best.axis) as u32);
    let bin = f32x8::splat(best.bin as f32);
    let (mut left, mut right) = (Hull::empty(), Hull::empty());
    let mut middle = 0;
    for place in 0..items.len() {
        let item = items[place];
        let center = item.center();
        let below = best.bin_of.places(center).simd_lt(bin);
        let below = below.shuffle_wrapping(lane);
        left.add(center.filtered(below));
        right.add(center.filtered(!below));
        items[place] = items[middle];
        items[middle] = item;
        middle += (below.to_bitmask() & 1) as usize;
    }
    (middle, left, right)
}
