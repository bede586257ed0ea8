//! Projection of a lat-long image: exact integrals of each function over each pixel.
//!
//! In a frame whose pole is the image's, functions separate. Over a pixel, the integral of cos mφ is in closed form, and that
//! of the Legendre function is the same for a whole row: so a row costs sums of its pixels by order alone, and every row adds
//! its share to each degree. Rows go eight at a time, one a lane, in double precision. At last the coefficients are turned
//! from that frame to the world's, exactly.

use super::quadrature::{gauss_legendre, nodes_for};
use super::{Probe, coefficients, index, legendre, rotated};
use crate::error::{Error, Result};
use crate::lanes::{Rgb, WIDTH, f64x8};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Parts of an image that are summed by themselves: a fixed number, so that no sum depends on the threads.
const PARTS: usize = 64;

/// Pairs of columns that are summed at a time: with their eight rows they fit into the first cache.
const COLUMNS: usize = 64;

/// Coefficients of the radiance that a lat-long image shows, its pixels constant over their solid angles, row 0 at +y, column
/// `x` at azimuths `φ = 2π·[x, x + 1)/width` with the direction `(sin θ sin φ, cos θ, −sin θ cos φ)`.
///
/// The threads are those of the current rayon pool; they change no bit.
///
/// # Errors
/// [`Error::Usage`] where the image is not twice as wide as high, `pixels` are not as many, or one is not finite.
pub fn project(width: usize, height: usize, pixels: &[Rgb], degree: usize) -> Result<Probe> {
    if height == 0 || width != 2 * height || width.checked_mul(height) != Some(pixels.len()) {
        return Err(Error::Usage(format!(
            "{} pixels of {width}×{height} are no lat-long image; it is twice as wide as high",
            pixels.len()
        )));
    }
    let plan = Plan::new(width, height, degree);
    let groups = height.div_ceil(WIDTH);
    let per_part = groups.div_ceil(PARTS);
    let parts: Vec<Vec<[f64; 3]>> = (0..groups.div_ceil(per_part))
        .into_par_iter()
        .map(|part| {
            let groups = part * per_part..groups.min((part + 1) * per_part);
            plan.part(pixels, groups)
        })
        .collect();
    let mut sums = vec![[0.0; 3]; coefficients(degree)];
    for part in &parts {
        for (sum, part) in sums.iter_mut().zip(part) {
            for (sum, part) in sum.iter_mut().zip(part) {
                *sum += part;
            }
        }
    }
    if sums.iter().flatten().any(|sum| !sum.is_finite()) {
        return Err(not_finite(width, pixels));
    }
    // The frame of the image: its x is −z of the world, its y is −x, its z is y.
    let to_world = DMat3::from_cols(DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y);
    Probe::radiance(rotated(&sums, &to_world))
}

fn not_finite(width: usize, pixels: &[Rgb]) -> Error {
    let wrong = |pixel: &Rgb| pixel.to_array().iter().any(|value| !value.is_finite());
    let at = pixels.iter().position(wrong).unwrap_or_default();
    Error::Usage(format!(
        "pixel ({}, {}) is not finite; repair the image",
        at % width,
        at / width
    ))
}

/// What all rows share.
struct Plan {
    width: usize,
    height: usize,
    degree: usize,
    /// For each order, cos and sin of mφ in the middle of each column of the left half.
    azimuths: Vec<[f64; 2]>,
    /// For each order, the integral of cos mφ over a column, over its value in the middle.
    widths: Vec<f64>,
    /// Nodes within a row and their weights, for an interval from −1 to 1.
    nodes: Vec<(f64, f64)>,
    /// For each order, the factor from the one before to its first function; for each degree, the two of the recursion.
    legendre: Vec<(f64, Vec<[f64; 2]>)>,
}

/// Sums over azimuths of eight rows, RGB with cos mφ and RGB with sin mφ.
type Sums = [f64x8; 6];

impl Plan {
    fn new(width: usize, height: usize, degree: usize) -> Self {
        let half = width / 2;
        // Multiples of half a column: m · (2x + 1) of them, modulo a turn.
        let turn = 2 * width;
        let angles: Vec<(f64, f64)> = (0..turn)
            .map(|k| libm::sincos(PI * k as f64 / width as f64))
            .collect();
        let azimuths = (0..=degree).flat_map(|m| {
            let angles = &angles;
            (0..half).map(move |x| {
                let (sin, cos) = angles[m * (2 * x + 1) % turn];
                [cos, sin]
            })
        });
        let widths = (0..=degree).map(|m| match m {
            0 => 2.0 * PI / width as f64,
            _ => 2.0 * angles[m % turn].0 / m as f64,
        });
        let legendre = (0..=degree).map(|m| {
            let steps = (m..=degree).map(|l| legendre::step(l, m));
            (legendre::first(m), steps.collect())
        });
        let half_height = 0.5 * PI / height as f64;
        Self {
            azimuths: azimuths.collect(),
            widths: widths.collect(),
            // Over a row, a function of degree l times sin θ is a sum of cosines and sines of up to (l + 1)θ.
            nodes: gauss_legendre(nodes_for((degree + 1) as f64 * half_height)),
            legendre: legendre.collect(),
            width,
            height,
            degree,
        }
    }

    /// The share of some groups of eight rows in the coefficients, in the frame of the image.
    fn part(&self, pixels: &[Rgb], groups: std::ops::Range<usize>) -> Vec<[f64; 3]> {
        let mut shares = vec![[f64x8::ZERO; 3]; coefficients(self.degree)];
        let mut sums: Vec<Sums> = vec![[f64x8::ZERO; 6]; self.degree + 1];
        let mut integrals = vec![f64x8::ZERO; (self.degree + 1) * (self.degree + 2) / 2];
        for group in groups {
            self.sum_azimuths(pixels, group, &mut sums);
            self.integrate_rows(group, &mut integrals);
            let mut integrals = integrals.iter();
            for (m, sums) in sums.iter().enumerate() {
                // Azimuths of the image run clockwise about its pole.
                let width = self.widths[m];
                let [cos, sin] = [width, -width].map(f64x8::splat);
                let [r, g, b, r_sin, g_sin, b_sin] = *sums;
                let even = [r, g, b].map(|sum| sum * cos);
                let odd = [r_sin, g_sin, b_sin].map(|sum| sum * sin);
                for (l, &integral) in (m..=self.degree).zip(&mut integrals) {
                    let order = m.cast_signed();
                    add(&mut shares[index(l, order)], integral, even);
                    if m > 0 {
                        add(&mut shares[index(l, -order)], integral, odd);
                    }
                }
            }
        }
        let total = |lanes: f64x8| lanes.to_array().iter().sum();
        shares.into_iter().map(|rgb| rgb.map(total)).collect()
    }

    /// Sums eight rows of pixels with cos mφ and sin mφ, for each order m.
    fn sum_azimuths(&self, pixels: &[Rgb], group: usize, sums: &mut [Sums]) {
        let rows = group * WIDTH..self.height.min((group + 1) * WIDTH);
        let half = self.width / 2;
        sums.fill([f64x8::ZERO; 6]);
        let mut folded = [[f64x8::ZERO; 6]; COLUMNS];
        for first in (0..half).step_by(COLUMNS) {
            let count = COLUMNS.min(half - first);
            // A column and its mirror image have the same cosine and opposite sines.
            for (lane, y) in rows.clone().enumerate() {
                let row = &pixels[y * self.width..(y + 1) * self.width];
                let left = &row[first..first + count];
                let right = &row[self.width - first - count..self.width - first];
                let pairs = left.iter().zip(right.iter().rev());
                for (folded, (left, right)) in folded.iter_mut().zip(pairs) {
                    let both = left.to_array().into_iter().zip(right.to_array());
                    for (channel, (left, right)) in both.enumerate() {
                        let (left, right) = (f64::from(left), f64::from(right));
                        folded[channel].as_mut_array()[lane] = left + right;
                        folded[channel + 3].as_mut_array()[lane] = left - right;
                    }
                }
            }
            for (sums, azimuths) in sums.iter_mut().zip(self.azimuths.chunks_exact(half)) {
                let mut sum = *sums;
                let azimuths = &azimuths[first..first + count];
                for (&[cos, sin], folded) in azimuths.iter().zip(&folded) {
                    let (cos, sin) = (f64x8::splat(cos), f64x8::splat(sin));
                    for channel in 0..3 {
                        sum[channel] = folded[channel].mul_add(cos, sum[channel]);
                        sum[channel + 3] = folded[channel + 3].mul_add(sin, sum[channel + 3]);
                    }
                }
                *sums = sum;
            }
        }
    }

    /// Integrals over θ, with its sine, of the Legendre functions in eight rows: by order, then degree. Rows beyond the image
    /// are black, and what is found for them counts for nothing.
    fn integrate_rows(&self, group: usize, integrals: &mut [f64x8]) {
        integrals.fill(f64x8::ZERO);
        let step = PI / self.height as f64;
        for &(node, weight) in &self.nodes {
            let angles: [(f64, f64); WIDTH] = std::array::from_fn(|lane| {
                let row = (group * WIDTH + lane) as f64;
                libm::sincos(step * (row + 0.5 + 0.5 * node))
            });
            let sin = f64x8::new(angles.map(|(sin, _)| sin));
            let cos = f64x8::new(angles.map(|(_, cos)| cos));
            let mut power = sin * f64x8::splat(0.5 * step * weight);
            let mut integrals = integrals.iter_mut();
            for (m, (first, steps)) in self.legendre.iter().enumerate() {
                power *= f64x8::splat(*first);
                if m > 0 {
                    power *= sin;
                }
                let (mut below, mut here) = (f64x8::ZERO, power);
                for (&[a, b], integral) in steps.iter().zip(&mut integrals) {
                    *integral += here;
                    let next = (cos * here).mul_sub(f64x8::splat(a), below * f64x8::splat(b));
                    (below, here) = (here, next);
                }
            }
        }
    }
}

fn add(to: &mut [f64x8; 3], integral: f64x8, sums: [f64x8; 3]) {
    for (to, sum) in to.iter_mut().zip(sums) {
        *to = integral.mul_add(sum, *to);
    }
}
