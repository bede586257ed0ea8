//! Tables that eight lanes read at once, each its own row.

use super::{WIDTH, f32x8, u32x8};

/// Fields of a row.
pub type Row = [f32; WIDTH];

/// Rows by id, read eight at a time.
///
/// Up to 16 rows are kept by column too, and a column is then a shuffle of one or two registers. Larger tables load eight
/// rows and transpose them, which on x86 beats eight hardware gathers.
#[derive(Clone, Debug, Default)]
pub struct Table {
    rows: Vec<Row>,
    /// For each field, rows 0 to 7 and 8 to 15.
    columns: [[f32x8; 2]; WIDTH],
}

/// The most rows that are kept by column.
const COLUMN: usize = 2 * WIDTH;

impl Table {
    /// From rows; their ids are their places.
    pub fn new(rows: Vec<Row>) -> Self {
        let cell = |row: usize, field: usize| rows.get(row).map_or(0.0, |row| row[field]);
        let half = |first: usize, field: usize| {
            f32x8::new(std::array::from_fn(|lane| cell(first + lane, field)))
        };
        Self {
            columns: std::array::from_fn(|field| [half(0, field), half(WIDTH, field)]),
            rows,
        }
    }

    /// The rows.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Field `f` of the result holds `rows[ids.lane(i)][f]` in lane `i`. An id of no row reads arbitrary values (dead lanes
    /// hold arbitrary ids).
    #[inline]
    pub fn gather(&self, ids: u32x8) -> [f32x8; WIDTH] {
        if self.rows.len() <= WIDTH {
            self.columns.map(|[low, _]| low.shuffle_wrapping(ids))
        } else if self.rows.len() <= COLUMN {
            let high = f32x8::from_bits((ids & u32x8::splat(WIDTH as u32)).simd_ne(u32x8::ZERO));
            self.columns.map(|[first, second]| {
                high.select(second.shuffle_wrapping(ids), first.shuffle_wrapping(ids))
            })
        } else {
            let last = self.rows.len() - 1;
            let ids = ids.min(u32x8::splat(last as u32)).to_array();
            f32x8::transpose(std::array::from_fn(|lane| {
                f32x8::new(self.rows[ids[lane] as usize])
            }))
        }
    }
}
