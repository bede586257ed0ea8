//! Warps of the unit square, with their densities.

use super::page::{Case, Section, Topic};
use super::{PAIRS, one, pair, vector, wide};
use crate::lanes::{Vec3x8, f32x8};
use crate::sampling::warp::{self, Pair};

pub(super) fn topic() -> Topic {
    Topic {
        name: "warps",
        about: "From the unit square (u) to points and unit directions, with densities per steradian, or per unit of area: \
                specification, section 5.",
        sections: vec![
            directions(
                "uniform_sphere",
                "Directions over the sphere.",
                warp::uniform_sphere,
                |_| warp::UNIFORM_SPHERE_PDF,
            ),
            directions(
                "uniform_hemisphere",
                "Directions over the hemisphere of z >= 0.",
                warp::uniform_hemisphere,
                |_| warp::UNIFORM_HEMISPHERE_PDF,
            ),
            directions(
                "cosine_hemisphere",
                "Directions over the hemisphere of z >= 0, by z; the density is z times the float nearest to 1/pi.",
                warp::cosine_hemisphere,
                |d| one(d.z * std::f32::consts::FRAC_1_PI),
            ),
            cosine_powers(),
            cones(),
            disks(),
            points(
                "uniform_triangle",
                "Barycentric coordinates of the second and third corner.",
                warp::uniform_triangle,
                |_| 2.0,
            ),
            points(
                "gaussian",
                "Offsets in pixels, normally distributed with a deviation of 0.5, up to 1.5.",
                warp::gaussian_truncated,
                |(x, y)| one(warp::gaussian_truncated_pdf(x, y)),
            ),
            tents(),
        ],
    }
}

fn directions(
    name: &'static str,
    about: &'static str,
    warp: fn(Pair) -> Vec3x8,
    pdf: fn(Vec3x8) -> f32,
) -> Section {
    let case = |u| {
        let direction = warp(pair(u));
        Case::new()
            .floats("u", &u)
            .floats("direction", &vector(direction))
            .float("pdf", pdf(direction))
    };
    Section::new(name, about, PAIRS.map(case).into())
}

fn points(
    name: &'static str,
    about: &'static str,
    warp: fn(Pair) -> (f32x8, f32x8),
    pdf: fn(Pair) -> f32,
) -> Section {
    let case = |u| {
        let point = warp(pair(u));
        Case::new()
            .floats("u", &u)
            .floats("point", &[one(point.0), one(point.1)])
            .float("pdf", pdf(point))
    };
    Section::new(name, about, PAIRS.map(case).into())
}

fn disks() -> Section {
    let case = |u| {
        let ((x, y), r2) = warp::uniform_disk(pair(u));
        Case::new()
            .floats("u", &u)
            .floats("point", &[one(x), one(y)])
            .float("squared_radius", one(r2))
    };
    Section::new(
        "uniform_disk",
        "Points of the unit disk, and their squared radius.",
        PAIRS.map(case).into(),
    )
}

fn cosine_powers() -> Section {
    let case = |(n, u)| {
        let direction = warp::cosine_power(pair(u), wide(n));
        Case::new()
            .float("n", n)
            .floats("u", &u)
            .floats("direction", &vector(direction))
            .float("pdf", one(warp::cosine_power_pdf(direction, wide(n))))
    };
    let cases = [0.0, 1.0, 32.0, 10_000.0].map(|n| PAIRS.map(|u| (n, u)));
    Section::new(
        "cosine_power",
        "Directions over the hemisphere of z >= 0, by z^n.",
        cases.into_iter().flatten().map(case).collect(),
    )
}

fn cones() -> Section {
    let case = |(spread, u)| {
        let direction = warp::cone(pair(u), wide(spread));
        Case::new()
            .float("spread", spread)
            .floats("u", &u)
            .floats("direction", &vector(direction))
            .float("pdf", one(warp::cone_pdf(wide(spread))))
    };
    let cases = [1e-8, 0.0625, 0.5].map(|spread| PAIRS.map(|u| (spread, u)));
    Section::new(
        "cone",
        "Directions of a cone around +z; spread is 1 - the cosine of its half-angle.",
        cases.into_iter().flatten().map(case).collect(),
    )
}

fn tents() -> Section {
    let case = |u| {
        let x = warp::tent(wide(u));
        Case::new()
            .float("u", u)
            .float("x", one(x))
            .float("pdf", one(warp::tent_pdf(x)))
    };
    Section::new(
        "tent",
        "Offsets in [-1, 1] pixels, by 1 - |x|.",
        [
            0.0,
            0.125,
            0.25,
            0.375,
            0.5,
            0.625,
            0.75,
            0.875,
            super::BELOW_ONE,
        ]
        .map(case)
        .into(),
    )
}
