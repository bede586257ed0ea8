//! A port of the path tracer as a stranger would write it: one path at a time, in double precision, with other random
//! numbers; the built-in Cornell box by its numbers. It can be given the faults that ports have.

use ondine::compare::{Image, Layer};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

/// What is wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    None,
    /// Its longest paths have one edge less.
    DropsABounce,
    /// Light is weighted by the cosine of the direction that a path came from.
    WrongCosine,
    /// The density of light sampling is 1 % too high.
    PdfOff,
    /// No sample is brighter than 10.
    Clamps,
    /// What arrives on paths of three edges is 2 % too dark.
    DarkThirdEdge,
}

pub const PATH_LENGTH: usize = 5;

type V = [f64; 3];

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
fn scale(a: V, s: f64) -> V {
    a.map(|x| x * s)
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn unit(a: V) -> V {
    scale(a, 1.0 / dot(a, a).sqrt())
}

const LIGHT: (V, f64) = ([0.0, 0.7, 0.0], 0.15);
const RADIANCE: V = [20.0, 18.0, 15.0];
const WHITE: V = [0.73; 3];
const SPHERES: [(V, f64, V); 2] = [
    ([-0.42, -0.65, -0.35], 0.35, WHITE),
    ([0.42, -0.7, 0.25], 0.3, [0.3, 0.4, 0.73]),
];
/// Least and greatest corner of the room.
const ROOM: [V; 2] = [[-1.0, -1.0, -1.0], [1.0, 1.0, 3.0]];

enum Met {
    Light,
    Surface { point: V, normal: V, albedo: V },
}

fn sphere(origin: V, direction: V, (centre, radius): (V, f64)) -> Option<f64> {
    let to = add(centre, scale(origin, -1.0));
    let along = dot(to, direction);
    let inside = along * along - dot(to, to) + radius * radius;
    if inside < 0.0 {
        return None;
    }
    [along - inside.sqrt(), along + inside.sqrt()]
        .into_iter()
        .find(|&t| t > 1e-6)
}

fn meet(origin: V, direction: V) -> Met {
    let (mut nearest, mut axis, mut high) = (f64::INFINITY, 0, 0);
    for k in 0..3 {
        let side = usize::from(direction[k] > 0.0);
        let t = (ROOM[side][k] - origin[k]) / direction[k];
        if direction[k] != 0.0 && t < nearest {
            (nearest, axis, high) = (t, k, side);
        }
    }
    let mut normal = [0.0; 3];
    normal[axis] = if high == 1 { -1.0 } else { 1.0 };
    let mut albedo = match (axis, high) {
        (0, 0) => [0.65, 0.05, 0.05],
        (0, _) => [0.12, 0.45, 0.15],
        _ => WHITE,
    };
    for (centre, radius, colour) in SPHERES {
        if let Some(t) = sphere(origin, direction, (centre, radius))
            && t < nearest
        {
            nearest = t;
            albedo = colour;
            let point = add(origin, scale(direction, t));
            normal = unit(add(point, scale(centre, -1.0)));
        }
    }
    if sphere(origin, direction, LIGHT).is_some_and(|t| t < nearest) {
        return Met::Light;
    }
    let point = add(origin, scale(direction, nearest));
    Met::Surface {
        point: add(point, scale(normal, 1e-9)),
        normal,
        albedo,
    }
}

/// Around an axis: the vector of a cosine and an azimuth.
fn around(axis: V, cos: f64, azimuth: f64) -> V {
    let helper = if axis[0].abs() < 0.5 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let x = unit(add(helper, scale(axis, -dot(helper, axis))));
    let y = [
        axis[1] * x[2] - axis[2] * x[1],
        axis[2] * x[0] - axis[0] * x[2],
        axis[0] * x[1] - axis[1] * x[0],
    ];
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    add(
        scale(axis, cos),
        add(scale(x, sin * azimuth.cos()), scale(y, sin * azimuth.sin())),
    )
}

/// One less the cosine of the cone under which the light is seen.
fn cone(point: V) -> f64 {
    let to = add(LIGHT.0, scale(point, -1.0));
    let sin2 = LIGHT.1 * LIGHT.1 / dot(to, to);
    1.0 - (1.0 - sin2).max(0.0).sqrt()
}

/// Radiance of one path by its number of edges.
fn trace(random: &mut Pcg64Mcg, mut direction: V, fault: Fault) -> [V; PATH_LENGTH] {
    let mut one = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let mut origin = [0.0, 0.0, 2.95];
    let mut found = [[0.0; 3]; PATH_LENGTH];
    let mut throughput = [1.0; 3];
    let mut pdf = f64::INFINITY;
    let length = PATH_LENGTH - usize::from(fault == Fault::DropsABounce);
    let light_pdf = |point: V| {
        let true_one = 1.0 / (TAU * cone(point));
        if fault == Fault::PdfOff {
            1.01 * true_one
        } else {
            true_one
        }
    };
    let power = |a: f64, b: f64| {
        if a.is_infinite() {
            1.0
        } else {
            a * a / (a * a + b * b)
        }
    };
    for edge in 0..length {
        let (point, normal, albedo) = match meet(origin, direction) {
            Met::Light => {
                let weight = power(pdf, light_pdf(origin));
                (0..3).for_each(|c| found[edge][c] += throughput[c] * RADIANCE[c] * weight);
                break;
            }
            Met::Surface {
                point,
                normal,
                albedo,
            } => (point, normal, albedo),
        };
        if edge + 1 == length {
            break;
        }
        (0..3).for_each(|c| throughput[c] *= albedo[c]);
        let axis = unit(add(LIGHT.0, scale(point, -1.0)));
        let to_light = around(axis, 1.0 - one() * cone(point), TAU * one());
        let cos = dot(normal, to_light);
        if cos > 0.0 && matches!(meet(point, to_light), Met::Light) {
            let density = light_pdf(point);
            let weighted = match fault {
                Fault::WrongCosine => -dot(normal, direction),
                _ => cos,
            };
            let weight = power(density, cos / PI) * weighted / PI / density;
            (0..3).for_each(|c| found[edge + 1][c] += throughput[c] * RADIANCE[c] * weight);
        }
        let cos = one().sqrt();
        direction = around(normal, cos, TAU * one());
        pdf = cos / PI;
        origin = point;
    }
    if fault == Fault::DarkThirdEdge {
        found[2] = scale(found[2], 0.98);
    }
    if fault == Fault::Clamps {
        let sum = found.into_iter().fold([0.0; 3], add);
        for layer in &mut found {
            (0..3).for_each(|c| layer[c] *= if sum[c] > 10.0 { 10.0 / sum[c] } else { 1.0 });
        }
    }
    found
}

/// The Cornell box in `side` × `side` pixels, with its layers by path length; variances and counts too.
pub fn render(side: usize, spp: u32, seed: u64, fault: Fault) -> Image {
    // Sums and sums of squares, of the image and of each path length.
    type Pixel = [[V; 2]; PATH_LENGTH + 1];
    let pixels: Vec<Pixel> = (0..side * side)
        .into_par_iter()
        .map(|pixel| {
            let mut random = Pcg64Mcg::seed_from_u64(seed << 32 | pixel as u64);
            let mut sums = Pixel::default();
            for _ in 0..spp {
                let mut one = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
                let half = 25f64.to_radians().tan();
                let on = |place: usize, jitter: f64| {
                    ((place as f64 + jitter) / side as f64 * 2.0 - 1.0) * half
                };
                let direction = [on(pixel % side, one()), -on(pixel / side, one()), -1.0];
                let found = trace(&mut random, unit(direction), fault);
                let sum = found.into_iter().fold([0.0; 3], add);
                for (layer, value) in sums.iter_mut().zip([sum].into_iter().chain(found)) {
                    layer[0] = add(layer[0], value);
                    layer[1] = add(layer[1], value.map(|x| x * x));
                }
            }
            sums
        })
        .collect();
    let n = f64::from(spp);
    let layer = |k: usize| {
        let plane = |of: &dyn Fn([V; 2], usize) -> f64| {
            [0, 1, 2].map(|c| pixels.iter().map(|pixel| of(pixel[k], c) as f32).collect())
        };
        Layer {
            radiance: plane(&|[sum, _], c| sum[c] / n),
            variance: Some(plane(&|[sum, square], c| {
                ((square[c] - sum[c] * sum[c] / n) / (n - 1.0) / n).max(0.0)
            })),
        }
    };
    Image {
        path: PathBuf::from("port"),
        width: side,
        height: side,
        image: layer(0),
        lengths: (1..=PATH_LENGTH).map(|k| (k as u32, layer(k))).collect(),
        samples: Some(vec![spp as f32; side * side]),
        ..Image::default()
    }
}
