//! The GGX microsurface, for all that is rough.

use crate::lanes::{Vec3x8, f32x8, sin_cos_turns, square};
use std::f32::consts::FRAC_1_PI;

/// Least alpha: a smoother surface is a mirror to single precision.
pub(super) const MIN_ALPHA: f32 = 1e-4;

/// An isotropic GGX microsurface with height-correlated Smith shadowing
/// (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", sec. 5.2, eq. 33 and 34;
/// Heitz 2014, "Understanding the Masking-Shadowing Function", sec. 5.3 and 6.2.1, eq. 99).
///
/// Drawn from the visible normals by spherical caps (Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical
/// Caps", listing 3). With `s = sqrt(α² sin²θ + cos²θ)`, masking is `G1 = 2c / (c + s)` and masking with shadowing
/// `G2 = 2 co ci / (so ci + si co)`: put in, every cosine in a denominator cancels, and grazing angles need no care.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ggx {
    alpha: f32x8,
    alpha2: f32x8,
    /// 1/α².
    inverse_alpha2: f32x8,
    /// 1/(π α²).
    peak: f32x8,
}

impl Ggx {
    /// Its part of a row of parameters; `alpha` is the roughness, not squared, and at least [`MIN_ALPHA`] is used.
    pub fn row(alpha: f32) -> [f32; 4] {
        let alpha = alpha.max(MIN_ALPHA);
        let inverse = 1.0 / (f64::from(alpha) * f64::from(alpha));
        [
            alpha,
            alpha * alpha,
            inverse as f32,
            (inverse * std::f64::consts::FRAC_1_PI) as f32,
        ]
    }

    /// From the fields of [`Ggx::row`].
    #[inline]
    pub fn load([alpha, alpha2, inverse_alpha2, peak]: [f32x8; 4]) -> Self {
        Self {
            alpha,
            alpha2,
            inverse_alpha2,
            peak,
        }
    }

    /// From alphas that are at least [`MIN_ALPHA`].
    #[inline]
    pub fn new(alpha: f32x8) -> Self {
        let alpha2 = square(alpha);
        let inverse_alpha2 = f32x8::ONE / alpha2;
        Self {
            alpha,
            alpha2,
            inverse_alpha2,
            peak: inverse_alpha2 * FRAC_1_PI,
        }
    }

    /// BSDF × cos θi of a surface that reflects everything, and density of [`Ggx::sample`]; zero where `wi` or `wo` is not
    /// above the surface.
    #[inline]
    pub fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> (f32x8, f32x8) {
        let above = wo.z.simd_gt(f32x8::ZERO) & wi.z.simd_gt(f32x8::ZERO);
        let (so, si) = (self.stretched(wo), self.stretched(wi));
        let half_facets = self.facets(wo, wi) * 0.5;
        // D G2 / (4 co ci) · ci  and  D G1 / (4 co).
        let value = half_facets * wi.z / so.mul_add(wi.z, si * wo.z);
        let pdf = half_facets / (so + wo.z);
        (value & above, pdf & above)
    }

    /// G2 / G1: value over density, without the density of facets.
    #[inline]
    pub fn weight(&self, wo: Vec3x8, wi: Vec3x8) -> f32x8 {
        let (so, si) = (self.stretched(wo), self.stretched(wi));
        wi.z * (so + wo.z) / so.mul_add(wi.z, si * wo.z)
    }

    /// Reflects `wo` in a microfacet that it sees; the direction may be below the surface.
    #[inline]
    pub fn sample(&self, wo: Vec3x8, u: (f32x8, f32x8)) -> Vec3x8 {
        let h = self.visible_normal(wo, u);
        h.mul_add(wo.dot(h) * 2.0, -wo)
    }

    /// `sqrt(α² sin²θ + cos²θ)`: the stretched length of a direction.
    #[inline]
    fn stretched(&self, w: Vec3x8) -> f32x8 {
        let sin2 = w.x.mul_add(w.x, square(w.y));
        sin2.mul_add(self.alpha2, square(w.z)).sqrt()
    }

    /// Density of microfacet normals around `wo + wi`, not normalised.
    #[inline]
    fn facets(&self, wo: Vec3x8, wi: Vec3x8) -> f32x8 {
        let h = wo + wi;
        let sin2 = h.x.mul_add(h.x, square(h.y));
        let cos2 = square(h.z);
        // (|h|² / (hz² + (hx² + hy²)/α²))² / (π α²): neither a unit vector nor a tangent is needed.
        let ratio = (sin2 + cos2)
            / sin2
                .mul_add(self.inverse_alpha2, cos2)
                .fast_max(f32x8::splat(f32::MIN_POSITIVE));
        square(ratio) * self.peak
    }

    /// A microfacet normal seen from `wo`, unit.
    #[inline]
    fn visible_normal(&self, wo: Vec3x8, u: (f32x8, f32x8)) -> Vec3x8 {
        let w = Vec3x8::new(wo.x * self.alpha, wo.y * self.alpha, wo.z).normalize();
        // A point c of the cap z ≥ −wz; 1 − cz and cz + wz are written without a difference of near numbers.
        let height = f32x8::ONE + w.z;
        let below_pole = u.0 * height;
        let r = (below_pole * (f32x8::splat(2.0) - below_pole))
            .fast_max(f32x8::ZERO)
            .sqrt();
        let (sin, cos) = sin_cos_turns(u.1);
        Vec3x8::new(
            r.mul_add(cos, w.x) * self.alpha,
            r.mul_add(sin, w.y) * self.alpha,
            (f32x8::ONE - u.0) * height,
        )
        .normalize()
    }
}
