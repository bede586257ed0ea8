//! Hills over the unit square, y up.

use glam::{Vec2, Vec3};
use ondine::scene::mesh::Mesh;

/// A height field of triangles.
pub struct Landscape {
    /// Vertices on a side.
    side: u32,
    pub positions: Vec<Vec3>,
    pub corners: Vec<[u32; 3]>,
}

impl Landscape {
    /// Where cameras are that see it.
    pub const VIEWPOINT: Vec3 = Vec3::new(0.5, 0.9, -0.6);
    /// Where they look.
    pub const CENTRE: Vec3 = Vec3::new(0.5, 0.1, 0.5);

    /// Eight thousand triangles.
    pub fn small() -> Self {
        Self::new(65)
    }

    /// Half a million triangles.
    pub fn large() -> Self {
        Self::new(512)
    }

    fn new(side: u32) -> Self {
        let step = 1.0 / side as f32;
        let grid = (0..side * side).map(|i| {
            let (x, z) = ((i % side) as f32 * step, (i / side) as f32 * step);
            Vec3::new(x, height(x, z), z)
        });
        let squares = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
        let triangles =
            squares.flat_map(|a| [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]]);
        Self {
            side,
            positions: grid.collect(),
            corners: triangles.collect(),
        }
    }

    /// With smooth normals, and texture coordinates that are x and z.
    pub fn mesh(self) -> Mesh {
        let step = 1.0 / self.side as f32;
        let normal = |p: &Vec3| {
            let slope = |dx, dz| height(p.x + dx, p.z + dz) - height(p.x - dx, p.z - dz);
            Vec3::new(-slope(step, 0.0), 2.0 * step, -slope(0.0, step))
        };
        let mesh = Mesh {
            name: "landscape".to_owned(),
            normals: self.positions.iter().map(normal).collect(),
            uvs: self.positions.iter().map(|p| Vec2::new(p.x, p.z)).collect(),
            positions: self.positions,
            triangles: self.corners,
        };
        mesh.checked().expect("a height field").0
    }
}

/// Seven octaves of hills.
fn height(x: f32, z: f32) -> f32 {
    (0..7).fold(0.0, |sum, octave| {
        let f = 2f32.powi(octave);
        sum + ((x * f * 6.0).sin() * (z * f * 7.0 + f).cos()).abs() * 0.15 / f
    })
}

/// A square above the hills that faces them.
pub fn lamp() -> Mesh {
    let corner = |x, z| Vec3::new(x, 1.2, z);
    Mesh {
        name: "lamp".to_owned(),
        positions: vec![
            corner(0.2, 0.2),
            corner(0.8, 0.2),
            corner(0.8, 0.8),
            corner(0.2, 0.8),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: Vec::new(),
        uvs: Vec::new(),
    }
}
