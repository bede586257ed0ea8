//! The basis, eight directions at a time.

use super::{coefficients, index};
use crate::lanes::{Vec3x8, f32x8};

/// The basis functions up to a degree.
#[derive(Clone, Debug)]
pub struct Basis {
    degree: usize,
}

impl Basis {
    /// Those of degrees 0 to `degree`, at most [`MAX_DEGREE`](super::MAX_DEGREE).
    #[must_use]
    pub fn new(degree: usize) -> Self {
        Self { degree }
    }

    /// The greatest degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Their values at eight unit directions, in the order of [`index`]; `values` has [`coefficients`] of them.
    ///
    /// # Panics
    /// Where `values` is of another length.
    pub fn evaluate(&self, direction: &Vec3x8, values: &mut [f32x8]) {
        assert_eq!(values.len(), coefficients(self.degree));
        let Vec3x8 { x, y, z } = *direction;
        // Associated Legendre functions over sin^m θ, and cos mφ · sin^m θ, sin mφ · sin^m θ.
        let (mut cos, mut sin) = (f32x8::ONE, f32x8::ZERO);
        let mut diagonal = (0.25 / std::f64::consts::PI).sqrt();
        for m in 0..=self.degree {
            let (mut below, mut here) = (f32x8::ZERO, f32x8::splat(diagonal as f32));
            let mut before = 0.0;
            for l in m..=self.degree {
                if m == 0 {
                    values[index(l, 0)] = here;
                } else {
                    values[index(l, m as isize)] = here * cos;
                    values[index(l, -(m as isize))] = here * sin;
                }
                let (lf, mf) = ((l + 1) as f64, m as f64);
                let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
                let next =
                    z * here * f32x8::splat(a as f32) - below * f32x8::splat((a * before) as f32);
                before = 1.0 / a;
                (below, here) = (here, next);
            }
            let step = 2.0 * m as f64 + 3.0;
            diagonal *= (step / (step - 1.0)).sqrt();
            if m == 0 {
                diagonal *= std::f64::consts::SQRT_2;
            }
            (cos, sin) = (x * cos - y * sin, x * sin + y * cos);
        }
    }
}
