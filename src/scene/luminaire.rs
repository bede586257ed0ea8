//! Light sources with a surface, eight lanes at a time: points of them, and with what density.

use crate::lanes::{FrameX8, Rgbx8, Vec3x8, f32x8, safe_sqrt, square, u32x8};
use crate::sampling::warp::{self, Pair};
use std::f32::consts::TAU;

/// Eight light sources.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightX8 {
    pub position: Vec3x8,
    pub radius: f32x8,
    pub area: f32x8,
    pub chance: f32x8,
    pub inverse_chance: f32x8,
    pub primitive: u32x8,
    pub two_sided: f32x8,
    pub radiance: Rgbx8,
    pub mesh: u32x8,
    pub normal: Vec3x8,
    pub u: Vec3x8,
    pub v: Vec3x8,
}

impl LightX8 {
    /// Direction, distance to the surface and 1 ÷ density (steradians; 0 where the light shows its dark side): uniform in
    /// the cone that the sphere subtends (Shirley & Morley, Realistic Ray Tracing, 2nd ed., "Sampling a Spherical
    /// Luminaire"); from inside, uniform over all directions.
    #[inline]
    pub fn point_of_sphere(&self, from: Vec3x8, point: Pair) -> (Vec3x8, f32x8, f32x8) {
        let to_center = self.position - from;
        let squared = to_center.length_squared();
        // One division serves the direction, the distance and the cone.
        let inverse_squared = f32x8::ONE / squared;
        let inverse_distance = inverse_squared.sqrt();
        let (spread, outside) = sphere_cone(square(self.radius) * inverse_squared);
        let local = warp::cone(point, spread);
        let direction = FrameX8::new(to_center * inverse_distance).to_world(local);
        // sin²α from the local x and y: 1 − cos² would lose a small cone's bits.
        let sin2 = local.x.mul_add(local.x, local.y * local.y);
        let half = safe_sqrt(sin2.mul_neg_add(squared, square(self.radius)));
        let half = outside.select(-half, half);
        (
            direction,
            (squared * inverse_distance).mul_add(local.z, half),
            (spread * TAU) & (outside | self.two_sided),
        )
    }

    /// The same for a quad: uniform over its area.
    #[inline]
    pub fn point_of_quad(&self, from: Vec3x8, point: Pair) -> (Vec3x8, f32x8, f32x8) {
        let on_light = self
            .u
            .mul_add(point.0, self.v.mul_add(point.1, self.position));
        let way = on_light - from;
        let squared = way.length_squared();
        let inverse_squared = f32x8::ONE / squared;
        let inverse_distance = inverse_squared.sqrt();
        let direction = way * inverse_distance;
        let facing = -direction.dot(self.normal);
        let lit = facing.simd_gt(f32x8::ZERO) | self.two_sided;
        (
            direction,
            squared * inverse_distance,
            (facing.abs() * self.area * inverse_squared) & lit,
        )
    }

    /// The same for a point of a mesh and its normal, drawn uniformly over its area; 0 where it is `from` itself.
    #[inline]
    pub fn point_of_mesh(
        &self,
        from: Vec3x8,
        on_light: Vec3x8,
        normal: Vec3x8,
    ) -> (Vec3x8, f32x8, f32x8) {
        let way = on_light - from;
        let squared = way.length_squared();
        let distance = squared.sqrt();
        let direction = way * (f32x8::ONE / distance);
        let facing = -direction.dot(normal);
        let lit = facing.simd_gt(f32x8::ZERO) | self.two_sided;
        let apart = squared.simd_gt(f32x8::ZERO);
        let inverse_pdf = facing.abs() * self.area / squared;
        (direction, distance, inverse_pdf & lit & apart)
    }
}

/// `1 − cos α_max` of the cone under which a sphere is seen, from sin²α_max, and whether the point is outside; inside, the
/// "cone" is all directions.
///
/// `1 − sqrt(1 − s)` loses a small cone's bits, and its stable form `s / (1 + sqrt(1 − s))` waits for a quotient after a
/// root. The first five terms of the series serve where s is small, within 4·10⁻⁹.
#[inline]
pub(super) fn sphere_cone(sin2: f32x8) -> (f32x8, f32x8) {
    let s = sin2;
    let series = s
        .mul_add(f32x8::splat(7.0 / 256.0), f32x8::splat(5.0 / 128.0))
        .mul_add(s, f32x8::splat(1.0 / 16.0))
        .mul_add(s, f32x8::splat(1.0 / 8.0))
        .mul_add(s, f32x8::HALF)
        * s;
    let direct = f32x8::ONE - safe_sqrt(f32x8::ONE - s);
    let outside = s.simd_lt(f32x8::ONE);
    let spread = s.simd_lt(f32x8::splat(0.04)).select(series, direct);
    (outside.select(spread, f32x8::splat(2.0)), outside)
}
