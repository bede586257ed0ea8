//! Shading by the double sum: `Σ_l √(4π/(2l + 1)) f_l Σ_m L_lm Y_lm(d)`.

use super::{Lobe, Probe, Series};
use crate::error::Result;
use crate::lanes::{Rgb, Rgbx8, Vec3x8, f32x8};
use std::f64::consts::FRAC_1_PI;

/// A surface under distant light that nothing stands in the way of (Ramamoorthi & Hanrahan 2001, sec. 3; 2002, "Frequency Space
/// Environment Map Rendering", for the mirror direction).
#[derive(Clone, Debug)]
pub struct Shading {
    series: Series,
    is_glossy: bool,
}

impl Shading {
    /// A surface that reflects by a lobe, with this albedo: by the cosine, it is Lambertian, and sends out albedo/π times the
    /// irradiance; by a Phong lobe about the mirror direction, whose integral is 1, it sends out albedo times the mean of the
    /// light under the lobe. The cosine to the normal is not in it, nor does the lobe end at the horizon.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::error::Error::Usage) where the light is not radiance.
    pub fn new(light: &Probe, lobe: Lobe, albedo: Rgb) -> Result<Self> {
        let scale = match lobe {
            Lobe::Cosine => FRAC_1_PI,
            Lobe::Phong(_) => 1.0,
        };
        let albedo = albedo.to_array().map(|albedo| scale * f64::from(albedo));
        let reflected = light.convolved(lobe)?;
        let scaled = |rgb: &[f64; 3]| std::array::from_fn(|c| albedo[c] * rgb[c]);
        let coefficients: Vec<[f64; 3]> = reflected.coefficients.iter().map(scaled).collect();
        Ok(Self {
            series: Series::new(reflected.degree, &coefficients),
            is_glossy: matches!(lobe, Lobe::Phong(_)),
        })
    }

    /// Radiance that leaves eight points, W·sr⁻¹·m⁻². Both vectors are unit and of world space: the normal, and the way to who
    /// looks, which a Lambertian surface does not ask for. It may be negative where the light's series is.
    #[inline]
    #[must_use]
    pub fn shade(&self, normal: Vec3x8, outgoing: Vec3x8) -> Rgbx8 {
        let direction = match self.is_glossy {
            true => (normal * (normal.dot(outgoing) * f32x8::splat(2.0)) - outgoing).renormalize(),
            false => normal,
        };
        self.series.evaluate(direction)
    }
}
