//! Parallelograms.

use super::Distances;
use crate::lanes::{Vec3x8, f32x8};
use glam::{DVec3, Vec3};

/// A parallelogram, each number in all eight lanes so that a kernel reads it as a memory operand.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    normal: Vec3x8,
    /// `normal · corner`.
    distance: f32x8,
    /// `side · p + side_offset` runs from −1 to 1 along the first edge; `other` along the second.
    side: Vec3x8,
    side_offset: f32x8,
    other: Vec3x8,
    other_offset: f32x8,
}

/// How far beyond its edges a quad reaches, relative to half its side: two quads that share an edge leave no gap.
const OVERLAP: f32 = 1.0 + 4.0 * f32::EPSILON;

impl Quad {
    /// From a corner and two edges that are not parallel, scene units.
    pub fn new(corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let (corner, u, v) = (corner.as_dvec3(), u.as_dvec3(), v.as_dvec3());
        let n = u.cross(v);
        let normal = n.normalize();
        // The dual basis: side · u = 2 and side · v = 0.
        let side = 2.0 * v.cross(n) / n.length_squared();
        let other = 2.0 * n.cross(u) / n.length_squared();
        let wide = |v: DVec3| Vec3x8::splat(v.as_vec3());
        let splat = |x: f64| f32x8::splat(x as f32);
        Self {
            normal: wide(normal),
            distance: splat(normal.dot(corner)),
            side: wide(side),
            side_offset: splat(-1.0 - side.dot(corner)),
            other: wide(other),
            other_offset: splat(-1.0 - other.dot(corner)),
        }
    }

    /// Distance at which each ray meets it, from either side, as bits (see [`Distances`]).
    #[inline]
    pub(super) fn hit(&self, origin: Vec3x8, direction: Vec3x8) -> Distances {
        let height = self.normal.x.mul_neg_add(
            origin.x,
            self.normal
                .y
                .mul_neg_add(origin.y, self.normal.z.mul_neg_add(origin.z, self.distance)),
        );
        // A ray in the plane gives ±∞ or NaN, which is not inside below.
        let t = height / self.normal.dot(direction);
        let p = direction.mul_add(t, origin);
        let along = |axis: &Vec3x8, offset: f32x8| {
            axis.x
                .mul_add(p.x, axis.y.mul_add(p.y, axis.z.mul_add(p.z, offset)))
        };
        let a = along(&self.side, self.side_offset).abs();
        let b = along(&self.other, self.other_offset).abs();
        // Outside or NaN sets all bits: no hit. A NaN in `a` is not hidden by the maximum: `a` is NaN only if `b` is, and x86
        // gives the second operand.
        let inside = a.fast_max(b).simd_le(f32x8::splat(OVERLAP));
        (t | !inside).to_bits()
    }
}
