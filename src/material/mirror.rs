//! Perfect specular reflection.

use super::{Bsdf, EvalX8, Kind, ModulationX8, SampleX8};
use crate::lanes::{Rgb, Rgbx8, Row, Table, Vec3x8, f32x8, u32x8};

/// `reflectance · δ(wi − reflected wo) / |cos θi|` (Pharr, Jakob & Humphreys, PBR 4th ed., sec. 9.3).
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    reflectance: Rgbx8,
}

impl Mirror {
    /// The row of parameters.
    pub fn row(reflectance: Rgb) -> Row {
        [
            reflectance.r,
            reflectance.g,
            reflectance.b,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        ]
    }
}

impl Bsdf for Mirror {
    const KIND: Kind = Kind::Mirror;
    const SPECULAR: bool = true;
    const TRANSMISSIVE: bool = false;

    #[inline]
    fn load(table: &Table, ids: u32x8) -> Self {
        let [r, g, b, ..] = table.gather(ids);
        Self {
            reflectance: Rgbx8::new(r, g, b),
        }
    }

    #[inline]
    fn modulate(self, by: &ModulationX8) -> Self {
        Self {
            reflectance: self.reflectance * by.color,
        }
    }

    #[inline]
    fn eval(&self, _wo: Vec3x8, _wi: Vec3x8) -> EvalX8 {
        EvalX8::NONE
    }

    #[inline]
    fn sample(&self, wo: Vec3x8, _direction: (f32x8, f32x8), _lobe: f32x8) -> SampleX8 {
        SampleX8 {
            wi: Vec3x8::new(-wo.x, -wo.y, wo.z),
            weight: self.reflectance,
            pdf: f32x8::splat(f32::INFINITY),
        }
    }
}
