//! PCG32 (O'Neill 2014, "PCG", section 6.3.1, XSH-RR 64/32), eight generators at a time with random access.
//!
//! Lane by lane it equals `rand_pcg::Pcg32`: each path has a generator, and number k of it is reached by one
//! multiplication, because the jump over k steps of an LCG is an LCG step with other constants (Brown 1994).

use crate::lanes::{f32x8, u32x8};
use crate::sampling::sobol::unit;

/// Multiplier of the LCG.
const MULTIPLIER: u64 = 6_364_136_223_846_793_005;

/// The stream every path's generator is on, as `rand_pcg::Pcg32::new` takes it.
pub const STREAM: u64 = 0x0a02_bdbf_7bb3_c0a7;

/// Increment of the LCG.
const INCREMENT: u64 = (STREAM << 1) | 1;

/// The constants that take a generator's first state to the state after some number of steps.
#[derive(Clone, Copy, Debug)]
pub struct Jump {
    multiplier: u64,
    increment: u64,
}

impl Jump {
    /// The jumps over 0, 1, … `count − 1` outputs, from the `state` that `Pcg32::new(state, STREAM)` takes.
    pub fn table(count: usize) -> Vec<Jump> {
        // `new` makes one step from state + increment before the first output.
        let mut jump = Jump {
            multiplier: MULTIPLIER,
            increment: INCREMENT.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT),
        };
        (0..count)
            .map(|_| {
                let current = jump;
                jump = Jump {
                    multiplier: current.multiplier.wrapping_mul(MULTIPLIER),
                    increment: current
                        .increment
                        .wrapping_mul(MULTIPLIER)
                        .wrapping_add(INCREMENT),
                };
                current
            })
            .collect()
    }
}

/// The number behind a jump of each lane's generator, in [0, 1); the state is given in two halves.
#[inline]
pub fn number(low: u32x8, high: u32x8, jump: Jump) -> f32x8 {
    unit(output(low, high, jump))
}

/// The word behind a jump of each lane's generator.
#[inline]
pub fn output(low: u32x8, high: u32x8, jump: Jump) -> u32x8 {
    let halves = |word: u64| (u32x8::splat(word as u32), u32x8::splat((word >> 32) as u32));
    // state = low·2^0 + high·2^32, times the multiplier, plus the increment, modulo 2^64.
    let (multiplier_low, multiplier_high) = halves(jump.multiplier);
    let (increment_low, increment_high) = halves(jump.increment);
    let (product_low, carried) = low.mul_keep_low_high(multiplier_low);
    let state_low = product_low + increment_low;
    let carry = state_low.simd_lt(increment_low) & u32x8::splat(1);
    let state_high =
        carried + low * multiplier_high + high * multiplier_low + increment_high + carry;
    // xorshifted = ((state >> 18) ^ state) >> 27, rotated right by state >> 59.
    let mixed_low = state_low ^ ((state_low >> 18) | (state_high << 14));
    let mixed_high = state_high ^ (state_high >> 18);
    let word = (mixed_low >> 27) | (mixed_high << 5);
    let turn = state_high >> 27;
    (word >> turn) | (word << ((u32x8::splat(32) - turn) & u32x8::splat(31)))
}
