//! Triangle meshes, checked once for every loader.

use glam::{Vec2, Vec3};

/// A triangle mesh. Shared by all its instances.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Where it came from, as `info` and errors name it.
    pub name: String,
    /// Its own space; finite, within ±10⁹.
    pub positions: Vec<Vec3>,
    /// Corners, counter-clockwise seen from outside; each below `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals by vertex, unit; none: flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates by vertex; none: (0, 0).
    pub uvs: Vec<Vec2>,
}

/// Greatest coordinate of a vertex, as of every point of a scene.
const FARTHEST: f32 = 1e9;

/// What a mesh of a file may not be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A coordinate that is not finite or too large.
    #[error("vertex {vertex} is at ({x}, {y}, {z}); coordinates are finite numbers within ±1e9")]
    Position {
        /// Index from 0.
        vertex: usize,
        /// As read.
        x: f32,
        /// As read.
        y: f32,
        /// As read.
        z: f32,
    },
    /// A corner that is no vertex.
    #[error(
        "triangle {triangle} has corner {corner}, and there are {vertices} vertices (counted from 0)"
    )]
    Corner {
        /// Index from 0.
        triangle: usize,
        /// As read.
        corner: u32,
        /// How many there are.
        vertices: usize,
    },
    /// Attributes that do not match the vertices.
    #[error("it has {count} {what} for {vertices} vertices; give one for each, or none")]
    Attributes {
        /// `normals` or `texture coordinates`.
        what: &'static str,
        /// How many.
        count: usize,
        /// How many there are.
        vertices: usize,
    },
    /// No triangle with an area.
    #[error("it has no triangle with an area; a mesh needs one at least")]
    Empty,
    /// More than an index can name.
    #[error("it has {count} {what}; at most 2^32 - 2 can be told apart: split the mesh")]
    TooMany {
        /// `vertices` or `triangles`.
        what: &'static str,
        /// How many.
        count: usize,
    },
}

impl Mesh {
    /// Checks what a loader read, takes out the triangles without an area, and says how many those were.
    ///
    /// Normals that are not finite or have no length are replaced by those of a triangle that has them as a corner.
    ///
    /// # Errors
    /// [`MeshError`] at the first thing that cannot be rendered.
    pub fn checked(mut self) -> Result<(Self, usize), MeshError> {
        let vertices = self.positions.len();
        for (count, what) in [(vertices, "vertices"), (self.triangles.len(), "triangles")] {
            if count >= u32::MAX as usize {
                return Err(MeshError::TooMany { what, count });
            }
        }
        let is_far = |c: f32| !c.is_finite() || c.abs() > FARTHEST;
        let wrong = |p: &&Vec3| p.to_array().into_iter().any(is_far);
        if let Some(vertex) = self.positions.iter().position(|p| wrong(&p)) {
            let Vec3 { x, y, z } = self.positions[vertex];
            return Err(MeshError::Position { vertex, x, y, z });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&corner) = corners.iter().find(|&&c| c as usize >= vertices) {
                return Err(MeshError::Corner {
                    triangle,
                    corner,
                    vertices,
                });
            }
        }
        for (count, what) in [
            (self.normals.len(), "normals"),
            (self.uvs.len(), "texture coordinates"),
        ] {
            if count != 0 && count != vertices {
                return Err(MeshError::Attributes {
                    what,
                    count,
                    vertices,
                });
            }
        }
        let before = self.triangles.len();
        let positions = &self.positions;
        self.triangles
            .retain(|corners| area_normal(positions, *corners).length_squared() > 0.0);
        if self.triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        self.mend_normals();
        for uv in &mut self.uvs {
            if !uv.is_finite() {
                *uv = Vec2::ZERO;
            }
        }
        let dropped = before - self.triangles.len();
        Ok((self, dropped))
    }

    fn mend_normals(&mut self) {
        let mut broken = false;
        for normal in &mut self.normals {
            let unit = normal.as_dvec3().normalize_or_zero().as_vec3();
            broken |= unit == Vec3::ZERO;
            *normal = unit;
        }
        if broken {
            for &corners in &self.triangles {
                for corner in corners {
                    let normal = &mut self.normals[corner as usize];
                    if *normal == Vec3::ZERO {
                        *normal = area_normal(&self.positions, corners)
                            .normalize_or_zero()
                            .as_vec3();
                    }
                }
            }
        }
    }

    /// Bytes it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
    }

    /// The box around its vertices: least and greatest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let grow = |(low, high): (Vec3, Vec3), point: &Vec3| (low.min(*point), high.max(*point));
        self.positions.iter().fold(empty, grow)
    }
}

/// Normal of a triangle, twice its area long.
fn area_normal(positions: &[Vec3], [a, b, c]: [u32; 3]) -> glam::DVec3 {
    let [a, b, c] = [a, b, c].map(|corner| positions[corner as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// The warning of a file whose triangles without an area were left out.
pub(super) fn without_area(file: &str, dropped: usize) -> Option<String> {
    (dropped > 0).then(|| {
        let triangles = if dropped == 1 {
            "triangle"
        } else {
            "triangles"
        };
        format!("{file}: {dropped} {triangles} without an area left out")
    })
}
