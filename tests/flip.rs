//! ꟻLIP against a scalar oracle in double precision, written as the papers have it: whole kernels, one pixel at a time.

mod common;

use common::Random;
use ondine::compare::flip::{Exposures, Flip, hdr, ldr};
use std::f64::consts::PI;

/// What single precision may differ by. The root of a difference of features near 0 is what needs most.
const TOLERANCE: f64 = 3e-4;

const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

type Planes = [Vec<f32>; 3];
type Colour = [f64; 3];

/// An image of double precision, whose border goes on.
struct Image {
    width: i64,
    height: i64,
    pixels: Vec<Colour>,
}

impl Image {
    fn new(planes: &Planes, width: usize, show: impl Fn(f64) -> f64) -> Self {
        let pixels = (0..planes[0].len())
            .map(|i| [0, 1, 2].map(|c| show(f64::from(planes[c][i]))))
            .collect();
        Self {
            width: width as i64,
            height: (planes[0].len() / width) as i64,
            pixels,
        }
    }

    fn map(&self, f: impl Fn(Colour) -> Colour) -> Self {
        Self {
            pixels: self.pixels.iter().map(|&pixel| f(pixel)).collect(),
            ..*self
        }
    }

    fn at(&self, x: i64, y: i64) -> Colour {
        let (x, y) = (x.clamp(0, self.width - 1), y.clamp(0, self.height - 1));
        self.pixels[(y * self.width + x) as usize]
    }

    /// Σ kernel(dx, dy) · pixel, for each channel and pixel.
    fn filtered(&self, radius: i64, kernels: &[Vec<f64>; 3]) -> Vec<Colour> {
        let mut all = Vec::new();
        for y in 0..self.height {
            for x in 0..self.width {
                let mut sum = [0.0; 3];
                let mut tap = 0;
                for dy in -radius..=radius {
                    for dx in -radius..=radius {
                        let pixel = self.at(x + dx, y + dy);
                        (0..3).for_each(|c| sum[c] += kernels[c][tap] * pixel[c]);
                        tap += 1;
                    }
                }
                all.push(sum);
            }
        }
        all
    }
}

/// A kernel over the plane, row after row.
fn kernel(radius: i64, weight: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let side = -radius..=radius;
    side.clone()
        .flat_map(|y| side.clone().map(move |x| (x as f64, y as f64)))
        .map(|(x, y)| weight(x, y))
        .collect()
}

fn normalised(kernel: Vec<f64>) -> Vec<f64> {
    let sum: f64 = kernel.iter().sum();
    kernel.iter().map(|weight| weight / sum).collect()
}

/// Positive weights add up to 1, negative to −1.
fn balanced(kernel: Vec<f64>) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = kernel.iter().filter(|weight| **weight < 0.0).sum();
    kernel
        .iter()
        .map(|&weight| weight / if weight > 0.0 { positive } else { -negative })
        .collect()
}

fn to_xyz([r, g, b]: Colour) -> Colour {
    [
        0.4123907993 * r + 0.3575843394 * g + 0.1804807884 * b,
        0.2126390059 * r + 0.7151686788 * g + 0.0721923154 * b,
        0.0193308187 * r + 0.1191947798 * g + 0.9505321522 * b,
    ]
}

/// Cramer's rule on the matrix above.
fn from_xyz(xyz: Colour) -> Colour {
    let columns = [
        to_xyz([1.0, 0.0, 0.0]),
        to_xyz([0.0, 1.0, 0.0]),
        to_xyz([0.0, 0.0, 1.0]),
    ];
    let determinant = |[a, b, c]: [Colour; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
            + c[0] * (a[1] * b[2] - a[2] * b[1])
    };
    std::array::from_fn(|i| {
        let mut replaced = columns;
        replaced[i] = xyz;
        determinant(replaced) / determinant(columns)
    })
}

/// X, Y, Z over those of white.
fn relative(rgb: Colour) -> Colour {
    let white = to_xyz([1.0; 3]);
    let xyz = to_xyz(rgb);
    std::array::from_fn(|i| xyz[i] / white[i])
}

fn hunt(rgb: Colour) -> Colour {
    let delta = 6.0 / 29.0_f64;
    let [x, y, z] = relative(rgb).map(|t| {
        if t > delta.powi(3) {
            t.cbrt()
        } else {
            t / (3.0 * delta * delta) + 4.0 / 29.0
        }
    });
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

fn hyab(a: Colour, b: Colour) -> f64 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// Linear R, G, B as the eye sees them, after filters of contrast.
fn blurred(image: &Image) -> Vec<Colour> {
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
    let contrast = |terms: &[(f64, f64)]| {
        normalised(kernel(radius, |x, y| {
            let d2 = (x * x + y * y) / (PIXELS_PER_DEGREE * PIXELS_PER_DEGREE);
            let term = |(a, b): &(f64, f64)| a * (PI / b).sqrt() * (-PI * PI * d2 / b).exp();
            terms.iter().map(term).sum()
        }))
    };
    let kernels = [
        contrast(&[(1.0, 0.0047)]),
        contrast(&[(1.0, 0.0053)]),
        contrast(&[(34.1, 0.04), (13.5, 0.025)]),
    ];
    let opponents = image.map(|rgb| {
        let [x, y, z] = relative(rgb);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    });
    let white = to_xyz([1.0; 3]);
    let filtered = opponents.filtered(radius, &kernels);
    filtered
        .iter()
        .map(|[yy, cx, cz]| {
            let y = (yy + 16.0) / 116.0;
            let xyz = [
                (y + cx / 500.0) * white[0],
                y * white[1],
                (y - cz / 200.0) * white[2],
            ];
            from_xyz(xyz).map(|channel| channel.clamp(0.0, 1.0))
        })
        .collect()
}

/// How strong edges and points are at each pixel.
fn features(image: &Image) -> Vec<[f64; 2]> {
    let deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i64;
    let bell = |x: f64, y: f64| (-(x * x + y * y) / (2.0 * deviation * deviation)).exp();
    let luminance = image.map(|rgb| [relative(rgb)[1]; 3]);
    let strengths = |weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let across = balanced(kernel(radius, |x, y| weight(x) * bell(x, y)));
        let down = balanced(kernel(radius, |x, y| weight(y) * bell(x, y)));
        let none = vec![0.0; across.len()];
        let filtered = luminance.filtered(radius, &[across, down, none]);
        filtered.iter().map(|[a, b, _]| a.hypot(*b)).collect()
    };
    let edges = strengths(&|x| -x);
    let points = strengths(&|x| x * x / (deviation * deviation) - 1.0);
    edges
        .into_iter()
        .zip(points)
        .map(|(edge, point)| [edge, point])
        .collect()
}

fn oracle(reference: &Image, test: &Image) -> Vec<f64> {
    let greatest = hyab(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0])).powf(0.7);
    let (knee, level) = (0.4 * greatest, 0.95);
    let colours = blurred(reference).into_iter().zip(blurred(test));
    let features = features(reference).into_iter().zip(features(test));
    colours
        .zip(features)
        .map(|((a, b), (f, g))| {
            let distance = hyab(hunt(a), hunt(b)).powf(0.7);
            let colour = if distance < knee {
                level / knee * distance
            } else {
                level + (distance - knee) / (greatest - knee) * (1.0 - level)
            };
            let feature = (f[0] - g[0]).abs().max((f[1] - g[1]).abs());
            colour.powf(1.0 - (feature / 2.0_f64.sqrt()).sqrt())
        })
        .collect()
}

fn aces(x: f64) -> f64 {
    let x = 0.6 * x.max(0.0);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

fn hdr_oracle(reference: &Planes, test: &Planes, width: usize, exposures: Exposures) -> Vec<f64> {
    let mut most = vec![0.0_f64; reference[0].len()];
    let (start, stop) = (f64::from(exposures.start), f64::from(exposures.stop));
    for i in 0..exposures.count {
        let exposure = start + (stop - start) * f64::from(i) / f64::from(exposures.count - 1);
        let show = |x: f64| aces(x * exposure.exp2());
        let [a, b] = [reference, test].map(|planes| Image::new(planes, width, show));
        let errors = oracle(&a, &b);
        most.iter_mut()
            .zip(errors)
            .for_each(|(most, error)| *most = most.max(error));
    }
    most
}

/// Patches of colour, and the same with noise; some of both is brighter than white.
fn pair(seed: u64, width: usize, height: usize, bright: f32) -> [Planes; 2] {
    let mut random = Random::new(seed);
    let patches: Vec<f32> = (0..3 * 64).map(|_| random.one()).collect();
    let mut planes: [Planes; 2] = Default::default();
    for y in 0..height {
        for x in 0..width {
            let patch = (x / 7 + 3 * (y / 5)) % 64;
            for c in 0..3 {
                let value = patches[3 * patch + c];
                let value = value * value * bright;
                planes[0][c].push(value);
                planes[1][c].push(value * (0.7 + 0.6 * random.one()));
            }
        }
    }
    planes
}

fn assert_close(name: &str, flip: &Flip, oracle: &[f64]) {
    assert_eq!(flip.map.len(), oracle.len());
    for (i, (&found, &expected)) in flip.map.iter().zip(oracle).enumerate() {
        let difference = (f64::from(found) - expected).abs();
        assert!(
            difference < TOLERANCE,
            "{name}, pixel {i}: {found}, not {expected}"
        );
    }
    let mean = oracle.iter().sum::<f64>() / oracle.len() as f64;
    assert!(
        (flip.mean - mean).abs() < TOLERANCE,
        "{name}: {}, not {mean}",
        flip.mean
    );
}

#[test]
fn pictures_are_as_different_as_the_paper_says() {
    for (width, height) in [(45, 31), (1, 1), (1, 40), (33, 1), (150, 70)] {
        let [reference, test] = pair(1, width, height, 1.2);
        let images =
            [&reference, &test].map(|planes| Image::new(planes, width, |x| x.clamp(0.0, 1.0)));
        let expected = oracle(&images[0], &images[1]);
        assert_close(
            &format!("{width}x{height}"),
            &ldr(&reference, &test, width),
            &expected,
        );
    }
}

#[test]
fn radiance_is_as_different_as_at_the_exposure_that_shows_it_best() {
    let [mut reference, test] = pair(2, 60, 40, 9.0);
    // A light, and a pixel below nothing.
    reference[1][70] = 300.0;
    reference[2][900] = -1.0;
    let exposures = Exposures::of(&reference);
    assert!(exposures.count > 4, "{exposures:?}");
    let flip = hdr(&reference, &test, 60, exposures);
    assert_close("hdr", &flip, &hdr_oracle(&reference, &test, 60, exposures));
    assert!(flip.mean > 0.01);
}

/// What flip-evaluator 1.7 says of ramps that are off by a tenth.
#[test]
fn exposures_go_from_the_greatest_luminance_to_the_upper_median() {
    let grey = |values: &[f32]| -> Planes { std::array::from_fn(|_| values.to_vec()) };
    for (values, start, stop, count, mean) in [
        (
            &[1.0, 2.0, 3.0, 4.0][..],
            -0.916_702_8,
            -0.501_665_35,
            2,
            0.087_905_33,
        ),
        (
            &[1.0, 2.0, 3.0],
            -0.501_665_35,
            0.083_297_2,
            2,
            0.083_723_64,
        ),
        (
            &[1.0, 10.0, 100.0, 1000.0],
            -8.882_487,
            -5.560_559_3,
            4,
            0.080_010_27,
        ),
        (
            &[0.0, 0.0, 0.0, 1.0],
            1.083_297_3,
            24.083_298,
            23,
            0.038_429_91,
        ),
    ] {
        let reference = grey(values);
        let test = grey(&values.iter().map(|value| value * 1.1).collect::<Vec<_>>());
        let exposures = Exposures::of(&reference);
        assert!(
            (exposures.start - start).abs() < 1e-5,
            "{values:?}: {exposures:?}"
        );
        assert!(
            (exposures.stop - stop).abs() < 1e-5,
            "{values:?}: {exposures:?}"
        );
        assert_eq!(exposures.count, count, "{values:?}");
        let flip = hdr(&reference, &test, values.len(), exposures);
        assert!(
            (flip.mean - mean).abs() < 1e-4,
            "{values:?}: {}, not {mean}",
            flip.mean
        );
    }
}

#[test]
fn equal_images_do_not_differ_and_black_from_white_does() {
    let black: Planes = std::array::from_fn(|_| vec![0.0; 600]);
    let white: Planes = std::array::from_fn(|_| vec![1.0; 600]);
    assert_eq!(ldr(&white, &white, 30).map, vec![0.0; 600]);
    let [reference, _] = pair(3, 30, 20, 4.0);
    assert_eq!(
        hdr(&reference, &reference, 30, Exposures::of(&reference)).mean,
        0.0
    );
    assert!(ldr(&black, &white, 30).mean > 0.95);
    // What is black at every exposure against any light.
    assert!(hdr(&black, &white, 30, Exposures::of(&black)).mean > 0.95);
}

#[test]
fn no_number_is_too_strange() {
    let strange = [
        0.0,
        -1.0,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN_POSITIVE,
        -0.0,
        1e-45,
    ];
    let mut random = Random::new(4);
    let mut plane = || -> Vec<f32> {
        (0..300)
            .map(|_| strange[(random.one() * strange.len() as f32) as usize])
            .collect()
    };
    let [reference, test]: [Planes; 2] = std::array::from_fn(|_| std::array::from_fn(|_| plane()));
    let exposures = Exposures::of(&reference);
    assert!(exposures.count < 200, "{exposures:?}");
    for flip in [
        hdr(&reference, &test, 20, exposures),
        ldr(&reference, &test, 20),
    ] {
        assert!(flip.map.iter().all(|error| (0.0..=1.0).contains(error)));
    }
    let nothing = Planes::default();
    assert_eq!(
        hdr(&nothing, &nothing, 0, Exposures::of(&nothing)).mean,
        0.0
    );
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let [reference, test] = pair(5, 300, 170, 3.0);
    let exposures = Exposures::of(&reference);
    let maps = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| hdr(&reference, &test, 300, exposures))
    });
    assert_eq!(maps[0], maps[1]);
    assert_eq!(maps[0], maps[2]);
}
