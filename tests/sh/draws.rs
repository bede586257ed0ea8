//! Random directions and coefficients, and how far lists of them are apart.

use crate::common::{Random, V, unit};
use ondine::sh::coefficients;

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
