//! The basis, eight directions at a time.

use super::low::{LOW, low, turned};
use super::{MAX_DEGREE, coefficients, index, legendre, past_cache};
use crate::lanes::{Vec3x8, WIDTH, f32x8};
use rayon::prelude::*;

/// The basis functions up to a degree.
///
/// Degrees to 4 are written out. From there a recursion in the degree goes on, order by order: the modified forward column
/// method of Holmes & Featherstone 2002, "A unified approach to the Clenshaw summation and the recursive computation of very
/// high degree and order normalised associated Legendre functions". Its functions are normalised at each step and divided by
/// sin^m θ, so that no pole is special and nothing overflows: the greatest of degree 128 is 2·10²⁶. A value's bits do not
/// depend on the greatest degree.
#[derive(Clone, Debug)]
pub struct Basis {
    degree: usize,
    /// By order: the function of that degree.
    diagonal: Vec<f32>,
    /// Order by order, the steps from a degree to the next, as the recursion takes them.
    steps: Vec<Step>,
}

/// Rows that are made in the cache and then written in one go, line by line: memory takes lines in order faster than parts of
/// eight rows at a time.
const STAGED: usize = 2 * WIDTH;

/// Directions that a thread takes at a time.
const CHUNK: usize = 1024;

/// Bytes of a table that no cache keeps until it is read: it is written past them, 1.5 to 2 times faster.
const UNCACHED: usize = 1 << 24;

/// `next = here · z · rise + below · fall`
#[derive(Clone, Copy, Debug)]
struct Step {
    rise: f32,
    fall: f32,
}

impl Basis {
    /// Those of degrees 0 to `degree`.
    ///
    /// # Panics
    /// Where `degree` is above [`MAX_DEGREE`].
    #[must_use]
    pub fn new(degree: usize) -> Self {
        assert!(
            degree <= MAX_DEGREE,
            "degree {degree} is above {MAX_DEGREE}"
        );
        let diagonal = (0..=degree).scan(1.0, |product, m| {
            *product *= legendre::first(m);
            Some(*product as f32)
        });
        let steps = (0..=degree)
            .flat_map(|m| (m.max(LOW) + 1..=degree).map(move |l| (l, m)))
            .map(|(l, m)| {
                let [rise, fall] = legendre::step(l - 1, m);
                Step {
                    rise: rise as f32,
                    fall: -fall as f32,
                }
            })
            .collect();
        Self {
            degree,
            diagonal: diagonal.collect(),
            steps,
        }
    }

    /// The greatest degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Their values at eight unit directions, in the order of [`index`]; `values` has [`coefficients`] of them.
    ///
    /// A value is within 10⁻⁷ · (l + 1)² of the true one: that much comes, near the poles, of `z` being rounded to 32 bits.
    ///
    /// # Panics
    /// Where `values` is of another length.
    #[inline]
    pub fn evaluate(&self, direction: &Vec3x8, values: &mut [f32x8]) {
        assert_eq!(values.len(), coefficients(self.degree));
        // The same code: where the degree is a constant, all loops are unrolled, which is 1.2 times faster.
        match self.degree {
            0 => self.write(0, direction, values),
            1 => self.write(1, direction, values),
            2 => self.write(2, direction, values),
            3 => self.write(3, direction, values),
            4 => self.write(4, direction, values),
            5 => self.write(5, direction, values),
            6 => self.write(6, direction, values),
            7 => self.write(7, direction, values),
            8 => self.write(8, direction, values),
            degree => self.write(degree, direction, values),
        }
    }

    #[inline(always)]
    fn write(&self, degree: usize, direction: &Vec3x8, values: &mut [f32x8]) {
        let low = low(direction);
        let values = &mut values[..coefficients(degree)];
        let written = coefficients(degree.min(LOW));
        values[..written].copy_from_slice(&low.values[..written]);
        if degree <= LOW {
            return;
        }
        let Vec3x8 { x, y, z } = *direction;
        let mut turn = low.turns[LOW];
        let mut steps = self.steps.iter();
        for m in 0..=degree {
            let mut put = |l: usize, legendre: f32x8, (cos, sin): (f32x8, f32x8)| {
                // In this order: of order 0 the cosine stays.
                values[index(l, 0) - m] = legendre * sin;
                values[index(l, 0) + m] = legendre * cos;
            };
            let [mut below, mut here] = match low.last.get(m) {
                Some(&last) => {
                    turn = low.turns[m];
                    last
                }
                None => {
                    turn = turned(turn, x, y);
                    let first = f32x8::splat(self.diagonal[m]);
                    put(m, first, turn);
                    [f32x8::ZERO, first]
                }
            };
            for (l, step) in (m.max(LOW) + 1..=degree).zip(&mut steps) {
                let next = (z * step.rise).mul_add(here, below * step.fall);
                put(l, next, turn);
                (below, here) = (here, next);
            }
        }
    }

    /// Their values at each of these unit directions: a row of [`coefficients`] for each. The threads are those of the current
    /// rayon pool; they change no bit.
    ///
    /// # Panics
    /// Where `rows` is of another length.
    pub fn tabulate(&self, directions: &[[f32; 3]], rows: &mut [f32]) {
        let row = coefficients(self.degree);
        assert_eq!(rows.len(), directions.len() * row);
        let uncached = size_of_val(rows) >= UNCACHED;
        rows.par_chunks_mut(CHUNK * row)
            .zip(directions.par_chunks(CHUNK))
            .for_each(|(rows, directions)| self.fill(directions, rows, uncached));
    }

    /// One thread's part of a table.
    fn fill(&self, directions: &[[f32; 3]], rows: &mut [f32], uncached: bool) {
        let row = coefficients(self.degree);
        let mut values = vec![f32x8::ZERO; row];
        let mut stage = vec![0.0; STAGED * row];
        let groups = directions.chunks(STAGED);
        for (group, rows) in groups.zip(rows.chunks_mut(STAGED * row)) {
            let batches = group.chunks(WIDTH);
            for (batch, stage) in batches.zip(stage.chunks_mut(WIDTH * row)) {
                // The last batch may have fewer: its first direction stands in.
                let component = |axis: usize| {
                    f32x8::new(std::array::from_fn(|lane| {
                        batch.get(lane).unwrap_or(&batch[0])[axis]
                    }))
                };
                let direction = Vec3x8::new(component(0), component(1), component(2));
                self.evaluate(&direction, &mut values);
                scatter(&values, stage);
            }
            match uncached {
                true => past_cache::copy(rows, &stage[..rows.len()]),
                false => rows.copy_from_slice(&stage[..rows.len()]),
            }
        }
        if uncached {
            past_cache::finish();
        }
    }
}

/// Writes the lanes as rows.
#[inline(always)]
fn scatter(values: &[f32x8], rows: &mut [f32]) {
    let row = values.len();
    if row < WIDTH {
        for (lane, row) in rows.chunks_exact_mut(row).enumerate() {
            for (to, value) in row.iter_mut().zip(values) {
                *to = value.as_array()[lane];
            }
        }
        return;
    }
    // Squares of eight by eight; where eight do not divide the row, the last square overlaps the one before.
    for start in (0..row).step_by(WIDTH) {
        let start = start.min(row - WIDTH);
        let square = std::array::from_fn(|k| values[start + k]);
        for (row, eight) in rows.chunks_exact_mut(row).zip(f32x8::transpose(square)) {
            row[start..start + WIDTH].copy_from_slice(eight.as_array());
        }
    }
}
