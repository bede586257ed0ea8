//! What surrounds everything, compiled: radiance by direction, and directions in proportion to luminance.

use super::description::{Environment, LatLong};
use crate::lanes::{Rgb, Rgbx8, Vec3x8, WIDTH, f32x8, safe_sqrt, sin_cos_turns, square};
use crate::sampling::warp::{self, Pair};
use std::f32::consts::{FRAC_1_PI, TAU};
use std::f64::consts::PI;
use std::sync::Arc;

/// The greatest f32 below 1.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// The environment as the kernels read it.
#[derive(Clone, Debug)]
pub enum Sky {
    /// The same radiance from everywhere; drawn uniformly.
    Constant(Rgb),
    /// Linear in |d.y| above and below; drawn exactly by luminance.
    Gradient(Gradient),
    /// A lat-long image; drawn exactly by luminance × solid angle.
    Image(SkyImage),
}

/// A direction drawn from the environment.
#[derive(Clone, Copy, Debug)]
pub struct SkySample {
    /// World space, unit, towards the environment.
    pub direction: Vec3x8,
    /// W·sr⁻¹·m⁻² from there.
    pub radiance: Rgbx8,
    /// Density per steradian; 0 (only where the radiance is black) in place of a direction that has none.
    pub pdf: f32x8,
}

impl Sky {
    /// Makes the tables. What is black all over, or has no pixels, becomes a black constant.
    pub fn compile(environment: &Environment) -> Self {
        let compiled = match environment {
            Environment::Constant(radiance) => return Sky::Constant(*radiance),
            Environment::Gradient {
                zenith,
                horizon,
                ground,
            } => Gradient::new(*zenith, *horizon, *ground).map(Sky::Gradient),
            Environment::Image {
                image,
                rotate_degrees,
            } => SkyImage::new(image, *rotate_degrees).map(Sky::Image),
        };
        compiled.unwrap_or(Sky::Constant(Rgb::BLACK))
    }

    /// Radiance from `direction` (unit, world space), W·sr⁻¹·m⁻².
    #[inline]
    pub fn radiance(&self, direction: Vec3x8) -> Rgbx8 {
        match self {
            Sky::Constant(radiance) => Rgbx8::splat(*radiance),
            Sky::Gradient(gradient) => gradient.radiance(direction.y),
            Sky::Image(image) => image.radiance(image.pixels_at(direction)),
        }
    }

    /// Density with which [`Sky::sample`] draws `direction` (unit, world space), per steradian.
    #[inline]
    pub fn pdf(&self, direction: Vec3x8) -> f32x8 {
        self.radiance_and_pdf(direction).1
    }

    /// [`Sky::radiance`] and [`Sky::pdf`] for the price of one look-up.
    #[inline]
    pub fn radiance_and_pdf(&self, direction: Vec3x8) -> (Rgbx8, f32x8) {
        let radiance = self.radiance(direction);
        let pdf = match self {
            Sky::Constant(_) => f32x8::splat(warp::UNIFORM_SPHERE_PDF),
            Sky::Gradient(gradient) => radiance.luminance() * gradient.pdf_per_luminance,
            Sky::Image(image) => radiance.luminance() * image.pdf_per_luminance,
        };
        (radiance, pdf)
    }

    /// Draws a direction by luminance. Its radiance and density are those of the place drawn: of an image, the pixel.
    #[inline]
    pub fn sample(&self, u: Pair) -> SkySample {
        match self {
            Sky::Constant(radiance) => SkySample {
                direction: warp::uniform_sphere(u),
                radiance: Rgbx8::splat(*radiance),
                pdf: f32x8::splat(warp::UNIFORM_SPHERE_PDF),
            },
            Sky::Gradient(gradient) => {
                let direction = gradient.sample(u);
                let radiance = gradient.radiance(direction.y);
                SkySample {
                    direction,
                    radiance,
                    pdf: radiance.luminance() * gradient.pdf_per_luminance,
                }
            }
            Sky::Image(image) => {
                let (direction, pixels) = image.sample(u);
                let radiance = image.radiance(pixels);
                SkySample {
                    direction,
                    radiance,
                    pdf: radiance.luminance() * image.pdf_per_luminance,
                }
            }
        }
    }

    /// ∫ luminance dω over the sphere, W·m⁻².
    pub fn integral_luminance(&self) -> f32 {
        match self {
            Sky::Constant(radiance) => 2.0 * TAU * radiance.luminance(),
            Sky::Gradient(gradient) => gradient.integral,
            Sky::Image(image) => image.integral,
        }
    }
}

/// `L = horizon + (zenith|ground − horizon) · |d.y|`.
#[derive(Clone, Debug)]
pub struct Gradient {
    horizon: Rgb,
    /// Zenith − horizon, ground − horizon.
    rise: [Rgb; 2],
    /// Luminance at |d.y| = 0 and 1 of the upper and the lower half, each over the half's mean.
    ends: [[f32; 2]; 2],
    /// Part of the luminance that comes from above.
    upper: f32,
    integral: f32,
    pdf_per_luminance: f32,
}

impl Gradient {
    /// None where it is black.
    fn new(zenith: Rgb, horizon: Rgb, ground: Rgb) -> Option<Self> {
        let [z, h, g] = [zenith, horizon, ground].map(|c| f64::from(c.luminance()));
        // ∫ (h + (z − h) t) dω = 2π (h + z) / 2, over each half.
        let integral = (PI * (h + z) + PI * (h + g)) as f32;
        let ends = |end: f64| {
            let mean = 0.5 * (h + end);
            if mean > 0.0 {
                [(h / mean) as f32, (end / mean) as f32]
            } else {
                [1.0, 1.0]
            }
        };
        let minus = |a: Rgb, b: Rgb| Rgb::new(a.r - b.r, a.g - b.g, a.b - b.b);
        (integral >= f32::MIN_POSITIVE).then(|| Self {
            horizon,
            rise: [minus(zenith, horizon), minus(ground, horizon)],
            ends: [ends(z), ends(g)],
            upper: ((h + z) / (2.0 * h + z + g)) as f32,
            integral,
            pdf_per_luminance: 1.0 / integral,
        })
    }

    #[inline]
    fn radiance(&self, y: f32x8) -> Rgbx8 {
        let above = y.simd_ge(f32x8::ZERO);
        let [up, down] = self.rise.map(Rgbx8::splat);
        let radiance = Rgbx8::select(above, up, down).mul_add(y.abs(), Rgbx8::splat(self.horizon));
        // horizon + (zenith − horizon) · 1 may round below a zenith of 0.
        Rgbx8::new(
            radiance.r.fast_max(f32x8::ZERO),
            radiance.g.fast_max(f32x8::ZERO),
            radiance.b.fast_max(f32x8::ZERO),
        )
    }

    /// A half by its luminance, then |d.y| by the inverse of its quadratic distribution, in the form without
    /// cancellation (Pharr, Jakob & Humphreys, PBR 4th ed., sec. 2.3.2, `SampleLinear`).
    #[inline]
    fn sample(&self, u: Pair) -> Vec3x8 {
        let upper = f32x8::splat(self.upper);
        let above = u.0.simd_lt(upper);
        let share = above.select(upper, f32x8::ONE - upper);
        let rest = above.select(u.0, u.0 - upper) / share;
        let [up, down] = self.ends;
        let low = above.select(f32x8::splat(up[0]), f32x8::splat(down[0]));
        let high = above.select(f32x8::splat(up[1]), f32x8::splat(down[1]));
        // (low + high) · u / (low + sqrt(lerp(low², high²))), and low + high = 2.
        let squares = (f32x8::ONE - rest).mul_add(square(low), rest * square(high));
        let t = (rest * 2.0) / (low + squares.sqrt()).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let t = t.fast_min(f32x8::ONE);
        let r = ((f32x8::ONE - t) * (f32x8::ONE + t)).sqrt();
        let (sin, cos) = sin_cos_turns(u.1);
        Vec3x8::new(r * sin, above.select(t, -t), -(r * cos))
    }
}

/// The tables of a lat-long image (Pharr, Jakob & Humphreys, PBR 4th ed., sec. 12.5): the distribution of rows, and in
/// each row that of columns. Pixels are constant over their solid angle, and so is the density.
#[derive(Clone, Debug)]
pub struct SkyImage {
    image: Arc<LatLong>,
    /// `height + 1` entries from 0 to 1.
    rows: Vec<f32>,
    /// `width + 1` entries from 0 to 1 for each row.
    columns: Vec<f32>,
    /// Upper and lower border of each row: 1 − |cos θ| on its side of the equator, for single precision is coarse near
    /// cos θ = 1.
    borders: Vec<[f32; 2]>,
    /// Added to an azimuth of the world, in turns, to find that of the image; in [0, 1).
    turn: f32,
    integral: f32,
    pdf_per_luminance: f32,
}

/// 1 − cos θ for θ = π · part.
fn one_minus_cos(part: f64) -> f64 {
    let half = libm::sin(0.5 * PI * part);
    2.0 * half * half
}

/// Running sums of the weights over their total, from 0 to 1, and the total.
///
/// What has no weight has no width; all from the last weight on is 1, so that rounding cannot cut it off.
fn cumulative(weights: impl Iterator<Item = f64> + Clone, table: &mut Vec<f32>) -> f64 {
    let total: f64 = weights.clone().sum();
    let mut sum = 0.0;
    table.push(0.0);
    table.extend(weights.map(|weight| {
        sum += weight;
        if total > 0.0 {
            (sum / total) as f32
        } else {
            0.0
        }
    }));
    total
}

/// The interval of a distribution that `u` falls into, and where in it, in [0, 1).
#[inline]
fn find(cumulative: &[f32], u: f32) -> (usize, f32) {
    let above = cumulative.partition_point(|&c| c <= u);
    let index = above.clamp(1, cumulative.len() - 1) - 1;
    let (low, high) = (cumulative[index], cumulative[index + 1]);
    (index, ((u - low) / (high - low)).clamp(0.0, BELOW_ONE))
}

impl SkyImage {
    /// None where it is black.
    fn new(image: &Arc<LatLong>, rotate_degrees: f32) -> Option<Self> {
        let LatLong {
            width,
            height,
            pixels,
            ..
        } = &**image;
        let (width, height) = (*width, *height);
        let part = |border: usize| border as f64 / height as f64;
        let luminance =
            |c: &Rgb| 0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b);

        let mut columns = Vec::with_capacity((width + 1) * height);
        let mut borders = Vec::with_capacity(height);
        let mut weights = Vec::with_capacity(height);
        for y in 0..height {
            let row = pixels[y * width..(y + 1) * width].iter().map(luminance);
            // By the nearer pole: 1 − cos θ above the equator, 1 + cos θ below it.
            let [top, bottom] = if 2 * y < height {
                [part(y), part(y + 1)].map(one_minus_cos)
            } else {
                [part(height - y), part(height - y - 1)].map(one_minus_cos)
            };
            let solid_angle = 2.0 * PI / width as f64 * (bottom - top).abs();
            weights.push(cumulative(row, &mut columns) * solid_angle);
            borders.push([top as f32, bottom as f32]);
        }
        let mut rows = Vec::with_capacity(height + 1);
        let integral = cumulative(weights.into_iter(), &mut rows) as f32;
        let turn = f64::from(rotate_degrees) / 360.0;
        (integral >= f32::MIN_POSITIVE).then(|| Self {
            image: Arc::clone(image),
            rows,
            columns,
            borders,
            turn: (turn - libm::floor(turn)) as f32,
            integral,
            pdf_per_luminance: 1.0 / integral,
        })
    }

    /// Indices of the pixels that eight directions fall into.
    #[inline]
    fn pixels_at(&self, d: Vec3x8) -> [usize; WIDTH] {
        let (width, height) = (self.image.width, self.image.height);
        // atan2 where acos(y) would be coarse: near the poles.
        let from_pole = d.x.mul_add(d.x, square(d.z)).sqrt().atan2(d.y) * FRAC_1_PI;
        let turns =
            d.x.atan2(-d.z)
                .mul_add(f32x8::splat(0.5 * FRAC_1_PI), f32x8::splat(self.turn));
        let turns = turns - turns.floor();
        // Casts take what is negative or not a number to 0.
        let rows = (from_pole * height as f32).to_array();
        let columns = (turns * width as f32).to_array();
        std::array::from_fn(|lane| {
            let y = (rows[lane] as usize).min(height - 1);
            let x = (columns[lane] as usize).min(width - 1);
            y * width + x
        })
    }

    #[inline]
    fn radiance(&self, pixels: [usize; WIDTH]) -> Rgbx8 {
        let pixels = pixels.map(|index| self.image.pixels[index]);
        Rgbx8::new(
            f32x8::new(pixels.map(|c| c.r)),
            f32x8::new(pixels.map(|c| c.g)),
            f32x8::new(pixels.map(|c| c.b)),
        )
    }

    /// Directions and the pixels they were drawn in: the row by `u.0`, the column by `u.1`, so that what is stratified
    /// on the square is on the sphere.
    #[inline]
    fn sample(&self, u: Pair) -> (Vec3x8, [usize; WIDTH]) {
        let width = self.image.width;
        let (row_u, column_u) = (u.0.to_array(), u.1.to_array());
        let mut pixels = [0; WIDTH];
        let [mut pole, mut side, mut turns] = [[0.0; WIDTH]; 3];
        for lane in 0..WIDTH {
            let (y, down) = find(&self.rows, row_u[lane].min(BELOW_ONE));
            let row = &self.columns[y * (width + 1)..(y + 1) * (width + 1)];
            let (x, right) = find(row, column_u[lane].min(BELOW_ONE));
            let [top, bottom] = self.borders[y];
            pixels[lane] = y * width + x;
            pole[lane] = (bottom - top).mul_add(down, top);
            side[lane] = if 2 * y < self.image.height { 1.0 } else { -1.0 };
            turns[lane] = (x as f32 + right) / width as f32;
        }
        let (pole, side, turns) = (f32x8::new(pole), f32x8::new(side), f32x8::new(turns));
        let turns = turns - f32x8::splat(self.turn);
        let (sin, cos) = sin_cos_turns(turns - turns.floor());
        let r = safe_sqrt(pole * (f32x8::splat(2.0) - pole));
        let direction = Vec3x8::new(r * sin, side * (f32x8::ONE - pole), -(r * cos));
        (direction, pixels)
    }
}
