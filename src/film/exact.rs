//! Sums that do not depend on the order of addition: wide fixed-point integers.
//!
//! A sample is accepted when it is finite and |x| < 2³² ([`accepts`]); a pixel holds at most 2²⁷ samples
//! ([`MAX_SAMPLES`]). A [`Sum`] counts units of 2⁻⁶⁴: its magnitude stays below 2²⁷ · 2³² · 2⁶⁴ = 2¹²³, so an `i128`
//! never overflows. A [`Square`] counts units of 2⁻⁴⁰ and is never negative: it stays exact up to a sum of squares of
//! 2⁸⁷ (2²³ samples of the greatest size) and saturates there. Saturating addition of numbers that are not negative is
//! `min(total, MAX)`, associative and commutative too, so even then no order of addition shows in the bits.

use std::ops::{Add, AddAssign};

/// The most samples that a pixel can hold.
pub const MAX_SAMPLES: u32 = 1 << 27;

/// The bits of 2³²: as integers, the magnitudes of infinities and NaNs lie above it.
pub(super) const LIMIT_BITS: u32 = 0x4f80_0000;

/// Whether `x` can enter a sum: it is finite and |x| < 2³².
#[inline]
pub fn accepts(x: f32) -> bool {
    x.to_bits() & 0x7fff_ffff < LIMIT_BITS
}

/// A sum of values, in units of 2⁻⁶⁴.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct Sum(pub i128);

/// A sum of squares, in units of 2⁻⁴⁰; never negative, saturates at `i128::MAX`.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct Square(pub i128);

/// 1.5 · 2⁵²: adding it rounds |x| ≤ 2⁵⁰ to the nearest integer, ties to even, and leaves that integer in the low bits
/// of the result (Hecker 1996). Adds and subtractions only, so four channels vectorise; `f64 as i128` is a call per channel.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// `x` as an integer and what is left, in [-1/2, 1/2]; exact for |x| ≤ 2⁵⁰.
#[inline(always)]
fn split(x: f64) -> (i64, f64) {
    let rounded = x + ROUNDER;
    let integer = rounded
        .to_bits()
        .wrapping_sub(const { ROUNDER.to_bits() })
        .cast_signed();
    (integer, x - (rounded - ROUNDER))
}

/// 2^`e`.
const fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
}

impl Sum {
    /// The nearest multiple of 2⁻⁶⁴, ties to even. |x| ≤ 2³⁶, which 16 accepted samples cannot exceed.
    #[inline(always)]
    pub fn from_f64(x: f64) -> Self {
        debug_assert!(x.abs() <= power_of_two(36));
        // Units of 2^-14 above, of 2^-64 below. The upper part is even below, so ties fall as for the whole.
        let (high, rest) = split(x * power_of_two(14));
        let (low, _) = split(rest * power_of_two(50));
        Self((i128::from(high) << 50) + i128::from(low))
    }

    /// The nearest `f64`, ties to even.
    pub fn to_f64(self) -> f64 {
        self.0 as f64 * power_of_two(-64)
    }
}

impl Square {
    /// The nearest multiple of 2⁻⁴⁰, ties to even. 0 ≤ x ≤ 2⁶⁸, which 16 accepted samples cannot exceed.
    #[inline(always)]
    pub fn from_f64(x: f64) -> Self {
        debug_assert!((0.0..=power_of_two(68)).contains(&x));
        let (high, rest) = split(x * power_of_two(-18));
        let (middle, rest) = split(rest * power_of_two(29));
        let (low, _) = split(rest * power_of_two(29));
        Self((i128::from(high) << 58) + i128::from((middle << 29) + low))
    }

    /// The nearest `f64`, ties to even.
    pub fn to_f64(self) -> f64 {
        self.0 as f64 * power_of_two(-40)
    }
}

impl Add for Sum {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Add for Square {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl AddAssign for Sum {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl AddAssign for Square {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Mean of `count` values; 0 where there are none.
pub fn mean(sum: Sum, count: u32) -> f64 {
    if count == 0 {
        return 0.0;
    }
    sum.to_f64() / f64::from(count)
}

/// Variance of the mean: unbiased sample variance over `count`, `(n·Q − S²) / (n²·(n − 1))`.
///
/// The numerator is computed exactly in 256 bits, so nothing cancels; where the rounding of `square` made it negative
/// it is 0. 0 with fewer than two samples, which say nothing of their spread; infinite where `square` is saturated.
pub fn variance_of_mean(sum: Sum, square: Square, count: u32) -> f64 {
    if count < 2 {
        return 0.0;
    }
    if square.0 == i128::MAX {
        return f64::INFINITY;
    }
    // Both in units of 2^-128.
    let scaled = U256::product(u128::from(count), square.0.unsigned_abs()).shifted_left(88);
    let magnitude = sum.0.unsigned_abs();
    let n = f64::from(count);
    scaled
        .saturating_sub(U256::product(magnitude, magnitude))
        .to_f64()
        * power_of_two(-128)
        / (n * n * (n - 1.0))
}

/// 256 bits without a sign.
#[derive(Clone, Copy)]
struct U256 {
    high: u128,
    low: u128,
}

impl U256 {
    fn product(a: u128, b: u128) -> Self {
        const MASK: u128 = u64::MAX as u128;
        let (a1, a0, b1, b0) = (a >> 64, a & MASK, b >> 64, b & MASK);
        let low = a0 * b0;
        let (middle, carry) = (a1 * b0).overflowing_add(a0 * b1);
        let (low, carry_low) = low.overflowing_add(middle << 64);
        let high = a1 * b1 + (middle >> 64) + (u128::from(carry) << 64) + u128::from(carry_low);
        Self { high, low }
    }

    /// By `bits` in 1..128; bits that leave at the top are lost.
    fn shifted_left(self, bits: u32) -> Self {
        Self {
            high: self.high << bits | self.low >> (128 - bits),
            low: self.low << bits,
        }
    }

    fn saturating_sub(self, other: Self) -> Self {
        let (low, borrow) = self.low.overflowing_sub(other.low);
        let high = self
            .high
            .checked_sub(other.high)
            .and_then(|high| high.checked_sub(u128::from(borrow)));
        high.map_or(Self { high: 0, low: 0 }, |high| Self { high, low })
    }

    /// Within an ulp.
    fn to_f64(self) -> f64 {
        self.high as f64 * (power_of_two(127) * 2.0) + self.low as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounded to nearest, ties to even, from the mantissa: `x · 2^scale`.
    fn oracle(x: f64, scale: i32) -> i128 {
        if x == 0.0 {
            return 0;
        }
        let bits = x.to_bits();
        let exponent = ((bits >> 52) & 0x7ff) as i32;
        let fraction = i128::from(bits & ((1 << 52) - 1));
        let (mantissa, power) = match exponent {
            0 => (fraction, -1074 + scale),
            e => (fraction | 1 << 52, e - 1075 + scale),
        };
        let magnitude = if power >= 0 {
            mantissa << power
        } else if power < -60 {
            0
        } else {
            let floor = mantissa >> -power;
            let rest = mantissa - (floor << -power);
            let half = 1_i128 << (-power - 1);
            floor + i128::from(rest > half || (rest == half && floor & 1 == 1))
        };
        if x < 0.0 { -magnitude } else { magnitude }
    }

    fn numbers(seed: u64) -> impl Iterator<Item = u64> {
        let mut state = seed;
        std::iter::repeat_with(move || {
            // SplitMix64 (Steele et al. 2014).
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ z >> 31
        })
    }

    /// Doubles with exponents from 2^-90 to 2^`top`, among them ones with few mantissa bits, where ties lie.
    fn doubles(seed: u64, top: u64) -> impl Iterator<Item = f64> {
        numbers(seed).map(move |bits| {
            let exponent = 1023 - 90 + (bits >> 53) % (90 + top);
            let keep = bits & 63;
            let mantissa = bits.rotate_left(17) & ((1 << 52) - 1) & !((1 << keep.min(51)) - 1);
            f64::from_bits((bits & 1) << 63 | exponent << 52 | mantissa)
        })
    }

    #[test]
    fn a_value_becomes_the_nearest_multiple_ties_to_even() {
        for x in doubles(1, 36).take(400_000) {
            assert_eq!(Sum::from_f64(x).0, oracle(x, 64), "{x:e}");
        }
        let unit = power_of_two(-64);
        for (x, units) in [
            (0.0, 0),
            (-0.0, 0),
            (0.5 * unit, 0),
            (1.5 * unit, 2),
            (-2.5 * unit, -2),
            (f64::MIN_POSITIVE, 0),
            (power_of_two(36), 1 << 100),
            (-power_of_two(36), -(1 << 100)),
            (0.5, 1 << 63),
        ] {
            assert_eq!(Sum::from_f64(x).0, units, "{x:e}");
        }
    }

    #[test]
    fn a_square_becomes_the_nearest_multiple_ties_to_even() {
        for x in doubles(2, 68).take(400_000).map(f64::abs) {
            assert_eq!(Square::from_f64(x).0, oracle(x, 40), "{x:e}");
        }
        assert_eq!(Square::from_f64(power_of_two(68)).0, 1 << 108);
        assert_eq!(Square::from_f64(power_of_two(-41)).0, 0);
        assert_eq!(Square::from_f64(3.0 * power_of_two(-41)).0, 2);
    }

    #[test]
    fn what_a_double_holds_comes_back() {
        for x in doubles(3, 36).take(100_000) {
            let x = (x * power_of_two(30)).trunc() * power_of_two(-30);
            assert_eq!(Sum::from_f64(x).to_f64(), x);
        }
    }

    #[test]
    fn any_order_and_grouping_sums_to_the_same_bits() {
        let values: Vec<f64> = doubles(4, 36).take(1000).collect();
        let sum = |order: &[usize], group: usize| {
            order
                .chunks(group)
                .map(|ids| {
                    ids.iter()
                        .fold(Default::default(), |(s, q): (Sum, Square), &i| {
                            (
                                s + Sum::from_f64(values[i]),
                                q + Square::from_f64(values[i].abs()),
                            )
                        })
                })
                .fold((Sum::default(), Square::default()), |a, b| {
                    (a.0 + b.0, a.1 + b.1)
                })
        };
        let mut order: Vec<usize> = (0..values.len()).collect();
        let expected = sum(&order, values.len());
        let mut random = numbers(5);
        for round in 0..50 {
            for i in (1..order.len()).rev() {
                order.swap(i, (random.next().unwrap() % (i as u64 + 1)) as usize);
            }
            assert_eq!(sum(&order, 1 + 7 * round), expected);
        }
    }

    #[test]
    fn saturated_squares_stay_so_in_any_order() {
        let (big, small) = (Square(i128::MAX - 5), Square(4));
        assert_eq!((big + small) + small, Square(i128::MAX));
        assert_eq!(big + (small + small), Square(i128::MAX));
        assert_eq!(
            variance_of_mean(Sum(1), Square(i128::MAX), 2),
            f64::INFINITY
        );
    }

    #[test]
    fn wide_products_agree_with_schoolbook_digits() {
        let random: Vec<u64> = numbers(6).take(400).collect();
        for w in random.chunks_exact(4) {
            let a = u128::from(w[0]) << 64 | u128::from(w[1]);
            let b = u128::from(w[2]) << 64 | u128::from(w[3]);
            // Digits of 32 bits.
            let digit = |x: u128, i: usize| (x >> (32 * i)) & 0xffff_ffff;
            let mut columns = [0_u128; 9];
            for i in 0..4 {
                for j in 0..4 {
                    columns[i + j] += digit(a, i) * digit(b, j);
                }
            }
            for i in 0..8 {
                columns[i + 1] += columns[i] >> 32;
                columns[i] &= 0xffff_ffff;
            }
            let product = U256::product(a, b);
            for i in 0..4 {
                assert_eq!(digit(product.low, i), columns[i]);
                assert_eq!(digit(product.high, i), columns[i + 4]);
            }
        }
    }

    #[test]
    fn the_variance_of_a_large_offset_does_not_cancel() {
        // One ulp of f32 around 1e6: the naive formula in f64 loses most digits of the spread.
        let (offset, spread) = (1.0e6, power_of_two(-4));
        let (mut sum, mut square) = (Sum::default(), Square::default());
        for i in 0..1000 {
            let x = offset + if i % 2 == 0 { spread } else { -spread };
            sum += Sum::from_f64(x);
            square += Square::from_f64(x * x);
        }
        let expected = spread * spread / 999.0;
        let got = variance_of_mean(sum, square, 1000);
        assert!((got / expected - 1.0).abs() < 1e-12, "{got:e} {expected:e}");
        assert_eq!(
            variance_of_mean(Sum::from_f64(3.0), Square::from_f64(9.0), 1),
            0.0
        );
        assert_eq!(mean(Sum::default(), 0), 0.0);
    }
}
