//! Rays as one bundle: intervals of their origins and slopes (Boulos, Wald & Shirley 2006, "Geometric and Arithmetic Culling
//! Methods for Entire Ray Packets"), so that eight boxes are met once for all of them.
//!
//! What a bundle saves in the tree it loses to boxes and triangles that no ray meets, the more the wider it is.

use super::RayX8;
use super::ready::FAR;
use super::slot::WIDEN;
use super::triangle::ShearX8;
use crate::lanes::{WIDTH, f32x8, u32x8};

/// The least component of directions that all run the same way along an axis, in slopes that f32 can tell from those of
/// parallel rays.
const STEEP: f32 = 1e-6;

/// Lanes of an [`Extent`].
const ORIGINS: u32 = 0b0000_0111;
const SLOPES: u32 = 0b1100_0000;

/// The least and the greatest of each number of some rays: three of the origin, three of the direction, two slopes.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    low: f32x8,
    high: f32x8,
}

impl Extent {
    #[inline(always)]
    pub fn of(rays: &RayX8, shear: &ShearX8) -> Self {
        let (o, d) = (&rays.origin, &rays.direction);
        let [across, along, _] = shear.slopes;
        let values = [o.x, o.y, o.z, d.x, d.y, d.z, across, along];
        let [first, rest @ ..] = f32x8::transpose(values);
        let (mut low, mut high) = (first, first);
        for value in rest {
            low = low.fast_min(value);
            high = high.fast_max(value);
        }
        Self { low, high }
    }

    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.fast_min(other.low),
            high: self.high.fast_max(other.high),
        }
    }

    /// Whether origins are at most `apart` from each other along each axis.
    #[inline(always)]
    pub fn begins_together(&self, apart: f32) -> bool {
        let close = (self.high - self.low).simd_le(f32x8::splat(apart));
        close.to_bitmask() & ORIGINS == ORIGINS
    }

    /// Whether the slopes are at most `spread` apart, and no origin is far from a tree of this reach.
    #[inline(always)]
    pub fn keeps_together(&self, reach: f32, spread: f32) -> bool {
        let far = f32x8::splat(FAR * reach);
        let near = self.low.simd_ge(-far) & self.high.simd_le(far);
        let close = (self.high - self.low).simd_le(f32x8::splat(spread));
        near.to_bitmask() & ORIGINS == ORIGINS && close.to_bitmask() & SLOPES == SLOPES
    }
}

/// Rays with one greatest axis, as intervals. In each array the first three are for x, y and z.
pub(super) struct Bundle {
    axis: usize,
    octant: usize,
    /// Whether the rays run from high to low.
    backwards: [bool; 3],
    /// Axes along which the rays do not all run the same way, as bits.
    fans: u32,
    /// The least and the greatest inverse of a direction's component: a plane is between `plane · slope + offset` of both.
    /// Of a fan they say nothing.
    slopes: [[f32; WIDTH]; 2],
    near_offsets: [[f32; WIDTH]; 2],
    far_offsets: [[f32; WIDTH]; 2],
    /// Where a fan's rays are at a distance: the least and the greatest origin, and how fast they go.
    origins: [[f32; WIDTH]; 2],
    speeds: [[f32; WIDTH]; 2],
}

impl Bundle {
    /// All rays of an extent, the first of which have this shear. None where rays go both ways along all axes: a fan needs
    /// another axis to end at.
    #[inline(always)]
    pub fn new(extent: &Extent, first: &ShearX8) -> Option<Self> {
        let axis = first.axis.as_array()[0] as usize;
        let octant = first.octant.as_array()[0] as usize;
        let directions = u32x8::new([3, 4, 5, 3, 3, 3, 3, 3]);
        let Extent { low, high } = *extent;
        let speeds = [low, high].map(|value| value.shuffle_wrapping(directions));
        let steep = f32x8::splat(STEEP);
        let backwards = speeds[1].simd_lt(-steep);
        let slab = speeds[0].simd_gt(steep) | backwards;
        let for_near = backwards.select(low, high);
        let for_far = backwards.select(high, low);
        let slopes = [speeds[1], speeds[0]].map(|speed| slab & (f32x8::ONE / speed));
        let infinite = f32x8::splat(f32::INFINITY);
        let near_offsets = slopes.map(|slope| slab.select(-(for_near * slope), -infinite));
        let far_offsets = slopes.map(|slope| slab.select(-(for_far * slope), infinite));
        let fans = !slab.to_bitmask() & 0b111;
        let backwards = backwards.to_bitmask();
        (fans != 0b111).then(|| Self {
            axis,
            octant,
            backwards: [0, 1, 2].map(|axis| backwards >> axis & 1 == 1),
            fans,
            slopes: slopes.map(f32x8::to_array),
            near_offsets: near_offsets.map(f32x8::to_array),
            far_offsets: far_offsets.map(f32x8::to_array),
            origins: [low.to_array(), high.to_array()],
            speeds: [
                speeds[0].fast_min(f32x8::ZERO).to_array(),
                speeds[1].fast_max(f32x8::ZERO).to_array(),
            ],
        })
    }

    /// The greatest axis.
    #[inline(always)]
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// The octant of the first ray's direction: the order in which all of them meet the children of a node.
    #[inline(always)]
    pub fn octant(&self) -> usize {
        self.octant & 7
    }

    /// The boxes that any of the rays may meet, as a mask, and how far they are at least.
    #[inline(always)]
    pub fn enter(&self, planes: &[f32x8; 6], nearest: f32x8, best: f32x8) -> (f32x8, f32x8) {
        let splat = f32x8::splat;
        let (mut enter, mut leave) = (nearest, best);
        for axis in 0..3 {
            let backwards = self.backwards[axis];
            let near = planes[axis + 3 * usize::from(backwards)];
            let far = planes[axis + 3 * usize::from(!backwards)];
            let at = |plane: f32x8, offsets: &[[f32; WIDTH]; 2], end: usize| {
                plane.mul_add(splat(self.slopes[end][axis]), splat(offsets[end][axis]))
            };
            let nearer = at(near, &self.near_offsets, 0).fast_min(at(near, &self.near_offsets, 1));
            let farther = at(far, &self.far_offsets, 0).fast_max(at(far, &self.far_offsets, 1));
            enter = enter.fast_max(nearer);
            leave = leave.fast_min(farther);
        }
        let leave = leave * splat(WIDEN);
        let mut hit = enter.simd_le(leave);
        if self.fans != 0 {
            for axis in (0..3).filter(|axis| self.fans >> axis & 1 == 1) {
                let at = |end: usize| {
                    leave.mul_add(
                        splat(self.speeds[end][axis]),
                        splat(self.origins[end][axis]),
                    )
                };
                hit &= at(0).simd_le(planes[axis + 3]) & at(1).simd_ge(planes[axis]);
            }
        }
        (hit, enter)
    }
}
