//! Mesh primitives: triangles, strips and fans become one [`Mesh`] each, which all nodes share.

use super::Reader;
use super::file::AGAIN;
use super::material::Surface;
use crate::error::Result;
use crate::scene::mesh::{Mesh, MeshError};
use crate::scene::toml::names::quoted;
use glam::{Vec2, Vec3};
use gltf::mesh::{Mode, Semantic};
use std::sync::Arc;

/// A primitive that can be rendered.
#[derive(Clone, Copy)]
pub(super) struct Part {
    /// Index into the description's meshes.
    pub(super) mesh: usize,
    pub(super) surface: Surface,
    /// Bounds, the mesh's space.
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl<'a> Reader<'a> {
    /// The primitives of a mesh, read when the first node needs them.
    pub(super) fn parts(&mut self, mesh: &gltf::Mesh<'a>) -> Result<Vec<Part>> {
        if let Some(parts) = self.parts.get(&mesh.index()) {
            return Ok(parts.clone());
        }
        let mut parts = Vec::new();
        for primitive in mesh.primitives() {
            let place = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            let surface = self.surface(&primitive.material())?;
            let Some(read) = self.primitive(&primitive, surface.uv_set, &place)? else {
                continue;
            };
            let name = match mesh.name() {
                Some(name) => format!("{place} {}", quoted(name)),
                None => place,
            };
            let (low, high) = read.bounds();
            parts.push(Part {
                mesh: self.description.meshes.len(),
                surface,
                low,
                high,
            });
            self.description
                .meshes
                .push(Arc::new(Mesh { name, ..read }));
        }
        self.parts.insert(mesh.index(), parts.clone());
        Ok(parts)
    }

    /// The triangles of a primitive; none where it has none.
    fn primitive(
        &mut self,
        primitive: &gltf::Primitive,
        uv_set: u32,
        place: &str,
    ) -> Result<Option<Mesh>> {
        if primitive.morph_targets().len() > 0 {
            self.notes.tell(place, "morph targets are left out");
        }
        let mode = primitive.mode();
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            self.notes.tell(place, "points and lines are left out");
            return Ok(None);
        }
        let file = self.file;
        let at = |name: &str| format!("{place}.attributes.{name}");
        let attribute = |semantic| primitive.get(&semantic);
        let Some(positions) = attribute(Semantic::Positions) else {
            let message = format!("it is missing, so there are no vertices; {AGAIN}");
            return Err(file.error(at("POSITION"), message));
        };
        let positions = file.vectors(&positions, &at("POSITION"))?;
        let corners = match primitive.indices() {
            Some(indices) => file.indices(&indices, &format!("{place}.indices"))?,
            None => (0..=u32::MAX).take(positions.len()).collect(),
        };
        let normals = attribute(Semantic::Normals)
            .map(|accessor| file.vectors(&accessor, &at("NORMAL")))
            .transpose()?
            .unwrap_or_default();
        let uvs = attribute(Semantic::TexCoords(uv_set))
            .map(|accessor| file.vectors(&accessor, &at(&format!("TEXCOORD_{uv_set}"))))
            .transpose()?
            .unwrap_or_default();
        let mesh = Mesh {
            name: String::new(),
            positions: positions.into_iter().map(Vec3::from).collect(),
            triangles: triangles(mode, &corners),
            normals: normals.into_iter().map(Vec3::from).collect(),
            uvs: uvs.into_iter().map(Vec2::from).collect(),
        };
        match mesh.checked() {
            Ok((mesh, flat)) => {
                self.flat += flat;
                Ok(Some(without_unused(mesh)))
            }
            Err(MeshError::Empty) => {
                self.notes
                    .tell(place, "primitives without an area are left out");
                Ok(None)
            }
            Err(error) => Err(file.error(place, format!("{error}; {AGAIN}"))),
        }
    }
}

/// The triangles of corners in a row (glTF 2.0, sec. 3.7.2.1). Corners that are left over make none.
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let of_row = |(index, row): (usize, &[u32])| match mode {
        Mode::TriangleFan => [row[1], row[2], corners[0]],
        // The front of every other triangle of a strip is turned.
        _ if index % 2 == 1 => [row[0], row[2], row[1]],
        _ => [row[0], row[1], row[2]],
    };
    match mode {
        Mode::Triangles => corners.as_chunks().0.to_vec(),
        _ => corners.windows(3).enumerate().map(of_row).collect(),
    }
}

/// Primitives often share the vertices of a whole model: each keeps those that its triangles use.
fn without_unused(mesh: Mesh) -> Mesh {
    const UNUSED: u32 = u32::MAX;
    let mut new = vec![UNUSED; mesh.positions.len()];
    let mut kept = Vec::new();
    for &corner in mesh.triangles.as_flattened() {
        let slot = &mut new[corner as usize];
        if *slot == UNUSED {
            *slot = 0;
            kept.push(corner as usize);
        }
    }
    if kept.len() == mesh.positions.len() {
        return mesh;
    }
    // In their order, so that neighbours stay neighbours.
    kept.sort_unstable();
    for (index, &old) in (0..).zip(&kept) {
        new[old] = index;
    }
    let pick = |from: &[Vec3]| {
        kept.iter()
            .filter_map(|&old| from.get(old).copied())
            .collect()
    };
    Mesh {
        positions: pick(&mesh.positions),
        normals: pick(&mesh.normals),
        uvs: kept
            .iter()
            .filter_map(|&old| mesh.uvs.get(old).copied())
            .collect(),
        triangles: mesh
            .triangles
            .iter()
            .map(|corners| corners.map(|c| new[c as usize]))
            .collect(),
        name: mesh.name,
    }
}
