//! Rays and shapes: distances, ties, what casts a shadow, and the surface that is met.

use super::page::{Case, Section, Topic};
use super::{one, unit, wide};
use crate::error::Result;
use crate::lanes::{Queue, Rgbx8, Vec3x8, f32x8, first_lanes, u32x8};
use crate::material::Kind;
use crate::scene::{Scene, toml};
use crate::shape::{NO_PRIMITIVE, Quad, Room, Shapes, Sphere};
use crate::wavefront::intersect;
use crate::wavefront::queues::{PathRayX8, VertexX8};
use glam::Vec3;

/// Origin and direction.
type Line = (Vec3, Vec3);

pub(super) fn topic() -> Result<Topic> {
    Ok(Topic {
        name: "intersections",
        about: "Rays and shapes: specification, section 7. Directions are unit, distances in scene units; a miss has no \
                distance and no primitive (null). Primitives are numbered in the order of each section's text.",
        sections: vec![
            spheres(),
            quads(),
            edges(),
            ties(),
            rooms(),
            shadows(),
            surfaces()?,
        ],
    })
}

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn ray((origin, direction): Line) -> Case {
    Case::new()
        .floats("origin", &origin.to_array())
        .floats("direction", &direction.to_array())
}

fn hit(case: Case, (distance, primitive): (f32x8, u32x8)) -> Case {
    case.float("distance", one(distance))
        .id("primitive", primitive.to_array()[0])
}

/// What lines meet of some shapes.
fn closest(name: &'static str, about: &'static str, shapes: &Shapes, lines: &[Line]) -> Section {
    let case = |&line: &Line| {
        let (origin, direction) = line;
        let met = shapes.closest(Vec3x8::splat(origin), Vec3x8::splat(direction));
        hit(ray(line), met)
    };
    Section::new(name, about, lines.iter().map(case).collect())
}

fn spheres() -> Section {
    let mut shapes = Shapes::default();
    shapes.add_sphere(Sphere::new(v(0.0, 0.0, -4.0), 1.0), 0);
    shapes.add_sphere(Sphere::new(v(1000.0, 0.0, 0.0), 0.125), 1);
    let lines = [
        (Vec3::ZERO, Vec3::NEG_Z),
        (Vec3::ZERO, unit(0.125, 0.0625, -1.0)),
        (v(0.0, 0.0, -4.0), Vec3::X),
        (v(0.0, 0.5, -4.25), unit(1.0, 2.0, 3.0)),
        (Vec3::ZERO, Vec3::Z),
        // Touches it, and passes just inside and outside.
        (v(1.0, 0.0, 0.0), Vec3::NEG_Z),
        (v(1.0_f32.next_down(), 0.0, 0.0), Vec3::NEG_Z),
        (v(1.0_f32.next_up(), 0.0, 0.0), Vec3::NEG_Z),
        // Begins on it.
        (v(0.0, 0.0, -3.0), Vec3::Z),
        (v(0.0, 0.0, -3.0), Vec3::NEG_Z),
        (Vec3::ZERO, Vec3::X),
        (Vec3::ZERO, unit(1.0, 1e-4, 0.0)),
        (Vec3::ZERO, unit(1.0, 2e-4, 0.0)),
    ];
    closest(
        "sphere",
        "0: centre (0, 0, -4), radius 1. 1: centre (1000, 0, 0), radius 0.125.",
        &shapes,
        &lines,
    )
}

fn quads() -> Section {
    let mut shapes = Shapes::default();
    let (corner, along, up) = (v(-1.0, -0.5, -2.0), v(2.0, 0.0, 0.0), v(0.5, 1.0, 0.25));
    shapes.add_quad(Quad::new(corner, along, up), 0);
    let to = |a: f32, b: f32| {
        let point = corner + along * a + up * b;
        (
            Vec3::ZERO,
            unit(point.x.into(), point.y.into(), point.z.into()),
        )
    };
    let lines = [
        to(0.5, 0.5),
        to(0.25, 0.875),
        to(0.0, 0.0),
        to(1.0, 0.5),
        to(0.5, 1.0),
        to(1.0, 1.0),
        to(1.0 + 1e-5, 0.5),
        to(-1e-5, 0.5),
        to(0.5, 1.5),
        // From behind, away from it, along its plane.
        (v(0.0, 0.0, -4.0), Vec3::Z),
        (Vec3::ZERO, Vec3::Z),
        (corner - along, Vec3::X),
        (Vec3::ZERO, Vec3::X),
    ];
    closest(
        "quad",
        "0: corner (-1, -0.5, -2), edges (2, 0, 0) and (0.5, 1, 0.25).",
        &shapes,
        &lines,
    )
}

fn edges() -> Section {
    let mut shapes = Shapes::default();
    let quad = |x: f32| Quad::new(v(x, -1.0, -3.0), Vec3::X, v(0.0, 2.0, 0.0));
    shapes.add_quad(quad(0.0), 0);
    shapes.add_quad(quad(-1.0), 1);
    let line = |x: f32| (v(x, 0.0, 0.0), Vec3::NEG_Z);
    closest(
        "shared_edge",
        "0: corner (0, -1, -3), edges (1, 0, 0) and (0, 2, 0). 1: the same from corner (-1, -1, -3). Both reach a little over \
         their common edge; where both are met at one distance, the first counts.",
        &shapes,
        &[0.0, 1e-8, -1e-8, 1e-7, -1e-7, 1e-6, -1e-6].map(line),
    )
}

fn ties() -> Section {
    let mut shapes = Shapes::default();
    shapes.add_sphere(Sphere::new(v(0.0, 0.0, -3.0), 1.0), 0);
    let quad = Quad::new(v(-1.0, -1.0, -2.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0));
    shapes.add_quad(quad, 1);
    shapes.add_quad(quad, 2);
    shapes.add_sphere(Sphere::new(v(0.0, 0.0, -3.0), 1.0), 3);
    closest(
        "ties",
        "0: sphere at (0, 0, -3), radius 1. 1 and 2: quad of corner (-1, -1, -2), edges (2, 0, 0) and (0, 2, 0). 3: the sphere \
         again. Quads come before spheres, each kind in its order.",
        &shapes,
        &[
            (Vec3::ZERO, Vec3::NEG_Z),
            (v(0.0, 0.0, -6.0), Vec3::Z),
            (v(0.25, 0.25, 0.0), Vec3::NEG_Z),
        ],
    )
}

fn rooms() -> Section {
    let (x, y, z) = (v(4.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(0.0, 0.0, 8.0));
    let corner = v(-2.0, -1.0, -4.0);
    let quads = [
        (corner, x, y),
        (corner + z, x, y),
        (corner, y, z),
        (corner + x, y, z),
        (corner, z, x),
        (corner + y, z, x),
    ];
    let room = Room::new(&quads, &[0, 1, 2, 3, 4, 5]);
    let case = |line: Line| {
        let (origin, direction) = (Vec3x8::splat(line.0), Vec3x8::splat(line.1));
        let none = (wide(f32::INFINITY), u32x8::splat(NO_PRIMITIVE));
        let met = room
            .as_ref()
            .map_or(none, |room| room.leave(origin, direction, none));
        hit(ray(line), met)
    };
    let lines = [
        (Vec3::ZERO, Vec3::NEG_Z),
        (Vec3::ZERO, Vec3::X),
        (Vec3::ZERO, Vec3::NEG_Y),
        (v(0.5, 0.25, 1.0), unit(1.0, 2.0, 3.0)),
        (v(0.5, 0.25, 1.0), unit(-3.0, 1.0, -5.0)),
        // Into an edge and a corner.
        (Vec3::ZERO, unit(2.0, 1.0, 0.0)),
        (Vec3::ZERO, unit(-2.0, -1.0, -4.0)),
        // Begins on a wall, along it and into it.
        (v(2.0, 0.0, 0.0), Vec3::Z),
        (v(2.0, 0.0, 0.0), Vec3::X),
    ];
    Section::new(
        "room",
        "A box from (-2, -1, -4) to (2, 1, 4): 0 and 1 are its walls at z = -4 and 4, 2 and 3 at x = -2 and 2, 4 and 5 at y = -1 \
         and 1; slabs are tried in this order.",
        lines.map(case).into(),
    )
}

fn shadows() -> Section {
    let mut shapes = Shapes::default();
    shapes.add_quad(
        Quad::new(v(-1.0, -1.0, -2.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0)),
        0,
    );
    shapes.add_sphere(Sphere::new(v(0.0, 0.0, -4.0), 1.0), 1);
    let case = |(limit, target): (f32, u32)| {
        let line = (Vec3::ZERO, Vec3::NEG_Z);
        let (origin, direction) = (Vec3x8::splat(line.0), Vec3x8::splat(line.1));
        let occluded = shapes.occluded(origin, direction, wide(limit), u32x8::splat(target));
        ray(line)
            .float("limit", limit)
            .id("target", target)
            .flag("occluded", occluded.all())
    };
    Section::new(
        "shadow",
        "0: quad of corner (-1, -1, -2), edges (2, 0, 0) and (0, 2, 0). 1: sphere at (0, 0, -4), radius 1. Occluded is what meets \
         anything but the target at a distance below the limit.",
        [
            (f32::INFINITY, NO_PRIMITIVE),
            (2.0, NO_PRIMITIVE),
            (2.0_f32.next_up(), NO_PRIMITIVE),
            (2.0_f32.next_up(), 0),
            (3.0, 0),
            (3.0_f32.next_up(), 0),
            (f32::INFINITY, 0),
            (f32::INFINITY, 1),
        ]
        .map(case)
        .into(),
    )
}

/// The scene of [`surfaces`].
const SURFACES: &str = "version = 1
[camera]
position = [0.0, 0.0, 0.0]
look_at = [0.0, 0.0, -1.0]
vertical_fov = 45.0
[materials.gray]
type = \"lambert\"
albedo = [0.5, 0.5, 0.5]
[[objects]]
sphere = { center = [0.0, 0.0, -4.0], radius = 1.0 }
material = \"gray\"
[[objects]]
sphere = { center = [100.0, 0.0, 0.0], radius = 10.0 }
material = \"gray\"
[[objects]]
quad = { corner = [-1.0, -3.0, -1.0], u = [0.0, 0.25, 2.0], v = [2.0, 0.5, 0.0] }
material = \"gray\"
[environment]
constant = [1.0, 1.0, 1.0]
";

fn surfaces() -> Result<Section> {
    let scene = Scene::compile(&toml::parse(SURFACES, "vectors", None)?);
    let lines = [
        (Vec3::ZERO, Vec3::NEG_Z),
        (Vec3::ZERO, unit(0.125, 0.0625, -1.0)),
        (v(0.0, 0.5, -4.25), unit(1.0, 2.0, 3.0)),
        (Vec3::ZERO, unit(1.0, 0.0625, -0.03125)),
        (Vec3::ZERO, Vec3::NEG_Y),
        (v(0.25, 8.0, 0.125), unit(0.03125, -1.0, -0.0625)),
    ];
    let case = |line: Line| {
        let mut rays = Queue::<PathRayX8>::with_capacity(1);
        rays.push(
            first_lanes(1),
            &PathRayX8 {
                origin: Vec3x8::splat(line.0),
                direction: Vec3x8::splat(line.1),
                throughput: Rgbx8::ONE,
                ..PathRayX8::default()
            },
        );
        let mut vertices = Kind::ALL.map(|_| Queue::<VertexX8>::with_capacity(1));
        intersect::closest(
            &scene,
            false,
            &rays,
            &mut vertices,
            &mut Queue::with_capacity(1),
        );
        let vertex = vertices[Kind::Lambert as usize].get(0);
        ray(line)
            .floats("position", &vertex.position.to_array())
            .floats("normal", &vertex.normal.to_array())
            .float("offset", vertex.offset)
    };
    Ok(Section {
        scene: Some(SURFACES.to_owned()),
        ..Section::new(
            "surface",
            "Of what is met: the position, the outward unit normal, and the offset of rays that start there, scene units.",
            lines.map(case).into(),
        )
    })
}
