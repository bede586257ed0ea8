//! Lobes around z: exact coefficients, and estimates of them.
//!
//! Such a function has coefficients of order 0 alone. That of the degrees 0, 1, 2 … is all there is.

use crate::lanes::{WIDTH, f32x8};
use std::f64::consts::PI;

/// The coefficients of the normalised Phong lobe `(n + 1) / 2 · max(cos θ, 0)ⁿ` for degrees 0 to `degree`; the exponent `n` is
/// any number from 0. Exponent 1 is the clamped cosine; whatever the exponent, that of degree 0 is √π / 2.
///
/// Integrals of `tⁿ · P_l(t)` over [0, 1] are products, by
/// `I_l = I_(l−2) · (n − l + 2) / (n + l + 1)`, `I_0 = 1 / (n + 1)`, `I_1 = 1 / (n + 2)` (Gradshteyn & Ryzhik, 7.126.1): nothing
/// cancels, so each is within 10⁻¹³ of itself. Where `n` is a whole number, those of degree n + 2, n + 4 … are exactly 0.
#[must_use]
pub fn phong(exponent: f64, degree: usize) -> Vec<f64> {
    // (n + 1) / 2 · 2π · I_l, so that degree 0 does not hang on n.
    let mut integrals = [PI, PI * (exponent + 1.0) / (exponent + 2.0)];
    (0..=degree)
        .map(|l| {
            let l = l as f64;
            let [this, next] = integrals;
            integrals = [next, this * (exponent - l) / (exponent + l + 3.0)];
            zonal_norm(l) * this
        })
        .collect()
}

/// `Y_l0` over `P_l`.
fn zonal_norm(l: f64) -> f64 {
    (0.25 * (2.0 * l + 1.0) / PI).sqrt()
}

/// Legendre polynomials of degrees 0, 1, 2 … at eight places in [−1, 1].
///
/// Bonnet's recursion as `P_(l+1) = z·P_l + l / (l + 1) · (z·P_l − P_(l−1))`: exact at z = 1, where narrow lobes are.
#[inline(always)]
fn legendre(z: f32x8, factors: &[f32], values: &mut [f32x8]) {
    let (mut below, mut here) = (f32x8::ZERO, f32x8::ONE);
    for (value, &factor) in values.iter_mut().zip(factors) {
        *value = here;
        let risen = z * here;
        (below, here) = (here, (risen - below).mul_add(f32x8::splat(factor), risen));
    }
}

/// A coefficient as samples give it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Their mean.
    pub value: f64,
    /// One standard deviation of the mean.
    pub standard_error: f64,
}

impl Estimate {
    /// How many standard errors it is off; none where it cannot be off by chance, as under a density proportional to what is
    /// integrated.
    #[must_use]
    pub fn z(&self, truth: f64) -> Option<f64> {
        // What 32-bit samples round.
        let noise = f64::from(f32::EPSILON) * truth.abs().max(1.0);
        (self.standard_error > noise).then(|| (self.value - truth) / self.standard_error)
    }
}

/// Pairs of samples that a block has; blocks are added in their order.
pub const BLOCK: usize = 4096;

/// One sample in each lane: the cosine of its direction with z, and the integrand without its harmonic over the density.
pub type Sample = (f32x8, f32x8);

/// Sums over pairs of samples, of the coefficients to a degree.
///
/// The two samples of a pair are drawn alike and independently: both from the whole domain, or both from one stratum of it.
/// Then a quarter of the squared difference estimates the variance of the pair's mean, and their sum that of the sum, whatever
/// the strata are (Cochran 1977, "Sampling Techniques", sec. 5A.12 on pairs); and nothing cancels, as in a mean of squares.
#[derive(Clone, Debug)]
pub struct Sums {
    pairs: u64,
    /// l / (l + 1).
    factors: Vec<f32>,
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl Sums {
    /// Nothing yet, for degrees 0 to `degree`.
    #[must_use]
    pub fn new(degree: usize) -> Self {
        Self {
            pairs: 0,
            factors: (0..=degree).map(|l| l as f32 / (l + 1) as f32).collect(),
            sums: vec![0.0; degree + 1],
            squares: vec![0.0; degree + 1],
        }
    }

    /// Adds eight pairs for each of the `batches`.
    pub fn add(&mut self, batches: impl Iterator<Item = [Sample; 2]>) {
        let degrees = self.factors.len();
        let mut values = [vec![f32x8::ZERO; degrees], vec![f32x8::ZERO; degrees]];
        for [(z0, weight0), (z1, weight1)] in batches {
            self.pairs += WIDTH as u64;
            legendre(z0, &self.factors, &mut values[0]);
            legendre(z1, &self.factors, &mut values[1]);
            let values = values[0].iter().zip(&values[1]);
            for ((a, b), (sum, square)) in values.zip(self.sums.iter_mut().zip(&mut self.squares)) {
                let (a, b) = (*a * weight0, *b * weight1);
                let difference = a - b;
                *sum += f64::from((a + b).reduce_add());
                *square += f64::from((difference * difference).reduce_add());
            }
        }
    }

    /// Adds those of a later block.
    pub fn merge(&mut self, later: &Self) {
        self.pairs += later.pairs;
        for (to, from) in self.sums.iter_mut().zip(&later.sums) {
            *to += from;
        }
        for (to, from) in self.squares.iter_mut().zip(&later.squares) {
            *to += from;
        }
    }

    /// Samples added.
    #[must_use]
    pub fn samples(&self) -> u64 {
        2 * self.pairs
    }

    /// The coefficient of each degree.
    #[must_use]
    pub fn estimates(&self) -> Vec<Estimate> {
        let pairs = self.pairs as f64;
        self.sums
            .iter()
            .zip(&self.squares)
            .enumerate()
            .map(|(l, (sum, square))| {
                let norm = zonal_norm(l as f64);
                Estimate {
                    value: norm * 0.5 * sum / pairs,
                    standard_error: norm * 0.5 * square.sqrt() / pairs,
                }
            })
            .collect()
    }
}
