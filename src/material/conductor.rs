//! A rough conductor.

use super::ggx::Ggx;
use super::{Bsdf, EvalX8, Kind, ModulationX8, SampleX8};
use crate::lanes::{Rgb, Rgbx8, Row, Table, Vec3x8, f32x8, u32x8};

/// A GGX microsurface with a constant Fresnel reflectance, drawn from the normals that are seen.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    reflectance: Rgbx8,
    ggx: Ggx,
}

impl Conductor {
    /// The row of parameters; `alpha` is the GGX roughness, not squared, and at least 10⁻⁴ is used.
    pub fn row(alpha: f32, reflectance: Rgb) -> Row {
        let [alpha, alpha2, inverse_alpha2, peak] = Ggx::row(alpha);
        [
            reflectance.r,
            reflectance.g,
            reflectance.b,
            alpha,
            alpha2,
            inverse_alpha2,
            peak,
            0.0,
        ]
    }
}

impl Bsdf for Conductor {
    const KIND: Kind = Kind::Conductor;
    const SPECULAR: bool = false;
    const TRANSMISSIVE: bool = false;

    #[inline]
    fn load(table: &Table, ids: u32x8) -> Self {
        let [r, g, b, alpha, alpha2, inverse_alpha2, peak, _] = table.gather(ids);
        Self {
            reflectance: Rgbx8::new(r, g, b),
            ggx: Ggx::load([alpha, alpha2, inverse_alpha2, peak]),
        }
    }

    #[inline]
    fn modulate(self, by: &ModulationX8) -> Self {
        Self {
            reflectance: self.reflectance * by.color,
            ..self
        }
    }

    #[inline]
    fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> EvalX8 {
        let (value, pdf) = self.ggx.eval(wo, wi);
        EvalX8 {
            value: self.reflectance * value,
            pdf,
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3x8, direction: (f32x8, f32x8), _lobe: f32x8) -> SampleX8 {
        let wi = self.ggx.sample(wo, direction);
        let (_, pdf) = self.ggx.eval(wo, wi);
        let found = pdf.simd_gt(f32x8::ZERO);
        SampleX8 {
            wi,
            weight: (self.reflectance * self.ggx.weight(wo, wi)).masked(found),
            pdf,
        }
    }
}
