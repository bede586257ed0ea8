//! Scenes of triangles: surfaces, lights, holes and instances, against oracles, closed forms and shapes that are known.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/render.rs"]
mod render;

mod bits;
mod hulls;
mod images;
mod lamps;
mod maps;
mod sources;
mod surfaces;

use glam::{Affine3A, Vec2, Vec3};
use ondine::lanes::Rgb;
use ondine::scene::description::{Description, Light, Object, Shape};
use ondine::scene::mesh::Mesh;
use std::sync::Arc;

/// A scene of a camera, a gray Lambert material and a film, and nothing to see.
fn empty(camera: &str) -> Description {
    render::scene(&format!(
        "[camera]\n{camera}\n[materials.gray]\ntype = \"lambert\"\nalbedo = [0.5, 0.5, 0.5]\n{NOWHERE}"
    ))
}

/// A scene file has an object or a light; this one nobody meets.
const NOWHERE: &str = "[environment]\nconstant = [0.0, 0.0, 0.0]\n";

fn checked(mesh: Mesh) -> Arc<Mesh> {
    let (mesh, dropped) = mesh.checked().expect("a mesh");
    assert_eq!(dropped, 0);
    Arc::new(mesh)
}

/// The unit sphere: an octahedron whose edges are halved `level` times; with normals if `smooth`.
fn ball(level: u32, smooth: bool) -> Arc<Mesh> {
    let mut faces: Vec<[Vec3; 3]> = Vec::new();
    for i in 0..8 {
        let sign = |bit: u32| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)];
        let [a, b, c] = corners;
        let out = a.cross(b).dot(c) > 0.0;
        faces.push(if out { [a, b, c] } else { [a, c, b] });
    }
    for _ in 0..level {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let middle = |a: Vec3, b: Vec3| (a + b).as_dvec3().normalize().as_vec3();
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let positions: Vec<Vec3> = faces.iter().flatten().copied().collect();
    checked(Mesh {
        name: "ball".into(),
        triangles: (0..faces.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        normals: if smooth {
            positions.clone()
        } else {
            Vec::new()
        },
        uvs: positions.iter().map(|p| Vec2::new(p.x, p.y)).collect(),
        positions,
    })
}

/// `corner + a u + b v` by `side`² cells of two triangles; texture coordinates (a, b).
fn sheet(corner: Vec3, u: Vec3, v: Vec3, side: u32) -> Arc<Mesh> {
    let row = side + 1;
    let part = |i: u32| i as f32 / side as f32;
    let grid = || (0..row * row).map(|i| Vec2::new(part(i % row), part(i / row)));
    let cells = (0..side * side).flat_map(|i| {
        let first = i / side * row + i % side;
        [
            [first, first + 1, first + row + 1],
            [first, first + row + 1, first + row],
        ]
    });
    checked(Mesh {
        name: "sheet".into(),
        positions: grid().map(|g| corner + u * g.x + v * g.y).collect(),
        triangles: cells.collect(),
        normals: Vec::new(),
        uvs: grid().collect(),
    })
}

/// Adds a mesh and its place.
fn add(description: &mut Description, mesh: &Arc<Mesh>, transform: Affine3A, material: usize) {
    let shape = place(description, mesh, transform);
    description.objects.push(Object { shape, material });
}

fn add_light(description: &mut Description, mesh: &Arc<Mesh>, transform: Affine3A, radiance: Rgb) {
    let shape = place(description, mesh, transform);
    description.lights.push(Light {
        shape,
        radiance,
        two_sided: false,
        material: None,
        texture: None,
    });
}

fn place(description: &mut Description, mesh: &Arc<Mesh>, transform: Affine3A) -> Shape {
    let known = description.meshes.iter().position(|m| Arc::ptr_eq(m, mesh));
    let mesh = known.unwrap_or_else(|| {
        description.meshes.push(Arc::clone(mesh));
        description.meshes.len() - 1
    });
    Shape::Mesh { mesh, transform }
}
