//! Floor 0: the eight-lane vocabulary. Every kernel of the tracer is written with these types.
//!
//! Masks are `f32x8` whose lanes are all ones or all zeros, as `wide`'s comparisons give them.
//! Only operations that IEEE 754 rounds exactly are used (no `rcp`, no `rsqrt`: they differ from one maker of
//! processors to the next), and fused multiply-adds are always written out, so a lane's bits do not depend on the machine.

mod math;
mod queue;
mod rgb;
mod vec3;

pub use math::*;
pub use queue::*;
pub use rgb::*;
pub use vec3::*;
pub use wide::{f32x8, u32x8};

/// Lanes of a batch.
pub const WIDTH: usize = 8;

/// Lanes `0..count` on, the others off.
#[inline]
pub fn first_lanes(count: usize) -> f32x8 {
    f32x8::from_bits(u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]).simd_lt(u32x8::splat(count as u32)))
}

/// Eight rows of a table, transposed: field `f` of the result holds `table[ids.lane(i)][f]` in lane `i`.
///
/// Row loads and shuffles: on x86 this beats eight hardware gathers. An id past the end reads the last row (dead lanes
/// hold arbitrary ids); an empty table gives zeros.
#[inline]
pub fn gather_rows(table: &[[f32; WIDTH]], ids: u32x8) -> [f32x8; WIDTH] {
    let Some(last) = table.len().checked_sub(1) else {
        return [f32x8::ZERO; WIDTH];
    };
    let ids = ids.min(u32x8::splat(last as u32)).to_array();
    f32x8::transpose(std::array::from_fn(|lane| {
        f32x8::new(table[ids[lane] as usize])
    }))
}
