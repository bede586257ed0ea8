//! Constants and gradients.

use crate::common::*;
use crate::{ALL, luminance, y_to_z, z_to_y};
use ondine::lanes::{Rgb, WIDTH, f32x8};
use ondine::sampling::warp;
use ondine::scene::description::Environment;
use ondine::scene::environment::Sky;
use std::f64::consts::PI;

const GRADIENTS: [[Rgb; 3]; 5] = [
    [
        Rgb::new(0.2, 0.4, 1.0),
        Rgb::new(1.0, 0.9, 0.8),
        Rgb::new(0.3, 0.2, 0.1),
    ],
    [Rgb::WHITE, Rgb::BLACK, Rgb::BLACK],
    [Rgb::BLACK, Rgb::WHITE, Rgb::BLACK],
    [Rgb::BLACK, Rgb::BLACK, Rgb::splat(3.0)],
    [Rgb::WHITE, Rgb::WHITE, Rgb::WHITE],
];

pub fn gradient([zenith, horizon, ground]: [Rgb; 3]) -> Sky {
    Sky::compile(&Environment::Gradient {
        zenith,
        horizon,
        ground,
    })
}

fn gradient_oracle([zenith, horizon, ground]: [Rgb; 3], y: f64) -> [f64; 3] {
    let end = if y >= 0.0 { zenith } else { ground };
    let mix = |h: f32, e: f32| f64::from(h) + (f64::from(e) - f64::from(h)) * y.abs();
    [
        mix(horizon.r, end.r),
        mix(horizon.g, end.g),
        mix(horizon.b, end.b),
    ]
}

#[test]
fn gradients_agree_with_their_oracle_and_samples_with_their_pdf() {
    for (k, colours) in GRADIENTS.into_iter().enumerate() {
        let sky = gradient(colours);
        let [z, h, g] = colours.map(luminance);
        let total = PI * (z + 2.0 * h + g);
        assert_close(
            sky.integral_luminance().into(),
            total,
            1e-6,
            0.0,
            "integral",
        );
        let mut random = Random::new(94 + k as u64);
        for _ in 0..10_000 {
            let d = warp::uniform_sphere(random.pair());
            let (radiance, pdf) = sky.radiance_and_pdf(d);
            for i in 0..WIDTH {
                let want = gradient_oracle(colours, lane(&d, i)[1]);
                for (got, want) in radiance.lane(i).to_array().into_iter().zip(want) {
                    assert_close(got.into(), want, 1e-6, 1e-7, "radiance");
                }
                let want = 0.2126 * want[0] + 0.7152 * want[1] + 0.0722 * want[2];
                assert_close(pdf.to_array()[i].into(), want / total, 1e-6, 1e-7, "pdf");
            }
        }

        let mut sum = 0.0;
        let (p, integral) = chi_square_of_directions(
            |d| sky.pdf(z_to_y(d)),
            || {
                let sample = sky.sample(random.pair());
                let (radiance, pdf) = sky.radiance_and_pdf(sample.direction);
                assert_eq!(pdf.to_array(), sample.pdf.to_array());
                assert_eq!(radiance.r.to_array(), sample.radiance.r.to_array());
                let some = pdf.simd_gt(f32x8::ZERO);
                let share = sample.radiance.luminance() / pdf;
                sum += f64::from((share & some).reduce_add());
                let length = sample.direction.length_squared() - f32x8::ONE;
                assert!(length.abs().simd_lt(f32x8::splat(1e-6)).all());
                (y_to_z(sample.direction), ALL)
            },
        );
        assert!(p > SIGNIFICANCE, "gradient {k}: p = {p}");
        assert_close(integral, 1.0, 1e-5, 0.0, "∫ pdf");
        assert_close(sum / SAMPLES as f64, total, 1e-5, 0.0, "mean of L / pdf");
    }
}

#[test]
fn constants_are_constant() {
    let sky = Sky::compile(&Environment::Constant(Rgb::new(1.0, 2.0, 3.0)));
    let mut random = Random::new(100);
    let (p, _) = chi_square_of_directions(
        |d| sky.pdf(d),
        || {
            let sample = sky.sample(random.pair());
            assert_eq!(sample.radiance.lane(2), Rgb::new(1.0, 2.0, 3.0));
            (sample.direction, ALL)
        },
    );
    assert!(p > SIGNIFICANCE, "p = {p}");
    let want = 4.0 * PI * luminance(Rgb::new(1.0, 2.0, 3.0));
    assert_close(sky.integral_luminance().into(), want, 1e-6, 0.0, "integral");
}
