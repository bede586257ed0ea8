//! Rays and triangles.

use super::page::{Case, Section, Topic};
use super::unit;
use crate::bvh::{Bvh, Hit, HitX8, Instance, NO_TRIANGLE, Quality, Ray, RayX8, Stacks, Triangles};
use crate::lanes::{Batch, Queue};
use glam::{Affine3A, Vec3};

/// A fan around the origin's axis: four triangles that share a vertex and edges, and the first again.
const POSITIONS: [Vec3; 5] = [
    Vec3::new(0.0, 0.0, -2.0),
    Vec3::new(1.0, -1.0, -2.0),
    Vec3::new(1.0, 1.0, -2.5),
    Vec3::new(-1.0, 1.0, -2.0),
    Vec3::new(-1.0, -1.0, -1.5),
];
const CORNERS: [[u32; 3]; 5] = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [2, 0, 1]];

const FAN: &str = "Corners a (0, 0, -2), b (1, -1, -2), c (1, 1, -2.5), d (-1, 1, -2), e (-1, -1, -1.5); triangles 0: abc, 1: acd, 2: \
                   ade, 3: aeb, and 4: cab, the first again.";

pub(super) fn topic() -> Topic {
    Topic {
        name: "triangles",
        about: FAN,
        sections: vec![hits(), shadows()],
    }
}

fn fan() -> Bvh {
    let mesh = Triangles {
        positions: &POSITIONS,
        corners: &CORNERS,
    };
    let place = Instance {
        mesh: 0,
        to_world: Affine3A::IDENTITY,
    };
    Bvh::build(&[mesh], &[place], Quality::Fast)
}

fn hits() -> Section {
    let bvh = fan();
    let to = |p: Vec3| Ray::new(Vec3::ZERO, unit(p.x.into(), p.y.into(), p.z.into()));
    let [a, b, c, d, e] = POSITIONS;
    let rays = [
        to((a + b + c) / 3.0),
        to((a + c + d) / 3.0),
        to((a + d + e) / 3.0),
        to((a + e + b) / 3.0),
        // Shared vertex, corners, shared edges.
        to(a),
        to(b),
        to(c),
        to(d),
        to(e),
        to((a + b) / 2.0),
        to((a + c) / 2.0),
        to((a * 3.0 + d) / 4.0),
        to((b + c) / 2.0),
        // From behind, beside it, away from it, not unit, from a distance on.
        Ray::new(Vec3::new(0.5, 0.0, -4.0), Vec3::Z),
        Ray::new(Vec3::new(1.5, 0.0, 0.0), Vec3::NEG_Z),
        Ray::new(Vec3::ZERO, Vec3::Z),
        Ray::new(Vec3::ZERO, Vec3::new(0.25, 0.0, -4.0)),
        Ray {
            nearest: 2.0,
            ..Ray::new(Vec3::ZERO, Vec3::NEG_Z)
        },
        Ray::new(Vec3::new(-3.0, 0.25, -1.75), unit(1.0, 0.0, -0.125)),
        Ray::new(Vec3::new(0.25, 3.0, -1.75), unit(0.0, -1.0, -0.125)),
    ];
    // Towards shared edges from elsewhere, where edge functions are roundings; and along a diagonal of the axes.
    let from = Vec3::new(0.3, -0.2, 0.1);
    let towards = |p: Vec3| {
        let way = p - from;
        Ray::new(from, unit(way.x.into(), way.y.into(), way.z.into()))
    };
    let seams = [b, c, d, e]
        .into_iter()
        .flat_map(|end| [0.1, 0.35, 0.6, 0.85].map(|part| towards(a + (end - a) * part)));
    let diagonals = [
        Vec3::new(1.0, 1.0, -1.0),
        Vec3::new(-1.0, 0.5, -1.0),
        Vec3::new(0.25, -1.0, -1.0),
    ]
    .map(|way| Ray::new(Vec3::new(0.23, 0.07, -2.07) - way * 0.7, way));
    let case = |ray: Ray| {
        let mut queue = Queue::<RayX8>::with_capacity(1);
        queue.push_one(ray);
        let nothing = Hit {
            distance: f32::INFINITY,
            triangle: NO_TRIANGLE,
            instance: NO_TRIANGLE,
        };
        let mut batch = HitX8::default();
        batch.set_lane(0, nothing);
        let mut hits = [batch];
        bvh.closest(&queue, &mut hits, &mut Stacks::default());
        let [batch] = hits;
        let hit = batch.lane(0);
        Case::new()
            .floats("origin", &ray.origin.to_array())
            .floats("direction", &ray.direction.to_array())
            .float("nearest", ray.nearest)
            .float("distance", hit.distance)
            .id("triangle", hit.triangle)
    };
    Section::new(
        "closest",
        "The hit above nearest, in units of the direction's length; of several at one distance that of the lowest number. A miss \
         has no distance and no triangle (null).",
        rays.into_iter()
            .chain(seams)
            .chain(diagonals)
            .map(case)
            .collect(),
    )
}

fn shadows() -> Section {
    let bvh = fan();
    let case = |(farthest, ignored): (f32, u32)| {
        let ray = Ray {
            farthest,
            ignored,
            ..Ray::new(Vec3::ZERO, Vec3::new(-0.25, 0.0, -1.0))
        };
        let mut queue = Queue::<RayX8>::with_capacity(1);
        queue.push_one(ray);
        let mut occluded = [0];
        bvh.occluded(&queue, &mut occluded, &mut Stacks::default());
        Case::new()
            .floats("origin", &ray.origin.to_array())
            .floats("direction", &ray.direction.to_array())
            .float("farthest", farthest)
            .id("ignored", ignored)
            .flag("occluded", occluded[0] & 1 == 1)
    };
    Section::new(
        "any",
        "Occluded is what meets any triangle but the ignored one at a distance below farthest.",
        [
            (f32::INFINITY, NO_TRIANGLE),
            (f32::INFINITY, 2),
            (f32::INFINITY, 0),
            (1.75, NO_TRIANGLE),
            (2.0, NO_TRIANGLE),
        ]
        .map(case)
        .into(),
    )
}
