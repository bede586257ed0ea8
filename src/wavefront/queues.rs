//! Where stages meet: the records that pass between them, and one worker's queues.

use super::tally::Tally;
use crate::bvh::{HitX8, Rays, ShadowRays, Stacks};
use crate::film::{AovSample, AovSet};
use crate::lanes::{Batch, Queue, Rgb, Table, Vec3x8, WIDTH, f32x8, u32x8};
use crate::material::{Bsdf, Kind, ModulationX8};
use crate::record;
use crate::scene::Scene;
use crate::scene::meshes::TRIANGLE;
use glam::Vec3;

/// Batches that a kernel takes through each of its steps before the next step: the roots and quotients of one wait while
/// those of the next begin.
pub const GROUP: usize = 4;

record! {
    /// A path on its way to its next vertex.
    pub struct PathRay, PathRayX8 {
        /// World space, already off the surface.
        origin: Vec3,
        /// Unit, world space.
        direction: Vec3,
        /// Product of BSDF × cosine ÷ density so far.
        throughput: Rgb,
        /// Density with which `direction` was drawn, per steradian; +∞ from the camera and from a specular material.
        pdf: f32,
        /// Its place in the wave: pixel of the tile × samples + sample.
        path: u32,
        /// Sampler state.
        key: u32,
        /// Sampler state.
        index: u32,
    }
}

record! {
    /// A hit that waits in its material kind's queue.
    pub struct Vertex, VertexX8 {
        /// World space.
        position: Vec3,
        /// Unit, back along the ray.
        wo: Vec3,
        /// Unit, outwards.
        normal: Vec3,
        /// How far off the surface rays start: a bound of the position's rounding error, scene units.
        offset: f32,
        /// Material id.
        material: u32,
        /// As in [`PathRay`].
        throughput: Rgb,
        /// As in [`PathRay`].
        path: u32,
        /// As in [`PathRay`].
        key: u32,
        /// As in [`PathRay`].
        index: u32,
    }
}

record! {
    /// A hit on a mesh, which waits there too.
    pub struct MeshVertex, MeshVertexX8 {
        /// With the shading normal.
        vertex: Vertex,
        /// Geometric normal: unit, outwards.
        ng: Vec3,
        /// What the material's textures multiply its colour by.
        color: Rgb,
        /// Its roughness likewise.
        roughness: f32,
        /// Its metallic likewise.
        metallic: f32,
    }
}

/// A vertex as shading kernels see it, on whatever it is.
pub trait Surface: Batch {
    /// Whether the shading normal may differ from the geometric one.
    const SMOOTH: bool;
    /// What every vertex has, with the shading normal.
    fn vertex(&self) -> &VertexX8;
    /// The geometric normal on the side of the shading normal `ns`.
    fn ng(&self, ns: Vec3x8) -> Vec3x8;
    /// Its material.
    fn bsdf<B: Bsdf>(&self, table: &Table) -> B;
}

impl Surface for VertexX8 {
    const SMOOTH: bool = false;
    #[inline]
    fn vertex(&self) -> &VertexX8 {
        self
    }
    #[inline]
    fn ng(&self, ns: Vec3x8) -> Vec3x8 {
        ns
    }
    #[inline]
    fn bsdf<B: Bsdf>(&self, table: &Table) -> B {
        B::load(table, self.material)
    }
}

impl Surface for MeshVertexX8 {
    const SMOOTH: bool = true;
    #[inline]
    fn vertex(&self) -> &VertexX8 {
        &self.vertex
    }
    #[inline]
    fn ng(&self, ns: Vec3x8) -> Vec3x8 {
        self.ng * f32x8::ONE.copysign(self.ng.dot(ns))
    }
    #[inline]
    fn bsdf<B: Bsdf>(&self, table: &Table) -> B {
        let maps = ModulationX8::new(self.color, self.metallic, self.roughness);
        B::load(table, self.vertex.material).modulate(&maps)
    }
}

record! {
    /// A ray that found light by itself.
    pub struct Encounter, EncounterX8 {
        /// World space.
        origin: Vec3,
        /// Unit, world space.
        direction: Vec3,
        /// To the light, scene units; +∞ for the sky.
        distance: f32,
        /// Light id; [`NONE`](crate::scene::NONE) for the sky.
        light: u32,
        /// The light's primitive.
        primitive: u32,
        /// As in [`PathRay`].
        throughput: Rgb,
        /// As in [`PathRay`].
        pdf: f32,
        /// As in [`PathRay`].
        path: u32,
    }
}

record! {
    /// A ray that found a mesh that emits.
    pub struct MeshEncounter, MeshEncounterX8 {
        /// As if it were on any light.
        encounter: Encounter,
        /// Geometric normal: unit, outwards.
        ng: Vec3,
        /// Texture coordinate.
        u: f32,
        /// Texture coordinate.
        v: f32,
    }
}

record! {
    /// The light of an encounter, term by term.
    pub struct Arrival, ArrivalX8 {
        /// Radiance that leaves the light towards the path.
        emitted: Rgb,
        /// Density with which light sampling would have drawn this point, per steradian, choice of the light included.
        light_pdf: f32,
        /// What the strategy gives to light that is met.
        weight: f32,
        /// Radiance that reaches the camera: throughput × emitted × weight.
        contribution: Rgb,
        /// As in [`PathRay`].
        path: u32,
    }
}

record! {
    /// A ray to a light, with what it carries if nothing is between.
    pub struct ShadowRay, ShadowRayX8 {
        /// World space, already off the surface.
        origin: Vec3,
        /// Unit, world space.
        direction: Vec3,
        /// To the light, scene units; +∞ for the sky.
        distance: f32,
        /// The light's primitive, which casts no shadow on its own light.
        target: u32,
        /// Radiance that reaches the camera.
        contribution: Rgb,
        /// As in [`PathRay`].
        path: u32,
    }
}

record! {
    /// A ray on its way through meshes with holes.
    pub struct CutoutRay, CutoutRayX8 {
        /// World space.
        origin: Vec3,
        /// World space.
        direction: Vec3,
        /// Of the last hole; nothing here or nearer is met.
        nearest: f32,
        /// Nothing here or farther is met.
        farthest: f32,
        /// Triangle of the world that is not met, or an id of none.
        ignored: u32,
        /// Its place in the queue it comes from: batch × 8 + lane.
        place: u32,
    }
}

/// Shadow rays end this much before their light, relative to its greatest coordinate: 64 units in the last place. What
/// touches the light there, such as the triangle next to it, casts no shadow on its point.
const SHADOW_END: f32 = 64.0 / 16_777_216.0;

impl Rays for PathRayX8 {
    fn origin(&self) -> &Vec3x8 {
        &self.origin
    }
    fn direction(&self) -> &Vec3x8 {
        &self.direction
    }
}

impl Rays for ShadowRayX8 {
    fn origin(&self) -> &Vec3x8 {
        &self.origin
    }
    fn direction(&self) -> &Vec3x8 {
        &self.direction
    }
}

impl ShadowRays for ShadowRayX8 {
    fn farthest(&self) -> f32x8 {
        self.distance.mul_add(
            f32x8::splat(1.0 - SHADOW_END),
            self.origin.max_abs() * -SHADOW_END,
        )
    }
    fn ignored(&self) -> u32x8 {
        self.target ^ u32x8::splat(TRIANGLE)
    }
}

impl Rays for CutoutRayX8 {
    fn origin(&self) -> &Vec3x8 {
        &self.origin
    }
    fn direction(&self) -> &Vec3x8 {
        &self.direction
    }
    fn nearest(&self) -> f32x8 {
        self.nearest
    }
}

/// What it takes to trace rays through meshes.
#[derive(Clone, Debug)]
pub struct Tracing {
    /// What each ray met: distance, and either a primitive's id as `triangle` and [`NONE`](crate::scene::NONE) as
    /// `instance`, or a triangle of a part.
    pub hits: Vec<HitX8>,
    /// For each batch of shadow rays, a bit for each lane that meets something.
    pub occluded: Vec<u8>,
    /// Rays on their way through holes, now and next.
    pub cutouts: [Queue<CutoutRayX8>; 2],
    /// What those met.
    pub cutout_hits: Vec<HitX8>,
    /// The trees' memory.
    pub stacks: Stacks,
}

impl Tracing {
    /// Room for `paths` rays; for none in holes where there are no holes.
    fn new(paths: usize, cutouts: bool) -> Self {
        let batches = paths.div_ceil(WIDTH);
        let in_holes = if cutouts { paths } else { 0 };
        Self {
            hits: Vec::with_capacity(batches),
            occluded: Vec::with_capacity(batches),
            cutouts: [
                Queue::with_capacity(in_holes),
                Queue::with_capacity(in_holes),
            ],
            cutout_hits: Vec::with_capacity(in_holes.div_ceil(WIDTH)),
            stacks: Default::default(),
        }
    }
}

/// One worker's queues, and the sums of the wave it carries. Nothing in it is shared.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Rays of this edge.
    pub rays: Queue<PathRayX8>,
    /// Rays of the next edge.
    pub next_rays: Queue<PathRayX8>,
    /// Hits, by material kind.
    pub vertices: [Queue<VertexX8>; Kind::ALL.len()],
    /// Hits on meshes, by material kind.
    pub mesh_vertices: [Queue<MeshVertexX8>; Kind::ALL.len()],
    /// Rays that found light by themselves.
    pub encounters: Queue<EncounterX8>,
    /// Those that found it on a mesh.
    pub mesh_encounters: Queue<MeshEncounterX8>,
    /// What it takes to trace rays through meshes.
    pub tracing: Tracing,
    /// Rays to lights.
    pub shadow_rays: Queue<ShadowRayX8>,
    /// For each batch of shadow rays, a bit for each lane that reaches its light.
    pub visible: Vec<u8>,
    /// Radiance of each path of the wave; the fourth number is unused.
    pub radiance: Vec<[f32; 4]>,
    /// The part of it that came on paths of 1 edge, of 2 and so on, where asked for.
    pub by_length: Vec<Vec<[f32; 4]>>,
    /// What each path's camera ray met, where asked for.
    pub first_hits: Vec<AovSample>,
    /// Seconds and counts.
    pub tally: Tally,
}

impl Workspace {
    /// Room for waves of up to `paths` paths through a scene.
    pub fn new(paths: usize, scene: &Scene, aovs: AovSet) -> Self {
        let room = |needed: bool| if needed { paths } else { 0 };
        let meshes = scene.meshes.as_ref();
        let on_meshes = |kind: Kind| meshes.is_some_and(|meshes| meshes.kinds.contains(&kind));
        let cutouts = meshes.is_some_and(|meshes| !meshes.masked.tree.is_empty());
        // Whole batches: a dead lane too has a place to add its 0 to.
        let radiance = vec![[0.0; 4]; paths.next_multiple_of(WIDTH)];
        Self {
            rays: Queue::with_capacity(paths),
            next_rays: Queue::with_capacity(paths),
            vertices: Kind::ALL.map(|kind| Queue::with_capacity(room(scene.kinds.contains(&kind)))),
            mesh_vertices: Kind::ALL.map(|kind| Queue::with_capacity(room(on_meshes(kind)))),
            encounters: Queue::with_capacity(paths),
            mesh_encounters: Queue::with_capacity(room(meshes.is_some_and(|meshes| meshes.emits))),
            tracing: Tracing::new(room(meshes.is_some()), cutouts),
            shadow_rays: Queue::with_capacity(paths),
            visible: Vec::with_capacity(paths.div_ceil(WIDTH)),
            by_length: vec![radiance.clone(); aovs.lengths as usize],
            radiance,
            first_hits: vec![AovSample::default(); room(aovs.has_first_hits())],
            tally: Tally::default(),
        }
    }

    /// Makes ready for a wave.
    pub fn start(&mut self, paths: usize) {
        self.tally.start();
        self.rays.clear();
        for radiance in std::iter::once(&mut self.radiance).chain(&mut self.by_length) {
            radiance[..paths].fill([0.0; 4]);
        }
        self.first_hits.fill(AovSample::default());
    }

    /// The rays of the next edge become the rays of this one.
    pub fn swap_rays(&mut self) {
        std::mem::swap(&mut self.rays, &mut self.next_rays);
    }
}
