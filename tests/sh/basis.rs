//! The basis against associated Legendre functions and the integral that makes it orthonormal.

use crate::common::{Random, V, unit};
use crate::quadrature::gauss_legendre;
use ondine::lanes::{Vec3x8, WIDTH, f32x8};
use ondine::sh::{Basis, MAX_DEGREE, coefficients, index};
use std::f64::consts::{PI, TAU};

/// Real harmonics up to a degree by their definition, in spherical coordinates:
/// `K_lm · P_lm(cos θ) · (cos mφ | sin |m|φ) · √2`, with P_lm normalised as it is raised.
fn oracle(degree: usize, direction: V) -> Vec<f64> {
    let [x, y, z] = direction;
    let (sin, phi) = (x.hypot(y), y.atan2(x));
    let mut values = vec![0.0; coefficients(degree)];
    let mut sectoral = (0.25 / PI).sqrt();
    for m in 0..=degree {
        if m > 0 {
            let m = m as f64;
            sectoral *= ((2.0 * m + 1.0) / (2.0 * m)).sqrt() * sin;
        }
        let (mut below, mut here) = (0.0, sectoral);
        for l in m..=degree {
            let (azimuth, root) = ((m as f64) * phi, if m == 0 { 1.0 } else { 2f64.sqrt() });
            values[index(l, -(m as isize))] = root * here * azimuth.sin();
            values[index(l, m as isize)] = root * here * azimuth.cos();
            let (l, m) = (l as f64 + 1.0, m as f64);
            let next = ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt()
                * (z * here
                    - (((l - 1.0) * (l - 1.0) - m * m) / (4.0 * (l - 1.0) * (l - 1.0) - 1.0))
                        .abs()
                        .sqrt()
                        * below);
            (below, here) = (here, next);
        }
    }
    values
}

/// Eight directions: at random, or near what is special.
fn directions(random: &mut Random, batch: usize) -> [V; WIDTH] {
    let mut one = || 2.0 * f64::from(random.one()) - 1.0;
    std::array::from_fn(|lane| {
        let any = [one(), one(), one()];
        let small = 10f64.powi(-(batch as i32 % 12));
        match (batch % 3, lane) {
            (0, 0) => [0.0, 0.0, 1.0],
            (0, 1) => [0.0, 0.0, -1.0],
            (0, 2) => [1.0, 0.0, 0.0],
            (0, 3) => [0.0, -1.0, 0.0],
            (1, _) => unit([small * any[0], small * any[1], any[2]]),
            _ => unit(any),
        }
    })
}

fn wide(directions: &[V; WIDTH]) -> Vec3x8 {
    let axis = |k: usize| f32x8::new(std::array::from_fn(|lane| directions[lane][k] as f32));
    Vec3x8::new(axis(0), axis(1), axis(2))
}

/// The greatest error over the directions, by degree.
fn errors(degree: usize, batches: usize) -> Vec<f64> {
    let basis = Basis::new(degree);
    let mut values = vec![f32x8::ZERO; coefficients(degree)];
    let mut random = Random::new(11);
    let mut errors = vec![0.0_f64; degree + 1];
    for batch in 0..batches {
        let wide = wide(&directions(&mut random, batch));
        basis.evaluate(&wide, &mut values);
        for lane in 0..WIDTH {
            let v = wide.lane(lane);
            let want = oracle(degree, unit([v.x, v.y, v.z].map(f64::from)));
            for (k, want) in want.into_iter().enumerate() {
                let l = k.isqrt();
                let error = (f64::from(values[k].as_array()[lane]) - want).abs();
                assert!(error.is_finite(), "degree {l}, value {k}");
                errors[l] = errors[l].max(error);
            }
        }
    }
    errors
}

#[test]
fn values_are_those_of_the_textbook() {
    for (l, error) in errors(16, 3000).into_iter().enumerate() {
        let bound = 1e-7 * ((l + 1) * (l + 1)) as f64;
        assert!(
            error < bound,
            "degree {l}: {error:e} is not below {bound:e}"
        );
    }
}

#[test]
fn the_recursion_is_stable_to_the_greatest_degree() {
    for (l, error) in errors(MAX_DEGREE, 60).into_iter().enumerate() {
        let bound = 1e-7 * ((l + 1) * (l + 1)) as f64;
        assert!(
            error < bound,
            "degree {l}: {error:e} is not below {bound:e}"
        );
    }
}

#[test]
fn the_first_degrees_go_with_the_axes() {
    let mut values = [f32x8::ZERO; 4];
    let v = Vec3x8::new(f32x8::splat(0.48), f32x8::splat(0.6), f32x8::splat(0.64));
    Basis::new(1).evaluate(&v, &mut values);
    let scale = (0.75 / PI).sqrt();
    let want = [(0.25 / PI).sqrt(), 0.6 * scale, 0.64 * scale, 0.48 * scale];
    for (value, want) in values.iter().zip(want) {
        assert!((f64::from(value.as_array()[0]) - want).abs() < 1e-7);
    }
}

#[test]
fn the_bits_of_a_value_do_not_depend_on_the_greatest_degree() {
    // To 8 the loops are unrolled; to 4 nothing is recursive.
    let all = Basis::new(24);
    let mut all_values = vec![f32x8::ZERO; coefficients(24)];
    let mut random = Random::new(12);
    for batch in 0..200 {
        let direction = wide(&directions(&mut random, batch));
        all.evaluate(&direction, &mut all_values);
        for degree in 0..24 {
            let mut values = vec![f32x8::ZERO; coefficients(degree)];
            Basis::new(degree).evaluate(&direction, &mut values);
            for (k, (some, all)) in values.iter().zip(&all_values).enumerate() {
                assert_eq!(
                    some.to_bits(),
                    all.to_bits(),
                    "value {k} of degree {degree}"
                );
            }
        }
    }
}

/// The greatest distance of the Gram matrix to the identity: by a rule that is exact for products of two functions, nodes of
/// Gauss and Legendre in z times uniform azimuths.
fn gram_error(degree: usize) -> f64 {
    let (basis, count) = (Basis::new(degree), coefficients(degree));
    let azimuths = (2 * degree + 1).next_multiple_of(WIDTH);
    let mut gram = vec![0.0; count * count];
    let mut values = vec![f32x8::ZERO; count];
    for (z, weight) in gauss_legendre(degree + 1) {
        let r = (1.0 - z * z).sqrt();
        for first in (0..azimuths).step_by(WIDTH) {
            let batch = std::array::from_fn(|lane| {
                let (sin, cos) = ((first + lane) as f64 * TAU / azimuths as f64).sin_cos();
                [r * cos, r * sin, z]
            });
            basis.evaluate(&wide(&batch), &mut values);
            let weight = weight * TAU / azimuths as f64;
            for lane in 0..WIDTH {
                let lane: Vec<f64> = values.iter().map(|v| v.as_array()[lane].into()).collect();
                for (row, a) in gram.chunks_exact_mut(count).zip(&lane) {
                    let a = a * weight;
                    row.iter_mut().zip(&lane).for_each(|(sum, b)| *sum += a * b);
                }
            }
        }
    }
    let identity = |k: usize| if k / count == k % count { 1.0 } else { 0.0 };
    let off = gram
        .iter()
        .enumerate()
        .map(|(k, sum)| (sum - identity(k)).abs());
    off.fold(0.0, f64::max)
}

#[test]
fn the_functions_are_orthonormal() {
    for (degree, bound) in [(0, 2e-7), (4, 5e-7), (8, 1e-6), (16, 2e-6)] {
        let error = gram_error(degree);
        assert!(
            error < bound,
            "degree {degree}: {error:e} is not below {bound:e}"
        );
    }
}

#[test]
fn squares_of_a_degree_add_up_to_the_same_in_all_directions() {
    // Unsöld's theorem: (2l + 1) / 4π. It finds a wrong constant at any degree.
    let basis = Basis::new(MAX_DEGREE);
    let mut values = vec![f32x8::ZERO; coefficients(MAX_DEGREE)];
    let mut random = Random::new(13);
    for batch in 0..30 {
        basis.evaluate(&wide(&directions(&mut random, batch)), &mut values);
        for l in 0..=MAX_DEGREE {
            for lane in 0..WIDTH {
                let of_degree = values[l * l..(l + 1) * (l + 1)].iter();
                let sum: f64 = of_degree
                    .map(|v| f64::from(v.as_array()[lane]).powi(2))
                    .sum();
                let ratio = sum * 4.0 * PI / (2 * l + 1) as f64;
                let bound = 2e-7 * ((l + 1) * (l + 1)) as f64;
                assert!((ratio - 1.0).abs() < bound, "degree {l}: {ratio}");
            }
        }
    }
}

#[test]
fn rows_hold_what_batches_give_however_many_there_are() {
    let mut random = Random::new(14);
    for degree in [0, 1, 2, 3, 8, 11] {
        let (basis, row) = (Basis::new(degree), coefficients(degree));
        let mut values = vec![f32x8::ZERO; row];
        for count in [0, 1, 7, 8, 9, 16, 21, 64] {
            let all: Vec<V> = (0..8)
                .flat_map(|batch| directions(&mut random, batch))
                .collect();
            let given: Vec<[f32; 3]> = all[..count].iter().map(|v| v.map(|c| c as f32)).collect();
            let mut rows = vec![f32::NAN; count * row];
            basis.tabulate(&given, &mut rows);
            for (direction, row) in all.iter().zip(rows.chunks_exact(row)) {
                basis.evaluate(&wide(&[*direction; WIDTH]), &mut values);
                for (value, wide) in row.iter().zip(&values) {
                    assert_eq!(value.to_bits(), wide.as_array()[0].to_bits());
                }
            }
        }
    }
}

#[test]
fn a_table_that_no_cache_holds_has_the_rows_of_small_ones() {
    let mut random = Random::new(15);
    let (basis, row) = (Basis::new(8), coefficients(8));
    // 324 bytes a row: 17 MB. Not a whole number of anything.
    let count = 52_001_usize;
    let given: Vec<[f32; 3]> = (0..count.div_ceil(WIDTH))
        .flat_map(|batch| directions(&mut random, batch))
        .map(|v| v.map(|c| c as f32))
        .take(count)
        .collect();
    // From an odd place, so that no line begins where a row does.
    let mut room = vec![f32::NAN; count * row + 3];
    basis.tabulate(&given, &mut room[3..]);
    let mut small = vec![f32::NAN; 1000 * row];
    for (given, rows) in given.chunks(1000).zip(room[3..].chunks(1000 * row)) {
        let small = &mut small[..rows.len()];
        basis.tabulate(given, small);
        assert!(
            rows.iter()
                .zip(&*small)
                .all(|(a, b)| a.to_bits() == b.to_bits())
        );
    }
}
