//! Probabilities under noise alone: two-sided normal, χ², the worst of many.

use std::f64::consts::{SQRT_2, TAU};

/// Probability that a normal score is as far from 0 as `z`, on either side. Full relative precision down to 10⁻³⁰⁰.
pub fn two_sided(z: f64) -> f64 {
    libm::erfc(z.abs() / SQRT_2)
}

/// The score whose [`two_sided`] probability is `p`, in 0 < p ≤ 1.
pub fn score(p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 38.0);
    // To the last bit: erfc falls all the way.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if two_sided(middle) > p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Probability that the least of `count` independent probabilities is `p` or less (Šidák 1967).
pub fn least_of(p: f64, count: usize) -> f64 {
    if p >= 1.0 {
        return 1.0;
    }
    -libm::expm1(count as f64 * libm::log1p(-p))
}

/// Probability that a sum of squares of `degrees` normal scores is `x` or more: the regularised upper incomplete gamma
/// function Q(degrees/2, x/2), by its series below the mean and its continued fraction above (Abramowitz & Stegun
/// 6.5.29, 6.5.31; the fraction by Lentz's method). Relative precision 10⁻¹⁰ up to a million degrees.
pub fn chi_square(x: f64, degrees: usize) -> f64 {
    let (a, x) = (0.5 * degrees as f64, 0.5 * x);
    if degrees == 0 || x <= 0.0 {
        return 1.0;
    }
    // x^a e^(-x) / Γ(a), its exponent without the cancellation of three great numbers where x is near a.
    let front = libm::exp(a * (libm::log(x / a) + 1.0 - x / a) - stirling_rest(a));
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-17 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - front * sum).max(0.0);
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for i in 1..100_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-16 {
            break;
        }
    }
    front * fraction
}

/// ln Γ(a) − (a ln a − a).
fn stirling_rest(a: f64) -> f64 {
    if a < 100.0 {
        return libm::lgamma(a) - (a * libm::log(a) - a);
    }
    let inverse = 1.0 / a;
    // Stirling's series; the next term is below 10⁻¹⁷.
    0.5 * libm::log(TAU / a)
        + inverse * (1.0 / 12.0 - inverse * inverse / 360.0)
        + inverse * inverse * inverse * inverse * inverse / 1260.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn assert_close(got: f64, want: f64, relative: f64) {
        let error = (got / want - 1.0).abs();
        assert!(error <= relative, "{got:e} is not {want:e}: {error:e}");
    }

    /// Wanted values by mpmath, 40 digits.
    #[test]
    fn normal_tails_keep_their_digits() {
        for (z, want) in [
            (0.5, 0.617_075_077_451_973_8),
            (3.0, 0.002_699_796_063_260_189),
            (7.03, 2.065_335_382_588_536_1e-12),
            (20.0, 5.507_248_237_212_467_4e-89),
            (37.0, 1.145_114_244_504_915_4e-299),
        ] {
            assert_close(two_sided(z), want, 1e-13);
            assert_close(two_sided(-z), want, 1e-13);
            assert_close(score(want), z, 1e-13);
        }
        assert_eq!(two_sided(0.0), 1.0);
    }

    #[test]
    fn chi_square_tails_keep_their_digits() {
        for (x, degrees, want) in [
            (1.0, 1, 0.317_310_507_862_914_1),
            (30.0, 1, 4.320_463_057_827_497_3e-8),
            (10.0, 10, 0.440_493_285_065_212_4),
            (120.0, 10, 5.060_046_065_842_574e-21),
            (60.0, 256, 1.0),
            (300.0, 256, 0.030_589_935_099_244_536),
            (520.0, 256, 3.928_263_995_549_249_2e-20),
            (8100.0, 8100, 0.497_910_406_085_022_94),
            (9000.0, 8100, 4.241_820_343_969_057e-12),
            (9500.0, 8100, 9.237_408_486_097_22e-26),
            (1_003_000.0, 1_000_000, 0.017_016_772_933_266_315),
            (1_010_000.0, 1_000_000, 9.068_528_823_262_077e-13),
        ] {
            assert_close(chi_square(x, degrees), want, 1e-9);
        }
        assert_eq!(chi_square(0.0, 5), 1.0);
        assert_eq!(chi_square(1e9, 1), 0.0);
    }

    #[test]
    fn the_least_of_many_is_sidaks() {
        assert_eq!(least_of(1.0, 7), 1.0);
        assert_close(least_of(0.5, 2), 0.75, 1e-15);
        assert_close(least_of(1e-20, 1000), 1e-17, 1e-12);
    }
}
