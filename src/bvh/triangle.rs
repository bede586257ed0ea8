//! Rays and triangles: the watertight test of Woop, Benthin & Wald (2013, "Watertight Ray/Triangle Intersection", JCGT 2.1).
//!
//! A triangle is sheared so that the ray runs along one axis from the origin, and the signs of three edge functions say
//! whether it is met. A corner is sheared in the same way wherever it occurs, and an edge function is a difference of two
//! rounded products, never fused: it changes nothing but its sign when the edge runs the other way. So a ray near an edge
//! is inside one neighbour or the other, or both, and slips through no seam.

use super::node::Block;
use crate::lanes::{Vec3x8, WIDTH, f32x8, u32x8};

/// A ray as the triangle test wants it.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Shear {
    pub origin: [f32; 3],
    /// −d_x/d_z, −d_y/d_z and 1/d_z, where z is the axis of the greatest component and x, y, z are in cyclic order.
    pub slopes: [f32; 3],
    /// Which axis that is.
    pub axis: u32,
    /// Bit a: component a of the direction is negative.
    pub octant: u32,
}

/// Eight of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearX8 {
    origin: Vec3x8,
    /// As [`Shear::slopes`].
    pub slopes: [f32x8; 3],
    /// As [`Shear::axis`].
    pub axis: u32x8,
    /// As [`Shear::octant`].
    pub octant: u32x8,
}

impl ShearX8 {
    pub fn new(origin: &Vec3x8, direction: &Vec3x8) -> Self {
        let [x, y, z] = [direction.x, direction.y, direction.z];
        let is_z = z.abs().simd_ge(x.abs()) & z.abs().simd_ge(y.abs());
        let is_y = y.abs().simd_ge(x.abs()) & !is_z;
        let pick =
            |if_x: f32x8, if_y: f32x8, if_z: f32x8| is_z.select(if_z, is_y.select(if_y, if_x));
        let inverse = f32x8::ONE / pick(x, y, z);
        let bit = |d: f32x8, axis: u32| (d.to_bits() >> 31) << axis;
        let axis = |n: u32| f32x8::from_bits(u32x8::splat(n));
        Self {
            origin: *origin,
            slopes: [-pick(y, z, x) * inverse, -pick(z, x, y) * inverse, inverse],
            axis: pick(axis(0), axis(1), axis(2)).to_bits(),
            octant: bit(x, 0) | bit(y, 1) | bit(z, 2),
        }
    }

    /// The greatest axis, where all eight have the same and run the same way along it.
    pub fn common_axis(&self) -> Option<usize> {
        let axis = self.axis.as_array()[0];
        let same = self.axis.simd_eq(u32x8::splat(axis)).to_bitmask() == 255;
        let negative = self.slopes[2].to_bitmask();
        (same && (negative == 0 || negative == 255)).then_some(axis as usize)
    }

    /// Each by itself.
    pub fn lanes(&self) -> [Shear; WIDTH] {
        let o = &self.origin;
        let [x, y, z] = self.slopes;
        let (axis, octant) = (f32x8::from_bits(self.axis), f32x8::from_bits(self.octant));
        f32x8::transpose([o.x, o.y, o.z, x, y, z, axis, octant]).map(|row| {
            let [ox, oy, oz, x, y, z, axis, octant] = row.to_array();
            Shear {
                origin: [ox, oy, oz],
                slopes: [x, y, z],
                axis: axis.to_bits(),
                octant: octant.to_bits(),
            }
        })
    }
}

/// The three axes from the one after the greatest component's on.
pub(super) const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// Distances at which a ray meets eight triangles, and the mask of those that it does meet.
#[inline(always)]
pub(super) fn meet_block(block: &Block, shear: &Shear) -> (f32x8, f32x8) {
    let [x, y, z] = AXES[shear.axis as usize & 3];
    let [slope_x, slope_y, scale] = shear.slopes.map(f32x8::splat);
    let corner = |corner: usize| {
        let along = |axis: usize| block.corners[corner][axis] - f32x8::splat(shear.origin[axis]);
        let depth = along(z);
        (
            depth.mul_add(slope_x, along(x)),
            depth.mul_add(slope_y, along(y)),
            depth,
        )
    };
    meet(corner(0), corner(1), corner(2), scale)
}

/// Distances at which eight rays with the same axes meet the triangle in a lane, and the mask of those that do. Each has the
/// bits that [`meet_block`] gives.
#[inline(always)]
pub(super) fn meet_triangle<const AXIS: usize>(
    block: &Block,
    lane: usize,
    shear: &ShearX8,
) -> (f32x8, f32x8) {
    let [x, y, z] = const { AXES[AXIS] };
    let origin = [shear.origin.x, shear.origin.y, shear.origin.z];
    let [slope_x, slope_y, scale] = shear.slopes;
    let corner = |corner: usize| {
        let along =
            |axis: usize| f32x8::splat(block.corners[corner][axis].as_array()[lane]) - origin[axis];
        let depth = along(z);
        (
            depth.mul_add(slope_x, along(x)),
            depth.mul_add(slope_y, along(y)),
            depth,
        )
    };
    meet(corner(0), corner(1), corner(2), scale)
}

/// The same for rays of any axes: corners are brought into the order of each ray's own.
#[inline(always)]
pub(super) fn meet_triangle_mixed(block: &Block, lane: usize, shear: &ShearX8) -> (f32x8, f32x8) {
    let [slope_x, slope_y, scale] = shear.slopes;
    let is = |axis: u32| f32x8::from_bits(shear.axis.simd_eq(u32x8::splat(axis)));
    let (is_y, is_z) = (is(1), is(2));
    let corner = |corner: usize| {
        let along = |axis: usize, origin: f32x8| {
            f32x8::splat(block.corners[corner][axis].as_array()[lane]) - origin
        };
        let origin = &shear.origin;
        let (x, y, z) = (along(0, origin.x), along(1, origin.y), along(2, origin.z));
        let pick =
            |if_x: f32x8, if_y: f32x8, if_z: f32x8| is_z.select(if_z, is_y.select(if_y, if_x));
        let depth = pick(x, y, z);
        (
            depth.mul_add(slope_x, pick(y, z, x)),
            depth.mul_add(slope_y, pick(z, x, y)),
            depth,
        )
    };
    meet(corner(0), corner(1), corner(2), scale)
}

/// Eight corners relative to origins, sheared; the depth is not scaled yet.
type Corner = (f32x8, f32x8, f32x8);

/// Distances at which rays meet triangles, and the mask of those that do; `scale` is 1/d_z.
#[inline(always)]
fn meet(a: Corner, b: Corner, c: Corner, scale: f32x8) -> (f32x8, f32x8) {
    let u = c.0 * b.1 - c.1 * b.0;
    let v = a.0 * c.1 - a.1 * c.0;
    let w = b.0 * a.1 - b.1 * a.0;
    let zero = f32x8::ZERO;
    let least = u.fast_min(v).fast_min(w);
    let most = u.fast_max(v).fast_max(w);
    let inside = least.simd_ge(zero) | most.simd_le(zero);
    let det = u + v + w;
    let t = u.mul_add(a.2, v.mul_add(b.2, w * c.2)) * scale / det;
    (t, inside & det.simd_ne(zero))
}
