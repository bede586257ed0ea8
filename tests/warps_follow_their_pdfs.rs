//! Every warp draws what its density says.

mod common;

use common::*;
use ondine::lanes::{Vec3x8, f32x8};
use ondine::sampling::warp;
use std::f64::consts::{PI, TAU};

const ALL: f32x8 = f32x8::ONE;

#[test]
fn chi_square_p_values_agree_with_tables() {
    // 95 % points of the χ² distribution (Abramowitz & Stegun, table 26.8; 1000 by its expansion 26.4.17).
    for (freedom, statistic) in [
        (1.0, 3.841_458_8),
        (10.0, 18.307_038),
        (100.0, 124.342_11),
        (1000.0, 1_074.679_4),
    ] {
        assert_close(
            gamma_q(0.5 * freedom, 0.5 * statistic),
            0.05,
            5e-6,
            0.0,
            "p",
        );
    }
    // Two degrees of freedom: exp(−x).
    assert_close(gamma_q(1.0, 0.2), (-0.2f64).exp(), 1e-13, 0.0, "p");
    assert_close(gamma_q(1.0, 30.0), (-30f64).exp(), 1e-12, 0.0, "p");
}

#[test]
fn chi_square_sees_a_wrong_density() {
    let mut random = Random::new(1);
    // Cosine instead of uniform, and an error of 3 % in the exponent of a lobe.
    let (p, _) = chi_square_of_directions(
        |d| f32x8::splat(warp::UNIFORM_HEMISPHERE_PDF) & d.z.simd_gt(f32x8::ZERO),
        || (warp::cosine_hemisphere(random.pair()), ALL),
    );
    assert!(p < 1e-30, "p = {p}");
    let (p, _) = chi_square_of_directions(
        |d| warp::cosine_power_pdf(d, f32x8::splat(20.6)),
        || (warp::cosine_power(random.pair(), f32x8::splat(20.0)), ALL),
    );
    assert!(p < 1e-30, "p = {p}");
}

fn check(
    seed: u64,
    what: &str,
    pdf: impl Fn(Vec3x8) -> f32x8,
    warp: impl Fn(warp::Pair) -> Vec3x8,
) {
    let mut random = Random::new(seed);
    let (p, _) = chi_square_of_directions(pdf, || (warp(random.pair()), ALL));
    assert!(p > SIGNIFICANCE, "{what}: p = {p}");
}

#[test]
fn uniform_and_cosine_directions_follow_their_pdfs() {
    check(
        2,
        "sphere",
        |_| f32x8::splat(warp::UNIFORM_SPHERE_PDF),
        warp::uniform_sphere,
    );
    check(
        3,
        "hemisphere",
        |d| f32x8::splat(warp::UNIFORM_HEMISPHERE_PDF) & d.z.simd_gt(f32x8::ZERO),
        warp::uniform_hemisphere,
    );
    check(
        4,
        "cosine",
        |d| d.z.fast_max(f32x8::ZERO) * std::f32::consts::FRAC_1_PI,
        warp::cosine_hemisphere,
    );
}

#[test]
fn cosine_powers_follow_their_pdfs() {
    for (seed, n) in [(5, 0.0), (6, 1.0), (7, 20.0), (8, 500.0)] {
        let n = f32x8::splat(n);
        check(
            seed,
            "cosine power",
            |d| warp::cosine_power_pdf(d, n),
            |u| warp::cosine_power(u, n),
        );
    }
}

#[test]
fn narrow_cosine_powers_follow_the_exact_distribution() {
    // n = 10⁴: the lobe fits in one bin of the sphere, so bin P(cos > c) = 1 − c^(n + 1), and look at 1 − cos as x² + y².
    let n = 1e4;
    let mut random = Random::new(9);
    let mut observed = [0; 200];
    for _ in 0..SAMPLES / 8 {
        let d = warp::cosine_power(random.pair(), f32x8::splat(n as f32));
        for i in 0..8 {
            let [x, y, z] = lane(&d, i);
            let tail = ((n + 1.0) * (-(x * x + y * y) / (1.0 + z)).ln_1p()).exp();
            observed[(tail * 200.0) as usize] += 1;
        }
    }
    let p = chi_square(&observed, &[SAMPLES as f64 / 200.0; 200]);
    assert!(p > SIGNIFICANCE, "p = {p}");
}

#[test]
fn cones_follow_their_pdfs() {
    for (seed, h) in [(10, 2.0), (11, 1.0), (12, 0.25)] {
        let size = f32x8::splat(h);
        check(
            seed,
            "cone",
            |d| warp::cone_pdf(size) & (f32x8::ONE - d.z).simd_le(size),
            |u| warp::cone(u, size),
        );
    }
}

#[test]
fn tiny_cones_are_uniform_and_unit() {
    let mut random = Random::new(13);
    for h in [1e-3, 1e-6, 1e-9, 1e-12] {
        let mut observed = vec![0; 20 * 20];
        for _ in 0..SAMPLES / 8 {
            let d = warp::cone(random.pair(), f32x8::splat(h as f32));
            for i in 0..8 {
                let [x, y, z] = lane(&d, i);
                assert_close(x * x + y * y + z * z, 1.0, 3e-7, 0.0, "length");
                let part = (x * x + y * y) / (1.0 + z) / h;
                let turn = y.atan2(x) / TAU;
                let (row, column) = ((part * 20.0) as usize, (turn - turn.floor()) * 20.0);
                observed[row.min(19) * 20 + column as usize % 20] += 1;
            }
        }
        let p = chi_square(&observed, &[SAMPLES as f64 / 400.0; 400]);
        assert!(p > SIGNIFICANCE, "1 − cos {h}: p = {p}");
        assert_close(
            f64::from(warp::cone_pdf(f32x8::splat(h as f32)).to_array()[0]),
            1.0 / (TAU * h),
            1e-6,
            0.0,
            "pdf",
        );
    }
}

/// χ² of points of the plane in a square of bins.
fn check_plane(
    seed: u64,
    radius: f64,
    pdf: impl Fn(f32x8, f32x8) -> f32x8,
    warp: impl Fn(warp::Pair) -> (f32x8, f32x8),
) {
    const BINS: usize = 60;
    let mut random = Random::new(seed);
    let bin = |v: f32| (((f64::from(v) / radius + 1.0) * 0.5 * BINS as f64) as usize).min(BINS - 1);
    let mut observed = vec![0; BINS * BINS];
    for _ in 0..SAMPLES / 8 {
        let (x, y) = warp(random.pair());
        for (x, y) in x.to_array().into_iter().zip(y.to_array()) {
            assert!(f64::from(x.hypot(y)) <= radius * (1.0 + 1e-6), "({x}, {y})");
            observed[bin(y) * BINS + bin(x)] += 1;
        }
    }
    let density = |x: [f64; 8], y: [f64; 8]| {
        let [x, y] = [x, y].map(|v| f32x8::new(v.map(|v| v as f32)));
        pdf(x, y).to_array().map(f64::from)
    };
    let edge = |i: usize| (2.0 * i as f64 / BINS as f64 - 1.0) * radius;
    let mut expected = Vec::new();
    for row in 0..BINS {
        for column in 0..BINS {
            let a = [edge(column), edge(column + 1)];
            let b = [edge(row), edge(row + 1)];
            expected.push(adaptive(&density, Cell { a, b }, 1e-8) * SAMPLES as f64);
        }
    }
    let total: f64 = expected.iter().sum();
    assert_close(total, SAMPLES as f64, 1e-4, 0.0, "integral");
    let p = chi_square(&observed, &expected);
    assert!(p > SIGNIFICANCE, "p = {p}");
}

#[test]
fn disk_points_are_uniform() {
    let inside = |x: f32x8, y: f32x8| x.mul_add(x, y * y).simd_le(f32x8::ONE);
    let density = f32x8::splat(1.0 / PI as f32);
    check_plane(
        14,
        1.0,
        |x, y| density & inside(x, y),
        |u| warp::uniform_disk(u).0,
    );
}

#[test]
fn gaussian_points_follow_their_pdf() {
    let radius = f64::from(warp::GAUSSIAN_RADIUS);
    check_plane(
        15,
        radius,
        warp::gaussian_truncated_pdf,
        warp::gaussian_truncated,
    );
}

#[test]
fn tent_points_follow_their_pdf() {
    check_plane(
        16,
        2f64.sqrt(),
        |x, y| warp::tent_pdf(x) * warp::tent_pdf(y),
        |u| (warp::tent(u.0), warp::tent(u.1)),
    );
}

#[test]
fn tent_inverts_its_distribution() {
    for i in 0..100_000 {
        let u = i as f32 / 100_000.0;
        let x = f64::from(warp::tent(f32x8::splat(u)).to_array()[0]);
        let below = if x < 0.0 {
            0.5 * (1.0 + x) * (1.0 + x)
        } else {
            1.0 - 0.5 * (1.0 - x) * (1.0 - x)
        };
        assert_close(below, f64::from(u), 0.0, 1e-7, "cdf");
    }
}

#[test]
fn uniform_triangle_covers_equal_parts_equally() {
    // The triangle b, c ≥ 0, b + c ≤ 1 in SIDE² congruent triangles.
    const SIDE: usize = 32;
    let mut observed = vec![0; SIDE * SIDE];
    let mut random = Random::new(30);
    for _ in 0..SAMPLES / 8 {
        let (b, c) = warp::uniform_triangle(random.pair());
        for i in 0..8 {
            let (b, c) = (f64::from(b.as_array()[i]), f64::from(c.as_array()[i]));
            assert!(b >= 0.0 && c >= 0.0 && b + c <= 1.0, "({b}, {c})");
            let (x, y) = (b * SIDE as f64, c * SIDE as f64);
            let (column, row) = ((x as usize).min(SIDE - 1), (y as usize).min(SIDE - 1));
            let upper = x.fract() + y.fract() > 1.0;
            // Row by row, each with its lower triangles and the upper ones between them.
            let before = row * 2 * SIDE - row * row;
            observed[before + 2 * column + usize::from(upper)] += 1;
        }
    }
    let expected = vec![SAMPLES as f64 / (SIDE * SIDE) as f64; SIDE * SIDE];
    let p = chi_square(&observed, &expected);
    assert!(p > SIGNIFICANCE, "p = {p}");
}
