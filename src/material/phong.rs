//! The normalised modified Phong model.

use super::{Bsdf, EvalX8, Kind, ModulationX8, SampleX8};
use crate::lanes::{FrameX8, Rgb, Rgbx8, Row, Table, Vec3x8, f32x8, pow_one_minus, u32x8};
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// `diffuse / π + specular · (n + 2) / 2π · cosⁿα`, α between `wi` and the mirror direction of `wo`
/// (Lafortune & Willems 1994, "Using the Modified Phong Reflectance Model for Physically Based Rendering", sec. 3 and 4).
///
/// Directions come from a mixture of the cosine lobe and a cosⁿα lobe, chosen by luminance; what the second sends below
/// the surface has weight zero.
#[derive(Clone, Copy, Debug)]
pub struct Phong {
    diffuse: Rgbx8,
    specular: Rgbx8,
    exponent: f32x8,
    /// Probability of the specular lobe.
    choose_specular: f32x8,
}

impl Phong {
    /// The row of parameters.
    pub fn row(diffuse: Rgb, specular: Rgb, exponent: f32) -> Row {
        let both = diffuse.luminance() + specular.luminance();
        let choose_specular = if both > 0.0 {
            specular.luminance() / both
        } else {
            0.0
        };
        [
            diffuse.r,
            diffuse.g,
            diffuse.b,
            specular.r,
            specular.g,
            specular.b,
            exponent,
            choose_specular,
        ]
    }
}

/// The direction a mirror would reflect to.
#[inline]
fn mirrored(wo: Vec3x8) -> Vec3x8 {
    Vec3x8::new(-wo.x, -wo.y, wo.z)
}

impl Bsdf for Phong {
    const KIND: Kind = Kind::Phong;
    const SPECULAR: bool = false;
    const TRANSMISSIVE: bool = false;

    #[inline]
    fn load(table: &Table, ids: u32x8) -> Self {
        let [dr, dg, db, sr, sg, sb, exponent, choose_specular] = table.gather(ids);
        Self {
            diffuse: Rgbx8::new(dr, dg, db),
            specular: Rgbx8::new(sr, sg, sb),
            exponent,
            choose_specular,
        }
    }

    #[inline]
    fn modulate(self, by: &ModulationX8) -> Self {
        let diffuse = self.diffuse * by.color;
        let specular = self.specular.luminance();
        let both = diffuse.luminance() + specular;
        Self {
            diffuse,
            choose_specular: specular / both.fast_max(f32x8::splat(f32::MIN_POSITIVE)),
            ..self
        }
    }

    #[inline]
    fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> EvalX8 {
        let above = wi.z.simd_gt(f32x8::ZERO) & wo.z.simd_ge(f32x8::ZERO);
        // 1 − cos α = |wi − r|² / 2: a dot product near 1 has an error of 6e-8, which n = 10⁴ would raise to 6e-4.
        let one_minus_cos = (wi - mirrored(wo)).length_squared() * 0.5;
        let lobe = pow_one_minus(one_minus_cos, self.exponent) * (0.5 * FRAC_1_PI);
        let lobe = lobe & one_minus_cos.simd_lt(f32x8::ONE);

        let cosine = wi.z * FRAC_1_PI;
        let glossy = lobe * (self.exponent + f32x8::splat(2.0)) * wi.z;
        let density = lobe * (self.exponent + f32x8::ONE);
        let pdf = self
            .choose_specular
            .mul_add(density, (f32x8::ONE - self.choose_specular) * cosine);
        EvalX8 {
            value: self
                .diffuse
                .mul_add(cosine, self.specular * glossy)
                .masked(above),
            pdf: pdf & above,
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3x8, direction: (f32x8, f32x8), lobe: f32x8) -> SampleX8 {
        let specular = lobe.simd_lt(self.choose_specular);
        let around_mirror = FrameX8::new(mirrored(wo));
        let wi = Vec3x8::select(
            specular,
            around_mirror.to_world(warp::cosine_power(direction, self.exponent)),
            warp::cosine_hemisphere(direction),
        );
        let EvalX8 { value, pdf } = self.eval(wo, wi);
        let found = pdf.simd_gt(f32x8::ZERO);
        SampleX8 {
            wi,
            weight: (value * (f32x8::ONE / pdf)).masked(found),
            pdf,
        }
    }
}
