//! Owen-scrambled Sobol' pairs, padded (Burley 2020, "Practical Hash-based Owen Scrambling").
//!
//! Every pair of dimensions is the (0, 2)-sequence of Sobol' with its index shuffled and its digits scrambled by a seed of
//! its own, so that any aligned power of two of samples is a (0, m, 2)-net of each pair and pairs are independent. Lane by
//! lane it equals `sobol_burley::sample(index, 0 | 1, seed)`, without that crate's table of direction numbers: the second
//! dimension's matrix is Pascal's triangle modulo 2, a product of four butterfly steps.

use super::hash::hash;
use crate::lanes::{f32x8, u32x8};
use wide::u8x32;

/// Samples of one sequence. Beyond it the seed changes: each 65,536 samples are a randomisation of their own.
pub const SEQUENCE_LENGTH: u32 = 1 << 16;

/// Both numbers of sample `reversed_index.reverse_bits()` of the sequences that belong to `seed`.
#[inline]
pub fn pair(reversed_index: u32x8, seed: u32x8) -> (f32x8, f32x8) {
    let index = shuffled(reversed_index, seed);
    let scramble = seed * u32x8::splat(0x9c8f_2d3b);
    let first = owen_scramble(index, hash(scramble ^ u32x8::splat(0x912f_69ba)));
    let second = owen_scramble(pascal(index), hash(scramble ^ u32x8::splat(0x174f_18ab)));
    (unit(reverse_bits(first)), unit(reverse_bits(second)))
}

/// The first number of [`pair`].
#[inline]
pub fn single(reversed_index: u32x8, seed: u32x8) -> f32x8 {
    let index = shuffled(reversed_index, seed);
    let scramble = seed * u32x8::splat(0x9c8f_2d3b);
    unit(reverse_bits(owen_scramble(
        index,
        hash(scramble ^ u32x8::splat(0x912f_69ba)),
    )))
}

/// The index in the order of this seed: an Owen scramble of its 16 bits.
#[inline]
fn shuffled(reversed_index: u32x8, seed: u32x8) -> u32x8 {
    let order = hash(seed ^ u32x8::splat(0x79c6_8e4a));
    reverse_bits(owen_scramble(reversed_index, order) & u32x8::splat(0xffff_0000))
}

/// Scrambles digits from the lowest bit up, the order of reversed numbers (Laine & Karras 2011, section 3.3, with the
/// constants of N. Vegdahl 2021, "Building a Better LK Hash").
#[inline]
fn owen_scramble(reversed: u32x8, seed: u32x8) -> u32x8 {
    let n = reversed;
    let n = n ^ (n * u32x8::splat(0x3d20_adea));
    let n = (n + seed) * ((seed >> 16) | u32x8::splat(1));
    let n = n ^ (n * u32x8::splat(0x0552_6c56));
    n ^ (n * u32x8::splat(0x53a2_2864))
}

/// Sobol's second dimension of a 16-bit index, bits reversed: bit k is the sum of the index bits j with C(j, k) odd, that
/// is, with j a superset of k.
#[inline]
fn pascal(index: u32x8) -> u32x8 {
    let n = index;
    let n = n ^ ((n >> 1) & u32x8::splat(0x5555));
    let n = n ^ ((n >> 2) & u32x8::splat(0x3333));
    let n = n ^ ((n >> 4) & u32x8::splat(0x0f0f));
    n ^ ((n >> 8) & u32x8::splat(0x00ff))
}

/// Each word's bits, last to first: two nibble look-ups and a turn of the bytes.
#[inline]
pub fn reverse_bits(word: u32x8) -> u32x8 {
    const HIGH: [u8; 16] = {
        let mut table = [0; 16];
        let mut nibble = 0;
        while nibble < 16 {
            table[nibble] = (nibble as u8).reverse_bits();
            nibble += 1;
        }
        table
    };
    const LOW: [u8; 16] = {
        let mut table = HIGH;
        let mut nibble = 0;
        while nibble < 16 {
            table[nibble] >>= 4;
            nibble += 1;
        }
        table
    };
    const TURN: [u8; 16] = [3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12];
    let bytes = |word: u32x8| u8x32::new(word.to_ne_bytes());
    let twice = |table: [u8; 16]| -> u8x32 { u8x32::new(std::array::from_fn(|i| table[i % 16])) };
    let nibbles = u32x8::splat(0x0f0f_0f0f);
    let high = twice(HIGH).swizzle_half_relaxed(bytes(word & nibbles));
    let low = twice(LOW).swizzle_half_relaxed(bytes((word >> 4) & nibbles));
    u32x8::from_ne_bytes((high | low).swizzle_half_relaxed(twice(TURN)).to_ne_bytes())
}

/// The upper 23 bits as a number in [0, 1).
#[inline]
pub fn unit(word: u32x8) -> f32x8 {
    f32x8::from_bits((word >> 9) | u32x8::splat(0x3f80_0000)) - f32x8::ONE
}
