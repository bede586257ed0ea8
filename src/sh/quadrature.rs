//! Gauss–Legendre quadrature.

use std::f64::consts::PI;

/// Nodes that integrate `cos kx` over an interval of half width `h` to 10⁻¹⁷ of it, for `angle` = kh: the rule's error is at
/// most `2²ⁿ⁺¹ (n!)⁴ / ((2n + 1) (2n)!³) · (kh)²ⁿ` (Davis & Rabinowitz, Methods of Numerical Integration, sec. 2.7).
pub(super) fn nodes_for(angle: f64) -> usize {
    let (mut count, mut error) = (0, 2.0);
    while error > 1e-17 {
        let n = f64::from(count);
        let pair = (2.0 * n + 1.0) * (2.0 * n + 2.0);
        error *= 4.0 * (n + 1.0).powi(4) * (2.0 * n + 1.0) / ((2.0 * n + 3.0) * pair.powi(3))
            * angle
            * angle;
        count += 1;
    }
    count as usize
}

/// Nodes and weights of `count` points over [−1, 1], by Newton's method.
pub(super) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let rule = (0..count).map(|i| {
        let mut x = libm::cos(PI * (i as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        // It converges from this guess in four steps or less; the last leaves rounding alone.
        for _ in 0..6 {
            let (mut below, mut here) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                let next = ((2.0 * k - 1.0) * x * here - (k - 1.0) * below) / k;
                (below, here) = (here, next);
            }
            slope = n * (x * here - below) / (x * x - 1.0);
            x -= here / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    });
    rule.collect()
}
