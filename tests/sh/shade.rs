//! Shading by the double sum, and images from coefficients.

use crate::common::{Random, V, dot, lane};
use crate::draws::{difference, direction, random_coefficients};
use crate::oracle::sum;
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8};
use ondine::sh::{Lobe, PUBLISHED, Probe, Shading, Window, index, project, published};
use std::f64::consts::PI;

fn wide(vectors: [V; WIDTH]) -> Vec3x8 {
    let [x, y, z] = [0, 1, 2].map(|axis| f32x8::new(vectors.map(|v| v[axis] as f32)));
    Vec3x8::new(x, y, z)
}

/// The unit vector that single precision made of a direction.
fn rounded(v: &Vec3x8, i: usize) -> V {
    crate::common::unit(lane(v, i))
}

/// Irradiance by equation 13 of Ramamoorthi & Hanrahan 2001, with c1 to c5.
fn irradiance(light: &[[f64; 3]], [c1, c2, c3, c4, c5]: [f64; 5], [x, y, z]: V) -> [f64; 3] {
    std::array::from_fn(|channel| {
        let at = |l, m| light[index(l, m)][channel];
        c1 * at(2, 2) * (x * x - y * y) + c3 * at(2, 0) * z * z + c4 * at(0, 0) - c5 * at(2, 0)
            + 2.0 * c1 * (at(2, -2) * x * y + at(2, 1) * x * z + at(2, -1) * y * z)
            + 2.0 * c2 * (at(1, 1) * x + at(1, -1) * y + at(1, 0) * z)
    })
}

/// As they were printed. The second and third are off by 6.5e-7 and 1.1e-6.
const PRINTED: [f64; 5] = [0.429043, 0.511664, 0.743125, 0.886227, 0.247708];

/// What they stand for.
fn constants() -> [f64; 5] {
    let second = PI / 4.0 * (5.0 / (16.0 * PI)).sqrt();
    [
        PI / 4.0 * (15.0 / (16.0 * PI)).sqrt(),
        PI / 3.0 * (3.0 / (4.0 * PI)).sqrt(),
        3.0 * second,
        PI * (1.0 / (4.0 * PI)).sqrt(),
        second,
    ]
}

#[test]
fn the_double_sum_is_the_published_irradiance() {
    let mut random = Random::new(1);
    for name in PUBLISHED {
        let light = published(name).unwrap();
        let convolved = light.convolved(Lobe::Cosine).unwrap();
        // A white surface sends out 1/π of it.
        let shading = Shading::new(&light, Lobe::Cosine, Rgb::WHITE).unwrap();
        let (mut greatest, mut from_exact, mut from_printed) = (0f64, 0f64, 0f64);
        for _ in 0..10_000 / WIDTH {
            let normal = wide(std::array::from_fn(|_| direction(&mut random)));
            let shaded = shading.shade(normal, normal);
            for i in 0..WIDTH {
                let n = rounded(&normal, i);
                let exact = irradiance(&light.coefficients, constants(), n);
                let double = difference(&[sum(&convolved.coefficients, n)], &[exact]);
                assert!(double < 1e-14, "{name}, double precision: {double:e}");
                let rgb = shaded.lane(i).to_array().map(|value| PI * f64::from(value));
                from_exact = from_exact.max(difference(&[rgb], &[exact]));
                let printed = irradiance(&light.coefficients, PRINTED, n);
                from_printed = from_printed.max(difference(&[rgb], &[printed]));
                greatest = exact.into_iter().fold(greatest, f64::max);
            }
        }
        assert!(from_exact < 1e-6, "{name}: {from_exact:e}");
        assert!(
            from_printed < 1e-6 * greatest,
            "{name}: {from_printed:e} of {greatest}"
        );
    }
}

/// `∫ lobe · light dω` about an axis, by the rule of rectangles in azimuth and in the cosine's square root.
fn by_quadrature(light: &Probe, axis: V, exponent: f64) -> [f64; 3] {
    let (n, m) = (400, 32);
    let helper = if axis[0].abs() < 0.5 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let cross = |a: V, b: V| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let u = crate::common::unit(cross(axis, helper));
    let v = cross(axis, u);
    let mut total = [0.0; 3];
    for i in 0..n {
        let cos = (f64::from(i) + 0.5) / f64::from(n);
        let sin = (1.0 - cos * cos).sqrt();
        let weight = cos.powf(exponent) * 2.0 * PI / f64::from(n * m);
        for k in 0..m {
            let (s, c) = (2.0 * PI * f64::from(k) / f64::from(m)).sin_cos();
            let d = std::array::from_fn(|a| axis[a] * cos + sin * (u[a] * c + v[a] * s));
            let radiance = sum(&light.coefficients, d);
            (0..3).for_each(|c| total[c] += weight * radiance[c]);
        }
    }
    total
}

#[test]
fn shading_is_the_integral_of_light_and_lobe() {
    let mut random = Random::new(2);
    let light = Probe::radiance(random_coefficients(&mut random, 7)).unwrap();
    let albedo = Rgb::new(0.9, 0.5, 0.1);
    for lobe in [Lobe::Cosine, Lobe::Phong(1.0), Lobe::Phong(12.5)] {
        let shading = Shading::new(&light, lobe, albedo).unwrap();
        for _ in 0..3 {
            let normal = wide(std::array::from_fn(|_| direction(&mut random)));
            let outgoing = wide(std::array::from_fn(|_| direction(&mut random)));
            let shaded = shading.shade(normal, outgoing);
            let (n, o) = (rounded(&normal, 0), rounded(&outgoing, 0));
            let mirror = std::array::from_fn(|a| 2.0 * dot(n, o) * n[a] - o[a]);
            let wanted = match lobe {
                Lobe::Cosine => by_quadrature(&light, n, 1.0).map(|e| e / PI),
                Lobe::Phong(exponent) => by_quadrature(&light, mirror, exponent)
                    .map(|e| e * (exponent + 1.0) / (2.0 * PI)),
            };
            let got = shaded.lane(0).to_array().map(f64::from);
            let wanted = std::array::from_fn(|c| wanted[c] * f64::from(albedo.to_array()[c]));
            let error = difference(&[got], &[wanted]);
            assert!(error < 2e-4, "{lobe}: {error:e}");
        }
    }
}

#[test]
fn in_a_furnace_all_send_out_its_radiance() {
    let white = vec![Rgb::splat(2.0); 32 * 16];
    let light = project(32, 16, &white, 20).unwrap();
    let mut random = Random::new(3);
    for lobe in [
        Lobe::Cosine,
        Lobe::Phong(0.0),
        Lobe::Phong(50.0),
        Lobe::Phong(1e6),
    ] {
        let shading = Shading::new(&light, lobe, Rgb::splat(0.5)).unwrap();
        let [normal, outgoing] =
            [(); 2].map(|()| wide(std::array::from_fn(|_| direction(&mut random))));
        let shaded = shading.shade(normal, outgoing);
        for value in shaded.lane(3).to_array() {
            assert!((value - 1.0).abs() < 1e-6, "{lobe}: {value}");
        }
    }
}

#[test]
fn light_that_was_convolved_is_not_convolved_again() {
    let light = published("uffizi")
        .unwrap()
        .convolved(Lobe::Cosine)
        .unwrap();
    let error = Shading::new(&light, Lobe::Phong(10.0), Rgb::WHITE).unwrap_err();
    assert!(
        error.to_string().contains("convolved with cosine"),
        "{error}"
    );
}

#[test]
fn an_image_of_coefficients_has_them_to_the_size_of_its_pixels() {
    let light = Probe::radiance(random_coefficients(&mut Random::new(4), 8)).unwrap();
    let error = |height: usize| {
        let pixels = light.reconstruct(height);
        let again = project(2 * height, height, &pixels, 8).unwrap();
        difference(&again.coefficients, &light.coefficients)
    };
    let [coarse, fine, finest] = [64, 256, 512].map(error);
    // (l Δ)²/24 in each direction, and single precision.
    assert!(coarse < 2e-2 && fine < coarse / 15.0, "{coarse:e} {fine:e}");
    assert!(finest < 3e-4, "{finest:e}");
}

#[test]
fn threads_change_no_bit_of_an_image() {
    let light = Probe::radiance(random_coefficients(&mut Random::new(5), 12)).unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| light.reconstruct(37))
    };
    let one = on(1);
    assert_eq!(one.len(), 37 * 74);
    for threads in [2, 5] {
        assert_eq!(on(threads), one, "{threads} threads");
    }
}

#[test]
fn windows_fall_from_one_and_less_rings_below_zero() {
    for window in [Window::Hanning, Window::Lanczos] {
        let factors: Vec<f64> = (0..=8).map(|l| window.factor(l, 8)).collect();
        assert_eq!(factors[0], 1.0);
        assert!(
            factors.windows(2).all(|pair| pair[1] < pair[0]),
            "{factors:?}"
        );
        assert!(factors[8] > 0.0, "the last degree counts");
    }
    // A bright pixel in the dark.
    let mut pixels = vec![Rgb::BLACK; 64 * 32];
    pixels[16 * 64 + 32] = Rgb::WHITE;
    let light = project(64, 32, &pixels, 8).unwrap();
    let ringing = |window| {
        let image = light.windowed(window).reconstruct(32);
        let values = image.iter().map(|pixel| pixel.r);
        let (low, high) = values.fold((0f32, 0f32), |(low, high), v| (low.min(v), high.max(v)));
        -low / high
    };
    let [none, lanczos, hanning] = [Window::None, Window::Lanczos, Window::Hanning].map(ringing);
    assert!(
        none > 0.1 && lanczos < 0.5 * none && hanning < lanczos,
        "{none} {lanczos} {hanning}"
    );
}
