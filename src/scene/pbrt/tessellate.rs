//! Curved shapes as meshes with smooth normals.

use crate::scene::mesh::Mesh;
use glam::{DVec3, Vec2};
use std::f64::consts::TAU;

/// Parts of a full turn.
const AROUND: usize = 128;
/// Parts from pole to pole.
const UPWARD: usize = 64;

/// The mesh of a surface over the unit square of its UV; its normal is `cross(∂p/∂u, ∂p/∂v)`, as pbrt has it.
fn grid(
    name: &str,
    columns: usize,
    rows: usize,
    surface: impl Fn(f64, f64) -> (DVec3, DVec3),
) -> Mesh {
    let mut mesh = Mesh {
        name: name.to_owned(),
        ..Mesh::default()
    };
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (column as f64 / columns as f64, row as f64 / rows as f64);
            let (position, normal) = surface(u, v);
            mesh.positions.push(position.as_vec3());
            mesh.normals.push(normal.as_vec3());
            mesh.uvs.push(Vec2::new(u as f32, v as f32));
        }
    }
    let corner = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [corner(column, row), corner(column + 1, row)];
            let [c, d] = [corner(column + 1, row + 1), corner(column, row + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Part of a sphere around the origin, poles on z: `low ≤ z ≤ high`, in units of the radius, and `sweep` turns.
pub(super) fn sphere(low: f64, high: f64, sweep: f64) -> Mesh {
    let [from, to] = [low, high].map(libm::acos);
    grid("sphere", AROUND, UPWARD, |u, v| {
        // The ends exactly: a pole is one point.
        let z = match v {
            0.0 => low,
            1.0 => high,
            _ => libm::cos(from + (to - from) * v),
        };
        let (sin, cos) = libm::sincos(TAU * sweep * u);
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let at = DVec3::new(r * cos, r * sin, z);
        (at, at)
    })
}

/// A disk of radius 1 around z, with a hole of radius `inner` in it, and `sweep` turns; it faces +z.
pub(super) fn disk(inner: f64, sweep: f64) -> Mesh {
    grid("disk", AROUND, 1, |u, v| {
        let (sin, cos) = libm::sincos(TAU * sweep * u);
        let r = 1.0 + (inner - 1.0) * v;
        (DVec3::new(r * cos, r * sin, 0.0), DVec3::Z)
    })
}

/// A tube of radius 1 around z, from z = 0 to 1, and `sweep` turns; it faces outwards.
pub(super) fn cylinder(sweep: f64) -> Mesh {
    grid("cylinder", AROUND, 1, |u, v| {
        let (sin, cos) = libm::sincos(TAU * sweep * u);
        (DVec3::new(cos, sin, v), DVec3::new(cos, sin, 0.0))
    })
}

/// A bilinear patch with the corners (0, 0), (1, 0), (0, 1), (1, 1) of its UV.
pub(super) fn patch([p00, p10, p01, p11]: [DVec3; 4]) -> Mesh {
    const PARTS: usize = 16;
    grid("bilinear patch", PARTS, PARTS, |u, v| {
        let along_u = (p10 - p00).lerp(p11 - p01, v);
        let along_v = (p01 - p00).lerp(p11 - p10, u);
        let position = p00.lerp(p10, u).lerp(p01.lerp(p11, u), v);
        (position, along_u.cross(along_v))
    })
}
