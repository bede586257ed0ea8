//! Meshes of a scene, placed: two trees to find them by, and what a hit looks up.
//!
//! A mesh that occurs once is put into the world, and so is one that emits; all of these together are one mesh of the tree
//! (its instance 0). What occurs more often is an instance. No mesh is kept twice: the tree has its own form of the
//! triangles, and a hit reads the mesh that the description holds.

use super::description::{Description, Maps, Shape};
use super::mesh::Mesh;
use super::trees::{Trees, box_corners};
use super::{NONE, Primitive};
use crate::bvh::{Bvh, HitX8, Quality};
use crate::lanes::{Row, Table, WIDTH, f32x8, u32x8};
use crate::material::Kind;
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Marks the id of a triangle among those of primitives.
pub const TRIANGLE: u32 = 1 << 31;

/// A mesh at a place of a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub mesh: usize,
    pub to_world: Affine3A,
    pub material: Option<usize>,
    pub light: Option<usize>,
}

/// The meshes of a scene.
#[derive(Clone, Debug)]
pub struct Meshes {
    /// What is there wherever it is met.
    pub opaque: Layer,
    /// What has holes: a hit counts only where [`Meshes::is_there`] says so.
    pub masked: Layer,
    /// The kinds of their materials, ascending.
    pub kinds: Vec<Kind>,
    /// Whether any of them emits.
    pub emits: bool,
    /// Corners of a box around all, world space.
    pub(super) corners: [Vec3; 8],
    /// A part is a mesh at a place: first and second axis, x and y of the third (8 numbers).
    pub(super) axes: Table,
    /// z of the third axis, translation (3), then as bits mesh, material, light, kind.
    pub(super) origins: Table,
    pub(super) sources: Vec<Arc<Mesh>>,
    /// Textures of the materials, if there are any.
    pub(super) maps: Option<super::maps::MapTable>,
    /// The first triangle of each part that is in the world, counted through both layers.
    firsts: Vec<u32>,
}

/// One tree, and how to read its hits.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// The tree.
    pub tree: Arc<Bvh>,
    /// Its instance 0 is of triangles in the world, be there any or none; the first of those, counted through both layers.
    first: u32,
    /// The part of its first other instance.
    first_part: u32,
}

/// Where a placed mesh goes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Cover {
    Opaque,
    Masked,
    /// Its alpha is nowhere enough.
    Nothing,
}

impl Cover {
    pub fn of(description: &Description, material: Option<usize>) -> Self {
        let maps = material.map(|id| &description.materials[id].maps);
        match maps.and_then(|maps| maps.alpha) {
            None => Cover::Opaque,
            Some(alpha) if alpha.texture.is_some() => Cover::Masked,
            Some(alpha) if alpha.factor >= alpha.cutoff => Cover::Opaque,
            Some(_) => Cover::Nothing,
        }
    }
}

/// Most vertices and triangles of the meshes in the world, so that ids fit.
const MOST_IN_WORLD: usize = (TRIANGLE - 1) as usize;

impl Meshes {
    /// Builds the trees; also gives, for each light of the description, the id of its first triangle, or [`NONE`].
    pub(super) fn compile(
        description: &Description,
        sources: Vec<Arc<Mesh>>,
        placed: Vec<Placed>,
        quality: Quality,
        trees: &mut Trees,
    ) -> (Option<Self>, Vec<u32>) {
        let mut light_ids = vec![NONE; description.lights.len()];
        let mut count: HashMap<usize, usize> = HashMap::new();
        for part in &placed {
            *count.entry(part.mesh).or_default() += 1;
        }
        // In the world or not, by layer.
        let mut groups: [[Vec<Placed>; 2]; 2] = Default::default();
        let mut in_world = 0;
        for part in placed {
            let layer = usize::from(Cover::of(description, part.material) == Cover::Masked);
            let mesh = &sources[part.mesh];
            let size = mesh.positions.len().max(mesh.triangles.len());
            let alone = part.light.is_some() || count[&part.mesh] == 1;
            let stays = alone && in_world + size <= MOST_IN_WORLD;
            if stays {
                in_world += size;
            }
            groups[layer][usize::from(!stays)].push(part);
        }

        let [[a, b], [c, d]] = &groups;
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let mut first = 0;
        let mut first_part = (a.len() + c.len()) as u32;
        let mut layers = [(a, b), (c, d)].into_iter().map(|(world, placed)| {
            let grown = trees.get(&sources, world, placed, quality);
            bounds = (bounds.0.min(grown.bounds.0), bounds.1.max(grown.bounds.1));
            let layer = Layer {
                tree: grown.tree,
                first,
                first_part,
            };
            first += triangles(&sources, world);
            first_part += placed.len() as u32;
            layer
        });
        let (opaque, masked) = (
            layers.next().unwrap_or_default(),
            layers.next().unwrap_or_default(),
        );
        drop(layers);

        let mut firsts = Vec::new();
        let mut next = 0;
        for part in a.iter().chain(c) {
            firsts.push(next);
            if let Some(light) = part.light {
                light_ids[light] = TRIANGLE | next;
            }
            next += sources[part.mesh].triangles.len() as u32;
        }
        let parts = || a.iter().chain(c).chain(b).chain(d);
        if parts().next().is_none() {
            return (None, light_ids);
        }
        let kind_of = |part: &Placed| {
            part.material
                .map(|id| description.materials[id].material.kind())
        };
        let mut kinds: Vec<Kind> = parts().filter_map(kind_of).collect();
        kinds.sort();
        kinds.dedup();
        let rows = |row: &dyn Fn(&Placed) -> Row| Table::new(parts().map(row).collect());
        let bits = |id: Option<usize>| f32::from_bits(id.map_or(NONE, |id| id as u32));
        let meshes = Self {
            axes: rows(&|part| {
                let m = part.to_world.matrix3;
                let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
                [x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y]
            }),
            origins: rows(&|part| {
                let (z, t) = (part.to_world.matrix3.z_axis, part.to_world.translation);
                let kind = kind_of(part).map(|kind| kind as usize);
                let (mesh, material) = (bits(Some(part.mesh)), bits(part.material));
                [
                    z.z,
                    t.x,
                    t.y,
                    t.z,
                    mesh,
                    material,
                    bits(part.light),
                    bits(kind),
                ]
            }),
            emits: parts().any(|part| part.light.is_some()),
            maps: super::maps::MapTable::of(description),
            corners: box_corners(bounds),
            opaque,
            masked,
            kinds,
            sources,
            firsts,
        };
        (Some(meshes), light_ids)
    }

    /// Makes hits of a layer's tree those of parts: `instance` becomes the part, `triangle` the index in its mesh, in the
    /// lanes of `met`.
    #[inline]
    pub fn resolve(&self, layer: &Layer, met: f32x8, hit: &mut HitX8) {
        let met = met.to_bitmask();
        for lane in (0..WIDTH).filter(|lane| met >> lane & 1 == 1) {
            let instance = hit.instance.as_array()[lane];
            let triangle = hit.triangle.as_array()[lane];
            let (part, triangle) = if instance == 0 {
                let triangle = layer.first + triangle;
                let part = self.firsts.partition_point(|&first| first <= triangle) - 1;
                (part as u32, triangle - self.firsts[part])
            } else {
                (layer.first_part + instance - 1, triangle)
            };
            hit.instance.as_mut_array()[lane] = part;
            hit.triangle.as_mut_array()[lane] = triangle;
        }
    }

    /// How many parts are in the world; the others are instances.
    pub(super) fn parts_in_world(&self) -> u32 {
        self.firsts.len() as u32
    }

    /// The id, among those of primitives, of triangles of parts in the world; of instances, a number that is no id.
    #[inline]
    pub fn primitive(&self, hit: &HitX8) -> u32x8 {
        let (parts, triangles) = (hit.instance.to_array(), hit.triangle.to_array());
        u32x8::new(std::array::from_fn(|lane| {
            let first = self.firsts.get(parts[lane] as usize);
            first.map_or(NONE, |first| TRIANGLE | first.wrapping_add(triangles[lane]))
        }))
    }
}

/// How many triangles there are in all.
fn triangles(sources: &[Arc<Mesh>], parts: &[Placed]) -> u32 {
    let count = |part: &Placed| sources[part.mesh].triangles.len() as u32;
    parts.iter().map(count).sum()
}

/// The meshes of a description and where they are; with those quads that need texture coordinates, without what is nothing
/// but hole.
pub(super) fn place(description: &Description) -> (Vec<Arc<Mesh>>, Vec<Placed>) {
    let mut sources = description.meshes.clone();
    let mut placed = Vec::new();
    for primitive in super::primitives(description) {
        let (shape, material, light) = primitive;
        let (mesh, to_world) = match shape {
            Shape::Mesh { mesh, transform } => (mesh, transform),
            Shape::Quad { corner, u, v } if is_textured(description, &primitive) => {
                sources.push(Arc::new(Mesh::of_quad(corner, u, v)));
                (sources.len() - 1, Affine3A::IDENTITY)
            }
            _ => continue,
        };
        let is_there = Cover::of(description, material) != Cover::Nothing;
        if is_there && !sources[mesh].triangles.is_empty() {
            placed.push(Placed {
                mesh,
                to_world,
                material,
                light,
            });
        }
    }
    (sources, placed)
}

/// Whether a shape is kept as a mesh: also a quad that needs texture coordinates.
pub(super) fn is_mesh(description: &Description, primitive: &Primitive) -> bool {
    match primitive.0 {
        Shape::Mesh { .. } => true,
        Shape::Quad { .. } => is_textured(description, primitive),
        Shape::Sphere { .. } => false,
    }
}

fn is_textured(description: &Description, &(_, material, light): &Primitive) -> bool {
    material.is_some_and(|id| description.materials[id].maps != Maps::default())
        || light.is_some_and(|id| description.lights[id].texture.is_some())
}
