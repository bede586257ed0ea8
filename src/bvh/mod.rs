//! Floor 2: the tree of triangles. Instances over meshes, eight children a node, eight triangles a leaf.

use crate::lanes::{Batch, Queue, Vec3x8, WIDTH, f32x8, u32x8};
use crate::record;
use glam::{Affine3A, Vec3};

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

/// What can be traced: a batch with eight rays in it.
pub trait Rays: Batch {
    /// World space.
    fn origin(&self) -> &Vec3x8;
    /// World space; need not be unit.
    fn direction(&self) -> &Vec3x8;
    /// Nothing at this distance or nearer is met.
    fn nearest(&self) -> f32x8 {
        f32x8::ZERO
    }
}

/// A ray that only asks whether anything is between.
pub trait ShadowRays: Rays {
    /// Nothing at this distance or farther is met.
    fn farthest(&self) -> f32x8;
    /// Triangle (of instance 0) that casts no shadow, or [`NO_TRIANGLE`].
    fn ignored(&self) -> u32x8 {
        u32x8::splat(NO_TRIANGLE)
    }
}

/// One worker's memory while it traces. Nothing in it is shared.
#[derive(Clone, Debug, Default)]
pub struct Stacks;

/// A tree over instances of meshes.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    instances: Vec<(Affine3A, Vec<[Vec3; 3]>)>,
}

impl Bvh {
    /// Builds the tree.
    pub fn build(meshes: &[Triangles], instances: &[Instance], _quality: Quality) -> Self {
        let place = |instance: &Instance| {
            let mesh = &meshes[instance.mesh];
            let corners = mesh
                .corners
                .iter()
                .map(|t| t.map(|c| mesh.positions[c as usize]));
            (instance.to_world.inverse(), corners.collect())
        };
        Self {
            instances: instances.iter().map(place).collect(),
        }
    }

    /// Whether there is nothing to meet.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty()
    }

    /// Improves each ray's hit: `hits` holds a batch for each batch of rays, each lane with the distance beyond which
    /// nothing counts. Of two hits at one distance the one of the lower instance, then triangle, stays; one at the given
    /// distance itself does not count.
    pub fn closest<B: Rays>(&self, rays: &Queue<B>, hits: &mut [HitX8], _stacks: &mut Stacks) {
        for ((live, rays), hits) in rays.batches().zip(hits) {
            for lane in (0..WIDTH).filter(|lane| live.to_bitmask() >> lane & 1 == 1) {
                let mut best = hits.lane(lane);
                let (o, d) = (rays.origin().lane(lane), rays.direction().lane(lane));
                let nearest = rays.nearest().to_array()[lane];
                self.each_hit(o, d, &mut |t, triangle, instance| {
                    if t > nearest && t < best.distance {
                        best = Hit {
                            distance: t,
                            triangle,
                            instance,
                        };
                    }
                });
                hits.set_lane(lane, best);
            }
        }
    }

    /// For each batch of rays, a bit for each lane that meets something.
    pub fn occluded<B: ShadowRays>(
        &self,
        rays: &Queue<B>,
        occluded: &mut [u8],
        _stacks: &mut Stacks,
    ) {
        for ((live, rays), bits) in rays.batches().zip(occluded) {
            for lane in (0..WIDTH).filter(|lane| live.to_bitmask() >> lane & 1 == 1) {
                let (o, d) = (rays.origin().lane(lane), rays.direction().lane(lane));
                let nearest = rays.nearest().to_array()[lane];
                let farthest = rays.farthest().to_array()[lane];
                let ignored = rays.ignored().to_array()[lane];
                self.each_hit(o, d, &mut |t, triangle, instance| {
                    let own = instance == 0 && triangle == ignored;
                    if t > nearest && t < farthest && !own {
                        *bits |= 1 << lane;
                    }
                });
            }
        }
    }

    fn each_hit(&self, o: Vec3, d: Vec3, found: &mut dyn FnMut(f32, u32, u32)) {
        for (instance, (to_object, triangles)) in self.instances.iter().enumerate() {
            let (o, d) = (
                to_object.transform_point3(o).as_dvec3(),
                to_object.transform_vector3(d).as_dvec3(),
            );
            for (index, corners) in triangles.iter().enumerate() {
                let [a, b, c] = corners.map(|p| p.as_dvec3() - o);
                let (u, v, w) = (d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
                let inside =
                    (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
                let det = u + v + w;
                if inside && det != 0.0 {
                    let p = (a * u + b * v + c * w) / det;
                    let t = p.dot(d) / d.length_squared();
                    found(t as f32, index as u32, instance as u32);
                }
            }
        }
    }
}
