//! Stage 4: next-event estimation. Each vertex that can draws a point of a light and sends a shadow ray to it.

use super::Context;
use super::queues::{GROUP, ShadowRayX8, Surface};
use crate::lanes::{Queue, Vec3x8, f32x8};
use crate::material::Bsdf;
use crate::sampling::{Dimension, mis};
use crate::scene::description::Strategy;
use crate::scene::light::LightSampleX8;

/// Whether vertices of this kind look for light sources at all.
pub fn samples_lights<B: Bsdf>(ctx: &Context) -> bool {
    let lights = &ctx.scene.lights;
    let is_dark = if samples_all(ctx) {
        lights.is_dark()
    } else {
        lights.punctual().is_dark()
    };
    !B::SPECULAR && !is_dark
}

/// Whether the strategy samples every light, or only those that no ray can meet.
fn samples_all(ctx: &Context) -> bool {
    matches!(ctx.strategy, Strategy::Light | Strategy::Mis)
}

/// Pushes a shadow ray for each vertex whose light sample could add light.
#[inline(never)]
pub fn sample_lights<B: Bsdf, V: Surface>(
    ctx: &Context,
    edge: u32,
    vertices: &Queue<V>,
    shadow_rays: &mut Queue<ShadowRayX8>,
) {
    let scene = ctx.scene;
    let samples_all = samples_all(ctx);
    for (live, vertices) in vertices.groups::<GROUP>() {
        let mut points = [(f32x8::ZERO, f32x8::ZERO); GROUP];
        for (point, vertex) in points.iter_mut().zip(vertices) {
            let path = vertex.vertex().path_key();
            *point = ctx.sampler.pair(path, Dimension::LightPoint, edge);
        }
        let mut lights = [LightSampleX8::default(); GROUP];
        for ((light, vertex), point) in lights.iter_mut().zip(vertices).zip(&points) {
            let path = vertex.vertex().path_key();
            let single = || ctx.sampler.single(path, Dimension::LightChoice, edge);
            let choice = || {
                if scene.lights.has_meshes() {
                    ctx.sampler.pair(path, Dimension::LightChoice, edge)
                } else {
                    (single(), f32x8::ZERO)
                }
            };
            let origin = light_origin::<B>(vertex);
            *light = if samples_all {
                let sky = scene.sky.as_ref();
                scene.lights.sample(sky, origin, choice, *point)
            } else {
                scene.lights.punctual().sample(origin, single())
            };
        }
        for ((live, surface), light) in live.iter().zip(vertices).zip(&lights) {
            let vertex = surface.vertex();
            let bsdf: B = surface.bsdf(&scene.materials);
            let (normal, frame) = vertex.frame::<B>();
            let wo = frame.to_local(vertex.wo);
            let bsdf = bsdf.eval(wo, frame.to_local(light.direction));
            let weight = match ctx.strategy {
                Strategy::Mis => {
                    let weight = mis::power_heuristic(bsdf.pdf * light.inverse_pdf);
                    light.is_punctual.select(f32x8::ONE, weight)
                }
                _ => f32x8::ONE,
            };
            let contribution =
                vertex.throughput * light.radiance * bsdf.value * (weight * light.inverse_pdf);
            let mut lit = *live & contribution.max_magnitude().simd_gt(f32x8::ZERO);
            if V::SMOOTH && !B::TRANSMISSIVE {
                let height = surface.ng(normal).dot(light.direction);
                lit &= height.simd_gt(f32x8::ZERO);
            }
            shadow_rays.push(
                lit,
                &ShadowRayX8 {
                    origin: light_origin::<B>(surface),
                    direction: light.direction,
                    distance: light.distance,
                    target: light.primitive,
                    contribution,
                    path: vertex.path,
                },
            );
        }
    }
}

/// Where shadow rays start: off the surface, on the side of `wo`.
#[inline]
fn light_origin<B: Bsdf>(surface: &impl Surface) -> Vec3x8 {
    let vertex = surface.vertex();
    let (normal, _) = vertex.frame::<B>();
    surface.ng(normal).mul_add(vertex.offset, vertex.position)
}
