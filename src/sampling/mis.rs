//! Multiple importance sampling.

use crate::lanes::{f32x8, square};

/// Weight of a sample, by the power heuristic with exponent 2 (Veach 1997, section 9.2.3): `ratio` is the density with which
/// the other strategy draws the same point over the density with which this one drew it.
#[inline]
pub fn power_heuristic(ratio: f32x8) -> f32x8 {
    // Of the ratio, not of the densities: their squares overflow, the ratio's only where the weight is 0.
    f32x8::ONE / (f32x8::ONE + square(ratio))
}
