//! Scalar functions, eight at a time.

use super::{f32x8, u32x8};

/// `(sin 2πu, cos 2πu)` for `u` in [0, 1], each within 2^-22 absolute.
///
/// The angle is folded to a quarter turn, where odd and even minimax polynomials in the fraction of a turn serve.
#[inline]
pub fn sin_cos_turns(u: f32x8) -> (f32x8, f32x8) {
    // k = nearest multiple of a quarter turn; r in [-1/8, 1/8] turns, exact in f32.
    let k = (u * 4.0).round_ties_even();
    let r = k.mul_neg_add(f32x8::splat(0.25), u);
    let x = r * std::f32::consts::TAU;
    let (sin, cos) = sin_cos_eighth(x);
    // Quarter k: (s, c) -> (c, -s) -> (-s, -c) -> (-c, s). Adding 1.5·2^23 leaves the integer k in the low mantissa bits.
    let quarter = (k + f32x8::splat(12_582_912.0)).to_bits();
    let swap = f32x8::from_bits((quarter & 1).simd_eq(u32x8::splat(1)));
    let sin_sign = (quarter & 2) << 30;
    let cos_sign = ((quarter + 1) & 2) << 30;
    let (a, b) = (swap.select(cos, sin), swap.select(sin, cos));
    (
        f32x8::from_bits(a.to_bits() ^ sin_sign),
        f32x8::from_bits(b.to_bits() ^ cos_sign),
    )
}

/// `(sin x, cos x)` for `x` in [−π/4, π/4], each within 2^-23 absolute (minimax polynomials of Cephes sinf and cosf,
/// S. Moshier 1989).
#[inline]
pub fn sin_cos_eighth(x: f32x8) -> (f32x8, f32x8) {
    let x2 = x * x;
    let s = x2.mul_add(f32x8::splat(-1.951_529_6e-4), f32x8::splat(8.332_161e-3));
    let s = x2.mul_add(s, f32x8::splat(-1.666_665_5e-1));
    let sin = (x2 * x).mul_add(s, x);
    let c = x2.mul_add(f32x8::splat(2.443_315_7e-5), f32x8::splat(-1.388_731_6e-3));
    let c = x2.mul_add(c, f32x8::splat(4.166_664_6e-2));
    let cos = (x2 * x2).mul_add(c, x2.mul_add(f32x8::splat(-0.5), f32x8::ONE));
    (sin, cos)
}

/// `x²`.
#[inline]
pub fn square(x: f32x8) -> f32x8 {
    x * x
}

/// `sqrt(max(x, 0))`.
#[inline]
pub fn safe_sqrt(x: f32x8) -> f32x8 {
    x.fast_max(f32x8::ZERO).sqrt()
}

/// `(1 − x)^y` for `x` ≥ 0 and `y` ≥ 0, without rounding `1 − x`; 0 where `x` ≥ 1 and `y` is not 0, 1 where `y` is 0.
///
/// The error is 2^-23 of `y · ln(1 − x)`: relative 3e-5 where the result is 1e-38, 2e-6 where it is above 1e-6. Results below
/// 1e-37 stop there.
#[inline]
pub fn pow_one_minus(x: f32x8, y: f32x8) -> f32x8 {
    let log = (-x.fast_min(f32x8::splat(1.0 - f32::EPSILON))).ln_1p();
    let power = (log * y).fast_max(f32x8::splat(-87.0)).exp();
    let zero = x.simd_ge(f32x8::ONE) & y.simd_gt(f32x8::ZERO);
    zero.select(f32x8::ZERO, power)
}

/// The least or the greatest of the eight lanes, as `best` has it of two, in each lane.
#[inline(always)]
pub fn reduce(v: f32x8, best: fn(f32x8, f32x8) -> f32x8) -> f32x8 {
    let v = best(v, v.shuffle_wrapping(u32x8::new([4, 5, 6, 7, 0, 1, 2, 3])));
    let v = best(v, v.shuffle_wrapping(u32x8::new([2, 3, 0, 1, 6, 7, 4, 5])));
    best(v, v.shuffle_wrapping(u32x8::new([1, 0, 3, 2, 5, 4, 7, 6])))
}
