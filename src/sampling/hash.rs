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

/// [`hash`] of one word.
pub fn hash_word(word: u32) -> u32 {
    hash(u32x8::splat(word)).to_array()[0]
}
