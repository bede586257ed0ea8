//! Floor 4: the wave. [`trace`] is the whole path tracer on one page: iterative, one kernel a stage, compaction between.

pub mod accumulate;
pub mod generate;
pub mod intersect;
pub mod nee;
pub mod observe;
pub mod queues;
pub mod shade;
mod tally;

pub use queues::Workspace;
pub use tally::{EdgeTally, Stage, StageTally, Tally};

use crate::film::{AovSet, Region};
use crate::lanes::Rgbx8;
use crate::material::{Bsdf, Conductor, Glass, Kind, Lambert, Mirror, Phong, Principled};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::description::Strategy;
use crate::scene::sensor::Sensor;
use observe::{Observer, Step};
use queues::VertexX8;

/// What every stage reads and none writes.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where paths begin.
    pub sensor: Sensor<'a>,
    /// Whether [`Scene::encloses`] the origin of every first ray, and so every path.
    pub enclosed: bool,
    /// The random numbers.
    pub sampler: &'a Sampler,
    /// How light is looked for.
    pub strategy: Strategy,
    /// Greatest number of edges of a path.
    pub path_length: u32,
    /// First edge at which Russian roulette may end a path.
    pub roulette: Option<u32>,
    /// What is kept beside radiance.
    pub aovs: AovSet,
}

/// The paths that one worker carries at a time: a tile of pixels × a run of samples (for a film, within one block).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wave {
    /// Left column, image pixels.
    pub x: u32,
    /// Top row, image pixels.
    pub y: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// First sample.
    pub first_sample: u32,
    /// Samples of each pixel; for a film, at most [`BLOCK`](crate::film::BLOCK).
    pub samples: u32,
}

impl Wave {
    /// Paths in it.
    pub fn paths(&self) -> usize {
        self.tile().pixels() * self.samples as usize
    }

    /// Its pixels.
    pub fn tile(&self) -> Region {
        Region {
            x0: self.x,
            y0: self.y,
            x1: self.x + self.width,
            y1: self.y + self.height,
        }
    }
}

/// Traces a wave; afterwards the workspace holds the radiance of each path.
///
/// # Panics
/// When the wave has more paths than the workspace has room for.
pub fn trace(ctx: &Context, wave: &Wave, ws: &mut Workspace) {
    trace_observed(ctx, wave, ws, &mut ());
}

/// The same, while somebody looks on.
///
/// # Panics
/// As [`trace`].
pub fn trace_observed(
    ctx: &Context,
    wave: &Wave,
    ws: &mut Workspace,
    observer: &mut impl Observer,
) {
    ws.start(wave.paths());
    generate::rays(ctx, wave, &mut ws.rays);
    ws.tally.end(Stage::Generate, ws.rays.len());
    observer.see(ctx, 1, Step::Generated, ws);
    if ctx.aovs.has_first_hits() {
        match ctx.scene.meshes.as_ref() {
            Some(meshes) => intersect::meshes::first_hits(ctx, meshes, ws),
            None => intersect::first_hits(ctx.scene, &ws.rays, &mut ws.first_hits),
        }
    }

    let meshes = ctx.scene.meshes.as_ref();
    for edge in 1..=ctx.path_length {
        let alive = ws.rays.len();
        if alive == 0 {
            break;
        }
        ws.tally.begin(edge, alive);
        let last = edge == ctx.path_length && edge > 1;
        // On its last edge a path can but find light: no need to know what else it meets.
        let only_lights = last && !meshes.is_some_and(|meshes| meshes.emits);

        if only_lights {
            intersect::lights(ctx.scene, &ws.rays, &mut ws.encounters);
        } else {
            meet(ctx, last, ws);
        }
        ws.tally.end(Stage::Intersect, alive);
        observer.see(ctx, edge, Step::Met { only_lights }, ws);
        ws.next_rays.clear();
        ws.shadow_rays.clear();

        if only_lights {
            accumulate::shadowed(ctx, &ws.encounters, &mut ws.shadow_rays);
        } else {
            for sums in sums(&mut ws.radiance, &mut ws.by_length, edge) {
                accumulate::encounters(ctx, &ws.encounters, sums);
                accumulate::mesh_encounters(ctx, &ws.mesh_encounters, sums);
            }
        }
        let encounters = ws.encounters.len() + ws.mesh_encounters.len();
        ws.tally.end(Stage::Accumulate, encounters);
        observer.see(ctx, edge, Step::AddedEncounters, ws);

        if edge < ctx.path_length {
            for kind in Kind::ALL {
                match kind {
                    Kind::Lambert => scatter::<Lambert>(ctx, edge, ws),
                    Kind::Mirror => scatter::<Mirror>(ctx, edge, ws),
                    Kind::Glass => scatter::<Glass>(ctx, edge, ws),
                    Kind::Phong => scatter::<Phong>(ctx, edge, ws),
                    Kind::Conductor => scatter::<Conductor>(ctx, edge, ws),
                    Kind::Principled => scatter::<Principled>(ctx, edge, ws),
                }
            }
        }

        observer.see(ctx, edge, Step::Scattered, ws);
        let shadows = ws.shadow_rays.len();
        intersect::visible(ctx.scene, &ws.shadow_rays, &mut ws.visible);
        if let Some(meshes) = meshes {
            intersect::meshes::visible(meshes, &ws.shadow_rays, &mut ws.visible, &mut ws.tracing);
        }
        ws.tally.end(Stage::Intersect, shadows);
        let length = if only_lights { edge } else { edge + 1 };
        for sums in sums(&mut ws.radiance, &mut ws.by_length, length) {
            accumulate::visible(&ws.shadow_rays, &ws.visible, sums);
        }
        ws.tally.end(Stage::Accumulate, shadows);
        ws.tally.shadows(shadows);
        observer.see(ctx, edge, Step::AddedShadowRays, ws);
        ws.swap_rays();
    }
}

/// Traces the first edge of a wave alone: what rays meet has the radiance that `shade` says, and light that they meet by
/// themselves its own. Afterwards the workspace holds the radiance of each path.
///
/// # Panics
/// As [`trace`].
pub fn trace_first(
    ctx: &Context,
    wave: &Wave,
    ws: &mut Workspace,
    shade: impl Fn(&VertexX8) -> Rgbx8,
) {
    ws.start(wave.paths());
    generate::rays(ctx, wave, &mut ws.rays);
    let paths = ws.rays.len();
    ws.tally.end(Stage::Generate, paths);
    ws.tally.begin(1, paths);
    meet(ctx, false, ws);
    ws.tally.end(Stage::Intersect, paths);
    accumulate::encounters(ctx, &ws.encounters, &mut ws.radiance);
    accumulate::mesh_encounters(ctx, &ws.mesh_encounters, &mut ws.radiance);
    for kind in Kind::ALL {
        accumulate::shaded(&ws.vertices[kind as usize], &shade, &mut ws.radiance);
        accumulate::shaded(&ws.mesh_vertices[kind as usize], &shade, &mut ws.radiance);
    }
    ws.tally.end(Stage::Accumulate, paths);
}

/// What light on paths of `length` edges is added to: the radiance of all paths, and that of their length where it is kept.
fn sums<'a>(
    radiance: &'a mut [[f32; 4]],
    by_length: &'a mut [Vec<[f32; 4]>],
    length: u32,
) -> impl Iterator<Item = &'a mut [[f32; 4]]> {
    let of_length = by_length.get_mut(length as usize - 1);
    std::iter::once(radiance).chain(of_length.map(Vec::as_mut_slice))
}

/// What the rays meet: hits in the queues of their kinds, light in those of the encounters.
fn meet(ctx: &Context, last: bool, ws: &mut Workspace) {
    match ctx.scene.meshes.as_ref() {
        Some(meshes) => intersect::meshes::closest(ctx, meshes, last, ws),
        None => intersect::closest(
            ctx.scene,
            ctx.enclosed,
            &ws.rays,
            &mut ws.vertices,
            &mut ws.encounters,
        ),
    }
}

/// The two stages that work on the vertices of one material kind, those on shapes and those on meshes.
fn scatter<B: Bsdf>(ctx: &Context, edge: u32, ws: &mut Workspace) {
    let on_shapes = &ws.vertices[B::KIND as usize];
    let on_meshes = &ws.mesh_vertices[B::KIND as usize];
    let count = on_shapes.len() + on_meshes.len();
    if count == 0 {
        return;
    }
    if shade::continues::<B>(ctx, edge) {
        shade::shade::<B, _>(ctx, edge, on_shapes, &mut ws.next_rays);
        shade::shade::<B, _>(ctx, edge, on_meshes, &mut ws.next_rays);
        ws.tally.end(Stage::Shade, count);
    }
    if nee::samples_lights::<B>(ctx) {
        nee::sample_lights::<B, _>(ctx, edge, on_shapes, &mut ws.shadow_rays);
        nee::sample_lights::<B, _>(ctx, edge, on_meshes, &mut ws.shadow_rays);
        ws.tally.end(Stage::Nee, count);
    }
}
