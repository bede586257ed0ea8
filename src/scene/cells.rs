//! Directions by a lat-long grid of weights.

use crate::lanes::{Vec3x8, WIDTH, f32x8, safe_sqrt, sin_cos_turns, square};
use crate::sampling::warp::Pair;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

/// The greatest f32 below 1.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// A distribution that is constant over each cell's solid angle (Pharr, Jakob & Humphreys, PBR 4th ed., sec. 12.5): that of
/// rows, and in each row that of columns. Rows and columns lie as in [`LatLong`](super::description::LatLong).
#[derive(Clone, Debug)]
pub(super) struct Cells {
    width: usize,
    height: usize,
    /// `height + 1` entries from 0 to 1.
    rows: Vec<f32>,
    /// `width + 1` entries from 0 to 1 for each row.
    columns: Vec<f32>,
    /// Upper and lower border of each row: 1 − |cos θ| on its side of the equator, for single precision is coarse near
    /// cos θ = 1.
    borders: Vec<[f32; 2]>,
    /// Added to an azimuth of the world, in turns, to find that of the grid; in [0, 1).
    turn: f32,
    /// ∫ weight dω over the sphere.
    pub integral: f32,
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

impl Cells {
    /// From the weights of cells, row-major; turned by some degrees around +y, counter-clockwise seen from above. None where
    /// they are all 0.
    pub fn new(
        (width, height): (usize, usize),
        weight: impl Fn(usize) -> f64,
        rotate_degrees: f32,
    ) -> Option<Self> {
        let part = |border: usize| border as f64 / height as f64;
        let mut columns = Vec::with_capacity((width + 1) * height);
        let mut borders = Vec::with_capacity(height);
        let mut weights = Vec::with_capacity(height);
        for y in 0..height {
            let row = (y * width..(y + 1) * width).map(&weight);
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
            width,
            height,
            rows,
            columns,
            borders,
            turn: (turn - libm::floor(turn)) as f32,
            integral,
        })
    }

    /// Indices of the cells that eight directions fall into.
    #[inline]
    pub fn at(&self, d: Vec3x8) -> [usize; WIDTH] {
        let (width, height) = (self.width, self.height);
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

    /// Directions and the cells they were drawn in: the row by `u.0`, the column by `u.1`, so that what is stratified
    /// on the square is on the sphere.
    #[inline]
    pub fn sample(&self, u: Pair) -> (Vec3x8, [usize; WIDTH]) {
        let width = self.width;
        let (row_u, column_u) = (u.0.to_array(), u.1.to_array());
        let mut cells = [0; WIDTH];
        let [mut pole, mut side, mut turns] = [[0.0; WIDTH]; 3];
        for lane in 0..WIDTH {
            let (y, down) = find(&self.rows, row_u[lane].min(BELOW_ONE));
            let row = &self.columns[y * (width + 1)..(y + 1) * (width + 1)];
            let (x, right) = find(row, column_u[lane].min(BELOW_ONE));
            let [top, bottom] = self.borders[y];
            cells[lane] = y * width + x;
            pole[lane] = (bottom - top).mul_add(down, top);
            side[lane] = if 2 * y < self.height { 1.0 } else { -1.0 };
            turns[lane] = (x as f32 + right) / width as f32;
        }
        let (pole, side, turns) = (f32x8::new(pole), f32x8::new(side), f32x8::new(turns));
        let turns = turns - f32x8::splat(self.turn);
        let (sin, cos) = sin_cos_turns(turns - turns.floor());
        let r = safe_sqrt(pole * (f32x8::splat(2.0) - pole));
        let direction = Vec3x8::new(r * sin, side * (f32x8::ONE - pole), -(r * cos));
        (direction, cells)
    }
}
