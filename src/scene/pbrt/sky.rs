//! Infinite lights to one environment.

use super::files::Files;
use super::lexer::At;
use super::lights::Infinite;
use super::warnings::Warnings;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::{Environment, Image, LatLong, Pixels};
use crate::scene::image::{self, ColorSpace};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_2_PI, PI, TAU};
use std::path::Path;
use std::sync::Arc;

/// Greatest height of the environment, pixels.
const HIGHEST: usize = 4096;
/// Samples along each side of a pixel.
const SAMPLES: usize = 2;

/// An image by direction.
struct Source {
    image: Image,
    factor: f32,
    is_lat_long: bool,
    from_world: DAffine3,
}

/// The sum of all infinite lights; none without any.
pub(super) fn environment(
    lights: &[Infinite],
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<Option<Environment>> {
    let mut constant = Rgb::BLACK;
    let mut sources = Vec::new();
    for light in lights {
        match light {
            Infinite::Constant(radiance) => constant = sum(constant, *radiance),
            Infinite::Image {
                path,
                factor,
                to_world,
                at,
            } => sources.push(source(path, *factor, to_world, at, files, warnings)?),
        }
    }
    let Some(height) = sources.iter().map(|source| source.image.height).max() else {
        return Ok((!lights.is_empty()).then_some(Environment::Constant(constant)));
    };
    let height = height.clamp(1, HIGHEST);
    let width = 2 * height;
    let pixel = |index: usize| {
        let directions = directions(index % width, index / width, height);
        let mut total = [0.0; 3];
        for source in &sources {
            for &direction in &directions {
                let color = source.radiance(direction);
                for (total, channel) in total.iter_mut().zip(color) {
                    *total += channel;
                }
            }
        }
        let [r, g, b] = total.map(|total| total / (SAMPLES * SAMPLES) as f32);
        sum(Rgb::new(r, g, b), constant)
    };
    let names: Vec<&str> = sources
        .iter()
        .map(|source| source.image.file.as_str())
        .collect();
    Ok(Some(Environment::Image {
        image: Arc::new(LatLong {
            file: names.join(" + "),
            width,
            height,
            pixels: (0..width * height).into_par_iter().map(pixel).collect(),
        }),
        rotate_degrees: 0.0,
    }))
}

/// Sum by channel, finite.
fn sum(a: Rgb, b: Rgb) -> Rgb {
    let add = |a: f32, b: f32| (a + b).min(f32::MAX);
    Rgb::new(add(a.r, b.r), add(a.g, b.g), add(a.b, b.b))
}

/// Directions of the world within a pixel of a lat-long image, as [`LatLong`] has them.
fn directions(x: usize, y: usize, height: usize) -> [DVec3; SAMPLES * SAMPLES] {
    std::array::from_fn(|sample| {
        let within =
            |pixel: usize, part: usize| pixel as f64 + (part as f64 + 0.5) / SAMPLES as f64;
        let (sin_phi, cos_phi) =
            libm::sincos(TAU * within(x, sample % SAMPLES) / (2 * height) as f64);
        let (sin_theta, cos_theta) = libm::sincos(PI * within(y, sample / SAMPLES) / height as f64);
        DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
    })
}

fn source(
    path: &Path,
    factor: f32,
    to_world: &DAffine3,
    at: &At,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<Source> {
    let image = image::read(path, ColorSpace::Srgb).map_err(|error| at.error(error.to_string()))?;
    let hashed = files.hash(path);
    hashed.map_err(|error| at.error(format!("{}: {error}", path.display())))?;
    let (width, height) = (image.width, image.height);
    let is_lat_long = width == 2 * height;
    if is_lat_long {
        warnings.tell(at, format!("the image is {width}×{height}, and pbrt-v4 has square ones (equal-area octahedral); it is read as a lat-long image, z up"));
    } else if width != height {
        return Err(at.error(format!(
            "the image of an infinite light is {width}×{height}; it must be square (equal-area octahedral), convert it by pbrt's `imgtool makeequiarea`"
        )));
    }
    let from_world = to_world.inverse();
    if !from_world.is_finite() {
        return Err(
            at.error("the light's transformation has no inverse; remove the scale of 0 before it")
        );
    }
    Ok(Source {
        image,
        factor,
        is_lat_long,
        from_world,
    })
}

impl Source {
    /// Radiance from a direction of the world: of the nearest pixel, as pbrt-v4 takes it.
    fn radiance(&self, direction: DVec3) -> [f32; 3] {
        let direction = self
            .from_world
            .transform_vector3(direction)
            .normalize_or_zero();
        let (u, v) = if self.is_lat_long {
            lat_long(direction)
        } else {
            octahedral(direction)
        };
        let Image { width, height, .. } = self.image;
        let pixel =
            |part: f64, count: usize| ((part * count as f64) as usize).min(count.saturating_sub(1));
        let index = pixel(v, height) * width + pixel(u, width);
        let color = match &self.image.pixels {
            Pixels::Srgb8(pixels) => pixels
                .get(index)
                .map(|pixel| pixel.map(|c| image::linear(f32::from(c) / 255.0))),
            Pixels::Linear8(pixels) => pixels
                .get(index)
                .map(|pixel| pixel.map(|c| f32::from(c) / 255.0)),
            Pixels::Float(pixels) => pixels.get(index).copied(),
        };
        let [r, g, b, _] = color.unwrap_or_default();
        [r, g, b].map(|channel| (channel * self.factor).min(f32::MAX / 8.0))
    }
}

/// Where a unit vector lies in the square of the equal-area octahedral map, row 0 at v = 0 (Clarberg 2008, "Fast
/// Equal-Area Mapping of the (Hemi)Sphere using SIMD"; Pharr, Jakob & Humphreys, PBR 4th ed., sec. 3.8.3).
pub(super) fn octahedral(d: DVec3) -> (f64, f64) {
    let DVec3 { x, y, z } = d.abs();
    let radius = (1.0 - z).max(0.0).sqrt();
    let (low, high) = (x.min(y), x.max(y));
    let angle = if high > 0.0 {
        FRAC_2_PI * libm::atan(low / high)
    } else {
        0.0
    };
    let angle = if x < y { 1.0 - angle } else { angle };
    let v = angle * radius;
    let u = radius - v;
    // The lower half is folded outwards.
    let (u, v) = if d.z < 0.0 {
        (1.0 - v, 1.0 - u)
    } else {
        (u, v)
    };
    let unit = |value: f64, sign: f64| 0.5 * (value.copysign(sign) + 1.0);
    (unit(u, d.x), unit(v, d.y))
}

/// Where a unit vector lies in a lat-long image of pbrt: +z on top, x along its left edge.
fn lat_long(d: DVec3) -> (f64, f64) {
    let phi = libm::atan2(d.y, d.x);
    let phi = if phi < 0.0 { phi + TAU } else { phi };
    (phi / TAU, libm::acos(d.z.clamp(-1.0, 1.0)) / PI)
}
