//! The recursion in the degree of the normalised Legendre functions over sinᵐθ, whose values are the basis without its azimuth.
//!
//! The modified forward column method of Holmes & Featherstone 2002 (see [`Basis`](super::Basis)).

use std::f64::consts::PI;

/// The first function of an order, that of degree `m`, over the first of the order before; of order 0 itself.
pub(super) fn first(m: usize) -> f64 {
    let twice = 2.0 * m as f64;
    // Functions of order 0 have no sqrt(2).
    let square = match m {
        0 => 0.25 / PI,
        1 => 3.0,
        _ => (twice + 1.0) / twice,
    };
    square.sqrt()
}

/// `[a, b]` of `Yₗ₊₁ₘ = a z Yₗₘ − b Yₗ₋₁ₘ`; `b` is 0 where `l` is `m`, for there is nothing below.
pub(super) fn step(l: usize, m: usize) -> [f64; 2] {
    let a = |next: usize| {
        let (l2, m2) = ((next * next) as f64, (m * m) as f64);
        ((4.0 * l2 - 1.0) / (l2 - m2)).sqrt()
    };
    match l == m {
        true => [a(l + 1), 0.0],
        false => [a(l + 1), a(l + 1) / a(l)],
    }
}
