//! Colours as the eye tells them apart: opponents, CIELAB with Hunt's effect, and the distance of two.

use crate::lanes::{Rgbx8, f32x8};
use std::sync::LazyLock;

/// From linear RGB to X, Y, Z over those of white: sRGB's primaries and white point (IEC 61966-2-1).
const TO_XYZ: [[f64; 3]; 3] = [
    [0.433_887_35, 0.376_224_01, 0.189_888_64],
    [0.212_639_01, 0.715_168_68, 0.072_192_31],
    [0.017_750_04, 0.109_447_62, 0.872_802_34],
];

/// Its inverse.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.080_399_09, -1.537_383_18, -0.543_015_91],
    [-0.921_223_36, 1.875_967_50, 0.045_255_86],
    [0.052_873_94, -0.203_976_96, 1.151_103_02],
];

/// A luminance over white's, and how far X and Z, over white's, differ from it: Y′, C′x and C′z of the papers without their
/// scales and offset, which cancel where a filter's weights add up to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opponents {
    pub y: f32x8,
    pub x_less_y: f32x8,
    pub y_less_z: f32x8,
}

/// CIELAB with a and b as strong as the luminance makes them (Andersson et al. 2020, "Perceptually Uniform Color Space").
#[derive(Clone, Copy, Debug)]
pub(super) struct Hunt {
    pub l: f32x8,
    pub a: f32x8,
    pub b: f32x8,
}

#[inline]
fn row([a, b, c]: [f64; 3], x: f32x8, y: f32x8, z: f32x8) -> f32x8 {
    let [a, b, c] = [a, b, c].map(|weight| f32x8::splat(weight as f32));
    x.mul_add(a, y.mul_add(b, z * c))
}

impl Opponents {
    #[inline]
    pub fn of(rgb: Rgbx8) -> Self {
        let [x, y, z] = TO_XYZ.map(|weights| row(weights, rgb.r, rgb.g, rgb.b));
        Self {
            y,
            x_less_y: x - y,
            y_less_z: y - z,
        }
    }

    /// The colour, each channel cut off at 0 and 1.
    #[inline]
    pub fn to_rgb(self) -> Rgbx8 {
        let (x, y, z) = (self.y + self.x_less_y, self.y, self.y - self.y_less_z);
        let [r, g, b] = FROM_XYZ.map(|weights| {
            row(weights, x, y, z)
                .fast_max(f32x8::ZERO)
                .fast_min(f32x8::ONE)
        });
        Rgbx8::new(r, g, b)
    }
}

/// CIELAB's root, with its straight foot.
#[inline]
fn root(t: f32x8) -> f32x8 {
    const KNEE: f32 = 6.0 / 29.0;
    let foot = t.mul_add(
        f32x8::splat(1.0 / (3.0 * KNEE * KNEE)),
        f32x8::splat(4.0 / 29.0),
    );
    t.simd_gt(f32x8::splat(KNEE * KNEE * KNEE))
        .select(t.cbrt(), foot)
}

impl Hunt {
    #[inline]
    pub fn of(rgb: Rgbx8) -> Self {
        let [x, y, z] = TO_XYZ.map(|weights| root(row(weights, rgb.r, rgb.g, rgb.b)));
        let l = y.mul_sub(f32x8::splat(116.0), f32x8::splat(16.0));
        let strength = l * 0.01;
        Self {
            l,
            a: (x - y) * 500.0 * strength,
            b: (y - z) * 200.0 * strength,
        }
    }

    /// HyAB: city blocks between lightness and colour, straight among colours (Abasi et al. 2020).
    #[inline]
    fn distance(self, other: Self) -> f32x8 {
        let (a, b) = (self.a - other.a, self.b - other.b);
        (self.l - other.l).abs() + a.mul_add(a, b * b).sqrt()
    }

    /// The error of colour, 0 to 1: distances to the power 0.7, of which the first 40 % take 95 % of the range
    /// (Andersson et al. 2020, "Color Difference Metric and Error Redistribution").
    #[inline]
    pub fn error(self, other: Self) -> f32x8 {
        const KNEE: f32 = 0.4;
        const LEVEL: f32 = 0.95;
        let greatest = *GREATEST;
        let distance = power(self.distance(other), f32x8::splat(EXPONENT)) * (1.0 / greatest);
        let near = distance * (LEVEL / KNEE);
        let far = (distance - f32x8::splat(KNEE)).mul_add(
            f32x8::splat((1.0 - LEVEL) / (1.0 - KNEE)),
            f32x8::splat(LEVEL),
        );
        distance.simd_lt(f32x8::splat(KNEE)).select(near, far)
    }
}

/// Distances count by this power.
const EXPONENT: f32 = 0.7;

/// The distance of green and blue, the greatest that is counted, to that power.
static GREATEST: LazyLock<f32> = LazyLock::new(|| {
    let pure = |g: f32, b: f32| Hunt::of(Rgbx8::new(f32x8::ZERO, f32x8::splat(g), f32x8::splat(b)));
    let distance = pure(1.0, 0.0).distance(pure(0.0, 1.0)).as_array()[0];
    libm::powf(distance, EXPONENT)
});

/// `x^y` for `x` ≥ 0 and 0 ≤ `y` ≤ 1, 1 where both are 0. What is below 10⁻³⁰ counts as that.
#[inline]
pub(super) fn power(x: f32x8, y: f32x8) -> f32x8 {
    (x.fast_max(f32x8::splat(1e-30)).ln() * y).exp()
}
