//! Light sampling: points that lie on their lights, densities that agree with what hits report, chances by power.

mod choice;
#[path = "../common/mod.rs"]
mod common;

use common::*;
use glam::Vec3;
use ondine::lanes::{Rgb, Vec3x8, WIDTH, f32x8, u32x8};
use ondine::scene::builtin;
use ondine::scene::description::{Environment, Light, Shape};
use ondine::scene::environment::Sky;
use ondine::scene::light::{LightSampleX8, Lights};
use ondine::shape::{NO_PRIMITIVE, Quad, Shapes, Sphere};
use std::f64::consts::{PI, TAU};

/// Primitive ids of the lights here: their places and this.
const FIRST_ID: u32 = 40;

/// Samples of a sweep.
const MANY: usize = 200_000;

fn sphere(center: V, radius: f64, two_sided: bool) -> Light {
    let center = Vec3::from_array(center.map(|c| c as f32));
    Light {
        shape: Shape::Sphere {
            center,
            radius: radius as f32,
        },
        radiance: Rgb::new(3.0, 2.0, 1.0),
        two_sided,
        material: None,
        texture: None,
    }
}

fn quad(corner: V, u: V, v: V, two_sided: bool) -> Light {
    let [corner, u, v] = [corner, u, v].map(|w| Vec3::from_array(w.map(|c| c as f32)));
    Light {
        shape: Shape::Quad { corner, u, v },
        radiance: Rgb::new(0.5, 4.0, 2.0),
        two_sided,
        material: None,
        texture: None,
    }
}

struct World {
    lights: Lights,
    shapes: Shapes,
    sky: Option<Sky>,
}

impl World {
    fn new(lights: &[Light], sky: Option<Environment>) -> Self {
        let mut shapes = Shapes::default();
        let with_ids: Vec<(Light, u32)> = lights.iter().copied().zip(FIRST_ID..).collect();
        for &(light, id) in &with_ids {
            match light.shape {
                Shape::Mesh { .. } => unreachable!("no mesh here"),
                Shape::Sphere { center, radius } => {
                    shapes.add_sphere(Sphere::new(center, radius), id)
                }
                Shape::Quad { corner, u, v } => shapes.add_quad(Quad::new(corner, u, v), id),
            }
        }
        let sky = sky.map(|sky| Sky::compile(&sky));
        let mut description = builtin::find("furnace")
            .expect("there")
            .load()
            .expect("valid");
        description.lights = lights.to_vec();
        let ids: Vec<u32> = with_ids.iter().map(|(_, id)| *id).collect();
        Self {
            lights: Lights::new(&description, &ids, sky.as_ref(), 2.0),
            shapes,
            sky,
        }
    }

    fn sample(&self, from: Vec3x8, random: &mut Random) -> LightSampleX8 {
        let choice = random.eight();
        self.lights.sample(
            self.sky.as_ref(),
            from,
            || (choice, f32x8::ZERO),
            random.pair(),
        )
    }
}

/// Spheres as (distance of the centre, radius): near, far, tiny, almost touching, huge.
const SPHERES: [(f64, f64); 6] = [
    (2.0, 1.0),
    (300.0, 1.0),
    (1.0, 1e-4),
    (1.0005, 1.0),
    (1e3, 990.0),
    (4.0, 0.3),
];

const QUADS: [[V; 3]; 4] = [
    [[-0.5, -0.5, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[3.0, 2.0, -9.0], [0.3, 0.1, 0.0], [0.0, 0.2, -0.5]],
    [[-2.0, -3.0, -0.05], [4.0, 0.0, 0.0], [0.0, 6.0, 0.0]],
    [[100.0, -1.0, 70.0], [0.0, 0.0, -9.0], [0.0, 8.0, 0.0]],
];

fn toward(azimuth: f64, distance: f64) -> V {
    [azimuth.cos() * 0.8, 0.6, azimuth.sin() * 0.8].map(|c| f64::from((c * distance) as f32))
}

/// One-light worlds, as seen from the origin, each with a name.
fn lone_lights() -> Vec<(String, Light, World)> {
    let mut all = Vec::new();
    for (i, (distance, radius)) in SPHERES.into_iter().enumerate() {
        let light = sphere(toward(i as f64, distance), radius, false);
        all.push((format!("sphere {i}"), light, World::new(&[light], None)));
    }
    let around = sphere([0.3, -0.2, 0.5], 1.0, true);
    all.push(("around".into(), around, World::new(&[around], None)));
    for (i, [corner, u, v]) in QUADS.into_iter().enumerate() {
        let light = quad(corner, u, v, true);
        all.push((format!("quad {i}"), light, World::new(&[light], None)));
    }
    all
}

#[test]
fn sampled_points_lie_on_their_light_and_a_ray_that_hits_it_there_reports_the_same_radiance_and_pdf()
 {
    let mut random = Random::new(200);
    let from = Vec3x8::ZERO;
    for (name, light, world) in lone_lights() {
        let mut missed = 0;
        for _ in 0..MANY / WIDTH {
            let s = world.sample(from, &mut random);
            let (t, id) = world.shapes.closest(from, s.direction);
            let (emitted, pdf) = world
                .lights
                .emitted(u32x8::ZERO, from, s.direction, s.distance);
            for i in 0..WIDTH {
                let d = lane(&s.direction, i);
                assert_close(dot(d, d), 1.0, 0.0, 1e-6, "length");
                assert_eq!(s.primitive.as_array()[i], FIRST_ID);
                let (got, want) = (s.pdf().as_array()[i], pdf.as_array()[i]);
                assert!(got > 0.0 && got.is_finite(), "{name}: pdf {got}");
                // A density at a quad is in proportion to 1/cos: grazing, both round.
                assert_close(f64::from(got), f64::from(want), 2e-5, 0.0, &name);
                assert_eq!(emitted.lane(i), s.radiance.lane(i), "{name}");
                if id.as_array()[i] == NO_PRIMITIVE {
                    missed += 1;
                    continue;
                }
                let (got, want) = (s.distance.as_array()[i], t.as_array()[i]);
                let (relative, absolute) = match light.shape {
                    Shape::Mesh { .. } => unreachable!("no mesh here"),
                    Shape::Sphere { center, radius } => {
                        // Where the ray grazes the sphere, the distance hangs on the root of what is all but 0.
                        let off = (s.direction.lane(i) * want - center) / radius;
                        let cosine = f64::from(off.dot(s.direction.lane(i)).abs()).max(1e-3);
                        (2e-6, 1e-6 * f64::from(center.length()) / cosine)
                    }
                    Shape::Quad { .. } => (2e-5, 0.0),
                };
                assert_close(f64::from(got), f64::from(want), relative, absolute, &name);
            }
        }
        assert!(missed < MANY / 2000, "{name}: {missed} rays miss");
    }
}

#[test]
fn sphere_samples_are_on_the_sphere_to_single_precision() {
    let mut random = Random::new(201);
    for (distance, radius) in SPHERES {
        let center = toward(1.0, distance);
        let world = World::new(&[sphere(center, radius, false)], None);
        for _ in 0..MANY / WIDTH {
            let s = world.sample(Vec3x8::ZERO, &mut random);
            for i in 0..WIDTH {
                let t = f64::from(s.distance.as_array()[i]);
                let p = lane(&s.direction, i).map(|c| c * t);
                let off = [0, 1, 2].map(|c| p[c] - center[c]);
                let error = (dot(off, off).sqrt() - radius).abs();
                assert!(
                    error < 3e-6 * distance,
                    "{error} off the sphere at {distance}, {radius}"
                );
            }
        }
    }
}

/// χ² of `bins × bins` equal parts of the unit square.
fn square_p(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    const BINS: usize = 32;
    let mut observed = vec![0; BINS * BINS];
    let mut count = 0;
    for (x, y) in points {
        assert!(
            (-1e-3..1.001).contains(&x) && (-1e-3..1.001).contains(&y),
            "({x}, {y})"
        );
        let bin = |w: f64| ((w * BINS as f64) as usize).min(BINS - 1);
        observed[bin(y) * BINS + bin(x)] += 1;
        count += 1;
    }
    chi_square(
        &observed,
        &vec![f64::from(count) / (BINS * BINS) as f64; BINS * BINS],
    )
}

fn directions(world: &World, seed: u64) -> Vec<V> {
    let mut random = Random::new(seed);
    (0..MANY / WIDTH)
        .flat_map(|_| {
            let s = world.sample(Vec3x8::ZERO, &mut random);
            std::array::from_fn::<V, WIDTH, _>(|i| lane(&s.direction, i))
        })
        .collect()
}

fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `1 − cos` of the cone under which a sphere is seen.
fn spread(distance: f64, radius: f64) -> f64 {
    let sine = radius / distance;
    sine * sine / (1.0 + (1.0 - sine * sine).sqrt())
}

#[test]
fn directions_to_a_sphere_are_uniform_in_its_cone() {
    for (seed, (distance, radius)) in (210..).zip(SPHERES) {
        let center = toward(2.0, distance);
        let world = World::new(&[sphere(center, radius, false)], None);
        let axis = unit(center);
        let side = unit(cross(axis, [0.0, 0.0, 1.0]));
        let other = cross(axis, side);
        let widest = spread(dot(center, center).sqrt(), f64::from(radius as f32));
        let p = square_p(directions(&world, seed).into_iter().map(|d| {
            // 1 − cos by the sine: for a tiny sphere the cosine itself rounds to 1.
            let (x, y) = (dot(d, side), dot(d, other));
            let square = x * x + y * y;
            let cosine = dot(d, axis);
            let part = if cosine > 0.0 {
                square / (1.0 + cosine)
            } else {
                1.0 - cosine
            };
            (part / widest, libm::atan2(y, x) / TAU + 0.5)
        }));
        assert!(p > SIGNIFICANCE, "{distance}, {radius}: p = {p}");
    }
}

#[test]
fn inside_a_two_sided_sphere_directions_are_uniform_all_around() {
    let world = World::new(&[sphere([0.3, -0.2, 0.5], 1.0, true)], None);
    let p = square_p(
        directions(&world, 220)
            .into_iter()
            .map(|[x, y, z]| (0.5 * (z + 1.0), libm::atan2(y, x) / TAU + 0.5)),
    );
    assert!(p > SIGNIFICANCE, "p = {p}");
}

#[test]
fn points_of_a_quad_are_uniform_and_the_pdf_is_that_of_the_directions() {
    for (seed, [corner, u, v]) in (230..).zip(QUADS) {
        let world = World::new(&[quad(corner, u, v, true)], None);
        let n = cross(u, v);
        let area = dot(n, n).sqrt();
        let mut random = Random::new(seed);
        let mut points = Vec::new();
        for _ in 0..MANY / WIDTH {
            let s = world.sample(Vec3x8::ZERO, &mut random);
            for i in 0..WIDTH {
                let d = lane(&s.direction, i);
                let t = dot(corner, n) / dot(d, n);
                let p: V = std::array::from_fn(|c| t * d[c] - corner[c]);
                points.push((
                    dot(cross(p, v), n) / dot(n, n),
                    dot(cross(u, p), n) / dot(n, n),
                ));
                let want = t * t / (dot(d, n).abs() / area * area);
                // The direction has single precision, which counts the more the more it grazes.
                let grazing = dot(d, n).abs() / area;
                assert_close(
                    f64::from(s.pdf().as_array()[i]),
                    want,
                    2e-6 + 1e-6 / grazing,
                    0.0,
                    "pdf",
                );
            }
        }
        let p = square_p(points.into_iter());
        assert!(p > SIGNIFICANCE, "{corner:?}: p = {p}");
    }
}

/// Solid angle of a triangle (Van Oosterom & Strackee 1983).
fn triangle(a: V, b: V, c: V) -> f64 {
    let [a, b, c] = [a, b, c].map(unit);
    2.0 * dot(a, cross(b, c))
        .atan2(1.0 + dot(a, b) + dot(b, c) + dot(c, a))
        .abs()
}

#[test]
fn the_mean_of_one_over_pdf_is_the_solid_angle_of_the_light() {
    let mean_of_inverse = |world: &World, seed| {
        let mut random = Random::new(seed);
        mean(MANY / WIDTH, || {
            let s = world.sample(Vec3x8::ZERO, &mut random);
            ondine::lanes::Rgbx8::gray(s.inverse_pdf)
        })
    };
    for (distance, radius) in SPHERES {
        let center = toward(0.5, distance);
        let world = World::new(&[sphere(center, radius, false)], None);
        let (got, error) = mean_of_inverse(&world, 240);
        let want = TAU * spread(dot(center, center).sqrt(), f64::from(radius as f32));
        // Near a sphere that almost touches, the cone's width hangs on the small gap, which rounds.
        assert_close(got, want, 1e-4, 4.0 * error, "sphere");
    }
    let around = World::new(&[sphere([0.3, -0.2, 0.5], 1.0, true)], None);
    assert_close(
        mean_of_inverse(&around, 241).0,
        4.0 * PI,
        1e-5,
        0.0,
        "around",
    );
    for (seed, [corner, u, v]) in (242..).zip(QUADS) {
        let world = World::new(&[quad(corner, u, v, true)], None);
        let (got, error) = mean_of_inverse(&world, seed);
        let add = |a: V, b: V| -> V { std::array::from_fn(|c| a[c] + b[c]) };
        let far = add(add(corner, u), v);
        let want = triangle(corner, add(corner, u), far) + triangle(corner, far, add(corner, v));
        assert_close(got, want, 1e-5, 4.0 * error, "quad");
    }
}

#[test]
fn one_sided_lights_are_dark_from_behind_and_from_inside() {
    let mut random = Random::new(250);
    let [corner, u, v] = QUADS[0];
    for (light, lit) in [
        (sphere([0.3, -0.2, 0.5], 1.0, false), false),
        (sphere([0.3, -0.2, 0.5], 1.0, true), true),
        (quad(corner, u, v, false), true),
        (quad(corner, v, u, false), false),
        (quad(corner, v, u, true), true),
    ] {
        let world = World::new(&[light], None);
        for _ in 0..100 {
            let s = world.sample(Vec3x8::ZERO, &mut random);
            let (emitted, _) =
                world
                    .lights
                    .emitted(u32x8::ZERO, Vec3x8::ZERO, s.direction, s.distance);
            for i in 0..WIDTH {
                assert_eq!(s.pdf().as_array()[i] > 0.0, lit, "{light:?}");
                assert_eq!(emitted.lane(i) == light.radiance, lit, "{light:?}");
                assert_eq!(emitted.lane(i) == Rgb::BLACK, !lit, "{light:?}");
            }
        }
    }
}
