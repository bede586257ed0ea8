//! Coefficients of lobes: the closed form against quadrature and published values, estimates against the closed form.

use crate::common::{SIGNIFICANCE, assert_close, gamma_q};
use crate::quadrature::{gauss_legendre, legendre};
use ondine::lanes::{WIDTH, f32x8, u32x8};
use ondine::sampling::{Dimension, Sampler, warp};
use ondine::sh::lobe::{Sample, Sums, phong};
use std::f64::consts::{PI, SQRT_2};

/// `2π · √((2l + 1) / 4π) · ∫ (n + 1) / 2 · tⁿ · P_l(t) dt` over [0, 1], by Gauss and Legendre. Only for whole exponents, for
/// which it is exact but for rounding.
fn by_quadrature(exponent: i32, degree: usize) -> Vec<f64> {
    let rule = gauss_legendre((exponent as usize + degree) / 2 + 1);
    (0..=degree)
        .map(|l| {
            let integral: f64 = rule
                .iter()
                .map(|&(x, weight)| (0.5 * (x + 1.0), 0.5 * weight))
                .map(|(t, weight)| weight * t.powi(exponent) * legendre(l, t).0)
                .sum();
            let norm = ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
            PI * f64::from(exponent + 1) * norm * integral
        })
        .collect()
}

#[test]
fn the_closed_form_agrees_with_quadrature() {
    for exponent in [0, 1, 2, 3, 5, 10, 17, 50, 100, 333, 1000] {
        let quadrature = by_quadrature(exponent, 20);
        for (l, (value, want)) in phong(exponent.into(), 20)
            .iter()
            .zip(quadrature)
            .enumerate()
        {
            let zero = l > exponent as usize && (l - exponent as usize).is_multiple_of(2);
            if zero {
                // The quadrature's rounding is what is left.
                assert_eq!(*value, 0.0, "exponent {exponent}, degree {l}");
                assert!(want.abs() < 1e-12);
            } else {
                let what = format!("exponent {exponent}, degree {l}");
                assert_close(*value, want, 1e-6, 0.0, &what);
            }
        }
    }
}

#[test]
fn the_closed_form_agrees_with_known_values() {
    // Clamped cosine: Ramamoorthi & Hanrahan 2001, "On the relationship between radiance and irradiance", eq. 8 (A_l over
    // the root of 4π / (2l + 1)); the others by Simpson's rule with 20,000 intervals, to four decimals.
    let cosine = phong(1.0, 20);
    let band = |l: usize| cosine[l] * (4.0 * PI / (2 * l + 1) as f64).sqrt();
    for (l, want) in [(0, PI), (1, 2.0 * PI / 3.0), (2, PI / 4.0), (4, -PI / 24.0)] {
        assert_close(band(l), want, 1e-14, 0.0, "clamped cosine");
    }
    let tables: [(f64, [f64; 7]); 4] = [
        (1.0, [0.8862, 1.0233, 0.4954, 0.0, -0.1108, 0.0, 0.0499]),
        (
            5.0,
            [0.8862, 1.3157, 1.2385, 0.8932, 0.4985, 0.2036, 0.0499],
        ),
        (
            10.0,
            [0.8862, 1.4071, 1.5244, 1.3817, 1.0907, 0.7578, 0.4627],
        ),
        (
            50.0,
            [0.8862, 1.5055, 1.8695, 2.0867, 2.1890, 2.1954, 2.1231],
        ),
    ];
    for (exponent, table) in tables {
        for (value, want) in phong(exponent, 6).iter().zip(table) {
            assert!(
                (value - want).abs() < 5.1e-5,
                "exponent {exponent}: {value}"
            );
        }
    }
    // What an early report prints, by Maple, for √2 |cos θ|: twice the even degrees, and the root.
    for (l, want) in [(0, 2.506628274), (2, 1.401247804), (4, -0.3133285342)] {
        assert_close(2.0 * SQRT_2 * cosine[l], want, 1e-9, 0.0, "by Maple");
    }
}

#[test]
fn exponents_between_whole_numbers_and_huge_ones_have_coefficients() {
    // Quadrature with 40 digits (mpmath 1.4): exponent, degree, coefficient.
    const WANT: &[(f64, usize, f64)] = &[
        (0.5, 1, 0.920_994_037_151_839_7),
        (0.5, 20, -0.010151379438697941),
        (2.75, 7, 0.0042011531496195027),
        (7.3, 20, 1.179_407_702_484_877e-6),
        (33.3, 13, 0.314_445_972_076_735_5),
        (999.5, 20, 4.600_656_358_047_825),
        (1e6, 20, 5.673429562703522),
        (12.000000001, 14, 1.3922324800159773e-13),
    ];
    for &(exponent, degree, want) in WANT {
        let what = format!("exponent {exponent}, degree {degree}");
        assert_close(phong(exponent, degree)[degree], want, 1e-12, 0.0, &what);
    }
}

/// Uniform directions over the sphere, for an exponent of 5: eight pairs.
fn uniform(sampler: &Sampler, batch: u32) -> [Sample; 2] {
    [0, 1].map(|which| {
        let path = sampler.path_key(
            u32x8::splat(which),
            u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]) + u32x8::splat(batch * WIDTH as u32),
        );
        let z = warp::uniform_sphere(sampler.pair(path, Dimension::BsdfDirection, 0)).z;
        let cosine = z.fast_max(f32x8::ZERO);
        let power = cosine * cosine * cosine * cosine * cosine;
        (z, power * (3.0 * 4.0 * PI as f32))
    })
}

#[test]
fn estimates_are_off_by_what_their_standard_error_says() {
    const SEEDS: u64 = 100;
    let exact = phong(5.0, 6);
    let mut squares = [0.0; 7];
    for seed in 0..SEEDS {
        let sampler = Sampler::pcg(seed, 1);
        let mut sums = Sums::new(6);
        sums.add((0..2500).map(|batch| uniform(&sampler, batch)));
        assert_eq!(sums.samples(), 40_000);
        for ((estimate, exact), square) in sums.estimates().iter().zip(&exact).zip(&mut squares) {
            let z = estimate.z(*exact).expect("a variance");
            *square += z * z;
        }
    }
    for (l, square) in squares.into_iter().enumerate() {
        // Too small a sum, from errors that are stated too large, is as wrong.
        let p = gamma_q(0.5 * SEEDS as f64, 0.5 * square);
        let within = SIGNIFICANCE..1.0 - SIGNIFICANCE;
        assert!(
            within.contains(&p),
            "degree {l}: sum of z squared {square}, p = {p}"
        );
    }
}

#[test]
fn ten_million_samples_are_within_four_standard_errors() {
    let sampler = Sampler::pcg(1, 1);
    let mut sums = Sums::new(6);
    sums.add((0..625_000).map(|batch| uniform(&sampler, batch)));
    assert_eq!(sums.samples(), 10_000_000);
    for (estimate, exact) in sums.estimates().iter().zip(phong(5.0, 6)) {
        let z = estimate.z(exact).expect("a variance");
        assert!(z.abs() < 4.0, "{estimate:?} for {exact}");
        assert!(estimate.standard_error < 1.5e-3, "{estimate:?}");
    }
}

#[test]
fn what_does_not_vary_has_no_error_to_speak_of() {
    let mut sums = Sums::new(2);
    let z = f32x8::new(std::array::from_fn(|lane| lane as f32 / 8.0));
    sums.add((0..10).map(|_| [(z, f32x8::splat(PI as f32)), (z, f32x8::splat(PI as f32))]));
    let exact = phong(1.0, 0)[0];
    let estimate = sums.estimates()[0];
    assert!((estimate.value - exact).abs() < 1e-7);
    assert_eq!(estimate.z(exact), None);
}

#[test]
fn blocks_add_up_to_the_whole() {
    let sampler = Sampler::pcg(3, 1);
    let sum = |batches: std::ops::Range<u32>| {
        let mut sums = Sums::new(4);
        sums.add(batches.map(|batch| uniform(&sampler, batch)));
        sums
    };
    let (mut parts, whole) = (sum(0..100), sum(0..250));
    parts.merge(&sum(100..250));
    assert_eq!(parts.samples(), whole.samples());
    for (a, b) in parts.estimates().iter().zip(whole.estimates()) {
        assert_close(a.value, b.value, 1e-12, 1e-12, "value");
        assert_close(
            a.standard_error,
            b.standard_error,
            1e-12,
            0.0,
            "standard error",
        );
    }
}
