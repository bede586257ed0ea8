//! The trees of a scene's meshes. Scenes of the same meshes in the same places share them, whatever these are made of.

use super::mesh::Mesh;
use super::meshes::Placed;
use crate::bvh::{Bvh, Instance, Quality, Triangles};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Trees that were built; those of the last scenes are kept.
#[derive(Debug, Default)]
pub struct Trees(Vec<Grown>);

/// How many are kept: two for each of the last two scenes.
const KEPT: usize = 4;

/// A tree, and what it was built of.
#[derive(Clone, Debug)]
pub(super) struct Grown {
    pub tree: Arc<Bvh>,
    /// Lowest and highest corner of the box around it, world space; of nothing, infinities.
    pub bounds: (Vec3, Vec3),
    quality: Quality,
    /// Those in the world, then instances.
    parts: Vec<(Arc<Mesh>, Affine3A)>,
    in_world: usize,
}

impl Trees {
    /// The tree of meshes in the world and of instances.
    pub(super) fn get(
        &mut self,
        sources: &[Arc<Mesh>],
        world: &[Placed],
        placed: &[Placed],
        quality: Quality,
    ) -> Grown {
        let parts: Vec<_> = world
            .iter()
            .chain(placed)
            .map(|part| (sources[part.mesh].clone(), part.to_world))
            .collect();
        let same = |(mesh, at): &(Arc<Mesh>, Affine3A), (other, there): &(Arc<Mesh>, Affine3A)| {
            Arc::ptr_eq(mesh, other) && at == there
        };
        let found = self.0.iter().position(|grown| {
            grown.quality == quality
                && grown.in_world == world.len()
                && grown.parts.len() == parts.len()
                && grown.parts.iter().zip(&parts).all(|(a, b)| same(a, b))
        });
        let grown = match found {
            Some(place) => self.0.remove(place),
            None => {
                let (tree, bounds) = build(sources, world, placed, quality);
                Grown {
                    tree: Arc::new(tree),
                    bounds,
                    quality,
                    parts,
                    in_world: world.len(),
                }
            }
        };
        self.0.push(grown.clone());
        if self.0.len() > KEPT {
            self.0.remove(0);
        }
        grown
    }
}

/// The tree of meshes in the world and of instances, and the box around all.
fn build(
    sources: &[Arc<Mesh>],
    world: &[Placed],
    placed: &[Placed],
    quality: Quality,
) -> (Bvh, (Vec3, Vec3)) {
    let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let mut widen = |p: Vec3| bounds = (bounds.0.min(p), bounds.1.max(p));
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    let sum = |count: fn(&Mesh) -> usize| world.iter().map(|p| count(&sources[p.mesh])).sum();
    positions.reserve_exact(sum(|mesh| mesh.positions.len()));
    corners.reserve_exact(sum(|mesh| mesh.triangles.len()));
    for part in world {
        let mesh = &sources[part.mesh];
        let first = positions.len() as u32;
        let to_world = |&p: &Vec3| part.to_world.transform_point3(p);
        positions.extend(mesh.positions.iter().map(to_world));
        corners.extend(mesh.triangles.iter().map(|t| t.map(|c| first + c)));
    }
    positions.iter().for_each(|&p| widen(p));

    // The world is instance 0 even where it is empty: a light's triangles are known by their numbers in it.
    let mut meshes = vec![Triangles {
        positions: &positions,
        corners: &corners,
    }];
    let mut instances = vec![Instance {
        mesh: 0,
        to_world: Affine3A::IDENTITY,
    }];
    let mut known = HashMap::new();
    for part in placed {
        let &mut (mesh, corners) = known.entry(part.mesh).or_insert_with(|| {
            let mesh = &sources[part.mesh];
            meshes.push(Triangles {
                positions: &mesh.positions,
                corners: &mesh.triangles,
            });
            let low = mesh
                .positions
                .iter()
                .copied()
                .fold(Vec3::INFINITY, Vec3::min);
            let high = mesh
                .positions
                .iter()
                .copied()
                .fold(Vec3::NEG_INFINITY, Vec3::max);
            (meshes.len() - 1, box_corners((low, high)))
        });
        corners
            .iter()
            .for_each(|&p| widen(part.to_world.transform_point3(p)));
        instances.push(Instance {
            mesh,
            to_world: part.to_world,
        });
    }
    (Bvh::build(&meshes, &instances, quality), bounds)
}

/// The corners of a box.
pub(super) fn box_corners((low, high): (Vec3, Vec3)) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
        Vec3::new(
            pick(0, low.x, high.x),
            pick(1, low.y, high.y),
            pick(2, low.z, high.z),
        )
    })
}
