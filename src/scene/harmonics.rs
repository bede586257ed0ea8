//! The environment that spherical harmonics describe, compiled.

use super::cells::Cells;
use super::description;
use crate::lanes::{Rgb, Rgbx8, Vec3x8, WIDTH, f32x8, sin_cos_turns};
use crate::sampling::warp::Pair;
use crate::sh::Series;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rows of the grid that directions are drawn by, for each degree: half a wave of the highest degree spans about four.
const ROWS_PER_DEGREE: usize = 4;
/// The fewest and the most rows.
const ROWS: [usize; 2] = [32, 256];
/// The least weight of a cell, relative to their mean: so every direction has a density, however the radiance varies in its
/// cell, and no sample weighs more than 20 times what it would if all were alike.
const LEAST_WEIGHT: f64 = 0.05;

/// Radiance by its coefficients, and the grid that directions are drawn by.
#[derive(Clone, Debug)]
pub struct Harmonics {
    series: Series,
    clamp: bool,
    /// Sine and cosine of the angle by which it is turned around +y.
    turn: (f32, f32),
    cells: Cells,
    /// Of each cell, per steradian.
    pdfs: Vec<f32>,
}

impl Harmonics {
    /// None where it is black.
    pub(super) fn new(environment: &description::Harmonics) -> Option<Self> {
        let series = environment.series();
        let grid = Grid::new(environment.probe.degree);
        let radiance = |d| clamped(series.evaluate(d), environment.clamp);
        let values = grid.values(radiance).into_iter();
        let mut weights: Vec<f64> = values.map(magnitude).collect();
        let mean = (0..weights.len())
            .map(|index| weights[index] * grid.solid_angle(index))
            .sum::<f64>()
            / (4.0 * PI);
        for weight in &mut weights {
            *weight += LEAST_WEIGHT * mean;
        }
        let cells = Cells::new(
            (2 * grid.rows, grid.rows),
            |index| weights[index],
            environment.rotate_degrees,
        )?;
        let integral = f64::from(cells.integral);
        let turns = environment.rotate_degrees / 360.0;
        let (sin, cos) = sin_cos_turns(f32x8::splat(turns - turns.floor()));
        Some(Self {
            clamp: environment.clamp,
            turn: (sin.to_array()[0], cos.to_array()[0]),
            pdfs: weights.iter().map(|w| (w / integral) as f32).collect(),
            series,
            cells,
        })
    }

    /// W·sr⁻¹·m⁻², from a unit direction of the world.
    #[inline]
    pub(super) fn radiance(&self, d: Vec3x8) -> Rgbx8 {
        let (sin, cos) = (f32x8::splat(self.turn.0), f32x8::splat(self.turn.1));
        let x = d.x.mul_sub(cos, d.z * sin);
        let z = d.x.mul_add(sin, d.z * cos);
        clamped(self.series.evaluate(Vec3x8::new(x, d.y, z)), self.clamp)
    }

    /// Density with which [`Harmonics::sample`] draws a direction, per steradian; above 0 everywhere.
    #[inline]
    pub(super) fn pdf(&self, d: Vec3x8) -> f32x8 {
        self.pdfs_of(self.cells.at(d))
    }

    /// A direction and its density.
    #[inline]
    pub(super) fn sample(&self, u: Pair) -> (Vec3x8, f32x8) {
        let (direction, cells) = self.cells.sample(u);
        (direction, self.pdfs_of(cells))
    }

    /// ∫ of the weights that directions are drawn by: that of the magnitude of the radiance, and a twentieth more.
    pub(super) fn integral(&self) -> f32 {
        self.cells.integral
    }

    #[inline]
    fn pdfs_of(&self, cells: [usize; WIDTH]) -> f32x8 {
        f32x8::new(cells.map(|cell| self.pdfs[cell]))
    }
}

impl description::Harmonics {
    /// The radiance before it is turned and clamped.
    fn series(&self) -> Series {
        Series::new(self.probe.degree, &self.probe.coefficients)
    }

    /// The part of the sphere, in [0, 1], where a channel is negative, and the least value of any channel, by a grid.
    pub(super) fn negative(&self) -> (f64, f32) {
        let (series, grid) = (self.series(), Grid::new(self.probe.degree));
        let mut part = 0.0;
        let mut least = f32::INFINITY;
        let values = grid.values(|d| series.evaluate(d)).into_iter();
        for (index, Rgb { r, g, b }) in values.enumerate() {
            let value = r.min(g).min(b);
            least = least.min(value);
            if value < 0.0 {
                part += grid.solid_angle(index) / (4.0 * PI);
            }
        }
        (part, least)
    }
}

#[inline]
fn clamped(radiance: Rgbx8, clamp: bool) -> Rgbx8 {
    if !clamp {
        return radiance;
    }
    let cut = |channel: f32x8| channel.fast_max(f32x8::ZERO);
    Rgbx8::new(cut(radiance.r), cut(radiance.g), cut(radiance.b))
}

/// Luminance were no channel negative: what cancels in the luminance of a colour still makes noise.
fn magnitude(Rgb { r, g, b }: Rgb) -> f64 {
    f64::from(Rgb::new(r.abs(), g.abs(), b.abs()).luminance())
}

/// The middles of a lat-long grid, twice as wide as high.
struct Grid {
    rows: usize,
}

impl Grid {
    fn new(degree: usize) -> Self {
        let [fewest, most] = ROWS;
        Self {
            // A multiple of four: cells come in whole batches.
            rows: (ROWS_PER_DEGREE * (degree + 1)).clamp(fewest, most),
        }
    }

    /// A colour at the middle of each cell, row-major. The threads are those of the current rayon pool; they change no bit.
    fn values(&self, colour: impl Fn(Vec3x8) -> Rgbx8 + Sync) -> Vec<Rgb> {
        let columns = 2 * self.rows;
        let batch = |row: usize, batch: usize| {
            let theta = PI * (row as f64 + 0.5) / self.rows as f64;
            let (sin, cos) = (libm::sin(theta), libm::cos(theta));
            let directions: [[f32; 3]; WIDTH] = std::array::from_fn(|lane| {
                let column = batch * WIDTH + lane;
                let phi = TAU * (column as f64 + 0.5) / columns as f64;
                [sin * libm::sin(phi), cos, -sin * libm::cos(phi)].map(|c| c as f32)
            });
            let [x, y, z] = [0, 1, 2].map(|axis| f32x8::new(directions.map(|d| d[axis])));
            let colours = colour(Vec3x8::new(x, y, z));
            (0..WIDTH).map(move |lane| colours.lane(lane))
        };
        let row = |row| (0..columns / WIDTH).flat_map(move |number| batch(row, number));
        (0..self.rows).into_par_iter().flat_map_iter(row).collect()
    }

    /// Steradians of a cell.
    fn solid_angle(&self, index: usize) -> f64 {
        let row = index / (2 * self.rows);
        let cos = |row: usize| libm::cos(PI * row as f64 / self.rows as f64);
        PI / self.rows as f64 * (cos(row) - cos(row + 1))
    }
}
