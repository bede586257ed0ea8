//! Stage 5: light reaches its paths. A path's contributions arrive in the order of its edges, whatever the wave.

use super::Context;
use super::queues::{ArrivalX8, EncounterX8, MeshEncounterX8, ShadowRayX8, Surface, VertexX8};
use crate::lanes::{Queue, Rgbx8, f32x8, u32x8};
use crate::sampling::mis;
use crate::scene::NONE;
use crate::scene::description::Strategy;
use wide::f32x4;

/// Adds the light that rays met by themselves.
#[inline(never)]
pub fn encounters(ctx: &Context, encounters: &Queue<EncounterX8>, radiance: &mut [[f32; 4]]) {
    for (live, encounter) in encounters.batches() {
        let light = arrival(ctx, encounter).contribution;
        add(live, encounter.path, light, radiance);
    }
}

/// Adds the light that rays met by themselves on meshes.
#[inline(never)]
pub fn mesh_encounters(
    ctx: &Context,
    encounters: &Queue<MeshEncounterX8>,
    radiance: &mut [[f32; 4]],
) {
    for (live, met) in encounters.batches() {
        let light = mesh_arrival(ctx, met).contribution;
        add(live, met.encounter.path, light, radiance);
    }
}

/// Adds what a function of the vertex says that each hit sends back.
#[inline]
pub fn shaded<V: Surface>(
    vertices: &Queue<V>,
    shade: impl Fn(&VertexX8) -> Rgbx8,
    radiance: &mut [[f32; 4]],
) {
    for (live, surface) in vertices.batches() {
        let vertex = surface.vertex();
        let light = vertex.throughput * shade(vertex);
        add(live, vertex.path, light, radiance);
    }
}

/// The last edge: what the ray heads for counts if nothing is between.
#[inline(never)]
pub fn shadowed(
    ctx: &Context,
    encounters: &Queue<EncounterX8>,
    shadow_rays: &mut Queue<ShadowRayX8>,
) {
    for (live, encounter) in encounters.batches() {
        let contribution = arrival(ctx, encounter).contribution;
        shadow_rays.push(
            live & contribution.max_magnitude().simd_gt(f32x8::ZERO),
            &ShadowRayX8 {
                origin: encounter.origin,
                direction: encounter.direction,
                distance: encounter.distance,
                target: encounter.primitive,
                contribution,
                path: encounter.path,
            },
        );
    }
}

/// Adds the light of the shadow rays that reached their lights.
#[inline(never)]
pub fn visible(shadow_rays: &Queue<ShadowRayX8>, visible: &[u8], radiance: &mut [[f32; 4]]) {
    for ((_, ray), &bits) in shadow_rays.batches().zip(visible) {
        let bits = u32x8::splat(u32::from(bits));
        let lanes = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
        let lit = f32x8::from_bits((bits & lanes).simd_ne(u32x8::ZERO));
        add(lit, ray.path, ray.contribution, radiance);
    }
}

/// The light that rays met by themselves, term by term.
#[inline]
pub fn arrival(ctx: &Context, encounter: &EncounterX8) -> ArrivalX8 {
    let scene = ctx.scene;
    let (mut emitted, mut light_pdf) = scene.lights.emitted(
        encounter.light,
        encounter.origin,
        encounter.direction,
        encounter.distance,
    );
    if let Some(sky) = &scene.sky {
        let is_sky = f32x8::from_bits(encounter.light.simd_eq(u32x8::splat(NONE)));
        if is_sky.any() {
            let (radiance, pdf) = scene.lights.sky(sky, encounter.direction);
            emitted = Rgbx8::select(is_sky, radiance, emitted);
            light_pdf = is_sky.select(pdf, light_pdf);
        }
    }
    weighed(ctx, encounter, emitted, light_pdf)
}

/// The same, met on meshes.
#[inline]
pub fn mesh_arrival(ctx: &Context, met: &MeshEncounterX8) -> ArrivalX8 {
    let encounter = &met.encounter;
    let (emitted, light_pdf) = ctx.scene.lights.emitted_by_mesh(
        encounter.light,
        encounter.direction,
        encounter.distance,
        met.ng,
        (met.u, met.v),
    );
    weighed(ctx, encounter, emitted, light_pdf)
}

/// What reaches the camera of light that next-event estimation finds with a given density.
#[inline(always)]
fn weighed(ctx: &Context, encounter: &EncounterX8, emitted: Rgbx8, light_pdf: f32x8) -> ArrivalX8 {
    let weight = match ctx.strategy {
        Strategy::Uniform | Strategy::Cosine => f32x8::ONE,
        // Light sampling could not have found it from the camera or a specular vertex.
        Strategy::Light => f32x8::ONE & encounter.pdf.simd_eq(f32x8::splat(f32::INFINITY)),
        // 0 for a discrete choice, whose density is +∞.
        Strategy::Mis => mis::power_heuristic(light_pdf / encounter.pdf),
    };
    ArrivalX8 {
        emitted,
        light_pdf,
        weight,
        contribution: encounter.throughput * emitted * weight,
        path: encounter.path,
    }
}

/// Adds each lane that is on to its path. The others add 0 to whatever path they hold, which changes no bit of it.
#[inline]
fn add(mask: f32x8, path: u32x8, light: Rgbx8, radiance: &mut [[f32; 4]]) {
    let Rgbx8 { r, g, b } = light.masked(mask);
    let none = f32x8::ZERO;
    let rows = f32x8::transpose([r, g, b, none, none, none, none, none]);
    for (path, row) in path.to_array().into_iter().zip(rows) {
        let [r, g, b, ..] = row.to_array();
        let sum = &mut radiance[path as usize];
        *sum = (f32x4::new(*sum) + f32x4::new([r, g, b, 0.0])).to_array();
    }
}
