//! Where stages meet: the records that pass between them, and one worker's queues.

use super::tally::Tally;
use crate::film::AovSample;
use crate::lanes::{Queue, Rgb, WIDTH};
use crate::material::Kind;
use crate::record;
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

/// One worker's queues, and the sums of the wave it carries. Nothing in it is shared.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Rays of this edge.
    pub rays: Queue<PathRayX8>,
    /// Rays of the next edge.
    pub next_rays: Queue<PathRayX8>,
    /// Hits, by material kind.
    pub vertices: [Queue<VertexX8>; Kind::ALL.len()],
    /// Rays that found light by themselves.
    pub encounters: Queue<EncounterX8>,
    /// Rays to lights.
    pub shadow_rays: Queue<ShadowRayX8>,
    /// For each batch of shadow rays, a bit for each lane that reaches its light.
    pub visible: Vec<u8>,
    /// Radiance of each path of the wave; the fourth number is unused.
    pub radiance: Vec<[f32; 4]>,
    /// What each path's camera ray met, where asked for.
    pub first_hits: Vec<AovSample>,
    /// Seconds and counts.
    pub tally: Tally,
}

impl Workspace {
    /// Room for waves of up to `paths` paths through a scene with the given material kinds.
    pub fn new(paths: usize, kinds: &[Kind], first_hits: bool) -> Self {
        let room = |kind: &Kind| if kinds.contains(kind) { paths } else { 0 };
        Self {
            rays: Queue::with_capacity(paths),
            next_rays: Queue::with_capacity(paths),
            vertices: Kind::ALL.map(|kind| Queue::with_capacity(room(&kind))),
            encounters: Queue::with_capacity(paths),
            shadow_rays: Queue::with_capacity(paths),
            visible: Vec::with_capacity(paths.div_ceil(WIDTH)),
            // Whole batches: a dead lane too has a place to add its 0 to.
            radiance: vec![[0.0; 4]; paths.next_multiple_of(WIDTH)],
            first_hits: vec![AovSample::default(); if first_hits { paths } else { 0 }],
            tally: Tally::default(),
        }
    }

    /// Makes ready for a wave.
    pub fn start(&mut self, paths: usize) {
        self.tally.start();
        self.rays.clear();
        self.radiance[..paths].fill([0.0; 4]);
        self.first_hits.fill(AovSample::default());
    }

    /// The rays of the next edge become the rays of this one.
    pub fn swap_rays(&mut self) {
        std::mem::swap(&mut self.rays, &mut self.next_rays);
    }
}
