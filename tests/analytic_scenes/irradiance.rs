//! A lambert plane under one light: radiance a/π · E, with E in closed form.

use crate::common::{V, dot, unit};
use crate::render::*;
use std::f64::consts::{PI, TAU};

const ALBEDO: f64 = 0.6;
const RADIANCE: [f64; 3] = [4.0, 2.0, 1.0];

/// A tiny patch around the origin of the plane y = 0, seen from far above, under one light.
fn check(light: &str, irradiance: f64, spp: [u32; 4], what: &str) {
    let description = scene(&format!(
        "[camera]\nposition = [-3.0, 4.0, -2.0]\nlook_at = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvertical_fov = 0.02\n\
         [materials.plane]\ntype = \"lambert\"\nalbedo = [{ALBEDO}, {ALBEDO}, {ALBEDO}]\n\
         [[objects]]\nquad = {{ corner = [-50.0, 0.0, 50.0], u = [100.0, 0.0, 0.0], v = [0.0, 0.0, -100.0] }}\nmaterial = \"plane\"\n\
         [[lights]]\n{light}\nradiance = {RADIANCE:?}\n"
    ));
    for (strategy, spp) in STRATEGIES.into_iter().zip(spp) {
        let mut settings = settings(&description, (16, 16), spp);
        (settings.strategy, settings.path_length) = (strategy, 2);
        let want = RADIANCE.map(|l| ALBEDO / PI * irradiance * l);
        assert_mean(
            &film(&description, &settings),
            want,
            1e-2,
            &format!("{what}, {strategy}"),
        );
    }
}

fn sphere(center: V, radius: f64) -> String {
    format!("sphere = {{ center = {center:?}, radius = {radius:?} }}")
}

#[test]
fn a_sphere_wholly_above_the_horizon_gives_pi_times_the_square_of_its_sine_times_cosine() {
    for (center, radius) in [
        ([1.0, 2.0, 0.5], 0.7),
        ([3.0, 1.0, 1.0], 0.9),
        ([0.5, 1.0, 0.4], 0.99),
    ] {
        let square = dot(center, center);
        let cosine = center[1] / square.sqrt();
        let irradiance = PI * radius * radius / square * cosine;
        check(
            &sphere(center, radius),
            irradiance,
            [8192, 8192, 1024, 1024],
            &format!("{center:?}"),
        );
    }
}

/// ∫ max(cos, 0) dω over the cone around a direction, midpoints.
fn above_horizon(axis: V, one_minus_cos: f64) -> f64 {
    const STEPS: usize = 2000;
    let side = unit([axis[1], -axis[0], 0.0]);
    let (mut sum, sine_to_up) = (0.0, (1.0 - axis[1] * axis[1]).sqrt());
    assert!(side[2] == 0.0 || sine_to_up > 0.0);
    for i in 0..STEPS {
        let h = (i as f64 + 0.5) / STEPS as f64 * one_minus_cos;
        let (cos, sin) = (1.0 - h, (h * (2.0 - h)).sqrt());
        for j in 0..STEPS {
            let phi = (j as f64 + 0.5) / STEPS as f64 * TAU;
            sum += (cos * axis[1] + sin * phi.cos() * sine_to_up).max(0.0);
        }
    }
    sum * one_minus_cos * TAU / (STEPS * STEPS) as f64
}

#[test]
fn a_sphere_partly_below_the_horizon_gives_the_integral_over_what_is_above() {
    for (center, radius) in [
        ([2.0, 0.3, 0.0], 1.0),
        ([1.5, -0.4, 0.3], 0.9),
        ([2.0, 0.0, 1.0], 0.5),
    ] {
        let distance = dot(center, center).sqrt();
        let sine = radius / distance;
        let irradiance = above_horizon(unit(center), 1.0 - (1.0 - sine * sine).sqrt());
        check(
            &sphere(center, radius),
            irradiance,
            [65536, 65536, 4096, 4096],
            &format!("{center:?}"),
        );
    }
}

/// E / L of a polygon above the horizon, counter-clockwise or not: Σ γᵢ (n · Γᵢ) / 2 (Lambert 1760).
fn polygon(corners: &[V]) -> f64 {
    let mut sum = 0.0;
    for (i, a) in corners.iter().enumerate() {
        let (a, b) = (unit(*a), unit(corners[(i + 1) % corners.len()]));
        let cross = [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ];
        let sine = dot(cross, cross).sqrt();
        sum += sine.atan2(dot(a, b)) * cross[1] / sine;
    }
    0.5 * sum.abs()
}

#[test]
fn a_quad_gives_what_lamberts_polygon_formula_says() {
    for (corner, u, v) in [
        ([-0.5, 1.5, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([1.0, 0.2, -1.0], [0.0, 0.0, 2.0], [0.3, 1.4, 0.0]),
        ([0.5, 0.8, 0.4], [0.9, 0.3, 0.2], [-0.3, 0.2, 1.1]),
        ([-2.0, 0.1, 0.2], [0.0, 1.5, 0.4], [4.0, 0.0, 0.0]),
    ] {
        let add = |a: V, b: V| -> V { std::array::from_fn(|c| a[c] + b[c]) };
        let corners = [
            corner,
            add(corner, u),
            add(add(corner, u), v),
            add(corner, v),
        ];
        let light =
            format!("two_sided = true\nquad = {{ corner = {corner:?}, u = {u:?}, v = {v:?} }}");
        check(
            &light,
            polygon(&corners),
            [16384, 16384, 4096, 4096],
            &format!("{corner:?}"),
        );
    }
}
