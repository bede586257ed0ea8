//! The shape kernels against the textbook in double precision, lane by lane.
//!
//! The oracle brackets what rounding may do: each primitive is met for certain, missed for certain, or on the fence
//! (grazing, at an edge, at the origin), and its distance lies in an interval. A kernel's answer must be one that some
//! choice on the fence explains.

mod common;

use common::{Random, V, dot, lane, pack, unit};
use glam::Vec3;
use ondine::lanes::{Vec3x8, WIDTH, f32x8, u32x8};
use ondine::scene::{Scene, builtin};
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

fn eight(v: [f32; 3]) -> Vec3x8 {
    Vec3x8::splat(Vec3::from_array(v))
}

#[test]
fn a_ray_parallel_to_a_quad_misses_it_in_its_plane_and_out_of_it() {
    let quad = Parallelogram {
        corner: [-1.0, 0.5, -1.0],
        u: [2.0, 0.0, 0.0],
        v: [0.0, 0.0, 2.0],
    };
    let shapes = kernel(&[quad]);
    for y in [0.5, 0.0, 0.6] {
        for d in [
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [0.6, 0.0, 0.8],
            [-0.6, -0.0, 0.8],
        ] {
            for x in [-3.0, 0.0, 0.9] {
                let (t, id) = shapes.closest(eight([x, y, 0.1]), eight(d));
                assert_eq!(
                    (t.to_array(), id.to_array()),
                    ([f32::INFINITY; 8], [NO_PRIMITIVE; 8])
                );
            }
        }
    }
}

#[test]
fn of_two_hits_at_the_same_distance_the_first_wins_and_quads_come_before_spheres() {
    let quad = Parallelogram {
        corner: [-1.0, -1.0, 0.0],
        u: [2.0, 0.0, 0.0],
        v: [0.0, 2.0, 0.0],
    };
    let ball = Ball {
        center: [0.0, 0.0, -1.0],
        radius: 1.0,
    };
    for (primitives, first) in [
        (vec![quad, quad, ball], 0),
        (vec![ball, ball], 0),
        (vec![ball, quad], 1),
        (vec![ball, ball, quad, quad], 2),
    ] {
        let (t, id) = kernel(&primitives).closest(eight([0.0, 0.0, 2.0]), eight([0.0, 0.0, -1.0]));
        assert_eq!((t.to_array(), id.to_array()), ([2.0; 8], [first; 8]));
    }
}

#[test]
fn the_target_of_a_shadow_ray_does_not_block_it_and_what_lies_before_it_does() {
    let ball = |z: f64| Ball {
        center: [0.0, 0.0, z],
        radius: 0.5,
    };
    let wall = Parallelogram {
        corner: [-1.0, -1.0, -4.0],
        u: [2.0, 0.0, 0.0],
        v: [0.0, 2.0, 0.0],
    };
    let shapes = kernel(&[ball(-1.0), wall]);
    let (o, d) = (eight([0.0; 3]), eight([0.0, 0.0, -1.0]));
    let blocked = |reach: f32, target: u32| {
        let bits = shapes
            .occluded(o, d, f32x8::splat(reach), u32x8::splat(target))
            .to_bitmask();
        assert!(bits == 0 || bits == 0xff);
        bits == 0xff
    };
    assert!(!blocked(0.5, 0) && !blocked(0.4, 1) && !blocked(0.5, NO_PRIMITIVE));
    assert!(blocked(0.6, NO_PRIMITIVE) && blocked(0.6, 1));
    assert!(!blocked(4.0, 0), "the wall ends the ray, not before it");
    assert!(blocked(4.1, 0) && blocked(4.0, 1) && blocked(f32::INFINITY, NO_PRIMITIVE));
}

#[test]
fn what_is_not_a_number_meets_nothing_and_leaves_its_neighbours_alone() {
    let mut random = Random::new(104);
    let primitives = world(&mut random);
    let shapes = kernel(&primitives);
    let (o, d) = (eight([3.0, 0.2, 0.1]), eight([-1.0, 0.0, 0.0]));
    let (want_t, want_id) = shapes.closest(o, d);
    assert_ne!(want_id.as_array()[0], NO_PRIMITIVE);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for component in 0..6 {
            for i in 0..WIDTH {
                let (mut o, mut d) = (o, d);
                let Vec3x8 { x, y, z } = if component < 3 { &mut o } else { &mut d };
                [x, y, z][component % 3].as_mut_array()[i] = bad;
                let (t, id) = shapes.closest(o, d);
                let far = f32x8::splat(f32::INFINITY);
                let occluded = shapes
                    .occluded(o, d, far, u32x8::splat(NO_PRIMITIVE))
                    .to_bitmask();
                for j in 0..WIDTH {
                    let (t, id) = (t.as_array()[j], id.as_array()[j]);
                    let want = if i == j {
                        (f32::INFINITY, NO_PRIMITIVE)
                    } else {
                        (want_t.as_array()[j], want_id.as_array()[j])
                    };
                    assert_eq!(
                        (t, id),
                        want,
                        "{bad} in component {component}, lane {j} of {i}"
                    );
                    assert_eq!(occluded >> j & 1, u32::from(i != j));
                }
            }
        }
    }
    let reach = f32x8::splat(f32::NAN);
    assert_eq!(
        shapes
            .occluded(o, d, reach, u32x8::splat(NO_PRIMITIVE))
            .to_bitmask(),
        0
    );
}

/// A million rays from inside a box (affine image of [−1, 1]³), aimed at its edges and corners.
fn misses_at_the_seams(shapes: &Shapes, place: impl Fn(V) -> V, seed: u64) -> usize {
    let mut random = Random::new(seed);
    let mut misses = 0;
    for batch in 0..1_000_000 / WIDTH {
        // Every other ray starts close to a wall.
        let starts: [V; 8] = std::array::from_fn(|i| {
            let mut p = point(&mut random, 0.999);
            if i % 2 == 1 {
                p[i / 2 % 3] =
                    (1.0 - 10f64.powf(-1.0 - 5.0 * f64::from(random.one()))).copysign(p[0]);
            }
            place(p)
        });
        let o = pack(starts);
        let d = pack(std::array::from_fn(|i| {
            let mut seam = point(&mut random, 1.0).map(|c: f64| 1f64.copysign(c));
            if batch % 4 != 0 {
                seam[(batch + i) % 3] = f64::from(random.one()) * 2.0 - 1.0;
            }
            unit(sub(place(seam), lane(&o, i)))
        }));
        let (t, _) = shapes.closest(o, d);
        misses += t
            .simd_eq(f32x8::splat(f32::INFINITY))
            .to_bitmask()
            .count_ones() as usize;
    }
    misses
}

#[test]
fn no_ray_slips_through_the_seams_of_the_cornell_box() {
    let scene = Scene::compile(
        &builtin::find("cornell")
            .expect("built in")
            .load()
            .expect("valid"),
    );
    let misses = misses_at_the_seams(&scene.shapes, |[x, y, z]| [x, y, 2.0 * z + 1.0], 105);
    assert_eq!(misses, 0);
}

#[test]
fn no_ray_slips_through_the_seams_of_a_turned_box() {
    // Columns of a rotation, by half widths of 1, 1.5 and 2, and off the origin.
    let axes = [[0.36, 0.48, -0.8], [-1.2, 0.9, 0.0], [0.96, 1.28, 1.2]];
    let place = |p: V| -> V {
        std::array::from_fn(|c| 0.3 + (0..3).map(|k| p[k] * axes[k][c]).sum::<f64>())
    };
    let mut walls = Vec::new();
    for k in 0..3 {
        for side in [-1.0, 1.0] {
            let mut corner = [-1.0; 3];
            corner[k] = side;
            let [u, v] = [1, 2].map(|step| axes[(k + step) % 3].map(|c| 2.0 * c));
            walls.push(Parallelogram {
                corner: place(corner),
                u,
                v,
            });
        }
    }
    assert_eq!(misses_at_the_seams(&kernel(&walls), place, 106), 0);
}
