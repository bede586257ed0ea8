//! How directions are drawn to estimate the coefficients of a lobe.

use crate::lanes::{WIDTH, f32x8, pow_one_minus, u32x8};
use crate::sampling::hash::hash_long;
use crate::sampling::{Dimension, Sampler, warp};
use crate::scene::description::choices;
use crate::sh::lobe::{BLOCK, Sample, Sums};
use rayon::prelude::*;
use std::f32::consts::{PI, SQRT_2};

/// Over which density.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sampling {
    /// Uniform over the sphere, as in the report.
    Uniform,
    /// Uniform, and each pair from a cell of its own.
    Stratified,
    /// Proportional to the lobe.
    CosinePower,
}

choices!(Sampling, "sampling": "uniform" = Uniform, "stratified" = Stratified, "cosine-power" = CosinePower);

/// What is integrated against the basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum Convention {
    /// `(n + 1) / 2 · max(cos θ, 0)ⁿ`
    Orthonormal,
    /// `√2 · (n + 1) / 2 · |cos θ|ⁿ`, as the report of 2014 has it.
    Report,
}

choices!(Convention, "convention": "orthonormal" = Orthonormal, "report" = Report);

/// Blocks that are under way before they are added up.
const GROUP: u64 = 256;

/// An estimate to be made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws {
    pub seed: u64,
    pub sampling: Sampling,
    pub convention: Convention,
    pub exponent: f64,
}

impl Draws {
    /// Sums over about so many samples, on the threads of the pool that it is called in. They do not depend on their number.
    pub fn sums(&self, samples: u32, degree: usize) -> Sums {
        let grid = Grid::new(self.sampling, samples);
        let sampler = self.sampler(&grid);
        let batches = u64::from(grid.columns) * u64::from(grid.rows) / WIDTH as u64;
        let per_block = (BLOCK / WIDTH) as u64;
        let blocks = batches.div_ceil(per_block);
        let mut total = Sums::new(degree);
        for first in (0..blocks).step_by(GROUP as usize) {
            let sums: Vec<Sums> = (first..(first + GROUP).min(blocks))
                .into_par_iter()
                .map(|block| {
                    let first = block * per_block;
                    let mut sums = Sums::new(degree);
                    sums.add(
                        (first..(first + per_block).min(batches))
                            .map(|batch| self.pairs(&sampler, &grid, batch)),
                    );
                    sums
                })
                .collect();
            sums.iter().for_each(|each| total.merge(each));
        }
        total
    }

    /// Each sampling, exponent and size has numbers of its own: their estimates are to be independent.
    fn sampler(&self, grid: &Grid) -> Sampler {
        let size = u64::from(grid.columns) << 32 | u64::from(grid.rows);
        let words = [self.sampling as u64, self.exponent.to_bits(), size];
        let mixed = |seed, word| hash_long(seed ^ word);
        Sampler::pcg(words.into_iter().fold(hash_long(self.seed), mixed), 0)
    }

    /// The samples of eight pairs.
    fn pairs(&self, sampler: &Sampler, grid: &Grid, batch: u64) -> [Sample; 2] {
        let first = batch * WIDTH as u64;
        let columns = u64::from(grid.columns);
        let column = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]) + u32x8::splat((first % columns) as u32);
        let row = (first / columns) as u32;
        [0, 1].map(|which| {
            let pair = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]) + u32x8::splat(first as u32);
            let path = sampler.path_key(u32x8::splat(0), (pair << 1) | u32x8::splat(which));
            let u = sampler.pair(path, Dimension::BsdfDirection, 0);
            let side = sampler.single(path, Dimension::BsdfLobe, 0);
            self.sample(grid.within(column, row, u), side)
        })
    }

    fn sample(&self, u: warp::Pair, side: f32x8) -> Sample {
        let n = f32x8::splat(self.exponent as f32);
        // Half of those that are proportional to the two-sided lobe lie below.
        let (factor, sides) = match self.convention {
            Convention::Orthonormal => (1.0, 1.0),
            Convention::Report => (SQRT_2, 2.0),
        };
        if self.sampling == Sampling::CosinePower {
            let z = warp::cosine_power(u, n).z;
            let below = side.simd_lt(f32x8::HALF) & f32x8::splat(sides).simd_gt(f32x8::ONE);
            return (below.select(-z, z), f32x8::splat(PI * factor * sides));
        }
        let z = warp::uniform_sphere(u).z;
        let cosine = match self.convention {
            Convention::Orthonormal => z,
            Convention::Report => z.abs(),
        };
        let scale = 2.0 * PI * (self.exponent as f32 + 1.0) * factor;
        let power = pow_one_minus(f32x8::ONE - cosine, n) * scale;
        (z, power & cosine.simd_gt(f32x8::ZERO))
    }
}

/// The unit square in cells, eight a batch; a pair of samples for each.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// A multiple of eight.
    columns: u32,
    rows: u32,
    /// Whether a pair stays in its cell.
    cells: bool,
}

impl Grid {
    /// For at most so many samples, and at least 16.
    fn new(sampling: Sampling, samples: u32) -> Self {
        let pairs = samples / 2;
        let columns = match sampling {
            // Nearly square.
            Sampling::Stratified => (pairs.isqrt() + 4) / 8 * 8,
            Sampling::Uniform | Sampling::CosinePower => 8,
        };
        let columns = columns.max(8);
        Self {
            columns,
            rows: (pairs / columns).max(1),
            cells: sampling == Sampling::Stratified,
        }
    }

    /// Numbers for the whole square, or for a cell of it.
    fn within(&self, column: u32x8, row: u32, u: warp::Pair) -> warp::Pair {
        /// The greatest number below 1.
        const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;
        if !self.cells {
            return u;
        }
        // Columns and rows are below 2^16, and so exact.
        let column = f32x8::new(column.to_array().map(|c| c as f32));
        let part = |index: f32x8, u: f32x8, of: u32| {
            ((index + u) / f32x8::splat(of as f32)).fast_min(f32x8::splat(BELOW_ONE))
        };
        (
            part(column, u.0, self.columns),
            part(f32x8::splat(row as f32), u.1, self.rows),
        )
    }
}
