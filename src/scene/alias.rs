//! Choices in proportion to weights: the alias method (Walker 1977; table by Vose 1991).

use crate::lanes::{Table, f32x8, u32x8};

/// Up to 2^22 things, of which one is chosen by chance.
#[derive(Clone, Debug, Default)]
pub(super) struct Alias {
    /// Threshold, alias (bits).
    columns: Table,
}

impl Alias {
    /// From chances that sum to 1; empty where they are all 0.
    pub fn new(chances: &[f64]) -> Self {
        let row = |(threshold, alias): (f32, u32)| {
            let alias = f32::from_bits(alias);
            [threshold, alias, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        };
        if chances.iter().any(|&chance| chance > 0.0) {
            let columns = alias_table(chances).into_iter().map(row).collect();
            Self {
                columns: Table::new(columns),
            }
        } else {
            Self::default()
        }
    }

    /// Whether there is nothing to choose.
    pub fn is_empty(&self) -> bool {
        self.columns.rows().is_empty()
    }

    /// One of them by a number, and what is left of that: again in [0, 1) and uniform, if coarse.
    #[inline]
    pub fn choose(&self, u: f32x8) -> (u32x8, f32x8) {
        let count = f32x8::splat(self.columns.rows().len() as f32);
        let scaled = u * count;
        let column = scaled.floor().fast_min(count - f32x8::ONE);
        // 1.5·2^23 leaves an integer below 2^22 in the low mantissa bits.
        let column_id = (column + f32x8::splat(12_582_912.0)).to_bits() & u32x8::splat(0x3f_ffff);
        let [threshold, alias, ..] = self.columns.gather(column_id);
        let within = scaled - column;
        let keep = within.simd_lt(threshold);
        let rest = keep.select(
            within / threshold,
            (within - threshold) / (f32x8::ONE - threshold),
        );
        (keep.select(column_id, alias.to_bits()), rest)
    }
}

/// The least share of choices that a light with power gets, of what it would get were all alike. A choice has 23 bits:
/// a rarer light would be chosen by the grain of the random numbers, and not as often as its weight says.
const LEAST_SHARE: f64 = 1e-3;

/// Chances in proportion to powers, but for [`LEAST_SHARE`]; all 0 where no light has power.
pub(super) fn chances(powers: &[f64]) -> Vec<f64> {
    let total: f64 = powers.iter().sum();
    let least = LEAST_SHARE * total / powers.len() as f64;
    let raised = powers
        .iter()
        .map(|&power| if power > 0.0 { power.max(least) } else { 0.0 });
    let total: f64 = raised.clone().sum();
    raised
        .map(|power| if total > 0.0 { power / total } else { 0.0 })
        .collect()
}

/// Vose's construction, from chances that sum to 1: each column, an equal share of all choices, keeps its id below the
/// threshold and takes the alias above it.
pub(super) fn alias_table(chances: &[f64]) -> Vec<(f32, u32)> {
    let count = chances.len();
    let mut scaled: Vec<f64> = chances.iter().map(|p| p * count as f64).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..count).partition(|&id| scaled[id] < 1.0);
    let mut columns: Vec<(f64, usize)> = (0..count).map(|id| (1.0, id)).collect();
    while let (Some(&less), Some(&more)) = (small.last(), large.last()) {
        small.pop();
        columns[less] = (scaled[less], more);
        scaled[more] -= 1.0 - scaled[less];
        if scaled[more] < 1.0 {
            large.pop();
            small.push(more);
        }
    }
    // What is left over differs from 1 by rounding alone, but a light of chance 0 must never be chosen.
    let brightest = (0..count)
        .max_by(|&a, &b| chances[a].total_cmp(&chances[b]))
        .unwrap_or(0);
    for (id, column) in columns.iter_mut().enumerate() {
        if chances[id] == 0.0 && column.1 == id {
            *column = (0.0, brightest);
        }
    }
    columns
        .into_iter()
        .map(|(threshold, alias)| (threshold as f32, alias as u32))
        .collect()
}
