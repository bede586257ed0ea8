//! Warps from the unit square, eight at a time, each with its density.

use crate::lanes::{Vec3x8, f32x8, pow_one_minus, safe_sqrt, sin_cos_eighth, sin_cos_turns};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};

/// Two numbers in [0, 1) a lane.
pub type Pair = (f32x8, f32x8);

/// Density of [`uniform_sphere`], per steradian.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Density of [`uniform_hemisphere`], per steradian.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 * FRAC_1_PI;

/// Uniform on the unit disk: squares become rings, so that what is stratified on the square stays so on the disk
/// (Shirley & Chiu 1997, "A Low Distortion Map Between Disk and Square"). The second value is the squared radius.
#[inline]
pub fn uniform_disk(u: Pair) -> ((f32x8, f32x8), f32x8) {
    let two = f32x8::splat(2.0);
    let (a, b) = (u.0.mul_sub(two, f32x8::ONE), u.1.mul_sub(two, f32x8::ONE));
    let wide = a.abs().simd_gt(b.abs());
    let (r, other) = (wide.select(a, b), wide.select(b, a));
    // The centre of the square: 0 / 0.
    let divisor = r.simd_eq(f32x8::ZERO).select(f32x8::ONE, r);
    let (sin, cos) = sin_cos_eighth(other / divisor * FRAC_PI_4);
    let (x, y) = (r * wide.select(cos, sin), r * wide.select(sin, cos));
    ((x, y), r * r)
}

/// Uniform directions over the sphere; density [`UNIFORM_SPHERE_PDF`].
#[inline]
pub fn uniform_sphere(u: Pair) -> Vec3x8 {
    cone(u, f32x8::splat(2.0))
}

/// Uniform directions over the hemisphere z ≥ 0; density [`UNIFORM_HEMISPHERE_PDF`].
#[inline]
pub fn uniform_hemisphere(u: Pair) -> Vec3x8 {
    cone(u, f32x8::ONE)
}

/// Directions over the hemisphere z ≥ 0 with density `z / π` per steradian (Malley's method).
#[inline]
pub fn cosine_hemisphere(u: Pair) -> Vec3x8 {
    let ((x, y), r2) = uniform_disk(u);
    Vec3x8::new(x, y, (f32x8::ONE - r2).sqrt())
}

/// Directions over the hemisphere z ≥ 0 with density `(n + 1) / 2π · zⁿ` per steradian
/// (Lafortune & Willems 1994, sec. 4): `z = (1 − u)^(1 / (n + 1))`, and `1 − z` is what is computed.
#[inline]
pub fn cosine_power(u: Pair, n: f32x8) -> Vec3x8 {
    let one_minus_z = -((-u.0).ln_1p() / (n + f32x8::ONE)).exp_m1();
    polar(one_minus_z, u.1)
}

/// Density of [`cosine_power`] at the unit vector `local`, per steradian.
#[inline]
pub fn cosine_power_pdf(local: Vec3x8, n: f32x8) -> f32x8 {
    let z = local.z.fast_max(f32x8::ZERO);
    let one_minus_z = local.x.mul_add(local.x, local.y * local.y) / (z + f32x8::ONE);
    let density = pow_one_minus(one_minus_z, n) * (n + f32x8::ONE) * (0.5 * FRAC_1_PI);
    density & local.z.simd_gt(f32x8::ZERO)
}

/// Uniform directions in the cone around +z whose half-angle has the cosine `1 − one_minus_cos_max`;
/// density [`cone_pdf`].
///
/// The difference, not the cosine, is the parameter: the cosine of a small angle rounds to 1.
#[inline]
pub fn cone(u: Pair, one_minus_cos_max: f32x8) -> Vec3x8 {
    let ((x, y), r2) = uniform_disk(u);
    // 1 − z is uniform: it goes with the disk's area. The disk's radius grows to sin α = sqrt((1 − z)(1 + z)).
    let one_minus_z = r2 * one_minus_cos_max;
    let scale = (one_minus_cos_max * (f32x8::splat(2.0) - one_minus_z)).sqrt();
    Vec3x8::new(x * scale, y * scale, f32x8::ONE - one_minus_z)
}

/// Density of [`cone`] inside it, per steradian.
#[inline]
pub fn cone_pdf(one_minus_cos_max: f32x8) -> f32x8 {
    f32x8::splat(0.5 * FRAC_1_PI) / one_minus_cos_max
}

/// Barycentric coordinates of a triangle's second and third corner, uniform over its area: half of the square is folded onto
/// the other along the diagonal, so that strata stay whole but for a shear (Heitz 2019, "A Low-Distortion Map Between
/// Triangle and Square").
#[inline]
pub fn uniform_triangle(u: Pair) -> (f32x8, f32x8) {
    let lower = u.0.simd_gt(u.1);
    let half = lower.select(u.1, u.0) * 0.5;
    (
        lower.select(u.0 - half, half),
        lower.select(half, u.1 - half),
    )
}

/// The unit vector at `1 − z` and an azimuth in turns; exact near the pole.
#[inline]
fn polar(one_minus_z: f32x8, turns: f32x8) -> Vec3x8 {
    let r = safe_sqrt(one_minus_z * (f32x8::splat(2.0) - one_minus_z));
    let (sin, cos) = sin_cos_turns(turns);
    Vec3x8::new(r * cos, r * sin, f32x8::ONE - one_minus_z)
}

/// On [-1, 1] with density [`tent_pdf`].
#[inline]
pub fn tent(u: f32x8) -> f32x8 {
    let left = u.simd_lt(f32x8::HALF);
    let tail = left.select(u, f32x8::ONE - u);
    let from_end = f32x8::ONE - (tail * 2.0).sqrt();
    left.select(-from_end, from_end)
}

/// `1 − |x|`, 0 beyond [-1, 1].
#[inline]
pub fn tent_pdf(x: f32x8) -> f32x8 {
    (f32x8::ONE - x.abs()).fast_max(f32x8::ZERO)
}

/// Standard deviation of [`gaussian_truncated`], pixels.
pub const GAUSSIAN_SIGMA: f32 = 0.5;

/// Greatest radius of [`gaussian_truncated`], pixels.
pub const GAUSSIAN_RADIUS: f32 = 1.5;

/// The part of the Gaussian that is kept: `1 − exp(−R² / 2σ²)`.
const GAUSSIAN_KEPT: f32 = 0.988_891;

/// Offsets in the plane, pixels, with a Gaussian density cut off at a radius; density [`gaussian_truncated_pdf`]
/// (Box & Muller 1958, on a part of the radii).
#[inline]
pub fn gaussian_truncated(u: Pair) -> (f32x8, f32x8) {
    let exponent = (u.0 * -GAUSSIAN_KEPT).ln_1p();
    let r = safe_sqrt(exponent * (-2.0 * GAUSSIAN_SIGMA * GAUSSIAN_SIGMA));
    let (sin, cos) = sin_cos_turns(u.1);
    (r * cos, r * sin)
}

/// Density of [`gaussian_truncated`], per square pixel.
#[inline]
pub fn gaussian_truncated_pdf(x: f32x8, y: f32x8) -> f32x8 {
    const VARIANCE: f32 = GAUSSIAN_SIGMA * GAUSSIAN_SIGMA;
    let r2 = x.mul_add(x, y * y);
    let density = (r2 * (-0.5 / VARIANCE)).exp() * (0.5 * FRAC_1_PI / (VARIANCE * GAUSSIAN_KEPT));
    // A hair beyond the radius, so that a rounded sample at the rim has a density.
    density
        & r2.simd_le(f32x8::splat(
            GAUSSIAN_RADIUS * GAUSSIAN_RADIUS * (1.0 + 1e-6),
        ))
}
