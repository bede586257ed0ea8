//! Floor 0: the eight-lane vocabulary. Every kernel of the tracer is written with these types.
//!
//! Masks are `f32x8` whose lanes are all ones or all zeros, as `wide`'s comparisons give them.
//! Only operations that IEEE 754 rounds exactly are used (no `rcp`, no `rsqrt`: they differ from one maker of
//! processors to the next), and fused multiply-adds are always written out, so a lane's bits do not depend on the machine.

mod fields;
mod math;
mod queue;
mod rgb;
mod table;
mod vec3;

pub use fields::*;
pub use math::*;
pub use queue::*;
pub use rgb::*;
pub use table::{Row, Table};
pub use vec3::*;
pub use wide::{f32x8, f64x8, u32x8};

/// Lanes of a batch.
pub const WIDTH: usize = 8;

/// Lanes `0..count` on, the others off.
#[inline]
pub fn first_lanes(count: usize) -> f32x8 {
    f32x8::from_bits(u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]).simd_lt(u32x8::splat(count as u32)))
}
