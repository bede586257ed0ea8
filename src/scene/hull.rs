//! What is around everything: its size, and the walls that have the whole scene on one side.

use super::description::Shape;
use crate::shape::{Quad, Room, Shapes, Sphere};
use glam::{DVec3, Vec3};

/// Adds a shape that needs no tree; a mesh is none.
pub(super) fn add(shapes: &mut Shapes, shape: Shape, id: u32) {
    match shape {
        Shape::Sphere { center, radius } => shapes.add_sphere(Sphere::new(center, radius), id),
        Shape::Quad { corner, u, v } => shapes.add_quad(Quad::new(corner, u, v), id),
        Shape::Mesh { .. } => {}
    }
}

/// Unit normal of a quad.
pub(super) fn normal(u: Vec3, v: Vec3) -> DVec3 {
    u.as_dvec3().cross(v.as_dvec3()).normalize()
}

/// Whether a shape is a quad with the whole scene, and these points, on one side of its plane: then no segment between two
/// points of the scene crosses it, and shadow rays need not ask.
pub(super) fn is_hull(shape: Shape, scene: &[Shape], points: &[Vec3]) -> bool {
    let Shape::Quad { corner, u, v } = shape else {
        return false;
    };
    let (corner, normal) = (corner.as_dvec3(), normal(u, v));
    let height = |p: &Vec3| normal.dot(p.as_dvec3() - corner);
    let reach = |points: &[Vec3]| {
        points
            .iter()
            .map(height)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
                (low.min(h), high.max(h))
            })
    };
    let (low, high) = reach(points);
    let (mut low, mut high) = (low.min(0.0), high.max(0.0));
    for &shape in scene {
        let (near, far) = match shape {
            Shape::Sphere { center, radius } => {
                let (h, r) = (height(&center), f64::from(radius));
                (h - r, h + r)
            }
            Shape::Quad { corner, u, v } => {
                reach(&[corner, corner + u, corner + v, corner + u + v])
            }
            // Among the points.
            Shape::Mesh { .. } => continue,
        };
        low = low.min(near);
        high = high.max(far);
    }
    // The corners are f32: what sticks out by their rounding does not count.
    let tolerance = 1e-6 * (high - low);
    low >= -tolerance || high <= tolerance
}

/// The room that the hull makes, and everything else.
pub(super) fn enclosing_room(scene: &[Shape], hull: &[bool]) -> Option<(Room, Shapes)> {
    let mut walls = (Vec::new(), Vec::new());
    let mut contents = Shapes::default();
    for (id, (&shape, &is_wall)) in scene.iter().zip(hull).enumerate() {
        match shape {
            Shape::Quad { corner, u, v } if is_wall => {
                walls.0.push((corner, u, v));
                walls.1.push(id as u32);
            }
            _ => add(&mut contents, shape, id as u32),
        }
    }
    Some((Room::new(&walls.0, &walls.1)?, contents))
}

/// Half the diagonal of the box around all shapes and points; 1 for an empty scene.
pub(super) fn bounding_radius(shapes: &[Shape], points: &[Vec3]) -> f32 {
    let around = |points: &[Vec3]| {
        (
            points.iter().copied().fold(Vec3::INFINITY, Vec3::min),
            points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max),
        )
    };
    let (mut low, mut high) = around(points);
    for shape in shapes {
        let (near, far) = match *shape {
            Shape::Sphere { center, radius } => (center - radius, center + radius),
            Shape::Quad { corner, u, v } => {
                around(&[corner, corner + u, corner + v, corner + u + v])
            }
            Shape::Mesh { .. } => continue,
        };
        low = low.min(near);
        high = high.max(far);
    }
    if low.x > high.x {
        return 1.0;
    }
    ((high - low).length() / 2.0).max(f32::MIN_POSITIVE)
}
