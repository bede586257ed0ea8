//! What trees are built from.

use super::node::Bounds;
use glam::Vec3;
use rayon::prelude::*;
use wide::f32x4;

/// From so many items on, several threads work on one run.
pub(super) const PARALLEL: usize = 1 << 16;
/// Items that a thread takes at a time then.
pub(super) const CHUNK: usize = 1 << 14;
/// Something to be put into a tree: its box and its number.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Item {
    /// The low corner; in the last place the number's bits.
    pub low: f32x4,
    pub high: f32x4,
}

impl Item {
    pub fn new(bounds: Bounds, number: u32) -> Self {
        let (low, high) = (bounds.low, bounds.high);
        Self {
            low: f32x4::new([low.x, low.y, low.z, f32::from_bits(number)]),
            high: f32x4::new([high.x, high.y, high.z, 0.0]),
        }
    }

    pub fn number(&self) -> u32 {
        self.low.to_array()[3].to_bits()
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn center(&self) -> f32x4 {
        self.low + self.high
    }
}

/// A box that grows; the fourth place is unused.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull {
    pub low: f32x4,
    pub high: f32x4,
}

impl Hull {
    pub fn empty() -> Self {
        Self {
            low: f32x4::splat(f32::INFINITY),
            high: f32x4::splat(f32::NEG_INFINITY),
        }
    }

    #[inline(always)]
    pub fn add(&mut self, low: f32x4, high: f32x4) {
        self.low = self.low.fast_min(low);
        self.high = self.high.fast_max(high);
    }

    #[inline(always)]
    pub fn union(mut self, other: Self) -> Self {
        self.add(other.low, other.high);
        self
    }

    /// Half the surface; 0 of nothing.
    #[inline(always)]
    pub fn area(&self) -> f32 {
        let [x, y, z, _] = (self.high - self.low).fast_max(f32x4::ZERO).to_array();
        x * y + y * z + z * x
    }

    pub fn bounds(&self) -> Bounds {
        let corner = |v: f32x4| Vec3::from_slice(&v.to_array()[..3]);
        Bounds {
            low: corner(self.low),
            high: corner(self.high),
        }
    }
}

/// What is known of a run of items: the box around them and the box around their centres (doubled).
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub hull: Hull,
    pub centers: Hull,
}

impl Extent {
    pub fn empty() -> Self {
        Self {
            hull: Hull::empty(),
            centers: Hull::empty(),
        }
    }

    #[inline(always)]
    pub fn add(&mut self, item: &Item) {
        self.hull.add(item.low, item.high);
        let center = item.center();
        self.centers.add(center, center);
    }

    pub fn of(items: &[Item]) -> Self {
        let one = |items: &[Item]| {
            let mut all = Self::empty();
            items.iter().for_each(|item| all.add(item));
            all
        };
        if items.len() < PARALLEL {
            return one(items);
        }
        items
            .par_chunks(CHUNK)
            .map(one)
            .reduce(Self::empty, Self::union)
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            hull: self.hull.union(other.hull),
            centers: self.centers.union(other.centers),
        }
    }
}
