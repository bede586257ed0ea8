//! The functions that everything else is made of.

use super::page::{Case, Section, Topic};
use super::{one, unit, vector, wide};
use crate::lanes::{FrameX8, Vec3x8, f32x8, pow_one_minus, sin_cos_eighth, sin_cos_turns};
use crate::sampling::mis;
use glam::Vec3;

pub(super) fn topic() -> Topic {
    Topic {
        name: "functions",
        about: "Elementary functions, frames and the power heuristic: specification, sections 2 and 3.",
        sections: vec![
            of_one(
                "exp",
                "e^x.",
                &[0.0, 1.0, -1.0, 0.5, -0.125, 10.0, -20.0, -87.0, 88.0, -4.5],
                f32x8::exp,
            ),
            of_one(
                "ln_1p",
                "ln(1 + x).",
                &[
                    0.0,
                    -0.5,
                    0.5,
                    -0.25,
                    1e-8,
                    -1e-6,
                    -0.999_999_9,
                    1.0,
                    -0.875,
                    3.0,
                ],
                f32x8::ln_1p,
            ),
            of_one(
                "exp_m1",
                "e^x - 1.",
                &[0.0, -1e-6, -0.125, -0.25, -1.0, -10.0, -20.0, 0.25, -0.5],
                f32x8::exp_m1,
            ),
            of_two(
                "atan2",
                "The angle of (x, y), radians.",
                ["y", "x"],
                &[
                    [0.0, 1.0],
                    [1.0, 0.0],
                    [0.0, -1.0],
                    [-1.0, 0.0],
                    [0.5, 0.5],
                    [-0.25, 0.75],
                    [0.75, -0.25],
                    [-0.125, -0.875],
                    [0.0, 0.0],
                ],
                |[y, x]| y.atan2(x),
            ),
            of_two(
                "pow_one_minus",
                "(1 - x)^y.",
                ["x", "y"],
                &[
                    [0.0, 5.0],
                    [0.5, 2.0],
                    [0.25, 32.0],
                    [1e-4, 10_000.0],
                    [1.0, 3.0],
                    [1.0, 0.0],
                    [1.5, 2.0],
                    [0.875, 50.0],
                ],
                |[x, y]| pow_one_minus(x, y),
            ),
            sines(
                "sin_cos_turns",
                "Sine and cosine of 2 pi x.",
                &[
                    0.0,
                    0.125,
                    0.25,
                    0.375,
                    0.5,
                    0.625,
                    0.75,
                    0.9375,
                    0.1,
                    0.3,
                    0.7,
                    0.999_999_9,
                ],
                sin_cos_turns,
            ),
            sines(
                "sin_cos_eighth",
                "Sine and cosine of x radians, |x| at most pi/4.",
                &[0.0, 0.25, -0.25, 0.5, -0.75, 0.78125, 1e-4],
                sin_cos_eighth,
            ),
            of_one(
                "power_heuristic",
                "Weight of a sample; x is the density of the other strategy over that of its own.",
                &[0.0, 1.0, 0.5, 2.0, 1e-10, 1e10, 1e30, f32::INFINITY],
                mis::power_heuristic,
            ),
            frames(),
        ],
    }
}

fn of_one(
    name: &'static str,
    about: &'static str,
    arguments: &[f32],
    function: fn(f32x8) -> f32x8,
) -> Section {
    let case = |&x: &f32| {
        Case::new()
            .float("x", x)
            .float("value", one(function(wide(x))))
    };
    Section::new(name, about, arguments.iter().map(case).collect())
}

fn of_two(
    name: &'static str,
    about: &'static str,
    names: [&str; 2],
    arguments: &[[f32; 2]],
    function: fn([f32x8; 2]) -> f32x8,
) -> Section {
    let case = |x: &[f32; 2]| {
        Case::new()
            .float(names[0], x[0])
            .float(names[1], x[1])
            .float("value", one(function(x.map(wide))))
    };
    Section::new(name, about, arguments.iter().map(case).collect())
}

fn sines(
    name: &'static str,
    about: &'static str,
    arguments: &[f32],
    function: fn(f32x8) -> (f32x8, f32x8),
) -> Section {
    let case = |&x: &f32| {
        let (sin, cos) = function(wide(x));
        Case::new()
            .float("x", x)
            .float("sin", one(sin))
            .float("cos", one(cos))
    };
    Section::new(name, about, arguments.iter().map(case).collect())
}

fn frames() -> Section {
    let normals = [
        Vec3::Z,
        Vec3::NEG_Z,
        Vec3::X,
        Vec3::NEG_Y,
        unit(1.0, 2.0, 3.0),
        unit(1.0, -2.0, -3.0),
        unit(1e-3, 0.0, -1.0),
    ];
    let v = Vec3::new(0.25, -0.5, 0.75);
    let case = |n: Vec3| {
        let frame = FrameX8::new(Vec3x8::splat(n));
        Case::new()
            .floats("normal", &n.to_array())
            .floats("v", &v.to_array())
            .floats("to_world", &vector(frame.to_world(Vec3x8::splat(v))))
            .floats("to_local", &vector(frame.to_local(Vec3x8::splat(v))))
    };
    Section::new(
        "frame",
        "The frame around a unit normal: v from the local frame to the world, and from the world to the local frame.",
        normals.map(case).into(),
    )
}
