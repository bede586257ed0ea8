//! Multiple importance sampling.

use crate::lanes::{f32x8, square};

/// Weight of a sample drawn with density `pdf` when another strategy draws the same point with density `other`, by the
/// power heuristic with exponent 2 (Veach 1997, section 9.2.3). 1 where `pdf` is +∞, a discrete choice.
#[inline]
pub fn power_heuristic(pdf: f32x8, other: f32x8) -> f32x8 {
    // As a ratio: the squares of densities overflow, the square of their ratio only where the weight is 0.
    f32x8::ONE / (f32x8::ONE + square(other / pdf))
}
