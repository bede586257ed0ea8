//! What a render looks through: where rays begin.

use super::camera::Camera;
use crate::lanes::{Vec3x8, f32x8, u32x8};
use crate::sampling::{Dimension, PathKeyX8, Sampler, warp};
use glam::Vec3;

/// Where rays begin, and which way.
#[derive(Clone, Copy, Debug)]
pub enum Sensor<'a> {
    /// A camera, with the pixels of an image.
    Camera(&'a Camera),
    /// Points, world space, that look all around. In place of pixels there is a row for each point, and in it a column for
    /// each set of samples, whose random numbers are independent of the others'.
    Probes(&'a [Vec3]),
}

impl Sensor<'_> {
    /// Points, world space, whose convex hull holds the origin of every ray.
    pub fn origins(&self) -> Vec<Vec3> {
        match self {
            Sensor::Camera(camera) => camera.origins(),
            Sensor::Probes(positions) => positions.to_vec(),
        }
    }

    /// Origins and unit directions, world space, of paths through the pixels of these columns and rows.
    #[inline]
    pub fn rays(
        &self,
        sampler: &Sampler,
        path: PathKeyX8,
        column: u32x8,
        row: u32x8,
    ) -> (Vec3x8, Vec3x8) {
        match self {
            Sensor::Camera(camera) => {
                let in_filter = sampler.pair(path, Dimension::PixelFilter, 0);
                let on_lens = if camera.has_lens() {
                    sampler.pair(path, Dimension::Lens, 0)
                } else {
                    (f32x8::ZERO, f32x8::ZERO)
                };
                camera.rays(whole(column), whole(row), in_filter, on_lens)
            }
            Sensor::Probes(positions) => {
                // Lanes beyond a wave's end may have rows beyond the last.
                let last = positions.len() - 1;
                let origins = row.to_array().map(|row| positions[last.min(row as usize)]);
                let axis =
                    |axis: usize| f32x8::new(std::array::from_fn(|lane| origins[lane][axis]));
                let origin = Vec3x8::new(axis(0), axis(1), axis(2));
                (origin, probe_directions(sampler, path))
            }
        }
    }
}

/// Where probes look on these paths: uniform over the sphere.
#[inline]
pub fn probe_directions(sampler: &Sampler, path: PathKeyX8) -> Vec3x8 {
    warp::uniform_sphere(sampler.pair(path, Dimension::PixelFilter, 0))
}

/// A whole number below 2^23 as a float.
fn whole(n: u32x8) -> f32x8 {
    f32x8::from_bits(n | u32x8::splat(0x4b00_0000)) - f32x8::splat(8_388_608.0)
}
