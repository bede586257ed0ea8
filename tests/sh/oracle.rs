//! The real basis in double precision, the textbook way.

use crate::common::V;
use ondine::sh::index;
use std::f64::consts::PI;

/// Yₗₘ of a unit direction: associated Legendre functions by their recursion in l, no Condon–Shortley sign (Sloan 2008,
/// "Stupid Spherical Harmonics Tricks", appendix A1).
pub fn basis(degree: usize, [x, y, z]: V) -> Vec<f64> {
    let phi = libm::atan2(y, x);
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let mut values = vec![0.0; (degree + 1) * (degree + 1)];
    for m in 0..=degree {
        // (2m − 1)!! sinᵐ, with the factorials of the normalisation taken in as they come.
        let mut pmm = (0.25 / PI).sqrt();
        for k in 1..=m {
            pmm *= sin * ((2 * k + 1) as f64 / (2 * k) as f64).sqrt();
        }
        let (mut below, mut here) = (0.0, pmm);
        for l in m..=degree {
            if l > m {
                let (lf, mf) = (l as f64, m as f64);
                let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
                let k = lf - 1.0;
                let b = if l > m + 1 {
                    ((k * k - mf * mf) / (4.0 * k * k - 1.0)).sqrt()
                } else {
                    0.0
                };
                (below, here) = (here, a * (z * here - b * below));
            }
            let angle = m as f64 * phi;
            let root = std::f64::consts::SQRT_2;
            if m == 0 {
                values[index(l, 0)] = here;
            } else {
                values[index(l, m as isize)] = root * here * angle.cos();
                values[index(l, -(m as isize))] = root * here * angle.sin();
            }
        }
    }
    values
}

/// Σ c Y.
pub fn sum(coefficients: &[[f64; 3]], d: V) -> [f64; 3] {
    let degree = coefficients.len().isqrt() - 1;
    let mut total = [0.0; 3];
    for (c, y) in coefficients.iter().zip(basis(degree, d)) {
        (0..3).for_each(|i| total[i] += c[i] * y);
    }
    total
}
