//! Floor 1: spherical harmonics.
//!
//! Real and orthonormal, without the Condon–Shortley sign: `Y₁₋₁ ∝ y`, `Y₁₀ ∝ z`, `Y₁₁ ∝ x`. The coefficient of degree `l`
//! and order `m` stands at `l² + l + m`, so those up to degree `l` are the first `(l + 1)²`.

mod basis;
pub mod lobe;
mod low;

pub use basis::Basis;

/// The greatest degree that anything here takes.
pub const MAX_DEGREE: usize = 128;

/// Coefficients of degrees 0 to `degree`: `(degree + 1)²`.
#[must_use]
pub const fn coefficients(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// Where degree `l` and order `m` stand, −l ≤ m ≤ l.
#[must_use]
pub const fn index(l: usize, m: isize) -> usize {
    (l * l + l).wrapping_add_signed(m)
}
