//! An environment of spherical harmonics: its radiance, what draws it, and light below zero.

use crate::common::*;
use crate::oracle;
use crate::render::{STRATEGIES, film, mean_and_error, scene, settings};
use ondine::lanes::WIDTH;
use ondine::sampling::warp;
use ondine::scene::description::{Description, Environment, Harmonics};
use ondine::scene::environment::Sky;
use ondine::sh::{Probe, Series, coefficients};
use std::f64::consts::{PI, TAU};

/// Coefficients that fall off as 1 / (l + 1)², with a bright constant; negative in places.
fn wild(degree: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut random = Random::new(seed);
    let mut values: Vec<[f64; 3]> = (0..coefficients(degree))
        .map(|i| {
            let l = i.isqrt() as f64;
            [(); 3].map(|()| (2.0 * f64::from(random.one()) - 1.0) / ((l + 1.0) * (l + 1.0)))
        })
        .collect();
    values[0] = [0.4, 0.3, 0.2];
    values
}

fn harmonics(values: &[[f64; 3]]) -> Harmonics {
    Harmonics {
        source: String::from("test"),
        probe: Probe::radiance(values.to_vec()).unwrap(),
        rotate_degrees: 0.0,
        clamp: false,
    }
}

#[test]
fn a_series_is_the_sum_of_its_terms() {
    let mut random = Random::new(500);
    for degree in [0, 1, 2, 3, 8, 16, 40, 128] {
        let values = wild(degree, 501);
        let series = Series::new(degree, &values);
        let size: f64 = values.iter().map(|c| c[0] * c[0]).sum::<f64>().sqrt();
        // Single precision loses the low bits of a degree's argument: the error grows with it.
        let tolerance = 1e-6 * size * (degree + 1) as f64;
        for _ in 0..if degree > 40 { 20 } else { 200 } {
            let d = warp::uniform_sphere(random.pair());
            let sum = series.evaluate(d);
            for i in 0..WIDTH {
                let want = oracle::sum(&values, unit(lane(&d, i)));
                for (got, want) in sum.lane(i).to_array().into_iter().zip(want) {
                    assert_close(got.into(), want, 0.0, tolerance, &format!("l = {degree}"));
                }
            }
        }
        for axis in [
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ] {
            let got = series.evaluate(splat(axis)).lane(0).r;
            let want = oracle::sum(&values, axis)[0];
            assert_close(
                got.into(),
                want,
                0.0,
                tolerance,
                &format!("l = {degree} on an axis"),
            );
        }
    }
}

#[test]
fn radiance_turns_with_the_environment_and_is_cut_off_where_asked() {
    let values = wild(3, 510);
    let mut random = Random::new(511);
    for (rotate_degrees, clamp) in [
        (0.0f32, false),
        (30.0, false),
        (-111.0, true),
        (360.0, false),
    ] {
        let sky = Sky::compile(&Environment::Harmonics(Harmonics {
            rotate_degrees,
            clamp,
            ..harmonics(&values)
        }));
        let (sin, cos) = f64::from(rotate_degrees).to_radians().sin_cos();
        let mut negative = 0;
        for _ in 0..500 {
            let d = warp::uniform_sphere(random.pair());
            let radiance = sky.radiance(d);
            for i in 0..WIDTH {
                let [x, y, z] = unit(lane(&d, i));
                let want = oracle::sum(&values, [cos * x - sin * z, y, sin * x + cos * z]);
                for (got, mut want) in radiance.lane(i).to_array().into_iter().zip(want) {
                    negative += usize::from(want < 0.0);
                    if clamp {
                        want = want.max(0.0);
                    }
                    assert_close(got.into(), want, 0.0, 4e-6, "radiance");
                }
            }
        }
        assert!(negative > 100, "{negative} negative values test little");
    }
}

#[test]
fn directions_follow_their_density_and_every_direction_has_one() {
    // Cells that the density is constant in: 32 rows, or 4 for each degree and one more.
    for (seed, degree, rows, rotate_degrees) in [(520, 2, 32, 0.0f32), (521, 9, 40, 77.0)] {
        let sky = Sky::compile(&Environment::Harmonics(Harmonics {
            rotate_degrees,
            ..harmonics(&wild(degree, seed))
        }));
        let columns = 2 * rows;
        let turn = f64::from(rotate_degrees) / 360.0;
        let mut random = Random::new(seed + 10);
        let mut observed = vec![0; rows * columns];
        let mut strayed = 0;
        for _ in 0..SAMPLES / WIDTH {
            let sample = sky.sample(random.pair());
            let (radiance, pdf) = sky.radiance_and_pdf(sample.direction);
            assert_eq!(radiance.r.to_array(), sample.radiance.r.to_array());
            strayed += pdf.simd_ne(sample.pdf).to_bitmask().count_ones();
            for i in 0..WIDTH {
                let [x, y, z] = lane(&sample.direction, i);
                let turns = libm::atan2(x, -z) / TAU + turn;
                let row = (libm::atan2(x.hypot(z), y) / PI * rows as f64) as usize;
                let column = ((turns - turns.floor()) * columns as f64) as usize;
                observed[row.min(rows - 1) * columns + column % columns] += 1;
            }
        }
        // Only by rounding, over the border of a cell.
        assert!(strayed < 2000, "{strayed} samples look up another density");
        let (mut sum, mut least) = (0.0, f64::INFINITY);
        let expected: Vec<f64> = (0..rows * columns)
            .map(|i| {
                let cos = |row: usize| (PI * row as f64 / rows as f64).cos();
                let (row, column) = (i / columns, i % columns);
                let theta = PI * (row as f64 + 0.5) / rows as f64;
                let phi = TAU * ((column as f64 + 0.5) / columns as f64 - turn);
                let (sin, y) = theta.sin_cos();
                let pdf = sky.pdf(splat([sin * phi.sin(), y, -sin * phi.cos()]));
                let pdf = f64::from(pdf.to_array()[0]);
                least = pdf.min(least);
                let chance = pdf * TAU / columns as f64 * (cos(row) - cos(row + 1));
                sum += chance;
                chance * SAMPLES as f64
            })
            .collect();
        assert_close(sum, 1.0, 1e-6, 0.0, "∫ pdf");
        assert!(least > 0.04 / (4.0 * PI), "least density {least}");
        let p = chi_square(&observed, &expected);
        assert!(p > SIGNIFICANCE, "degree {degree}: p = {p}");
    }
}

#[test]
fn a_black_series_is_a_black_sky() {
    let sky = Sky::compile(&Environment::Harmonics(harmonics(&[[0.0; 3]; 9])));
    assert_eq!(sky.integral_luminance(), 0.0);
}

/// A white sphere in the middle of the view, under this light.
fn sphere(light: Harmonics) -> Description {
    let mut description = scene(
        "[camera]\nposition = [0.0, 0.0, 4.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 20.0\n\
         [environment]\nconstant = [1.0, 1.0, 1.0]\n\
         [materials.white]\ntype = \"lambert\"\nalbedo = [1.0, 1.0, 1.0]\n\
         [[objects]]\nsphere = { center = [0.0, 0.0, 0.0], radius = 1.0 }\nmaterial = \"white\"\n",
    );
    description.environment = Some(Environment::Harmonics(light));
    description
}

#[test]
fn light_below_zero_takes_light_away_under_every_strategy() {
    // Radiance −1 + 0.2 z: every channel is negative everywhere. What a diffuse sphere reflects to the camera is known:
    // (1/π) ∫ L cos = L00 Y00 + (2/3) L10 Y10(n), and the pixel in the middle sees n = +z.
    let y = oracle::basis(1, [0.0, 0.0, 1.0]);
    let (c0, c1) = (-1.0 / y[0], 0.2 / y[2]);
    let light = [[c0; 3], [0.0; 3], [c1; 3], [0.0; 3]];
    let want = -1.0 + 2.0 / 3.0 * 0.2;
    let description = sphere(harmonics(&light));
    for strategy in STRATEGIES {
        let mut settings = settings(&description, (8, 8), 4096);
        settings.strategy = strategy;
        settings.path_length = 2;
        let film = film(&description, &settings);
        let (pixel, variance) = (film.means()[4 * 8 + 4], film.variances()[4 * 8 + 4]);
        for c in 0..3 {
            let off = (f64::from(pixel[c]) - want).abs();
            // The pixel's normals are up to 8 degrees from +z: 0.001 of the linear term.
            let allowed = 4.0 * f64::from(variance[c]).sqrt() + 2e-3;
            assert!(off < allowed, "{strategy}: {} is not {want}", pixel[c]);
        }
        assert!(mean_and_error(&film).0[0] < -0.5, "{strategy}");
    }
}

#[test]
fn strategies_agree_under_a_sky_that_rings() {
    let light = wild(6, 530);
    let description = sphere(harmonics(&light));
    let means: Vec<_> = STRATEGIES
        .iter()
        .map(|&strategy| {
            let mut settings = settings(&description, (16, 16), 1024);
            settings.strategy = strategy;
            mean_and_error(&film(&description, &settings))
        })
        .collect();
    for (mean, error) in &means[1..] {
        for c in 0..3 {
            let both = (error[c] * error[c] + means[0].1[c] * means[0].1[c]).sqrt();
            let z = (mean[c] - means[0].0[c]) / both;
            assert!(z.abs() < 4.0, "z = {z}");
        }
    }
}
