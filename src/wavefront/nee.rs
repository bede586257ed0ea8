//! Stage 4: next-event estimation. Each vertex that can draws a point of a light and sends a shadow ray to it.

use super::Context;
use super::queues::{GROUP, ShadowRayX8, VertexX8};
use crate::lanes::{Queue, Vec3x8, f32x8};
use crate::material::Bsdf;
use crate::sampling::{Dimension, mis};
use crate::scene::description::Strategy;
use crate::scene::light::LightSampleX8;

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
    for (live, vertices) in vertices.groups::<GROUP>() {
        let mut points = [(f32x8::ZERO, f32x8::ZERO); GROUP];
        for (point, vertex) in points.iter_mut().zip(vertices) {
            *point = ctx
                .sampler
                .pair(vertex.path_key(), Dimension::LightPoint, edge);
        }
        let mut lights = [LightSampleX8::default(); GROUP];
        for ((light, vertex), point) in lights.iter_mut().zip(vertices).zip(&points) {
            let path = vertex.path_key();
            let choice = || ctx.sampler.single(path, Dimension::LightChoice, edge);
            let origin = vertex.light_origin::<B>();
            *light = scene
                .lights
                .sample(scene.sky.as_ref(), origin, choice, *point);
        }
        for ((live, vertex), light) in live.iter().zip(vertices).zip(&lights) {
            let bsdf = B::load(&scene.materials, vertex.material);
            let (_, frame) = vertex.frame::<B>();
            let wo = frame.to_local(vertex.wo);
            let bsdf = bsdf.eval(wo, frame.to_local(light.direction));
            let weight = match ctx.strategy {
                Strategy::Mis => mis::power_heuristic(bsdf.pdf * light.inverse_pdf),
                _ => f32x8::ONE,
            };
            let contribution =
                vertex.throughput * light.radiance * bsdf.value * (weight * light.inverse_pdf);
            let lit = *live & contribution.max_channel().simd_gt(f32x8::ZERO);
            shadow_rays.push(
                lit,
                &ShadowRayX8 {
                    origin: vertex.light_origin::<B>(),
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

impl VertexX8 {
    /// Where its shadow rays start: off the surface, on the side of `wo`.
    #[inline]
    fn light_origin<B: Bsdf>(&self) -> Vec3x8 {
        let (normal, _) = self.frame::<B>();
        normal.mul_add(self.offset, self.position)
    }
}
