//! The wide scalar functions and frames against the textbook in double precision.

mod common;

use common::*;
use glam::Vec3;
use ondine::lanes::*;
use std::f64::consts::TAU;

#[test]
fn sines_and_cosines_are_within_their_bound() {
    for step in 0..=125_000 {
        let u = f32x8::new(std::array::from_fn(|i| (8 * step + i) as f32 / 1_000_007.0));
        let (sin, cos) = sin_cos_turns(u);
        for i in 0..WIDTH {
            let angle = TAU * f64::from(u.to_array()[i]);
            assert_close(
                f64::from(sin.to_array()[i]),
                angle.sin(),
                0.0,
                2.4e-7,
                "sin",
            );
            assert_close(
                f64::from(cos.to_array()[i]),
                angle.cos(),
                0.0,
                2.4e-7,
                "cos",
            );
        }
    }
    let (sin, cos) = sin_cos_turns(f32x8::new([0.0, 0.25, 0.5, 0.75, 1.0, 0.125, 0.875, 0.0]));
    assert_eq!(sin.to_array()[..5], [0.0, 1.0, 0.0, -1.0, 0.0]);
    assert_eq!(cos.to_array()[..5], [1.0, 0.0, -1.0, 0.0, 1.0]);
}

/// The relative error that the rounding of a logarithm of this size allows.
fn power_error(power: f64) -> f64 {
    1e-6 + power.ln().abs() * 2.5e-7
}

#[test]
fn powers_are_within_their_bound() {
    let mut random = Random::new(20);
    for exponent in [0.0f32, 0.5, 1.0, 5.0, 50.0, 500.0, 1e4] {
        for _ in 0..20_000 {
            let x = random.eight();
            // Where x^y is between 1 and 1e-37, on a scale even in log x.
            let small = (x * (85.0 / exponent.max(1.0))).fast_min(f32x8::ONE) * random.eight();
            let y = f32x8::splat(exponent);
            let complement = pow_one_minus(small, y);
            for i in 0..WIDTH {
                let n = f64::from(exponent);
                let want = (n * (-f64::from(small.to_array()[i])).ln_1p()).exp();
                if want > 1e-37 && small.to_array()[i] < 0.999_999 {
                    let got = f64::from(complement.to_array()[i]);
                    assert_close(got, want, power_error(want), 0.0, "(1 - x)^y");
                }
            }
        }
    }
}

#[test]
fn powers_of_zero_and_one_are_exact() {
    let x = f32x8::new([0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.5, 1e-30]);
    let y = f32x8::new([0.0, 3.0, 0.0, 1e4, 1e4, 1.0, 1e4, 1e4]);
    let want = [1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    assert_eq!(pow_one_minus(f32x8::ONE - x, y).to_array()[..6], want);
    for lane in 6..8 {
        assert!(pow_one_minus(f32x8::ONE - x, y).to_array()[lane] < 1e-37);
    }
    // Beyond the lobe: the cosine would be negative.
    assert_eq!(
        pow_one_minus(f32x8::splat(1.7), f32x8::ONE).to_array(),
        [0.0; 8]
    );
}

fn assert_frame(normals: Vec3x8) {
    let frame = FrameX8::new(normals);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| frame.to_world(Vec3x8::splat(axis)));
    for i in 0..WIDTH {
        let [t, b, n] = axes.map(|axis| lane(&axis, i));
        for (v, w, want) in [
            (t, t, 1.0),
            (b, b, 1.0),
            (n, n, 1.0),
            (t, b, 0.0),
            (t, n, 0.0),
            (b, n, 0.0),
        ] {
            assert_close(dot(v, w), want, 0.0, 1e-6, "frame");
        }
        let cross = [
            t[1] * b[2] - t[2] * b[1],
            t[2] * b[0] - t[0] * b[2],
            t[0] * b[1] - t[1] * b[0],
        ];
        assert_close(dot(cross, n), 1.0, 0.0, 1e-6, "handedness");
        for (got, want) in n.into_iter().zip(lane(&normals, i)) {
            assert_close(got, want, 0.0, 1e-7, "normal");
        }
        let back = lane(&frame.to_local(axes[0]), i);
        assert_close(dot(back, [1.0, 0.0, 0.0]), 1.0, 0.0, 1e-6, "round trip");
    }
}

#[test]
fn frames_are_orthonormal_at_the_poles_too() {
    let mut random = Random::new(21);
    for _ in 0..20_000 {
        let u = random.pair();
        assert_frame(ondine::sampling::warp::uniform_sphere(u));
        // Close around -z, where a frame without the sign's care breaks.
        let near = ondine::sampling::warp::cone(u, f32x8::splat(1e-9));
        assert_frame(-near);
    }
    assert_frame(Vec3x8::splat(Vec3::NEG_Z));
    assert_frame(Vec3x8::splat(Vec3::Z));
    assert_frame(Vec3x8::splat(Vec3::new(1.0, 0.0, -0.0)));
}
