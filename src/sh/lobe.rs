//! Zonal coefficients of a lobe, in closed form.

use std::f64::consts::PI;

/// `f_l = ∫ (n + 1)/2 · max(cos θ, 0)ⁿ · Y_l0 dω` for degrees 0 to `degree`.
#[must_use]
pub fn lobe(exponent: f64, degree: usize) -> Vec<f64> {
    let (mut before, mut here) = (1.0, (exponent + 1.0) / (exponent + 2.0));
    (0..=degree)
        .map(|l| {
            let l = l as f64;
            let value = PI * ((2.0 * l + 1.0) / (4.0 * PI)).sqrt() * before;
            let next = before * (exponent - l) / (exponent + l + 3.0);
            (before, here) = (here, next);
            value
        })
        .collect()
}
