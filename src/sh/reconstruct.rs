//! Back from coefficients to a lat-long image.

use super::{Probe, Series};
use crate::error::Error;
use crate::lanes::{Rgb, Vec3x8, WIDTH, f32x8};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// How much of each degree is kept, against the ringing of what was cut off sharply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// All of it.
    #[default]
    None,
    /// `(1 + cos πl/(L + 1))/2`.
    Hanning,
    /// `sin x/x` for `x = πl/(L + 1)`, Lanczos' sigma factors: less blur, more ringing than Hanning.
    Lanczos,
}

impl Window {
    /// Each choice and its name.
    pub const NAMES: [(&str, Self); 3] = [
        ("none", Self::None),
        ("hanning", Self::Hanning),
        ("lanczos", Self::Lanczos),
    ];

    /// The factor of degree `l` where `degree` is the greatest (Sloan 2008, "Stupid Spherical Harmonics Tricks", "Ringing").
    #[must_use]
    pub fn factor(self, l: usize, degree: usize) -> f64 {
        let x = PI * l as f64 / (degree + 1) as f64;
        match self {
            Self::Hanning => 0.5 * (1.0 + libm::cos(x)),
            Self::Lanczos if l > 0 => libm::sin(x) / x,
            Self::None | Self::Lanczos => 1.0,
        }
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(_, window)| window == self);
        f.pad(name.map_or("", |(name, _)| name))
    }
}

impl FromStr for Window {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let window = Self::NAMES.iter().find(|(name, _)| *name == text);
        window.map(|(_, window)| *window).ok_or_else(|| {
            Error::Usage(format!(
                "{text:?} is no window; write none, hanning or lanczos"
            ))
        })
    }
}

impl Probe {
    /// Each degree times its factor of a window.
    #[must_use]
    pub fn windowed(&self, window: Window) -> Self {
        self.scaled(|l| window.factor(l, self.degree))
    }

    /// A lat-long image of `2 · height` × `height` pixels, row after row: the sum in the middle of each pixel, in the directions
    /// that [`project`](super::project()) takes it from. It may be negative.
    ///
    /// The threads are those of the current rayon pool; they change no bit.
    #[must_use]
    pub fn reconstruct(&self, height: usize) -> Vec<Rgb> {
        let width = 2 * height;
        let series = Series::new(self.degree, &self.coefficients);
        let middles: Vec<(f32, f32)> = (0..width)
            .map(|x| libm::sincos(2.0 * PI * (x as f64 + 0.5) / width as f64))
            .map(|(sin, cos)| (sin as f32, cos as f32))
            .collect();
        let mut image = vec![Rgb::BLACK; width * height];
        image
            .par_chunks_mut(width.max(1))
            .enumerate()
            .for_each(|(y, row)| {
                let (sin, cos) = libm::sincos(PI * (y as f64 + 0.5) / height as f64);
                let (sin, cos) = (f32x8::splat(sin as f32), f32x8::splat(cos as f32));
                for (pixels, middles) in row.chunks_mut(WIDTH).zip(middles.chunks(WIDTH)) {
                    let middle = |lane: usize| middles.get(lane).copied().unwrap_or_default();
                    let sin_phi = f32x8::new(std::array::from_fn(|lane| middle(lane).0));
                    let cos_phi = f32x8::new(std::array::from_fn(|lane| middle(lane).1));
                    let sum = series.evaluate(Vec3x8::new(sin * sin_phi, cos, -(sin * cos_phi)));
                    for (lane, pixel) in pixels.iter_mut().enumerate() {
                        *pixel = sum.lane(lane);
                    }
                }
            });
        image
    }
}
