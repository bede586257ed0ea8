//! Ideal diffuse reflection.

use super::{Bsdf, EvalX8, Kind, ModulationX8, SampleX8};
use crate::lanes::{Rgb, Rgbx8, Row, Table, Vec3x8, f32x8, u32x8};
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// `albedo / π`, drawn proportionally to the cosine.
#[derive(Clone, Copy, Debug)]
pub struct Lambert {
    albedo: Rgbx8,
}

impl Lambert {
    /// The row of parameters.
    pub fn row(albedo: Rgb) -> Row {
        [albedo.r, albedo.g, albedo.b, 0.0, 0.0, 0.0, 0.0, 0.0]
    }
}

impl Bsdf for Lambert {
    const KIND: Kind = Kind::Lambert;
    const SPECULAR: bool = false;
    const TRANSMISSIVE: bool = false;

    #[inline]
    fn load(table: &Table, ids: u32x8) -> Self {
        let [r, g, b, ..] = table.gather(ids);
        Self {
            albedo: Rgbx8::new(r, g, b),
        }
    }

    #[inline]
    fn modulate(self, by: &ModulationX8) -> Self {
        Self {
            albedo: self.albedo * by.color,
        }
    }

    #[inline]
    fn eval(&self, _wo: Vec3x8, wi: Vec3x8) -> EvalX8 {
        let pdf = wi.z.fast_max(f32x8::ZERO) * FRAC_1_PI;
        EvalX8 {
            value: self.albedo * pdf,
            pdf,
        }
    }

    #[inline]
    fn sample(&self, _wo: Vec3x8, direction: (f32x8, f32x8), _lobe: f32x8) -> SampleX8 {
        let wi = warp::cosine_hemisphere(direction);
        SampleX8 {
            wi,
            weight: self.albedo,
            pdf: wi.z * FRAC_1_PI,
        }
    }
}
