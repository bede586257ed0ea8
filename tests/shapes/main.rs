//! The shape kernels against the textbook in double precision, lane by lane.
//!
//! The oracle brackets what rounding may do: each primitive is met for certain, missed for certain, or on the fence
//! (grazing, at an edge, at the origin), and its distance lies in an interval. A kernel's answer must be one that some
//! choice on the fence explains.

#[path = "../common/mod.rs"]
mod common;
mod rules;
mod seams;

use common::{Random, V, dot, lane, pack, unit};
use glam::Vec3;
use ondine::lanes::{Vec3x8, WIDTH, f32x8, u32x8};
use ondine::shape::{NO_PRIMITIVE, Quad, Shapes, Sphere};

const RAYS: usize = 100_000;

/// One rounding, relative.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

#[derive(Clone, Copy)]
enum Primitive {
    Ball { center: V, radius: f64 },
    Parallelogram { corner: V, u: V, v: V },
}
use Primitive::{Ball, Parallelogram};

/// Where a ray may meet a primitive, and whether it must.
#[derive(Clone, Copy)]
struct Meeting {
    low: f64,
    high: f64,
    certain: bool,
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn along(o: V, d: V, t: f64) -> V {
    [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
}

fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

impl Primitive {
    /// Possible meetings at t > 0, the textbook's with the kernel's rounding around it.
    fn meetings(&self, o: V, d: V) -> Vec<Meeting> {
        match *self {
            Ball { center, radius } => {
                // |o + t d − c|² = r², as a quadratic equation in t.
                let to_center = sub(center, o);
                let a = dot(d, d);
                let middle = dot(to_center, d) / a;
                let nearest = length(sub(along(o, d, middle), center));
                let discriminant = (radius - nearest) * (radius + nearest) / a;
                let size = length(to_center);
                let slack = 8.0
                    * ROUNDING
                    * (size * nearest + radius * radius + size * size * 8.0 * ROUNDING);
                let shift = 8.0 * ROUNDING * (size + radius);
                if discriminant < -slack {
                    return Vec::new();
                }
                let half_low = (discriminant - slack).max(0.0).sqrt();
                let half_high = (discriminant + slack).sqrt();
                let sure = discriminant > slack;
                let near = (middle - half_high - shift, middle - half_low + shift);
                let far = (middle + half_low - shift, middle + half_high + shift);
                let meeting = |(low, high): (f64, f64), certain| Meeting { low, high, certain };
                if near.0 > 0.0 {
                    vec![meeting(near, sure)]
                } else if near.1 > 0.0 {
                    vec![meeting(near, false), meeting(far, false)]
                } else if far.1 > 0.0 {
                    vec![meeting(far, sure && far.0 > 0.0)]
                } else {
                    Vec::new()
                }
            }
            Parallelogram { corner, u, v } => {
                let n = cross(u, v);
                let cosine = dot(unit(n), d);
                let size = length(o) + length(corner) + length(u) + length(v);
                let slack_cosine = 4.0 * ROUNDING;
                if cosine.abs() < 64.0 * slack_cosine {
                    // All but parallel: anything from a miss to a meeting anywhere.
                    return vec![Meeting {
                        low: 0.0,
                        high: f64::INFINITY,
                        certain: false,
                    }];
                }
                let t = dot(sub(corner, o), unit(n)) / cosine;
                let shift = (4.0 * ROUNDING * size + t.abs() * slack_cosine) / cosine.abs();
                let p = sub(along(o, d, t), corner);
                let place = [dot(cross(p, v), n), dot(cross(u, p), n)].map(|w| w / dot(n, n));
                let moved = shift + 4.0 * ROUNDING * (size + t.abs());
                let slack =
                    [length(v), length(u)].map(|edge| moved * edge / length(n) + 16.0 * ROUNDING);
                let outside = |i: usize| place[i] < -slack[i] || place[i] > 1.0 + slack[i];
                let inside = |i: usize| place[i] > slack[i] && place[i] < 1.0 - slack[i];
                if t + shift <= 0.0 || outside(0) || outside(1) {
                    return Vec::new();
                }
                vec![Meeting {
                    low: t - shift,
                    high: t + shift,
                    certain: inside(0) && inside(1) && t - shift > 0.0,
                }]
            }
        }
    }
}

fn kernel(primitives: &[Primitive]) -> Shapes {
    let vec = |v: V| Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32);
    let mut shapes = Shapes::default();
    for (id, primitive) in primitives.iter().enumerate() {
        match *primitive {
            Ball { center, radius } => {
                shapes.add_sphere(Sphere::new(vec(center), radius as f32), id as u32)
            }
            Parallelogram { corner, u, v } => {
                shapes.add_quad(Quad::new(vec(corner), vec(u), vec(v)), id as u32)
            }
        }
    }
    shapes
}

/// Checks `closest` and `occluded` on eight rays; returns how many of them were on the fence.
fn check(
    primitives: &[Primitive],
    shapes: &Shapes,
    o: Vec3x8,
    d: Vec3x8,
    random: &mut Random,
) -> usize {
    let (distance, id) = shapes.closest(o, d);
    let reach = f32x8::new(std::array::from_fn(|_| random.one() * 12.0));
    let target = u32x8::new(std::array::from_fn(|_| (random.one() * 8.0) as u32));
    let occluded = shapes.occluded(o, d, reach, target).to_bitmask();
    let mut fence = 0;
    for i in 0..WIDTH {
        let (origin, direction) = (lane(&o, i), lane(&d, i));
        let (t, id) = (f64::from(distance.as_array()[i]), id.as_array()[i]);
        let met: Vec<(u32, Meeting)> = (0..)
            .zip(primitives)
            .flat_map(|(id, p)| {
                p.meetings(origin, direction)
                    .into_iter()
                    .map(move |m| (id, m))
            })
            .collect();
        fence += usize::from(met.iter().any(|(_, m)| !m.certain));

        let explained = if id == NO_PRIMITIVE {
            t == f64::INFINITY
        } else {
            met.iter()
                .any(|(other, m)| *other == id && m.low <= t && t <= m.high)
        };
        assert!(
            explained,
            "from {origin:?} along {direction:?}: {id} at {t}"
        );
        let nearer = met
            .iter()
            .find(|(other, m)| *other != id && m.certain && m.high < t);
        assert!(
            nearer.is_none(),
            "from {origin:?} along {direction:?}: not {id} at {t}"
        );

        let (reach, target) = (f64::from(reach.as_array()[i]), target.as_array()[i]);
        let others = || {
            met.iter()
                .filter(|(other, _)| *other != target)
                .map(|(_, m)| m)
        };
        if occluded >> i & 1 == 1 {
            assert!(
                others().any(|m| m.low < reach),
                "{origin:?} {direction:?} {reach}: nothing between"
            );
        } else {
            assert!(
                !others().any(|m| m.certain && m.high < reach),
                "{origin:?} {direction:?} {reach}: occluded"
            );
        }
    }
    fence
}

fn direction(random: &mut Random) -> V {
    loop {
        let v: V = std::array::from_fn(|_| f64::from(random.one()) * 2.0 - 1.0);
        let square = dot(v, v);
        if (1e-4..=1.0).contains(&square) {
            return unit(v);
        }
    }
}

fn point(random: &mut Random, size: f64) -> V {
    std::array::from_fn(|_| (f64::from(random.one()) * 2.0 - 1.0) * size)
}

/// What the kernels are told, exactly: the oracle starts from the same single-precision numbers.
fn single(v: V) -> V {
    v.map(|c| f64::from(c as f32))
}

/// Spheres large, small, tiny and far, one inside another; quads leaning and upright.
fn world(random: &mut Random) -> Vec<Primitive> {
    let mut all: Vec<Primitive> = [
        ([0.0, 0.0, 0.0], 1.0),
        ([0.1, 0.0, 0.0], 0.5),
        ([2.0, 0.5, -1.0], 0.02),
        ([-1.5, 2.0, 1.0], 0.3),
        ([400.0, 30.0, -100.0], 5.0),
        ([0.0, -1003.0, 0.0], 1000.0),
    ]
    .map(|(center, radius)| Ball {
        center: single(center),
        radius: f64::from(radius as f32),
    })
    .into();
    all.push(Parallelogram {
        corner: [-3.0, -2.0, -3.0],
        u: [6.0, 0.0, 0.0],
        v: [0.0, 4.0, 0.0],
    });
    for _ in 0..3 {
        let corner = single(point(random, 3.0));
        let (u, v) = (single(point(random, 2.0)), single(point(random, 2.0)));
        all.push(Parallelogram { corner, u, v });
    }
    all
}

#[test]
fn random_rays_meet_what_the_textbook_says() {
    let mut random = Random::new(100);
    let primitives = world(&mut random);
    let shapes = kernel(&primitives);
    let mut fence = 0;
    for _ in 0..RAYS / WIDTH {
        let o = pack(std::array::from_fn(|_| point(&mut random, 4.0)));
        let d = pack(std::array::from_fn(|_| direction(&mut random)));
        fence += check(&primitives, &shapes, o, d, &mut random);
    }
    assert!(fence < RAYS / 100, "{fence} rays say nothing");
}

#[test]
fn rays_from_inside_spheres_meet_the_far_side() {
    let mut random = Random::new(101);
    for (center, radius) in [
        ([0.0; 3], 1.0),
        ([10.0, -3.0, 5.0], 0.01),
        ([2.0, 1.0, 0.0], 300.0),
    ] {
        let ball = Ball {
            center: single(center),
            radius: f64::from(radius as f32),
        };
        let shapes = kernel(&[ball]);
        let mut fence = 0;
        for _ in 0..RAYS / WIDTH {
            let o = pack(std::array::from_fn(|_| {
                along(
                    center,
                    direction(&mut random),
                    0.99 * radius * f64::from(random.one()),
                )
            }));
            let d = pack(std::array::from_fn(|_| direction(&mut random)));
            let (_, id) = shapes.closest(o, d);
            assert_eq!(id.to_array(), [0; 8]);
            fence += check(&[ball], &shapes, o, d, &mut random);
        }
        assert!(fence < RAYS / 50, "{fence} rays say nothing");
    }
}

#[test]
fn rays_aimed_near_the_rim_of_near_tiny_and_far_spheres_meet_them_or_not_as_the_textbook_says() {
    let mut random = Random::new(102);
    for (distance, radius) in [
        (3.0, 1.0),
        (1.001, 1.0),
        (10.0, 1e-3),
        (3e3, 2.0),
        (50.0, 49.0),
    ] {
        let mut fence = 0;
        for _ in 0..RAYS / 5 / WIDTH {
            let center = single(point(&mut random, 1.0));
            let ball = Ball {
                center,
                radius: f64::from(radius as f32),
            };
            let from = direction(&mut random);
            let start = along(center, from, distance);
            // Pass the centre at 0.9 to 1.1 radii.
            let d = pack(std::array::from_fn(|_| {
                let side = unit(cross(from, direction(&mut random)));
                let sine = (radius / distance * (0.9 + 0.2 * f64::from(random.one()))).min(1.0);
                let cosine = (1.0 - sine * sine).sqrt();
                std::array::from_fn(|c| sine * side[c] - cosine * from[c])
            }));
            fence += check(&[ball], &kernel(&[ball]), pack([start; 8]), d, &mut random);
        }
        assert!(
            fence < RAYS / 5 / 20,
            "{fence} rays say nothing at {distance}, {radius}"
        );
    }
}

#[test]
fn rays_all_but_parallel_to_a_quad_meet_it_where_the_textbook_says() {
    let mut random = Random::new(103);
    let quads = [
        Parallelogram {
            corner: [-2.0, 0.5, -2.0],
            u: [4.0, 0.0, 0.0],
            v: [0.0, 0.0, 4.0],
        },
        Parallelogram {
            corner: [-2.0, -0.25, -2.0],
            u: [4.0, 0.25, 0.0],
            v: [0.0, 0.5, 4.0],
        },
    ];
    let shapes = kernel(&quads);
    for _ in 0..RAYS / WIDTH {
        let o = pack(std::array::from_fn(|_| point(&mut random, 3.0)));
        let d = pack(std::array::from_fn(|_| {
            let mut d = direction(&mut random);
            d[1] *= 10f64.powf(-6.0 * f64::from(random.one()));
            unit(d)
        }));
        check(&quads, &shapes, o, d, &mut random);
    }
}
