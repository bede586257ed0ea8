//! What the statistical tests share: random numbers, quadrature, and Pearson's χ² test of a sampler against its density.
//!
//! Seeds are fixed, so a test's outcome is too. One test of a correct sampler has p below [`SIGNIFICANCE`] with
//! probability 10⁻³; over the about 50 of them here one would be expected to fail once in twenty choices of the seed
//! (Šidák: 1 − 0.999⁵⁰ = 5 %). At 10⁶ samples an error of 2 % in the width of a lobe gives p below 2·10⁻⁵, and what is
//! wrong by more gives 0.
#![allow(dead_code, reason = "each test file uses a part")]

use ondine::lanes::{Rgbx8, Vec3x8, WIDTH, f32x8};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::f64::consts::TAU;

/// Least p-value that a χ² test accepts.
pub const SIGNIFICANCE: f64 = 1e-3;

/// Samples of a χ² test.
pub const SAMPLES: usize = 1_000_000;

/// Eight-lane random numbers with a fixed seed.
pub struct Random(Pcg32);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0xda3e_39cb_94b9_5bdb))
    }

    /// In [0, 1), multiples of 2⁻²⁴.
    pub fn one(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    pub fn eight(&mut self) -> f32x8 {
        f32x8::new(std::array::from_fn(|_| self.one()))
    }

    pub fn pair(&mut self) -> (f32x8, f32x8) {
        (self.eight(), self.eight())
    }
}

/// `n` damaged copies of a file, from a fixed seed: bytes changed, removed, repeated or swapped for what breaks parsers
/// (signs, digits, limits of integers), or the end cut off.
pub fn mutations(seed: u64, bytes: &[u8], n: usize) -> impl Iterator<Item = Vec<u8>> {
    const PIECES: [&[u8]; 12] = [
        b"-",
        b"9",
        b"4294967296",
        b"-2147483648",
        b"1e39",
        b"nan",
        b"\n",
        b" ",
        b"",
        &[0; 4],
        &[0xff; 4],
        &[0, 0, 0xc0, 0x7f],
    ];
    let mut random = Pcg32::new(seed, 0xda3e_39cb_94b9_5bdb);
    let mut below = move |limit: usize| random.next_u32() as usize % limit.max(1);
    (0..n).map(move |_| {
        let mut copy = bytes.to_vec();
        for _ in 0..=below(4) {
            let at = below(copy.len() + 1);
            let end = (at + below(8)).min(copy.len());
            match below(5) {
                0 => copy
                    .iter_mut()
                    .skip(at)
                    .take(1)
                    .for_each(|byte| *byte = below(256) as u8),
                1 => copy
                    .iter_mut()
                    .skip(at)
                    .take(1)
                    .for_each(|byte| *byte ^= 1 << below(8)),
                2 => drop(copy.splice(at..end, PIECES[below(PIECES.len())].iter().copied())),
                3 => {
                    let from = below(copy.len() + 1);
                    let piece = copy[from..(from + below(64)).min(copy.len())].to_vec();
                    drop(copy.splice(at..at, piece));
                }
                _ if below(4) == 0 => copy.truncate(at),
                _ => drop(copy.drain(at..end)),
            }
        }
        copy
    })
}

/// A vector of one lane in double precision.
pub type V = [f64; 3];

pub fn lane(v: &Vec3x8, i: usize) -> V {
    let v = v.lane(i);
    [v.x, v.y, v.z].map(f64::from)
}

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn unit(v: V) -> V {
    let s = 1.0 / dot(v, v).sqrt();
    v.map(|c| c * s)
}

pub fn splat(v: V) -> Vec3x8 {
    let [x, y, z] = v.map(|c| f32x8::splat(c as f32));
    Vec3x8::new(x, y, z)
}

/// The unit vector of the local frame at a cosine and an azimuth in degrees.
pub fn at(cos: f64, azimuth: f64) -> V {
    let r = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let (sin, cosine) = azimuth.to_radians().sin_cos();
    [r * cosine, r * sin, cos]
}

#[track_caller]
pub fn assert_close(got: f64, want: f64, relative: f64, absolute: f64, what: &str) {
    let error = (got - want).abs();
    assert!(
        error <= relative * want.abs() + absolute,
        "{what}: {got} is not {want}"
    );
}

/// Gauss–Legendre nodes and weights of order 4 on [0, 1].
const NODES: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// A rectangle of parameters.
#[derive(Clone, Copy)]
pub struct Cell {
    pub a: [f64; 2],
    pub b: [f64; 2],
}

/// ∫∫ f(a, b) da db, eight points at a time, halving cells until two orders agree to `tolerance`.
pub fn adaptive(f: &impl Fn([f64; 8], [f64; 8]) -> [f64; 8], cell: Cell, tolerance: f64) -> f64 {
    fn rule(f: &impl Fn([f64; 8], [f64; 8]) -> [f64; 8], Cell { a, b }: Cell) -> f64 {
        let (width, height) = (a[1] - a[0], b[1] - b[0]);
        let mut sum = 0.0;
        for half in 0..2 {
            let node = |i: usize| (NODES[i % 4], NODES[2 * half + i / 4]);
            let values = f(
                std::array::from_fn(|i| width.mul_add(node(i).0.0, a[0])),
                std::array::from_fn(|i| height.mul_add(node(i).1.0, b[0])),
            );
            for (i, value) in values.into_iter().enumerate() {
                sum += value * node(i).0.1 * node(i).1.1;
            }
        }
        sum * width * height
    }
    fn refine(
        f: &impl Fn([f64; 8], [f64; 8]) -> [f64; 8],
        cell: Cell,
        coarse: f64,
        tolerance: f64,
        depth: u32,
    ) -> f64 {
        let Cell { a, b } = cell;
        let (ma, mb) = (0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1]));
        let quarters = [
            ([a[0], ma], [b[0], mb]),
            ([ma, a[1]], [b[0], mb]),
            ([a[0], ma], [mb, b[1]]),
            ([ma, a[1]], [mb, b[1]]),
        ]
        .map(|(a, b)| Cell { a, b });
        let parts = quarters.map(|q| rule(f, q));
        let fine: f64 = parts.iter().sum();
        if depth == 0 || (fine - coarse).abs() <= tolerance + 1e-6 * fine.abs() {
            return fine;
        }
        (0..4)
            .map(|i| refine(f, quarters[i], parts[i], 0.25 * tolerance, depth - 1))
            .sum()
    }
    refine(f, cell, rule(f, cell), tolerance, 9)
}

/// ∫ f dω over the sphere, with points crowded towards `axis`: where the integrand may have a narrow peak.
pub fn integrate_sphere(axis: V, f: impl Fn(Vec3x8) -> f32x8) -> f64 {
    let [x, y, z] = axis;
    let sign = 1f64.copysign(z);
    let k = -1.0 / (sign + z);
    let tangent = [1.0 + sign * x * x * k, sign * x * y * k, -sign * x];
    let bitangent = [x * y * k, sign + y * y * k, -y];
    let integrand = |s: [f64; 8], phi: [f64; 8]| {
        // 1 − cos θ = 2 s⁴
        let directions = std::array::from_fn(|i| {
            let h = 2.0 * s[i].powi(4);
            let (r, (sin, cos)) = ((h * (2.0 - h)).sqrt(), phi[i].sin_cos());
            std::array::from_fn(|c| {
                r * cos * tangent[c] + r * sin * bitangent[c] + (1.0 - h) * axis[c]
            })
        });
        let values = f(pack(directions)).to_array();
        std::array::from_fn(|i| f64::from(values[i]) * 8.0 * s[i].powi(3))
    };
    let mut sum = 0.0;
    for i in 0..16 {
        for j in 0..16 {
            let a = [f64::from(i) / 16.0, f64::from(i + 1) / 16.0];
            let b = [f64::from(j) / 16.0 * TAU, f64::from(j + 1) / 16.0 * TAU];
            sum += adaptive(&integrand, Cell { a, b }, 1e-7);
        }
    }
    sum
}

/// Eight vectors in single precision.
pub fn pack(v: [V; 8]) -> Vec3x8 {
    let [x, y, z] = [0, 1, 2].map(|c| f32x8::new(std::array::from_fn(|i| v[i][c] as f32)));
    Vec3x8::new(x, y, z)
}

/// p-value of counts against what was expected of them. Bins that expect less than 5 are pooled.
pub fn chi_square(observed: &[u64], expected: &[f64]) -> f64 {
    let (mut statistic, mut bins) = (0.0, 0usize);
    let (mut pooled_observed, mut pooled_expected) = (0.0, 0.0);
    let mut add = |observed: f64, expected: f64| {
        statistic += (observed - expected).powi(2) / expected;
        bins += 1;
    };
    for (&observed, &expected) in observed.iter().zip(expected) {
        let observed = observed as f64;
        if expected >= 5.0 {
            add(observed, expected);
        } else {
            pooled_observed += observed;
            pooled_expected += expected;
        }
    }
    if pooled_expected >= 5.0 {
        add(pooled_observed, pooled_expected);
    } else {
        // Too few for the approximation: all but impossible numbers of them pass.
        let most = pooled_expected + 8.0 * pooled_expected.sqrt() + 8.0;
        assert!(
            pooled_observed <= most,
            "{pooled_observed} samples where {pooled_expected} are expected"
        );
    }
    assert!(bins > 1, "{bins} bins test nothing");
    gamma_q(0.5 * (bins - 1) as f64, 0.5 * statistic)
}

/// χ² of directions over the sphere, in a grid of cos θ by φ around z, against `pdf`; where the mask of a sample is off it
/// found no direction, which is to happen as often as `pdf` falls short of 1. Returns p and ∫ pdf dω.
pub fn chi_square_of_directions(
    pdf: impl Fn(Vec3x8) -> f32x8,
    mut sample: impl FnMut() -> (Vec3x8, f32x8),
) -> (f64, f64) {
    const COSINES: usize = 64;
    const AZIMUTHS: usize = 96;
    let mut observed = vec![0; COSINES * AZIMUTHS + 1];
    for _ in 0..SAMPLES / WIDTH {
        let (directions, found) = sample();
        for i in 0..WIDTH {
            let [x, y, z] = lane(&directions, i);
            let row = (((z + 1.0) * 0.5 * COSINES as f64) as usize).min(COSINES - 1);
            let turn = libm::atan2(y, x) / TAU;
            let column = ((turn - turn.floor()) * AZIMUTHS as f64) as usize % AZIMUTHS;
            let valid = found.as_array()[i].to_bits() != 0;
            observed[if valid {
                row * AZIMUTHS + column
            } else {
                COSINES * AZIMUTHS
            }] += 1;
        }
    }

    let density = |cos: [f64; 8], phi: [f64; 8]| {
        let directions = std::array::from_fn(|i| at(cos[i], phi[i].to_degrees()));
        pdf(pack(directions)).to_array().map(f64::from)
    };
    let mut expected = Vec::with_capacity(observed.len());
    for row in 0..COSINES {
        let a = [row, row + 1].map(|r| 2.0 * r as f64 / COSINES as f64 - 1.0);
        for column in 0..AZIMUTHS {
            let b = [column, column + 1].map(|c| c as f64 / AZIMUTHS as f64 * TAU);
            expected.push(adaptive(&density, Cell { a, b }, 1e-8) * SAMPLES as f64);
        }
    }
    let found: f64 = expected.iter().sum();
    let lost = SAMPLES as f64 - found;
    assert!(
        lost > -1e-4 * SAMPLES as f64,
        "the density integrates to {found} / {SAMPLES}"
    );
    expected.push(lost.max(0.0));
    (chi_square(&observed, &expected), found / SAMPLES as f64)
}

/// Regularised upper incomplete gamma function Q(a, x): the p-value of χ² = 2x with 2a degrees of freedom
/// (Press et al., Numerical Recipes, 3rd ed., sec. 6.2).
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    // Lentz's continued fraction.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..100_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-14 {
            break;
        }
    }
    front * h
}

/// Mean of the red channel and its standard error, over `batches` × 8 samples.
pub fn mean(batches: usize, mut sample: impl FnMut() -> Rgbx8) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..batches {
        for value in sample().r.to_array().map(f64::from) {
            sum += value;
            squares += value * value;
        }
    }
    let n = (batches * WIDTH) as f64;
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}
