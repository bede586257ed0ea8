//! Stage 4: next-event estimation. Each vertex that can draws a point of a light and sends a shadow ray to it.

use super::Context;
use super::queues::{ShadowRayX8, VertexX8};
use crate::lanes::{Queue, f32x8};
use crate::material::Bsdf;
use crate::sampling::{Dimension, mis};
use crate::scene::description::Strategy;

/// Whether vertices of this kind look for light sources at all.
pub fn samples_lights<B: Bsdf>(ctx: &Context) -> bool {
    !B::SPECULAR
        && matches!(ctx.strategy, Strategy::Light | Strategy::Mis)
        && !ctx.scene.lights.is_dark()
}

/// Pushes a shadow ray for each vertex whose light sample could add light.
#[inline(never)]
pub fn sample_lights<B: Bsdf>(
    ctx: &Context,
    edge: u32,
    vertices: &Queue<VertexX8>,
    shadow_rays: &mut Queue<ShadowRayX8>,
) {
    let scene = ctx.scene;
    for (live, vertex) in vertices.batches() {
        let path = vertex.path_key();
        let bsdf = B::load(&scene.materials, vertex.material);
        let (normal, frame) = vertex.frame::<B>();
        let origin = normal.mul_add(vertex.offset, vertex.position);

        let point = ctx.sampler.pair(path, Dimension::LightPoint, edge);
        let choice = || ctx.sampler.single(path, Dimension::LightChoice, edge);
        let light = scene
            .lights
            .sample(scene.sky.as_ref(), origin, choice, point);

        let wo = frame.to_local(vertex.wo);
        let bsdf = bsdf.eval(wo, frame.to_local(light.direction));
        let weight = match ctx.strategy {
            Strategy::Mis => mis::power_heuristic(light.pdf, bsdf.pdf),
            _ => f32x8::ONE,
        };
        let contribution = vertex.throughput * light.radiance * bsdf.value * (weight / light.pdf);
        // The density is 0 where no point of the light faces here, and the quotient is not finite.
        let lit =
            live & light.pdf.simd_gt(f32x8::ZERO) & contribution.max_channel().simd_gt(f32x8::ZERO);
        shadow_rays.push(
            lit,
            &ShadowRayX8 {
                origin,
                direction: light.direction,
                distance: light.distance,
                target: light.primitive,
                contribution,
                path: vertex.path,
            },
        );
    }
}
