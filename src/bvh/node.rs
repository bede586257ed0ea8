//! How the tree lies in memory.

use crate::lanes::{f32x8, u32x8};
use glam::{Affine3A, Vec3};

/// A box around things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    pub const EMPTY: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
    };

    pub fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Whether all of another is inside.
    pub fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all()
    }

    /// Whether another has a point in common with it.
    pub fn touches(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && self.high.cmpge(other.low).all()
    }

    /// The box around this one, moved.
    pub fn placed(self, transform: &Affine3A) -> Self {
        (0..8).fold(Self::EMPTY, |all, corner| {
            let pick = |axis: usize| match corner >> axis & 1 {
                0 => self.low[axis],
                _ => self.high[axis],
            };
            let point = transform.transform_point3(Vec3::new(pick(0), pick(1), pick(2)));
            all.union(Self {
                low: point,
                high: point,
            })
        })
    }

    /// The greatest absolute coordinate; 0 of nothing.
    pub fn reach(self) -> f32 {
        self.low.abs().max(self.high.abs()).max_element()
    }
}

/// A place of the tree: what it is in the upper two bits, which one in the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link(pub u32);

impl Link {
    const SHIFT: u32 = 30;
    /// Kinds of places.
    pub const NODE: u32 = 0;
    pub const BLOCK: u32 = 1;
    pub const INSTANCE: u32 = 2;
    pub const END: u32 = 3;

    /// The ray has met everything.
    pub const DONE: Self = Self(u32::MAX);
    /// The ray leaves an instance.
    pub const LEAVE: Self = Self(u32::MAX - 1);

    /// What makes a place one of kind [`Link::END`]: it is farther than the nearest hit.
    pub const STALE: Self = Self(Self::END << Self::SHIFT);

    /// The most things of a kind.
    pub const MOST: usize = (1 << Self::SHIFT) - 2;

    pub fn new(kind: u32, index: usize) -> Self {
        debug_assert!(index < Self::MOST);
        Self(kind << Self::SHIFT | index as u32)
    }

    #[inline(always)]
    pub fn kind(self) -> u32 {
        self.0 >> Self::SHIFT
    }

    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & ((1 << Self::SHIFT) - 1)) as usize
    }
}

/// Eight children in SoA: one ray meets eight boxes at once.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `x`, `y`, `z` of the low corners, then of the high ones; what an empty lane holds is not met.
    pub planes: [f32x8; 6],
    /// [`Link`]s.
    pub children: u32x8,
    /// For each octant of directions (bit a: component a is negative) the lanes from the farthest child to the nearest,
    /// three bits each, the first the lowest, then the empty lanes. The upper eight bits have one on for each child.
    pub order: [u32; 8],
}

impl Node {
    /// A node without children.
    pub fn empty() -> Self {
        let (low, high) = (f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY));
        Self {
            planes: [low, low, low, high, high, high],
            children: u32x8::splat(Link::DONE.0),
            order: [0o7654_3210; 8],
        }
    }

    pub fn set(&mut self, lane: usize, bounds: Bounds, link: Link) {
        for axis in 0..3 {
            self.planes[axis].as_mut_array()[lane] = bounds.low[axis];
            self.planes[axis + 3].as_mut_array()[lane] = bounds.high[axis];
        }
        self.children.as_mut_array()[lane] = link.0;
    }

    /// The child in a lane and its box; none where the lane is empty.
    pub fn child(&self, lane: usize) -> Option<(Bounds, Link)> {
        let corner = |first: usize| {
            Vec3::from_array(std::array::from_fn(|axis| {
                self.planes[first + axis].as_array()[lane]
            }))
        };
        let link = Link(self.children.as_array()[lane]);
        (link.kind() != Link::END).then(|| {
            let (low, high) = (corner(0), corner(3));
            (Bounds { low, high }, link)
        })
    }
}

/// Eight triangles in SoA: one ray meets eight at once.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// By corner and axis. An empty lane is a triangle without an area, which nothing meets.
    pub corners: [[f32x8; 3]; 3],
    /// Indices in their mesh, ascending.
    pub triangles: u32x8,
}

impl Block {
    pub fn empty() -> Self {
        Self {
            corners: [[f32x8::ZERO; 3]; 3],
            triangles: u32x8::splat(super::NO_TRIANGLE),
        }
    }

    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], triangle: u32) {
        for (place, corner) in self.corners.iter_mut().zip(corners) {
            for axis in 0..3 {
                place[axis].as_mut_array()[lane] = corner[axis];
            }
        }
        self.triangles.as_mut_array()[lane] = triangle;
    }

    /// The corners of the triangle in a lane.
    pub fn corners_of(&self, lane: usize) -> [Vec3; 3] {
        std::array::from_fn(|corner| {
            Vec3::from_array(std::array::from_fn(|axis| {
                self.corners[corner][axis].as_array()[lane]
            }))
        })
    }

    /// The boxes of the triangles, as a [`Node`] has them, wider on all sides.
    #[inline(always)]
    pub fn planes(&self, wider: f32x8) -> [f32x8; 6] {
        let [a, b, c] = &self.corners;
        let low = |axis: usize| a[axis].fast_min(b[axis]).fast_min(c[axis]) - wider;
        let high = |axis: usize| a[axis].fast_max(b[axis]).fast_max(c[axis]) + wider;
        [low(0), low(1), low(2), high(0), high(1), high(2)]
    }

    /// The lanes that hold triangles.
    #[inline(always)]
    pub fn live(&self) -> u32 {
        self.triangles
            .simd_ne(u32x8::splat(super::NO_TRIANGLE))
            .to_bitmask()
    }

    /// Triangles in it.
    pub fn len(&self) -> usize {
        self.live().count_ones() as usize
    }
}

/// Eight lane numbers of three bits each.
#[inline(always)]
pub(super) fn unpack(order: u32) -> u32x8 {
    u32x8::splat(order) >> u32x8::new([0, 3, 6, 9, 12, 15, 18, 21])
}

/// The lanes that a mask has on, ascending.
#[inline(always)]
pub(super) fn compress(mask: u32) -> u32x8 {
    unpack(COMPRESS[mask as usize & 255])
}

/// For each mask, the lanes that are on, ascending, three bits each.
static COMPRESS: [u32; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut lane = 0;
        let mut filled = 0;
        while lane < 8 {
            if (mask >> lane) & 1 == 1 {
                table[mask] |= lane << (3 * filled);
                filled += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};
