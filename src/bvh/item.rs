//! What trees are built from.

use super::node::Bounds;
use crate::lanes::{f32x8, u32x8};
use glam::Vec3;
use rayon::prelude::*;

/// From so many items on, several threads work on one run.
pub(super) const PARALLEL: usize = 1 << 16;
/// Items that a thread takes at a time then.
pub(super) const CHUNK: usize = 1 << 14;

/// A box that grows: its low corner, negated, in the first three lanes, its high corner in lanes 4 to 6, so that one maximum
/// of eight lanes joins two boxes. What the other lanes hold is not looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull(f32x8);

impl Hull {
    /// The lane of the high corner's first component.
    pub const HIGH: usize = 4;

    pub fn empty() -> Self {
        Self(f32x8::splat(f32::NEG_INFINITY))
    }

    fn of(bounds: Bounds) -> Self {
        let (low, high) = (-bounds.low, bounds.high);
        Self(f32x8::new([
            low.x, low.y, low.z, 0.0, high.x, high.y, high.z, 0.0,
        ]))
    }

    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self(self.0.fast_max(other.0))
    }

    #[inline(always)]
    pub fn add(&mut self, other: Self) {
        *self = self.union(other);
    }

    /// Where a mask's lanes are on; nothing where they are off.
    #[inline(always)]
    pub fn filtered(self, mask: f32x8) -> Self {
        Self(mask.select(self.0, Self::empty().0))
    }

    /// Both corners in each other's place.
    #[inline(always)]
    fn turned(self) -> f32x8 {
        self.0
            .shuffle_wrapping(u32x8::new([4, 5, 6, 7, 0, 1, 2, 3]))
    }

    /// Twice the centre, as a box without an inside.
    #[inline(always)]
    pub fn center(self) -> Self {
        Self(self.0 - self.turned())
    }

    /// The sides' lengths, twice over.
    #[inline(always)]
    pub fn size(self) -> f32x8 {
        self.0 + self.turned()
    }

    /// Half the surface; 0 of nothing.
    #[inline(always)]
    pub fn area(self) -> f32 {
        let [x, y, z, ..] = self.size().fast_max(f32x8::ZERO).to_array();
        x * y + y * z + z * x
    }

    /// The low corner, where the high one lies; the high one, negated, where the low one does.
    #[inline(always)]
    pub fn low(self) -> f32x8 {
        -self.turned()
    }

    /// The corners as they lie, the low one negated.
    #[inline(always)]
    pub fn corners(self) -> f32x8 {
        self.0
    }

    pub fn bounds(self) -> Bounds {
        let [x, y, z, _, high @ ..] = self.0.to_array();
        Bounds {
            low: -Vec3::new(x, y, z),
            high: Vec3::from_slice(&high[..3]),
        }
    }
}

/// Something to be put into a tree: its box and its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item(Hull);

impl Item {
    /// Where a box has its item's number.
    const NUMBER: usize = 3;
    /// Makes a number's bits those of an ordinary float: sums of denormal ones are slow on some machines.
    const ORDINARY: u32 = 1 << 30;

    /// Of a number below 2³⁰.
    pub fn new(bounds: Bounds, number: u32) -> Self {
        let mut hull = Hull::of(bounds);
        hull.0.as_mut_array()[Self::NUMBER] = f32::from_bits(number | Self::ORDINARY);
        Self(hull)
    }

    pub fn number(&self) -> u32 {
        self.0.0.as_array()[Self::NUMBER].to_bits() & !Self::ORDINARY
    }

    #[inline(always)]
    pub fn hull(&self) -> Hull {
        self.0
    }

    /// Twice the centre, as a box without an inside.
    #[inline(always)]
    pub fn center(&self) -> Hull {
        self.0.center()
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

    pub fn of(items: &[Item]) -> Self {
        let one = |items: &[Item]| {
            items.iter().fold(Self::empty(), |all, item| {
                all.union(Self {
                    hull: item.hull(),
                    centers: item.center(),
                })
            })
        };
        if items.len() < PARALLEL {
            return one(items);
        }
        items
            .par_chunks(CHUNK)
            .map(one)
            .reduce(Self::empty, Self::union)
    }

    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self {
            hull: self.hull.union(other.hull),
            centers: self.centers.union(other.centers),
        }
    }
}
