//! What surrounds everything, compiled: radiance by direction, and directions in proportion to luminance.

use super::cells::Cells;
use super::description::{Environment, LatLong};
use super::harmonics::Harmonics;
use crate::lanes::{Rgb, Rgbx8, Vec3x8, WIDTH, f32x8, sin_cos_turns, square};
use crate::sampling::warp::{self, Pair};
use std::f32::consts::TAU;
use std::f64::consts::PI;
use std::sync::Arc;

/// The environment as the kernels read it.
#[derive(Clone, Debug)]
pub enum Sky {
    /// The same radiance from everywhere; drawn uniformly.
    Constant(Rgb),
    /// Linear in |d.y| above and below; drawn exactly by luminance.
    Gradient(Gradient),
    /// A lat-long image; drawn exactly by luminance × solid angle.
    Image(SkyImage),
    /// Band-limited; drawn by the magnitude of its radiance, cell by cell.
    Harmonics(Harmonics),
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
            Environment::Harmonics(described) => Harmonics::new(described).map(Sky::Harmonics),
        };
        compiled.unwrap_or(Sky::Constant(Rgb::BLACK))
    }

    /// Radiance from `direction` (unit, world space), W·sr⁻¹·m⁻².
    #[inline]
    pub fn radiance(&self, direction: Vec3x8) -> Rgbx8 {
        match self {
            Sky::Constant(radiance) => Rgbx8::splat(*radiance),
            Sky::Gradient(gradient) => gradient.radiance(direction.y),
            Sky::Image(image) => image.radiance(image.cells.at(direction)),
            Sky::Harmonics(harmonics) => harmonics.radiance(direction),
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
            Sky::Harmonics(harmonics) => harmonics.pdf(direction),
        };
        (radiance, pdf)
    }

    /// Draws a direction by luminance. Its radiance and density are those of the place drawn: of an image, the pixel; of a
    /// density in cells, the cell.
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
                let (direction, pixels) = image.cells.sample(u);
                let radiance = image.radiance(pixels);
                SkySample {
                    direction,
                    radiance,
                    pdf: radiance.luminance() * image.pdf_per_luminance,
                }
            }
            Sky::Harmonics(harmonics) => {
                let (direction, pdf) = harmonics.sample(u);
                SkySample {
                    direction,
                    radiance: harmonics.radiance(direction),
                    pdf,
                }
            }
        }
    }

    /// ∫ luminance dω over the sphere, W·m⁻²; of what may be negative, ∫ of its magnitude.
    pub fn integral_luminance(&self) -> f32 {
        match self {
            Sky::Constant(radiance) => 2.0 * TAU * radiance.luminance(),
            Sky::Gradient(gradient) => gradient.integral,
            Sky::Image(image) => image.cells.integral,
            Sky::Harmonics(harmonics) => harmonics.integral(),
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

/// A lat-long image and what draws its pixels, which are constant over their solid angle, as the density is.
#[derive(Clone, Debug)]
pub struct SkyImage {
    image: Arc<LatLong>,
    cells: Cells,
    pdf_per_luminance: f32,
}

impl SkyImage {
    /// None where it is black.
    fn new(image: &Arc<LatLong>, rotate_degrees: f32) -> Option<Self> {
        let luminance = |index: usize| {
            let c = image.pixels[index];
            0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b)
        };
        let size = (image.width, image.height);
        let cells = Cells::new(size, luminance, rotate_degrees)?;
        Some(Self {
            image: Arc::clone(image),
            pdf_per_luminance: 1.0 / cells.integral,
            cells,
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
}
