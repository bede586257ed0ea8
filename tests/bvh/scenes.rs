//! Soups of triangles, and rays at them, that no builder and no kernel likes.

use crate::common::Random;
use crate::rays::Ray;
use glam::{Affine3A, Quat, Vec3};
use ondine::bvh::Instance;
use ondine::scene::mesh::Mesh;

pub fn between(random: &mut Random, low: f32, high: f32) -> f32 {
    low + (high - low) * random.one()
}

pub fn point(random: &mut Random, radius: f32) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| between(random, -radius, radius)))
}

pub fn below(random: &mut Random, limit: usize) -> usize {
    (f64::from(random.one()) * limit as f64) as usize
}

/// 10^low to 10^high.
pub fn magnitude(random: &mut Random, low: f32, high: f32) -> f32 {
    10f32.powf(between(random, low, high))
}

/// A mesh in which no triangles share vertices.
pub fn soup(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Mesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh {
        triangles: triangles.collect(),
        positions,
        ..Mesh::default()
    }
}

pub fn corners(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.triangles[triangle].map(|corner| mesh.positions[corner as usize])
}

/// Triangles of all sizes and shapes: slivers, squares on a grid, copies, huge ones, points.
pub fn mixed(random: &mut Random, count: usize) -> Mesh {
    let mut triangles: Vec<[Vec3; 3]> = Vec::with_capacity(count);
    for _ in 0..count {
        let center = point(random, 1.0);
        let next = match below(random, 10) {
            0 => {
                let size = magnitude(random, 1.0, 4.0);
                [0; 3].map(|_| center + point(random, size))
            }
            1 => {
                let size = magnitude(random, -6.0, -2.0);
                [0; 3].map(|_| center + point(random, size))
            }
            2 => {
                let (end, width) = (point(random, 1.0), magnitude(random, -7.0, -2.0));
                let along = between(random, -0.5, 1.5);
                [center, end, center.lerp(end, along) + point(random, width)]
            }
            3 | 4 => {
                let snap = |v: Vec3| (v * 4.0).round() / 4.0;
                let (axis, size) = (below(random, 3), between(random, 0.25, 1.0));
                let [mut u, mut v] = [Vec3::ZERO; 2];
                u[(axis + 1) % 3] = snap(Vec3::splat(size)).x.max(0.25);
                v[(axis + 2) % 3] = snap(Vec3::splat(size)).x.max(0.25);
                let corner = snap(center);
                [corner, corner + u, corner + v]
            }
            5 if !triangles.is_empty() => {
                let mut copy = triangles[below(random, triangles.len())];
                copy.rotate_left(below(random, 3));
                copy
            }
            6 if below(random, 4) == 0 => [center; 3],
            _ => {
                let size = magnitude(random, -1.5, 0.0);
                [0; 3].map(|_| center + point(random, size))
            }
        };
        triangles.push(next);
    }
    soup(triangles)
}

/// The same without those that are so small beside the distances of rays that rounding alone decides about them.
pub fn mixed_sturdy(random: &mut Random, count: usize) -> Mesh {
    let mesh = mixed(random, count);
    let is_sturdy = |&[a, b, c]: &[Vec3; 3]| (b - a).length().max((c - a).length()) > 0.02;
    soup((0..count).map(|i| corners(&mesh, i)).filter(is_sturdy))
}

/// Turned, mirrored, squeezed and moved, two of each mesh and one of the first where it is.
pub fn placed(random: &mut Random, meshes: usize) -> Vec<Instance> {
    let mut instances = vec![Instance {
        mesh: 0,
        to_world: Affine3A::IDENTITY,
    }];
    for i in 0..2 * meshes {
        let sign = if below(random, 2) == 0 { 1.0 } else { -1.0 };
        let scale = Vec3::new(sign, 1.0, 1.0) * (Vec3::splat(1.2) + point(random, 0.7));
        let turn = Quat::from_axis_angle(
            (point(random, 1.0) + Vec3::splat(1.5)).normalize(),
            between(random, 0.0, 6.0),
        );
        let to_world = Affine3A::from_scale_rotation_translation(scale, turn, point(random, 3.0));
        instances.push(Instance {
            mesh: i % meshes,
            to_world,
        });
    }
    instances
}

/// A ray at a scene around the origin, often straight at something of `mesh` where that stands untransformed.
pub fn ray(random: &mut Random, mesh: &Mesh) -> Ray {
    let [a, b, c] = corners(mesh, below(random, mesh.triangles.len()));
    let [u, v] = [random.one(), random.one()];
    let target = match below(random, 5) {
        0 => a,
        1 => a.lerp(b, u),
        2 => (a + b + c) / 3.0,
        _ => a.lerp(b, u).lerp(c, v),
    };
    let mut origin = match below(random, 8) {
        0 => point(random, 100.0),
        1 => target,
        2 => [a, b, c][below(random, 3)],
        _ => point(random, 2.0),
    };
    let mut direction = match below(random, 4) {
        0 => point(random, 1.0),
        _ => target - origin,
    };
    if below(random, 3) == 0 {
        // Some components are zero, of either sign; where only one is left, the ray runs along an axis at its target.
        for axis in 0..3 {
            if below(random, 3) > 0 {
                direction[axis] = if below(random, 2) == 0 { 0.0 } else { -0.0 };
                origin[axis] = target[axis];
            }
        }
    }
    if direction == Vec3::ZERO {
        direction[below(random, 3)] = if below(random, 2) == 0 { 1.0 } else { -1.0 };
    }
    let scale = match below(random, 3) {
        0 => magnitude(random, -10.0, 10.0),
        1 => 1.0 / direction.length(),
        _ => 1.0,
    };
    let mut ray = Ray::new(origin, direction * scale);
    if below(random, 3) == 0 {
        ray.nearest = 2.0 * random.one() / scale;
    }
    match below(random, 4) {
        0 => ray.farthest = ray.nearest + 2.0 * random.one() / scale,
        1 => ray.farthest = f32::MAX,
        _ => {}
    }
    if below(random, 4) == 0 {
        ray.ignored = below(random, mesh.triangles.len()) as u32;
    }
    ray
}
