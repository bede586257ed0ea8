//! Floor 2: the tree of triangles. Instances over meshes, eight children a node, eight triangles a leaf.

mod bins;
mod build;
mod bundle;
mod cells;
mod item;
mod node;
mod packet;
mod prefetch;
mod ray;
mod ready;
mod slot;
mod split;
mod stream;
mod triangle;
mod validate;

use crate::lanes::{Batch, Queue, WIDTH, u32x8};
use crate::record;
use build::Plan;
use bundle::{Bundle, Extent};
use glam::{Affine3A, Vec3};
use item::Item;
use node::{Block, Bounds, Link, Node};
use packet::Met;
pub use ray::{Ray, RayX8, Rays, ShadowRays};
use rayon::prelude::*;
pub use stream::Stacks;
use triangle::ShearX8;
pub use validate::Census;

/// The id of no triangle and of no instance.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// The triangles of a mesh, its own space.
#[derive(Clone, Copy, Debug)]
pub struct Triangles<'a> {
    /// Finite.
    pub positions: &'a [Vec3],
    /// Each corner below `positions.len()`.
    pub corners: &'a [[u32; 3]],
}

impl Triangles<'_> {
    /// The corners of a triangle.
    #[inline]
    fn corners_of(&self, triangle: usize) -> [Vec3; 3] {
        self.corners[triangle].map(|corner| self.positions[corner as usize])
    }
}

/// A mesh at a place.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Index into the meshes.
    pub mesh: usize,
    /// From the mesh's space to the world; invertible.
    pub to_world: Affine3A,
}

/// How long to think about a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Binned surface area heuristic.
    #[default]
    Fast,
    /// With spatial splits too: slower to build, faster to trace where triangles are long.
    Best,
}

record! {
    /// The nearest thing that a ray met.
    pub struct Hit, HitX8 {
        /// Along the ray's direction, in units of its length; as given where nothing nearer was met.
        distance: f32,
        /// Index in its mesh, or as given.
        triangle: u32,
        /// Index of the instance, or as given.
        instance: u32,
    }
}

/// A tree over instances of meshes.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    places: Vec<Place>,
    root: Option<Root>,
    /// Whether it does not fit into a core's cache.
    is_large: bool,
    /// Whether a single mesh has so few triangles that no tree is needed.
    is_few: bool,
}

/// Where all rays begin.
#[derive(Clone, Copy, Debug)]
struct Root {
    link: Link,
    /// The greatest coordinate of what is below.
    reach: f32,
}

/// A placed mesh, as the upper tree's leaves have it.
#[derive(Clone, Debug)]
struct Place {
    to_object: Affine3A,
    root: Link,
    instance: u32,
    /// The greatest coordinate of the mesh, its own space.
    reach: f32,
}

/// The least edge of a triangle that is tested without a box around it, relative to the distance it is seen from: 64 rounding
/// errors of a corner, twice.
const LEAST_EDGE: f32 = 64.0 * f32::EPSILON;

/// Up to so many blocks, each ray tests every triangle.
const FEW: usize = 8;

/// How far apart the slopes of a packet's rays may be.
const SPREAD: f32 = 0.125;

/// How far apart, relative to the tree's reach, the origins of rays may be that are sorted by direction.
const APART: f32 = 0.125;

/// A tree this large, in bytes, is not in a core's cache whenever it is needed.
const LARGE: usize = 1 << 19;

impl Bvh {
    /// Builds the tree on the threads of the current rayon pool.
    pub fn build(meshes: &[Triangles], instances: &[Instance], quality: Quality) -> Self {
        let mut bvh = Self::default();
        let roots: Vec<_> = meshes
            .iter()
            .map(|mesh| bvh.add_mesh(mesh, quality))
            .collect();
        if let [Instance { mesh, to_world }] = instances
            && *to_world == Affine3A::IDENTITY
        {
            bvh.finish(roots[*mesh]);
            bvh.is_few = meshes.len() == 1 && bvh.blocks.len() <= FEW && bvh.has_large_triangles();
            return bvh;
        }
        let mut items = Vec::with_capacity(instances.len());
        for (number, instance) in instances.iter().enumerate() {
            let Some((bounds, root)) = roots[instance.mesh] else {
                continue;
            };
            items.push(Item::new(
                bounds.placed(&instance.to_world),
                bvh.places.len() as u32,
            ));
            bvh.places.push(Place {
                to_object: instance.to_world.inverse(),
                root,
                instance: number as u32,
                reach: bounds.reach(),
            });
        }
        let tree = build::build(
            &mut items,
            Plan {
                leaf: 1,
                kind: Link::INSTANCE,
                first_leaf: 0,
            },
            &mut bvh.nodes,
        );
        // A leaf of the upper tree is one instance: the places follow the leaves' order.
        let order = tree.leaves.iter();
        bvh.places = order
            .map(|&(first, _)| bvh.places[items[first as usize].number() as usize].clone())
            .collect();
        bvh.finish(tree.root);
        bvh
    }

    /// Whether no triangle is so small, beside the whole, that its edges are lost in the rounding errors of corners seen from
    /// afar: such a triangle may seem to be met by a ray that passes at a distance, and a tree's boxes keep it away.
    fn has_large_triangles(&self) -> bool {
        let Some(root) = &self.root else { return false };
        let least = LEAST_EDGE * (1.0 + ready::FAR) * root.reach;
        let edges = |corners: [Vec3; 3]| {
            let [a, b, c] = corners;
            [a.distance(b), b.distance(c), c.distance(a)]
        };
        self.blocks.iter().all(|block| {
            let each = (0..block.len()).flat_map(|lane| edges(block.corners_of(lane)));
            each.into_iter().all(|edge| edge > least)
        })
    }

    fn finish(&mut self, root: Option<(Bounds, Link)>) {
        self.root = root.map(|(bounds, link)| Root {
            link,
            reach: bounds.reach(),
        });
        let (nodes, blocks) = self.bytes();
        self.is_large = nodes + blocks > LARGE;
    }

    /// Adds a mesh's tree; its box and root, where it has triangles.
    fn add_mesh(&mut self, mesh: &Triangles, quality: Quality) -> Option<(Bounds, Link)> {
        let mut items = match quality {
            Quality::Fast => split::whole(mesh),
            Quality::Best => split::pieces(mesh),
        };
        let tree = build::build(
            &mut items,
            Plan {
                leaf: WIDTH,
                kind: Link::BLOCK,
                first_leaf: self.blocks.len(),
            },
            &mut self.nodes,
        );
        self.blocks
            .par_extend(tree.leaves.par_iter().map(|&(first, count)| {
                let (first, count) = (first as usize, count as usize);
                let mut triangles = [NO_TRIANGLE; WIDTH];
                let triangles = &mut triangles[..count];
                for (triangle, piece) in triangles.iter_mut().zip(&items[first..]) {
                    *triangle = piece.number();
                }
                triangles.sort_unstable();
                let mut block = Block::empty();
                // Pieces of one triangle are met as one.
                for (lane, same) in triangles.chunk_by(u32::eq).enumerate() {
                    block.set(lane, mesh.corners_of(same[0] as usize), same[0]);
                }
                block
            }));
        tree.root
    }

    /// Whether there is nothing to meet.
    pub fn is_empty(&self) -> bool {
        self.root.is_none()
    }

    /// Bytes of the nodes and of the triangles.
    pub fn bytes(&self) -> (usize, usize) {
        (
            size_of_val(&self.nodes[..]) + size_of_val(&self.places[..]),
            size_of_val(&self.blocks[..]),
        )
    }

    /// Improves each ray's hit: `hits` holds a batch for each batch of rays, each lane with the distance beyond which
    /// nothing counts. Of two hits at one distance the one of the lower instance, then triangle, stays; one at the given
    /// distance itself does not count.
    pub fn closest<B: Rays>(&self, rays: &Queue<B>, hits: &mut [HitX8], stacks: &mut Stacks) {
        let hits = std::cell::RefCell::new(hits);
        self.trace::<false>(
            rays.len(),
            stacks,
            |index| {
                RayX8::of(
                    rays.batch(index),
                    hits.borrow()[index].distance,
                    u32x8::splat(NO_TRIANGLE),
                )
            },
            |index, met| {
                let hit = &mut hits.borrow_mut()[index];
                hit.distance = met.found.select(met.distance, hit.distance);
                hit.triangle = met.found.select(met.triangle, hit.triangle);
                hit.instance = met.found.select(u32x8::ZERO, hit.instance);
            },
            |number, hit| {
                if let Some(hit) = hit {
                    hits.borrow_mut()[number / WIDTH].set_lane(number % WIDTH, hit);
                }
            },
        );
    }

    /// For each batch of rays, a bit for each lane that meets something.
    pub fn occluded<B: ShadowRays>(
        &self,
        rays: &Queue<B>,
        occluded: &mut [u8],
        stacks: &mut Stacks,
    ) {
        let occluded = std::cell::RefCell::new(occluded);
        self.trace::<true>(
            rays.len(),
            stacks,
            |index| {
                let batch = rays.batch(index);
                RayX8::of(batch, batch.farthest(), batch.ignored())
            },
            |index, met| occluded.borrow_mut()[index] |= met.found.to_bitmask() as u8,
            |number, hit| {
                let bit = u8::from(hit.is_some()) << (number % WIDTH);
                occluded.borrow_mut()[number / WIDTH] |= bit;
            },
        );
    }

    /// Traces `count` rays, a batch of which `rays` gives: what keeps together as packets, the others as a stream.
    #[inline(always)]
    fn trace<const ANY: bool>(
        &self,
        count: usize,
        stacks: &mut Stacks,
        rays: impl Fn(usize) -> RayX8,
        mut packet_done: impl FnMut(usize, &Met),
        mut ray_done: impl FnMut(usize, Option<Hit>),
    ) {
        let Some(root) = &self.root else { return };
        let Stacks {
            slots,
            packet: stack,
            cells,
            loose,
        } = stacks;
        loose.clear();
        let spread = if self.is_few { f32::INFINITY } else { SPREAD };
        let keeps_together = |extent: &Extent| extent.keeps_together(root.reach, spread);
        let mut index = 0;
        // An upper tree would need packets that turn to other spaces.
        let whole = if self.places.is_empty() {
            count / WIDTH
        } else {
            0
        };
        while index < whole {
            let batch = rays(index);
            let shear = ShearX8::new(&batch.origin, &batch.direction);
            let extent = Extent::of(&batch, &shear);
            let axis = shear.common_axis().filter(|_| keeps_together(&extent));
            // The first batch of two speaks for the second: where it does not keep together by itself, two do not.
            if axis.is_some() && index + 1 < whole {
                let next = rays(index + 1);
                let shears = [shear, ShearX8::new(&next.origin, &next.direction)];
                if shears[1].common_axis() == axis
                    && let two = extent.union(&Extent::of(&next, &shears[1]))
                    && keeps_together(&two)
                    && let Some(bundle) = Bundle::new(&two, &shear)
                {
                    let two = [batch, next];
                    let met = self.trace_packet::<ANY, 2>(&bundle, &two, &shears, root, stack);
                    packet_done(index, &met[0]);
                    packet_done(index + 1, &met[1]);
                    index += 2;
                    continue;
                }
            }
            if axis.is_some()
                && let Some(bundle) = Bundle::new(&extent, &shear)
            {
                let [met] = self.trace_packet::<ANY, 1>(&bundle, &[batch], &[shear], root, stack);
                packet_done(index, &met);
            } else if !self.is_few || !batch.begins_near(root.reach) {
                loose.push(index as u32);
            } else if extent.begins_together(APART * root.reach) {
                cells.add(&batch, &shear, index * WIDTH, |cell| {
                    cell.trace::<ANY>(self, root, stack, &mut ray_done);
                });
            } else {
                packet_done(index, &self.trace_few::<ANY>(&batch, &shear));
            }
            index += 1;
        }
        cells.flush(|cell| cell.trace::<ANY>(self, root, stack, &mut ray_done));
        loose.extend(index as u32..count.div_ceil(WIDTH) as u32);
        self.stream::<ANY>(root, count, loose, slots, rays, ray_done);
    }
}
