//! The basis in double precision, one direction at a time.

use crate::common::{Random, V, unit};
use ondine::sh::{coefficients, index};
use std::f64::consts::PI;

/// `Y_lm` of degrees 0 to `degree` at a unit vector, by azimuth and Legendre functions with all of their normalisation.
pub fn basis(degree: usize, [x, y, z]: V) -> Vec<f64> {
    let (sin, azimuth) = (x.hypot(y), y.atan2(x));
    let mut values = vec![0.0; coefficients(degree)];
    for m in 0..=degree {
        // Q_mm = √((2m + 1)!! / (2m)!! / 4π) sin^m θ.
        let mut here = (1..=m).fold((0.25 / PI).sqrt(), |product, k| {
            let k = k as f64;
            product * sin * ((2.0 * k + 1.0) / (2.0 * k)).sqrt()
        });
        let mut below = 0.0;
        for l in m..=degree {
            let order = m as isize;
            let angle = m as f64 * azimuth;
            if m == 0 {
                values[index(l, 0)] = here;
            } else {
                values[index(l, order)] = 2f64.sqrt() * here * angle.cos();
                values[index(l, -order)] = 2f64.sqrt() * here * angle.sin();
            }
            // Of the degrees l + 1 and l − 1 of an order (Abramowitz & Stegun 8.5.3, normalised).
            let factor = |l: f64| {
                let m = m as f64;
                ((l - m) * (l + m) / ((2.0 * l - 1.0) * (2.0 * l + 1.0))).sqrt()
            };
            let next = (z * here - factor(l as f64) * below) / factor(l as f64 + 1.0);
            (below, here) = (here, next);
        }
    }
    values
}

/// `Σ c Y` at a unit vector.
pub fn sum(coefficients: &[[f64; 3]], direction: V) -> [f64; 3] {
    let degree = coefficients.len().isqrt() - 1;
    let values = basis(degree, direction);
    std::array::from_fn(|channel| {
        let terms = coefficients.iter().zip(&values);
        terms.map(|(rgb, value)| rgb[channel] * value).sum()
    })
}

/// A uniformly distributed unit vector.
pub fn direction(random: &mut Random) -> V {
    loop {
        let v: V = std::array::from_fn(|_| 2.0 * f64::from(random.one()) - 1.0);
        let square: f64 = v.iter().map(|c| c * c).sum();
        if (1e-3..=1.0).contains(&square) {
            return unit(v);
        }
    }
}

/// Coefficients uniform in [−1, 1].
pub fn random_coefficients(random: &mut Random, degree: usize) -> Vec<[f64; 3]> {
    let one = |random: &mut Random| 2.0 * f64::from(random.one()) - 1.0;
    (0..coefficients(degree))
        .map(|_| std::array::from_fn(|_| one(random)))
        .collect()
}

/// The greatest difference of two lists.
pub fn difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}
