//! Integer hashing.

use crate::lanes::u32x8;

/// A bijection of 32-bit words with low bias: `lowbias32` of C. Wellons' hash-prospector, and a constant so that 0 is no
/// fixed point (as the crate `sobol_burley` has it).
#[inline]
pub fn hash(word: u32x8) -> u32x8 {
    let n = word ^ u32x8::splat(0xe6fe_3beb);
    let n = (n ^ (n >> 16)) * u32x8::splat(0x7feb_352d);
    let n = (n ^ (n >> 15)) * u32x8::splat(0x846c_a68b);
    n ^ (n >> 16)
}

/// A bijection of 64-bit words in which each bit of the word moves half of the result's: the output of SplitMix64 (Steele, Lea
/// & Flood 2014, "Fast splittable pseudorandom number generators", with Stafford's constants "Mix13").
#[must_use]
pub fn hash_long(word: u64) -> u64 {
    let n = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let n = (n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    n ^ (n >> 31)
}

/// [`hash`] of one word.
pub fn hash_word(word: u32) -> u32 {
    hash(u32x8::splat(word)).to_array()[0]
}
