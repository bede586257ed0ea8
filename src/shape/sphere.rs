//! Spheres.

use super::Distances;
use crate::lanes::{Vec3x8, f32x8};
use glam::Vec3;

/// A sphere, each number in all eight lanes so that a kernel reads it as a memory operand.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    center: Vec3x8,
    radius_squared: f32x8,
}

impl Sphere {
    /// From centre and radius, scene units.
    pub fn new(center: Vec3, radius: f32) -> Self {
        Self {
            center: Vec3x8::splat(center),
            radius_squared: f32x8::splat(radius * radius),
        }
    }

    /// Distance at which each ray meets it, as bits (see [`Distances`]). `direction` is unit.
    ///
    /// The discriminant comes from the point of the ray nearest to the centre, which keeps its bits when the sphere is
    /// small or far (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, ch. 7).
    #[inline]
    pub(super) fn hit(&self, origin: Vec3x8, direction: Vec3x8) -> Distances {
        let to_center = self.center - origin;
        let middle = to_center.dot(direction);
        let x = direction.x.mul_neg_add(middle, to_center.x);
        let y = direction.y.mul_neg_add(middle, to_center.y);
        let z = direction.z.mul_neg_add(middle, to_center.z);
        let discriminant =
            x.mul_neg_add(x, y.mul_neg_add(y, z.mul_neg_add(z, self.radius_squared)));
        // Negative gives NaN: no hit. From inside the near root is negative, and the far one is the lesser pattern.
        let half = discriminant.sqrt();
        (middle - half).to_bits().min((middle + half).to_bits())
    }
}
