//! Environments against the textbook in double precision, and their samplers against their densities.

#[path = "../common/mod.rs"]
mod common;
mod gradients;

use common::*;
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8};
use ondine::sampling::warp;
use ondine::scene::description::{Environment, LatLong};
use ondine::scene::environment::Sky;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const ALL: f32x8 = f32x8::ONE;

fn luminance(c: Rgb) -> f64 {
    0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b)
}

fn lat_long(width: usize, height: usize, pixel: impl Fn(usize, usize) -> Rgb) -> Arc<LatLong> {
    Arc::new(LatLong {
        file: String::from("test"),
        width,
        height,
        pixels: (0..width * height)
            .map(|i| pixel(i % width, i / width))
            .collect(),
    })
}

fn sky(image: &Arc<LatLong>, rotate_degrees: f32) -> Sky {
    Sky::compile(&Environment::Image {
        image: Arc::clone(image),
        rotate_degrees,
    })
}

/// Black holes, a black row, a sun of 5000 and a dim rest, in colour.
fn harsh(width: usize, height: usize) -> Arc<LatLong> {
    lat_long(width, height, |x, y| {
        if (x * 7 + y * 3) % 5 == 0 || y == height / 3 || x == width - 1 {
            Rgb::BLACK
        } else if x == width / 4 && y == height / 4 {
            Rgb::new(5000.0, 4500.0, 3500.0)
        } else {
            let part = (x + 2 * y) as f32 / (width + 2 * height) as f32;
            Rgb::new(0.1 + part, 0.5, 1.5 - part)
        }
    })
}

/// The pixel that a direction of the world falls into, and how far it is from the pixel's border, in pixels.
fn pixel_oracle(image: &LatLong, rotate_degrees: f64, [x, y, z]: V) -> (usize, f64) {
    // Turn the direction back by the angle around +y, and invert (sin θ sin φ, cos θ, −sin θ cos φ).
    let (sin, cos) = rotate_degrees.to_radians().sin_cos();
    let (x, z) = (cos * x - sin * z, sin * x + cos * z);
    let theta = x.hypot(z).atan2(y);
    let turns = x.atan2(-z) / TAU;
    let column = (turns - turns.floor()) * image.width as f64;
    let row = theta / PI * image.height as f64;
    let index =
        (row as usize).min(image.height - 1) * image.width + (column as usize).min(image.width - 1);
    let border = |v: f64| (v - v.round()).abs();
    (index, border(column).min(border(row)))
}

fn solid_angle(image: &LatLong, y: usize) -> f64 {
    let cos = |y: usize| (PI * y as f64 / image.height as f64).cos();
    TAU / image.width as f64 * (cos(y) - cos(y + 1))
}

fn integral_oracle(image: &LatLong) -> f64 {
    (0..image.pixels.len())
        .map(|i| luminance(image.pixels[i]) * solid_angle(image, i / image.width))
        .sum()
}

#[test]
fn images_are_looked_up_where_the_convention_says() {
    let image = harsh(61, 23);
    let mut random = Random::new(80);
    for rotate in [0.0f32, 30.0, -77.0, 360.0, 725.0] {
        let sky = sky(&image, rotate);
        let total = integral_oracle(&image);
        assert_close(
            sky.integral_luminance().into(),
            total,
            1e-6,
            0.0,
            "integral",
        );
        for _ in 0..20_000 {
            let d = warp::uniform_sphere(random.pair());
            let (radiance, pdf) = (sky.radiance(d), sky.pdf(d));
            for i in 0..WIDTH {
                let (index, border) = pixel_oracle(&image, rotate.into(), lane(&d, i));
                if border > 1e-4 {
                    assert_eq!(radiance.lane(i), image.pixels[index]);
                    let want = luminance(image.pixels[index]) / total;
                    assert_close(pdf.to_array()[i].into(), want, 1e-6, 0.0, "pdf");
                }
            }
        }
    }
}

#[test]
fn the_middle_of_an_image_looks_along_z_and_turns_to_x() {
    // Four columns: the third begins at φ = π, which is +z; each quarter turn counter-clockwise brings z to x.
    let image = lat_long(4, 1, |x, _| Rgb::splat(1.0 + x as f32));
    let toward = |rotate: f32, d: V| sky(&image, rotate).radiance(splat(unit(d))).lane(0).r;
    let (a_bit_left, a_bit_right) = ([0.01, 0.0, 1.0], [-0.01, 0.0, 1.0]);
    assert_eq!(toward(0.0, a_bit_left), 2.0);
    assert_eq!(toward(0.0, a_bit_right), 3.0);
    assert_eq!(toward(90.0, [1.0, 0.0, -0.01]), 2.0);
    assert_eq!(toward(90.0, [1.0, 0.0, 0.01]), 3.0);
}

/// χ² over pixels; and that samples agree with look-ups, away from borders.
fn check_image(seed: u64, image: &Arc<LatLong>, rotate: f32) {
    let sky = sky(image, rotate);
    let total = integral_oracle(image);
    let mut random = Random::new(seed);
    let mut observed = vec![0; image.pixels.len()];
    let mut strayed = 0;
    let mut sum = 0.0;
    for _ in 0..SAMPLES / WIDTH {
        let sample = sky.sample(random.pair());
        let (radiance, pdf) = sky.radiance_and_pdf(sample.direction);
        for i in 0..WIDTH {
            let d = lane(&sample.direction, i);
            assert_close(dot(d, d), 1.0, 1e-6, 0.0, "length");
            let p = sample.pdf.to_array()[i];
            assert!(p > 0.0, "a pixel that is never to be drawn");
            sum += luminance(sample.radiance.lane(i)) / f64::from(p);
            let (index, border) = pixel_oracle(image, rotate.into(), d);
            if radiance.lane(i) != sample.radiance.lane(i) || pdf.to_array()[i] != p {
                strayed += 1;
                assert!(border < 2e-3, "look-up strays by {border} pixels at {d:?}");
            }
            // By the oracle's pixel, unless rounding carried the sample over a border: then the nearest alike.
            let alike = image.pixels[index] == sample.radiance.lane(i);
            observed[if alike {
                index
            } else {
                nearest(image, index, sample.radiance.lane(i))
            }] += 1;
        }
    }
    assert!(
        strayed < SAMPLES / 1000,
        "{strayed} samples look up elsewhere"
    );
    // Every L / pdf is the integral: the density is exactly proportional.
    assert_close(sum / SAMPLES as f64, total, 1e-6, 0.0, "mean of L / pdf");
    let expected: Vec<f64> = (0..observed.len())
        .map(|i| luminance(image.pixels[i]) * solid_angle(image, i / image.width) / total)
        .map(|p| p * SAMPLES as f64)
        .collect();
    for (i, &count) in observed.iter().enumerate() {
        assert!(
            expected[i] > 0.0 || count == 0,
            "black pixel {i} was drawn {count} times"
        );
    }
    let p = chi_square(&observed, &expected);
    assert!(
        p > SIGNIFICANCE,
        "{}x{} by {rotate}: p = {p}",
        image.width,
        image.height
    );
}

/// The neighbour of a pixel (or itself) with this radiance.
fn nearest(image: &LatLong, index: usize, radiance: Rgb) -> usize {
    let (width, height) = (image.width as isize, image.height as isize);
    let (x, y) = (index as isize % width, index as isize / width);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let other = (y + dy).clamp(0, height - 1) * width + (x + dx).rem_euclid(width);
            if image.pixels[other as usize] == radiance {
                return other as usize;
            }
        }
    }
    panic!("{radiance:?} is not around pixel {index}");
}

#[test]
fn image_samples_follow_luminance_times_solid_angle() {
    let even = lat_long(32, 16, |x, y| Rgb::splat(1.0 + ((x * y) % 7) as f32));
    check_image(81, &even, 0.0);
    check_image(82, &even, 123.0);
    check_image(83, &harsh(61, 23), -50.0);
    check_image(84, &lat_long(2, 1, |_, _| Rgb::WHITE), 0.0);
    check_image(85, &lat_long(5, 1, |x, _| Rgb::splat(x as f32)), 0.0);
    check_image(86, &lat_long(1, 5, |_, y| Rgb::splat((4 - y) as f32)), 10.0);
}

#[test]
fn inside_a_pixel_directions_are_uniform_even_at_the_poles() {
    // A single pixel of a big image: at the pole, next to it, at the equator, below it, at the other pole.
    let (width, height) = (2048, 1024);
    for (seed, row) in [(87, 0), (88, 1), (89, 511), (90, 512), (91, 1023)] {
        let image = lat_long(width, height, |x, y| {
            Rgb::splat(f32::from(u8::from(x == 300 && y == row)))
        });
        let sky = sky(&image, 0.0);
        let mut random = Random::new(seed);
        let mut observed = vec![0; 20 * 20];
        let border = |y: usize| 2.0 * (0.5 * PI * y as f64 / height as f64).sin().powi(2);
        let (top, bottom) = (border(row), border(row + 1));
        for _ in 0..SAMPLES / WIDTH {
            let sample = sky.sample(random.pair());
            for i in 0..WIDTH {
                let [x, y, z] = lane(&sample.direction, i);
                let r2 = x * x + z * z;
                let one_minus_y = if y > 0.0 { r2 / (1.0 + y) } else { 1.0 - y };
                // Near −y the distance from that pole is what single precision holds.
                let down = if y < -0.5 {
                    let from_south = r2 / (1.0 - y);
                    let (low, high) = (border(height - row), border(height - row - 1));
                    (from_south - low) / (high - low)
                } else {
                    (one_minus_y - top) / (bottom - top)
                };
                let turns = libm::atan2(x, -z) / TAU;
                let right = (turns - turns.floor()) * width as f64 - 300.0;
                assert!((-0.01..1.01).contains(&down), "row {row}: {down}");
                assert!((-0.01..1.01).contains(&right), "row {row}: column {right}");
                let bin = |v: f64| ((v * 20.0).max(0.0) as usize).min(19);
                observed[bin(down) * 20 + bin(right)] += 1;
            }
        }
        // Rounding of the azimuth moves 1 in 2000 over a bin's border: allow each bin that beside its chance.
        let want = SAMPLES as f64 / 400.0;
        for count in observed {
            let off = (f64::from(count) - want).abs();
            assert!(
                off < 5.0 * want.sqrt() + 0.02 * want,
                "row {row}: {count} for {want}"
            );
        }
    }
}

#[test]
fn the_last_pixel_with_light_is_reached_and_black_ones_are_not() {
    // Rounded sums of 1000 thirds: a table that ends below 1 would let `u` fall beyond it.
    let image = lat_long(1000, 4, |x, y| {
        Rgb::splat(if x < 990 && y < 3 { 1.0 / 3.0 } else { 0.0 })
    });
    let sky = sky(&image, 0.0);
    let last = 1.0 - 0.5 * f32::EPSILON;
    for u in [0.0, 0.5, last, 1.0] {
        for v in [0.0, 0.5, last, 1.0] {
            let sample = sky.sample((f32x8::splat(u), f32x8::splat(v)));
            assert!(sample.pdf.simd_gt(f32x8::ZERO).all(), "{u} {v}");
            assert!(sample.direction.length_squared().is_finite().all());
            // At u = 0 the direction is the pole itself, of every column.
            if v >= last && u > 0.0 {
                let (index, _) = pixel_oracle(&image, 0.0, lane(&sample.direction, 0));
                assert!(
                    [989, 990].contains(&(index % 1000)),
                    "column {}",
                    index % 1000
                );
            }
        }
    }
    // A sun at the end of a row takes all but 10⁻⁷ of it.
    let sun = lat_long(2000, 1, |x, _| {
        Rgb::splat(if x == 1500 { 1e9 } else { 0.01 })
    });
    let sample = self::sky(&sun, 0.0).sample((f32x8::splat(0.5), f32x8::splat(last)));
    assert!(sample.pdf.simd_gt(f32x8::ZERO).all());
}

#[test]
fn even_images_are_drawn_evenly() {
    // Of 2 million equal pixels, a running sum over all in single precision would not tell one from the next.
    for (seed, width, height) in [(92, 2048, 1024), (102, 1, 1), (103, 3, 3)] {
        let image = lat_long(width, height, |_, _| Rgb::splat(0.3));
        let sky = sky(&image, 0.0);
        let total = 4.0 * PI * f64::from(0.3f32);
        assert_close(
            sky.integral_luminance().into(),
            total,
            1e-6,
            0.0,
            "integral",
        );
        let mut random = Random::new(seed);
        let (p, _) = chi_square_of_directions(
            |_| f32x8::splat(warp::UNIFORM_SPHERE_PDF),
            || {
                let sample = sky.sample(random.pair());
                let off = sample.pdf - f32x8::splat(warp::UNIFORM_SPHERE_PDF);
                assert!(off.abs().simd_lt(f32x8::splat(1e-6)).all());
                (y_to_z(sample.direction), ALL)
            },
        );
        assert!(p > SIGNIFICANCE, "{width}x{height}: p = {p}");
    }
}

#[test]
fn strata_of_the_square_stay_strata_of_the_sky() {
    // 64 × 64 jittered points on an even image: every one of 64 equal bands has its 64 points.
    let image = lat_long(64, 32, |_, _| Rgb::WHITE);
    let sky = sky(&image, 0.0);
    let mut random = Random::new(93);
    let mut bands = [0; 64];
    for row in 0..64 {
        for column in 0..8 {
            let u = (random.eight() * 0.98 + f32x8::splat(row as f32 + 0.01)) * (1.0 / 64.0);
            let v = f32x8::splat((column as f32 + 0.5) / 8.0);
            let d = sky.sample((u, v)).direction;
            for y in d.y.to_array() {
                bands[((1.0 - f64::from(y)) * 32.0) as usize] += 1;
            }
        }
    }
    assert_eq!(bands, [64; 64]);
}

/// The helper's z is up; here y is.
fn y_to_z(d: Vec3x8) -> Vec3x8 {
    Vec3x8::new(d.z, d.x, d.y)
}

fn z_to_y(d: Vec3x8) -> Vec3x8 {
    Vec3x8::new(d.y, d.z, d.x)
}

#[test]
fn pdfs_of_images_integrate_to_one() {
    let image = harsh(61, 23);
    let sky = sky(&image, 20.0);
    let mut random = Random::new(99);
    let (mean, error) = mean(SAMPLES / WIDTH, || {
        let d = warp::uniform_sphere(random.pair());
        ondine::lanes::Rgbx8::gray(sky.pdf(d) * (1.0 / warp::UNIFORM_SPHERE_PDF))
    });
    assert_close(mean, 1.0, 0.0, 4.0 * error, "∫ pdf");
    // And exactly, pixel by pixel at their middles.
    let mut sum = 0.0;
    for i in 0..image.pixels.len() {
        let (x, y) = (i % 61, i / 61);
        let theta = PI * (y as f64 + 0.5) / 23.0;
        let phi = TAU * (x as f64 + 0.5) / 61.0 - 20f64.to_radians();
        let d = [
            theta.sin() * phi.sin(),
            theta.cos(),
            -theta.sin() * phi.cos(),
        ];
        sum += f64::from(sky.pdf(splat(d)).to_array()[0]) * solid_angle(&image, y);
    }
    assert_close(sum, 1.0, 1e-6, 0.0, "∫ pdf");
}

#[test]
fn black_environments_are_black_and_panic_nowhere() {
    let mut random = Random::new(101);
    for sky in [
        Sky::compile(&Environment::Constant(Rgb::BLACK)),
        gradients::gradient([Rgb::BLACK; 3]),
        sky(&lat_long(1, 1, |_, _| Rgb::BLACK), 45.0),
        sky(&lat_long(7, 3, |_, _| Rgb::BLACK), 0.0),
        sky(&lat_long(0, 0, |_, _| Rgb::BLACK), 0.0),
    ] {
        assert_eq!(sky.integral_luminance(), 0.0);
        let sample = sky.sample(random.pair());
        assert_eq!(sample.radiance.lane(0), Rgb::BLACK);
        assert!(sample.pdf.simd_gt(f32x8::ZERO).all());
        assert_eq!(sky.radiance(sample.direction).lane(0), Rgb::BLACK);
        assert_eq!(sky.pdf(sample.direction).to_array(), sample.pdf.to_array());
    }
}

#[test]
fn directions_that_are_not_finite_panic_nowhere() {
    // Dead lanes hold arbitrary bits.
    let sky = sky(&harsh(8, 4), 10.0);
    for v in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -1e38] {
        let v = f32x8::splat(v);
        let _ = sky.radiance_and_pdf(Vec3x8::new(v, v, v));
        let _ = sky.sample((v, v));
    }
}
