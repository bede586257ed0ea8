//! Floor 2: shapes without a tree. Eight rays meet one primitive at a time, which beats any tree up to about 64 primitives.
//!
//! A hit at the same distance as an earlier one does not replace it: quads come before spheres, each in the order in which
//! they were added, so an image does not depend on anything else.

mod quad;
mod room;
mod sphere;

pub use quad::Quad;
pub use room::{QuadEdges, Room};
pub use sphere::Sphere;

use crate::lanes::{Vec3x8, f32x8, u32x8};

/// The id of no primitive.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A list of primitives, each with the id it is known by.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    quads: Vec<(Quad, u32x8)>,
    spheres: Vec<(Sphere, u32x8)>,
}

impl Shapes {
    /// Adds a parallelogram.
    pub fn add_quad(&mut self, quad: Quad, id: u32) {
        self.quads.push((quad, u32x8::splat(id)));
    }

    /// Adds a sphere.
    pub fn add_sphere(&mut self, sphere: Sphere, id: u32) {
        self.spheres.push((sphere, u32x8::splat(id)));
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.quads.len() + self.spheres.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The closest hit of each ray: distance along `direction` (unit) in scene units and id; +∞ and [`NO_PRIMITIVE`] for a miss.
    #[inline]
    pub fn closest(&self, origin: Vec3x8, direction: Vec3x8) -> (f32x8, u32x8) {
        let mut nearest = f32x8::splat(f32::INFINITY);
        let mut nearest_id = u32x8::splat(NO_PRIMITIVE);
        for (quad, id) in &self.quads {
            (nearest, nearest_id) = nearer(quad.hit(origin, direction), *id, nearest, nearest_id);
        }
        for (sphere, id) in &self.spheres {
            (nearest, nearest_id) = nearer(sphere.hit(origin, direction), *id, nearest, nearest_id);
        }
        (nearest, nearest_id)
    }

    /// Mask of the rays that meet anything but `target` nearer than `t_max`.
    #[inline]
    pub fn occluded(
        &self,
        origin: Vec3x8,
        direction: Vec3x8,
        t_max: f32x8,
        target: u32x8,
    ) -> f32x8 {
        // Nothing is nearer than a limit that is not a number.
        let limit = (t_max & t_max.simd_eq(t_max)).to_bits();
        let mut occluded = f32x8::ZERO;
        for (sphere, id) in &self.spheres {
            occluded |= before(sphere.hit(origin, direction), *id, limit, target);
        }
        for (quad, id) in &self.quads {
            occluded |= before(quad.hit(origin, direction), *id, limit, target);
        }
        occluded
    }
}

/// Distances of hits as bit patterns, compared as whole numbers: those of positive floats are in their order, and negative
/// distances, NaN and the pattern of all ones, which says "none", are greater than +∞. One minimum does what takes three
/// comparisons of floats.
type Distances = u32x8;

/// The nearer of two hits; the earlier one where they are equal.
#[inline]
fn nearer(hit: Distances, id: u32x8, nearest: f32x8, nearest_id: u32x8) -> (f32x8, u32x8) {
    let old = nearest.to_bits();
    let new = hit.min(old);
    let same = f32x8::from_bits(new.simd_eq(old));
    (f32x8::from_bits(new), same.select(nearest_id, id))
}

/// Mask of the hits nearer than the limit on anything but the target.
#[inline]
fn before(hit: Distances, id: u32x8, limit: Distances, target: u32x8) -> f32x8 {
    let beyond = hit.min(limit).simd_eq(limit) | target.simd_eq(id);
    !f32x8::from_bits(beyond)
}
