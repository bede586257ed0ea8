//! Gauss–Legendre quadrature.

use std::f64::consts::PI;

/// Nodes and weights on [−1, 1] of the rule that is exact for polynomials of degree 2n − 1, by Newton's method.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..100 {
                let (value, below) = legendre(n, x);
                slope = n as f64 * (x * value - below) / (x * x - 1.0);
                let step = value / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Legendre polynomials of degrees `n` and `n − 1`.
pub fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut here, mut below) = (1.0, 0.0);
    for l in 0..n {
        let l = l as f64;
        (here, below) = (((2.0 * l + 1.0) * x * here - l * below) / (l + 1.0), here);
    }
    (here, below)
}
