//! Projection of lat-long images.

use crate::common::Random;
use crate::draws::difference;
use crate::oracle::basis;
use ondine::lanes::{Rgb, Vec3x8, f32x8};
use ondine::scene::description::{Environment, LatLong};
use ondine::scene::environment::Sky;
use ondine::sh::{coefficients, index, project};
use std::f64::consts::PI;
use std::sync::Arc;

/// Noise with a few bright pixels.
fn noise(width: usize, seed: u64) -> Vec<Rgb> {
    let mut random = Random::new(seed);
    let bright = |value: f32| if value > 0.98 { 100.0 * value } else { value };
    (0..width * width / 2)
        .map(|_| Rgb::from(std::array::from_fn(|_| bright(random.one()))))
        .collect()
}

/// The direction at fractions of the image's width and height.
fn at(x: f64, y: f64) -> [f64; 3] {
    let ((sin_phi, cos_phi), (sin, cos)) = ((2.0 * PI * x).sin_cos(), (PI * y).sin_cos());
    [sin * sin_phi, cos, -sin * cos_phi]
}

/// Four-point Gauss–Legendre quadrature over `cells` parts of each side of each pixel.
fn by_quadrature(width: usize, pixels: &[Rgb], degree: usize, cells: usize) -> Vec<[f64; 3]> {
    const RULE: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let height = width / 2;
    let mut sums = vec![[0.0; 3]; coefficients(degree)];
    let (dx, dy) = ((width * cells) as f64, (height * cells) as f64);
    for row in 0..height * cells {
        for column in 0..width * cells {
            let pixel = pixels[row / cells * width + column / cells].to_array();
            for (u, wu) in RULE {
                for (v, wv) in RULE {
                    let (x, y) = (column as f64 + 0.5 + 0.5 * u, row as f64 + 0.5 + 0.5 * v);
                    let sin = (PI * y / dy).sin();
                    let weight = 0.25 * wu * wv * (2.0 * PI / dx) * (PI / dy) * sin;
                    let values = basis(degree, at(x / dx, y / dy));
                    for (sum, value) in sums.iter_mut().zip(values) {
                        for (sum, pixel) in sum.iter_mut().zip(pixel) {
                            *sum += weight * value * f64::from(pixel);
                        }
                    }
                }
            }
        }
    }
    sums
}

#[test]
fn coefficients_are_the_integrals_over_pixels() {
    for (width, degree, cells) in [(2, 3, 32), (4, 8, 32), (18, 6, 8), (32, 9, 4)] {
        let pixels = noise(width, width as u64);
        let probe = project(width, width / 2, &pixels, degree).unwrap();
        let wanted = by_quadrature(width, &pixels, degree, cells);
        let error = difference(&probe.coefficients, &wanted);
        assert!(error < 1e-11, "{width}, degree {degree}: {error:e}");
    }
}

#[test]
fn a_constant_image_has_one_coefficient() {
    for (width, degree) in [(2, 20), (6, 128), (256, 64), (1000, 8)] {
        let pixels = vec![Rgb::new(1.0, 2.0, 4.0); width * width / 2];
        let probe = project(width, width / 2, &pixels, degree).unwrap();
        for (k, rgb) in probe.coefficients.iter().enumerate() {
            let wanted = if k == 0 { (4.0 * PI).sqrt() } else { 0.0 };
            for (value, scale) in rgb.iter().zip([1.0, 2.0, 4.0]) {
                let error = value / scale - wanted;
                assert!(error.abs() < 1e-13, "{width}: coefficient {k}: {error:e}");
            }
        }
    }
}

/// A black image but for one pixel, whose direction the sky itself is asked for.
#[test]
fn a_pixel_lies_where_the_sky_sees_it() {
    let (width, height) = (64, 32);
    for pixel in [0, 17, 16 * 64 + 5, 20 * 64 + 40, 31 * 64 + 63] {
        let mut pixels = vec![Rgb::BLACK; width * height];
        pixels[pixel] = Rgb::WHITE;
        let probe = project(width, height, &pixels, 1).unwrap();
        let [y, z, x] = [1, 2, 3].map(|k| probe.coefficients[k][0] as f32);
        let towards = Vec3x8::new(f32x8::splat(x), f32x8::splat(y), f32x8::splat(z)).normalize();
        let sky = Sky::compile(&Environment::Image {
            image: Arc::new(LatLong {
                file: String::new(),
                width,
                height,
                pixels,
            }),
            rotate_degrees: 0.0,
        });
        assert_eq!(sky.radiance(towards).lane(0), Rgb::WHITE, "{pixel}");
    }
}

#[test]
fn an_image_of_a_function_has_its_coefficients_to_second_order() {
    // Y₃₋₂ at pixel centres: what is left is the pixels' size.
    let error = |width: usize| {
        let height = width / 2;
        let value = |x: usize, y: usize| {
            let (x, y) = (
                (x as f64 + 0.5) / width as f64,
                (y as f64 + 0.5) / height as f64,
            );
            basis(3, at(x, y))[index(3, -2)] as f32
        };
        let pixels: Vec<Rgb> = (0..width * height)
            .map(|i| Rgb::splat(value(i % width, i / width)))
            .collect();
        let mut wanted = vec![[0.0; 3]; coefficients(5)];
        wanted[index(3, -2)] = [1.0; 3];
        difference(
            &project(width, height, &pixels, 5).unwrap().coefficients,
            &wanted,
        )
    };
    let [coarse, fine] = [64, 256].map(error);
    assert!(coarse < 5e-3 && fine < coarse / 15.0, "{coarse:e} {fine:e}");
}

#[test]
fn threads_change_no_bit() {
    let pixels = noise(600, 5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| project(600, 300, &pixels, 12).unwrap())
    };
    let one = on(1);
    for threads in [2, 3, 7] {
        assert_eq!(on(threads), one, "{threads} threads");
    }
}

#[test]
fn what_is_no_sky_is_refused() {
    let white = vec![Rgb::WHITE; 32];
    let message =
        |width, height, pixels: &[Rgb]| project(width, height, pixels, 2).unwrap_err().to_string();
    assert!(message(8, 8, &white).contains("twice as wide"));
    assert!(message(8, 4, &white[1..]).contains("twice as wide"));
    assert!(message(0, 0, &[]).contains("twice as wide"));
    let mut broken = white.clone();
    broken[19].g = f32::NAN;
    assert!(message(8, 4, &broken).contains("pixel (3, 2) is not finite"));
    broken[19].g = f32::INFINITY;
    assert!(message(8, 4, &broken).contains("pixel (3, 2) is not finite"));
}
