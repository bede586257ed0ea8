//! Floor 1: spherical harmonics.
//!
//! Real and orthonormal, without the Condon–Shortley sign: `Y₁₋₁ ∝ y`, `Y₁₀ ∝ z`, `Y₁₁ ∝ x`. The coefficient of degree `l`
//! and order `m` stands at `l² + l + m`, so those up to degree `l` are the first `(l + 1)²`.

mod basis;
mod convolve;
mod legendre;
pub mod lobe;
mod low;
mod past_cache;
mod probe;
mod project;
mod published;
mod quadrature;
mod reconstruct;
mod rotate;
mod series;
mod shade;
mod table;

pub use basis::Basis;
pub use convolve::Lobe;
pub use probe::{CONVENTION, Document, GRID_FORMAT, Probe, is_csv};
pub use project::project;
pub use published::{NAMES as PUBLISHED, published};
pub use reconstruct::Window;
pub use rotate::rotated;
pub use series::Series;
pub use shade::Shading;

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
