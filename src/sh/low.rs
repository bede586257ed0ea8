//! Degrees 0 to 4, written out.

use crate::lanes::{Vec3x8, f32x8};

/// The last degree that is written out.
pub(super) const LOW: usize = 4;

/// Functions of those degrees.
const COUNT: usize = super::coefficients(LOW);

/// The values of the first degrees, and where the recursion goes on from.
pub(super) struct Low {
    /// In the order of [`index`](super::index).
    pub values: [f32x8; COUNT],
    /// By order: associated Legendre functions of degrees 3 and 4 over sin^m θ.
    pub last: [[f32x8; 2]; LOW + 1],
    /// By order: cos mφ · sin^m θ and sin mφ · sin^m θ.
    pub turns: [(f32x8, f32x8); LOW + 1],
}

/// One more turn by φ and factor sin θ of `(cos mφ, sin mφ) · sin^m θ`.
#[inline(always)]
pub(super) fn turned((cos, sin): (f32x8, f32x8), x: f32x8, y: f32x8) -> (f32x8, f32x8) {
    (x.mul_sub(cos, y * sin), x.mul_add(sin, y * cos))
}

/// The polynomials of Sloan 2013, "Efficient Spherical Harmonic Evaluation", appendix A2, without their signs. The constants
/// are `sqrt((2 − [m = 0]) · (2l + 1) / 4π · (l − m)! / (l + m)!)` times the coefficients of the Legendre functions.
#[inline(always)]
#[expect(
    clippy::excessive_precision,
    reason = "rounded by the compiler, to be read by people"
)]
pub(super) fn low(&Vec3x8 { x, y, z }: &Vec3x8) -> Low {
    let constant = |c: f32| f32x8::splat(c);
    let z2 = z * z;
    let quadratic = |a: f32, b: f32| z2.mul_add(constant(a), constant(b));
    let (p00, p10) = (constant(0.282_094_791_8), z * 0.488_602_511_9);
    let p20 = quadratic(0.946_174_695_8, -0.315_391_565_3);
    let p30 = z * quadratic(1.865_881_662_9, -1.119_528_997_8);
    let p40 = z2.mul_add(
        quadratic(3.702_494_142_0, -3.173_566_407_5),
        constant(0.317_356_640_7),
    );
    let (p11, p21) = (constant(0.488_602_511_9), z * 1.092_548_430_6);
    let p31 = quadratic(2.285_228_997_3, -0.457_045_799_5);
    let p41 = z * quadratic(4.683_325_804_9, -2.007_139_630_7);
    let (p22, p32) = (constant(0.546_274_215_3), z * 1.445_305_721_3);
    let p42 = quadratic(3.311_611_435_2, -0.473_087_347_9);
    let (p33, p43) = (constant(0.590_043_589_9), z * 1.770_130_769_8);
    let p44 = constant(0.625_835_735_4);
    let (c1, s1) = (x, y);
    let (c2, s2) = turned((c1, s1), x, y);
    let (c3, s3) = turned((c2, s2), x, y);
    let (c4, s4) = turned((c3, s3), x, y);
    #[rustfmt::skip]
    let values = [
        p00,
        p11 * s1, p10, p11 * c1,
        p22 * s2, p21 * s1, p20, p21 * c1, p22 * c2,
        p33 * s3, p32 * s2, p31 * s1, p30, p31 * c1, p32 * c2, p33 * c3,
        p44 * s4, p43 * s3, p42 * s2, p41 * s1, p40, p41 * c1, p42 * c2, p43 * c3, p44 * c4,
    ];
    Low {
        values,
        last: [
            [p30, p40],
            [p31, p41],
            [p32, p42],
            [p33, p43],
            [f32x8::ZERO, p44],
        ],
        turns: [
            (f32x8::ONE, f32x8::ZERO),
            (c1, s1),
            (c2, s2),
            (c3, s3),
            (c4, s4),
        ],
    }
}
