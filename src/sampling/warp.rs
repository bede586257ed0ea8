//! Warps from the unit square, eight at a time, each with its density.

use crate::lanes::{Vec3x8, f32x8, safe_sqrt, sin_cos_turns};
use std::f32::consts::FRAC_1_PI;

/// Two numbers in [0, 1) a lane.
pub type Pair = (f32x8, f32x8);

/// Density of [`uniform_sphere`], per steradian.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Density of [`uniform_hemisphere`], per steradian.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 * FRAC_1_PI;

/// Uniform on the unit disk, polar (radius `sqrt(u)`).
#[inline]
pub fn uniform_disk(u: Pair) -> (f32x8, f32x8) {
    let r = u.0.sqrt();
    let (sin, cos) = sin_cos_turns(u.1);
    (r * cos, r * sin)
}

/// Uniform directions over the sphere; density [`UNIFORM_SPHERE_PDF`].
#[inline]
pub fn uniform_sphere(u: Pair) -> Vec3x8 {
    let z = u.0.mul_add(f32x8::splat(-2.0), f32x8::ONE);
    // 1 - z² = 4u(1 - u): no cancellation near the poles.
    let r = (u.0 * (f32x8::ONE - u.0)).sqrt() * 2.0;
    let (sin, cos) = sin_cos_turns(u.1);
    Vec3x8::new(r * cos, r * sin, z)
}

/// Uniform directions over the hemisphere z ≥ 0; density [`UNIFORM_HEMISPHERE_PDF`].
#[inline]
pub fn uniform_hemisphere(u: Pair) -> Vec3x8 {
    let z = f32x8::ONE - u.0;
    let r = (u.0 * (f32x8::ONE + z)).sqrt();
    let (sin, cos) = sin_cos_turns(u.1);
    Vec3x8::new(r * cos, r * sin, z)
}

/// Directions over the hemisphere z ≥ 0 with density `z / π` per steradian (Malley's method).
#[inline]
pub fn cosine_hemisphere(u: Pair) -> Vec3x8 {
    let (x, y) = uniform_disk(u);
    Vec3x8::new(x, y, safe_sqrt(f32x8::ONE - u.0))
}
