//! Meshes as shapes need them, and what a transformation does to a shape.

use super::shapes::Geometry;
use crate::scene::mesh::Mesh;
use glam::{Affine3A, DAffine3, DVec3, Mat3A, Vec2, Vec3, Vec3A};
use std::sync::Arc;

/// A mesh as a shape needs it.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    /// Index into the geometries.
    pub geometry: usize,
    /// In the plane x = 0: what a transformation mirrors is mirrored here, so that the rest of it is not.
    pub mirrored: bool,
    /// Turned inside out.
    pub reversed: bool,
    /// With pbrt's UV for triangles that have none.
    pub with_uvs: bool,
}

/// Single precision, as kernels have it.
pub(super) fn narrow(to_world: DAffine3) -> Affine3A {
    let column = |v: DVec3| Vec3A::from(v.as_vec3());
    let matrix = to_world.matrix3;
    Affine3A {
        matrix3: Mat3A::from_cols(
            column(matrix.x_axis),
            column(matrix.y_axis),
            column(matrix.z_axis),
        ),
        translation: column(to_world.translation),
    }
}

/// The factor by which lengths grow, where it is the same in all directions, and a radius.
pub(super) fn uniform_scale(to_world: DAffine3) -> Option<f64> {
    let matrix = to_world.matrix3;
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let square = x.length_squared();
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * square;
    let is_uniform = near(y.length_squared(), square)
        && near(z.length_squared(), square)
        && near(x.dot(y), 0.0)
        && near(y.dot(z), 0.0)
        && near(z.dot(x), 0.0);
    let scale = square.sqrt();
    (is_uniform && (1e-9..=1e9).contains(&scale)).then_some(scale)
}

/// Whether two edges make a quad, as the scene format asks of one.
pub(super) fn is_sound(u: Vec3, v: Vec3) -> bool {
    let (u, v) = (u.as_dvec3(), v.as_dvec3());
    let area = u.cross(v).length();
    area >= 1e-4 * u.length() * v.length() && area >= 1e-18 && u.length().min(v.length()) >= 1e-9
}

/// The mesh of a geometry as a shape needs it.
pub(super) fn varied(geometry: &Geometry, variant: Variant) -> Arc<Mesh> {
    let mesh = geometry.mesh();
    let Variant {
        mirrored,
        reversed,
        with_uvs,
        ..
    } = variant;
    if !(mirrored || reversed || with_uvs) {
        return Arc::clone(mesh);
    }
    let mut mesh = if with_uvs {
        with_triangle_uvs(mesh)
    } else {
        Mesh::clone(mesh)
    };
    if mirrored {
        for vector in mesh.positions.iter_mut().chain(&mut mesh.normals) {
            vector.x = -vector.x;
        }
    }
    if reversed {
        for normal in &mut mesh.normals {
            *normal = -*normal;
        }
    }
    if mirrored ^ reversed {
        for corners in &mut mesh.triangles {
            corners.swap(1, 2);
        }
    }
    Arc::new(mesh)
}

/// pbrt's UV for meshes that have none: (0, 0), (1, 0), (1, 1) on each triangle.
fn with_triangle_uvs(mesh: &Mesh) -> Mesh {
    const CORNERS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::ONE];
    let mut own = Mesh {
        name: mesh.name.clone(),
        ..Mesh::default()
    };
    for corners in &mesh.triangles {
        let first = own.positions.len() as u32;
        for (&corner, uv) in corners.iter().zip(CORNERS) {
            own.positions.extend(mesh.positions.get(corner as usize));
            own.normals.extend(mesh.normals.get(corner as usize));
            own.uvs.push(uv);
        }
        own.triangles.push([first, first + 1, first + 2]);
    }
    own
}
