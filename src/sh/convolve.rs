//! Convolution with a lobe: what a surface reflects of the light around it.

use super::Probe;
use crate::error::Error;
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// A lobe, symmetric about a direction `d`, that light is weighted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe {
    /// `max(cos, 0)` about a normal: radiance becomes irradiance, W·m⁻². A Lambertian surface reflects albedo/π of it.
    Cosine,
    /// `(n + 1)/2π · max(cos, 0)ⁿ` about a mirror direction, whose integral is 1: radiance becomes the radiance that a white
    /// Phong lobe of exponent `n` reflects.
    Phong(f64),
}

/// The greatest exponent of a Phong lobe.
const GREATEST: f64 = 1e6;

impl Lobe {
    /// What each degree of the light is multiplied with, `√(4π/(2l + 1)) · f_l` of the lobe's zonal coefficients (Ramamoorthi
    /// & Hanrahan 2001, "On the relationship between radiance and irradiance", eq. 19, their Λ_l Â_l).
    #[must_use]
    pub fn factors(self, degree: usize) -> Vec<f64> {
        let (exponent, scale) = match self {
            Self::Cosine => (1.0, 1.0),
            Self::Phong(exponent) => (exponent, 1.0 / PI),
        };
        let zonal = super::lobe::phong(exponent, degree);
        let each = zonal.iter().enumerate();
        each.map(|(l, f)| scale * (4.0 * PI / (2.0 * l as f64 + 1.0)).sqrt() * f)
            .collect()
    }

    /// The name of a surface that reflects by it: `lambert` or `phong:N`.
    #[must_use]
    pub fn surface(self) -> String {
        match self {
            Self::Cosine => "lambert".to_owned(),
            Self::Phong(_) => self.to_string(),
        }
    }
}

impl fmt::Display for Lobe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cosine => f.write_str("cosine"),
            Self::Phong(exponent) => write!(f, "phong:{exponent}"),
        }
    }
}

impl FromStr for Lobe {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        if matches!(text, "cosine" | "lambert") {
            return Ok(Self::Cosine);
        }
        text.strip_prefix("phong:")
            .and_then(|exponent| exponent.parse().ok())
            .filter(|exponent| (0.0..=GREATEST).contains(exponent))
            .map(Self::Phong)
            .ok_or_else(|| {
                Error::Usage(format!(
                    "{text:?} is no lobe; write cosine, or phong:N with an exponent N from 0 to {GREATEST}"
                ))
            })
    }
}

impl Probe {
    /// The light convolved with a lobe: of radiance by direction, what is reflected by the lobe's axis. Errors are scaled with
    /// it.
    ///
    /// # Errors
    /// [`Error::Usage`] where it was convolved before.
    pub fn convolved(&self, lobe: Lobe) -> Result<Self, Error> {
        if let Some(before) = self.lobe {
            return Err(Error::Usage(format!(
                "the coefficients are those of light convolved with {before}, and cannot be convolved again; use those of radiance"
            )));
        }
        let factors = lobe.factors(self.degree);
        Ok(Self {
            lobe: Some(lobe),
            ..self.scaled(|l| factors[l])
        })
    }

    /// Each degree times a factor, and its errors with it.
    pub(super) fn scaled(&self, factor: impl Fn(usize) -> f64) -> Self {
        let scale = |list: &[[f64; 3]], sign: fn(f64) -> f64| {
            let each = list.iter().zip(super::probe::orders());
            each.map(|(rgb, (l, _))| rgb.map(|value| value * sign(factor(l))))
                .collect()
        };
        Self {
            coefficients: scale(&self.coefficients, |factor| factor),
            standard_errors: self
                .standard_errors
                .as_deref()
                .map(|errors| scale(errors, f64::abs)),
            ..self.clone()
        }
    }
}
