//! A smooth dielectric.

use super::{Bsdf, EvalX8, Kind, ModulationX8, SampleX8};
use crate::lanes::{Rgbx8, Row, Table, Vec3x8, f32x8, safe_sqrt, square, u32x8};

/// Fresnel reflection and refraction at a smooth interface, of unpolarised light
/// (Pharr, Jakob & Humphreys, PBR 4th ed., sec. 9.3.5 and 9.5.2).
///
/// Radiance is transported, so what is refracted is scaled by (ηi/ηt)²: sec. 9.5.2, "non-symmetric scattering".
#[derive(Clone, Copy, Debug)]
pub struct Glass {
    from_outside: Interface,
    from_inside: Interface,
}

/// Crossing the interface in one sense.
#[derive(Clone, Copy, Debug)]
struct Interface {
    /// Index of refraction on the side of wo over that on the other side.
    eta: f32x8,
    /// η².
    eta2: f32x8,
    /// 1 − η², rounded once: near ior = 1 a subtraction of rounded squares would lose it.
    gap: f32x8,
}

impl Interface {
    fn fields(eta: f64) -> [f32; 3] {
        [
            eta as f32,
            (eta * eta) as f32,
            ((1.0 - eta) * (1.0 + eta)) as f32,
        ]
    }

    #[inline]
    fn select(mask: f32x8, on: &Self, off: &Self) -> Self {
        Self {
            eta: mask.select(on.eta, off.eta),
            eta2: mask.select(on.eta2, off.eta2),
            gap: mask.select(on.gap, off.gap),
        }
    }

    /// cos²θt by Snell's law; not positive where reflection is total. No cancellation unless η > 1.
    #[inline]
    fn cos2_refracted(&self, cos_i: f32x8) -> f32x8 {
        self.eta2.mul_add(square(cos_i), self.gap)
    }

    /// The fraction of unpolarised light that is reflected, where reflection is not total.
    ///
    /// `(η ci − ct) / (η ci + ct) = (η² − 1) / (η ci + ct)²`, and likewise for the other polarisation: with cos²θt put in
    /// by Snell's law no difference of near numbers is left, and F is exactly 0 for η = 1.
    #[inline]
    fn fresnel(&self, cos_i: f32x8, cos_t: f32x8) -> f32x8 {
        let tiny = f32x8::splat(f32::MIN_POSITIVE);
        let senkrecht = self.gap / square(self.eta.mul_add(cos_i, cos_t)).fast_max(tiny);
        // (1 − η²) · ((1 + η²) ci² − η²) / (ci + η ct)²
        let brewster = (f32x8::ONE + self.eta2).mul_sub(square(cos_i), self.eta2);
        let parallel = self.gap * brewster / square(self.eta.mul_add(cos_t, cos_i)).fast_max(tiny);
        (square(senkrecht).mul_add(f32x8::HALF, square(parallel) * 0.5)).fast_min(f32x8::ONE)
    }
}

impl Glass {
    /// The row of parameters; `ior` is the index of refraction inside over outside.
    pub fn row(ior: f32) -> Row {
        let [a, b, c] = Interface::fields(1.0 / f64::from(ior));
        let [d, e, f] = Interface::fields(f64::from(ior));
        [a, b, c, d, e, f, 0.0, 0.0]
    }
}

impl Bsdf for Glass {
    const KIND: Kind = Kind::Glass;
    const SPECULAR: bool = true;
    const TRANSMISSIVE: bool = true;

    #[inline]
    fn load(table: &Table, ids: u32x8) -> Self {
        let [a, b, c, d, e, f, ..] = table.gather(ids);
        Self {
            from_outside: Interface {
                eta: a,
                eta2: b,
                gap: c,
            },
            from_inside: Interface {
                eta: d,
                eta2: e,
                gap: f,
            },
        }
    }

    #[inline]
    fn modulate(self, _by: &ModulationX8) -> Self {
        self
    }

    #[inline]
    fn eval(&self, _wo: Vec3x8, _wi: Vec3x8) -> EvalX8 {
        EvalX8::NONE
    }

    /// Reflects where `lobe` is below the Fresnel reflectance, so that the weight of a reflection is 1.
    #[inline]
    fn sample(&self, wo: Vec3x8, _direction: (f32x8, f32x8), lobe: f32x8) -> SampleX8 {
        let inside = wo.z.simd_lt(f32x8::ZERO);
        let side = Interface::select(inside, &self.from_inside, &self.from_outside);
        let cos_i = wo.z.abs();
        let cos2_t = side.cos2_refracted(cos_i);
        let cos_t = safe_sqrt(cos2_t);
        let total = cos2_t.simd_le(f32x8::ZERO);
        let reflects = total | lobe.simd_lt(side.fresnel(cos_i, cos_t));

        let reflected = Vec3x8::new(-wo.x, -wo.y, wo.z);
        let away = inside.select(cos_t, -cos_t);
        let refracted = Vec3x8::new(-(side.eta * wo.x), -(side.eta * wo.y), away);
        SampleX8 {
            wi: Vec3x8::select(reflects, reflected, refracted),
            weight: Rgbx8::gray(reflects.select(f32x8::ONE, side.eta2)),
            pdf: f32x8::splat(f32::INFINITY),
        }
    }
}
