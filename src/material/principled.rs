//! The metallic-roughness model of glTF.

use super::ggx::{Ggx, MIN_ALPHA};
use super::{Bsdf, EvalX8, Kind, ModulationX8, SampleX8};
use crate::lanes::{Rgb, Rgbx8, Row, Table, Vec3x8, f32x8, square, u32x8};
use crate::sampling::warp;
use std::f32::consts::FRAC_1_PI;

/// A dielectric (a diffuse base under a GGX coat) and a GGX metal, mixed by `metallic` (glTF 2.0, appendix B.2 and B.3), with
/// Schlick's Fresnel reflectance.
///
/// glTF's example lets `1 − F` of the half-vector through to the base: at grazing angles that adds up to almost twice the
/// light there is. Here what goes in and out of the base is what the coat leaves over, `1 − E` of both directions, as in
/// Shirley et al. 1997, "A Practitioners' Assessment of Light Reflection Models", sec. 5, and Kelemen & Szirmay-Kalos 2001,
/// "A Microfacet Based Coupled Specular-Matte BRDF Model", sec. 2: reciprocal, and never more light than there is.
///
/// A mixture of both lobes is drawn, chosen by the light that each reflects from `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Principled {
    base_color: Rgbx8,
    metallic: f32x8,
    roughness: f32x8,
    /// Reflectance of the coat along its normal and, by Schlick, at grazing angles.
    coat: [f32x8; 2],
}

impl Principled {
    /// The row of parameters, as in [`Material::Principled`](super::Material::Principled).
    pub fn row(base_color: Rgb, metallic: f32, roughness: f32, ior: f32) -> Row {
        let ior = f64::from(ior);
        let normal = ((ior - 1.0) / (ior + 1.0)).powi(2);
        // Less than 2 % is of no known solid: towards an index of 1, where nothing reflects, grazing angles fade out too
        // (Lagarde & de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", sec. 3.1.3).
        let grazing = (50.0 * normal).min(1.0);
        [
            base_color.r,
            base_color.g,
            base_color.b,
            metallic,
            roughness,
            normal as f32,
            grazing as f32,
            0.0,
        ]
    }

    /// What both lobes are to light that goes to `wo`.
    #[inline]
    fn lobes(&self, wo: Vec3x8) -> Lobes {
        let alpha = square(self.roughness).fast_max(f32x8::splat(MIN_ALPHA));
        let dielectric = f32x8::ONE - self.metallic;
        let [normal, grazing] = self.coat.map(|reflectance| reflectance * dielectric);
        let normal = self.base_color.mul_add(self.metallic, Rgbx8::gray(normal));
        let grazing = grazing + self.metallic;

        let bound = SchlickBound::new(alpha);
        let coat = Coat {
            through: f32x8::ONE - self.coat[0],
            fade: self.coat[1] - self.coat[0],
            bound,
        };
        let through = coat.transmitted(wo.z);
        let base_color = self.base_color * dielectric;

        let tiny = f32x8::splat(f32::MIN_POSITIVE);
        let along = normal.luminance();
        let specular = (grazing - along).mul_add(bound.at(wo.z), along);
        let both = base_color.luminance().mul_add(through, specular);
        Lobes {
            ggx: Ggx::new(alpha),
            normal,
            grazing,
            base: base_color * (through / coat.mean_transmitted().fast_max(tiny)),
            coat,
            choose_specular: specular / both.fast_max(tiny),
        }
    }
}

/// The lobes of the light that goes to one direction.
struct Lobes {
    ggx: Ggx,
    /// Specular reflectance along a facet's normal.
    normal: Rgbx8,
    /// Specular reflectance at grazing angles.
    grazing: f32x8,
    /// Albedo of the base, times what the coat lets through to `wo`, over what it lets through on average.
    base: Rgbx8,
    coat: Coat,
    /// Probability of the specular lobe.
    choose_specular: f32x8,
}

impl Lobes {
    #[inline]
    fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> EvalX8 {
        let above = wo.z.simd_gt(f32x8::ZERO) & wi.z.simd_gt(f32x8::ZERO);
        let (facets, density) = self.ggx.eval(wo, wi);
        // cos² = (1 + wo·wi) / 2 = |wo + wi|² / 4, between either direction and the half-vector.
        let cos = (wo + wi).length_squared().sqrt() * 0.5;
        let rest = (f32x8::ONE - cos).fast_max(f32x8::ZERO);
        let schlick = square(square(rest)) * rest;
        // normal + (grazing − normal) · (1 − cos)⁵
        let fresnel = self
            .normal
            .mul_add(f32x8::ONE - schlick, Rgbx8::gray(self.grazing * schlick));

        let cosine = (wi.z * FRAC_1_PI) & above;
        let through = self.coat.transmitted(wi.z);
        let pdf = self
            .choose_specular
            .mul_add(density, (f32x8::ONE - self.choose_specular) * cosine);
        EvalX8 {
            value: self.base.mul_add(through * cosine, fresnel * facets),
            pdf,
        }
    }
}

/// The coat of the dielectric.
#[derive(Clone, Copy)]
struct Coat {
    /// 1 − reflectance along the normal.
    through: f32x8,
    /// Reflectance at grazing angles − reflectance along the normal.
    fade: f32x8,
    bound: SchlickBound,
}

impl Coat {
    /// At most the part of the light from a direction that the coat does not reflect.
    #[inline]
    fn transmitted(&self, cos: f32x8) -> f32x8 {
        self.fade
            .mul_neg_add(self.bound.at(cos), self.through)
            .fast_max(f32x8::ZERO)
    }

    /// The mean of [`Coat::transmitted`] over the hemisphere, by the cosine.
    #[inline]
    fn mean_transmitted(&self) -> f32x8 {
        self.fade.mul_neg_add(self.bound.mean(), self.through)
    }
}

/// An upper bound of the light that a GGX surface with a reflectance of `(1 − cos)⁵` reflects from a direction:
/// `c + a x³ + b x⁵`, `x = 1 − cos θ`.
///
/// Fitted here, in the form of a polynomial of α over another, to 1776 quadratures, as a linear program: nowhere below
/// them; at most 0.05 above them where θ is up to 82°, and up to 0.19 beyond.
#[derive(Clone, Copy)]
struct SchlickBound {
    constant: f32x8,
    cubic: f32x8,
    quintic: f32x8,
}

impl SchlickBound {
    #[inline]
    fn new(alpha: f32x8) -> Self {
        let linear =
            |slope: f32, at_zero: f32| alpha.mul_add(f32x8::splat(slope), f32x8::splat(at_zero));
        let scale = f32x8::ONE / alpha.mul_add(linear(20.0, 6.0), f32x8::ONE);
        Self {
            constant: alpha * scale * 0.01,
            cubic: linear(1.2, 0.23) * scale,
            quintic: linear(-0.92, 0.77) * scale,
        }
    }

    #[inline]
    fn at(&self, cos: f32x8) -> f32x8 {
        let x = f32x8::ONE - cos;
        let x2 = square(x);
        self.quintic
            .mul_add(x2, self.cubic)
            .mul_add(x2 * x, self.constant)
    }

    /// The mean over the hemisphere, by the cosine: `∫ f(x) 2 (1 − x) dx`.
    #[inline]
    fn mean(&self) -> f32x8 {
        self.quintic.mul_add(
            f32x8::splat(1.0 / 21.0),
            self.cubic.mul_add(f32x8::splat(0.1), self.constant),
        )
    }
}

impl Bsdf for Principled {
    const KIND: Kind = Kind::Principled;
    const SPECULAR: bool = false;
    const TRANSMISSIVE: bool = false;

    #[inline]
    fn load(table: &Table, ids: u32x8) -> Self {
        let [r, g, b, metallic, roughness, normal, grazing, _] = table.gather(ids);
        Self {
            base_color: Rgbx8::new(r, g, b),
            metallic,
            roughness,
            coat: [normal, grazing],
        }
    }

    #[inline]
    fn modulate(self, by: &ModulationX8) -> Self {
        Self {
            base_color: self.base_color * by.color,
            metallic: self.metallic * by.metallic,
            roughness: self.roughness * by.roughness,
            ..self
        }
    }

    #[inline]
    fn eval(&self, wo: Vec3x8, wi: Vec3x8) -> EvalX8 {
        self.lobes(wo).eval(wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3x8, direction: (f32x8, f32x8), lobe: f32x8) -> SampleX8 {
        let lobes = self.lobes(wo);
        let wi = Vec3x8::select(
            lobe.simd_lt(lobes.choose_specular),
            lobes.ggx.sample(wo, direction),
            warp::cosine_hemisphere(direction),
        );
        let EvalX8 { value, pdf } = lobes.eval(wo, wi);
        let found = pdf.simd_gt(f32x8::ZERO);
        SampleX8 {
            wi,
            weight: (value * (f32x8::ONE / pdf)).masked(found),
            pdf,
        }
    }
}
