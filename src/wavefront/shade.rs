//! Stage 3: where paths go on. One kernel for each material kind.

use super::Context;
use super::queues::{GROUP, PathRayX8, Surface, VertexX8};
use crate::lanes::{FrameX8, Queue, Vec3x8, f32x8};
use crate::material::{Bsdf, SampleX8};
use crate::sampling::{Dimension, PathKeyX8, warp};
use crate::scene::description::Strategy;

/// Whether the paths at the end of `edge` go on at all: where the next edge is the last and light is found by light
/// samples alone, only a specular material still has something to find.
pub fn continues<B: Bsdf>(ctx: &Context, edge: u32) -> bool {
    B::SPECULAR || ctx.strategy != Strategy::Light || edge + 1 < ctx.path_length
}

/// Draws the next direction of each path and pushes the rays of the paths that go on.
#[inline(never)]
pub fn shade<B: Bsdf, V: Surface>(
    ctx: &Context,
    edge: u32,
    vertices: &Queue<V>,
    rays: &mut Queue<PathRayX8>,
) {
    for (live, vertices) in vertices.groups::<GROUP>() {
        let mut directions = [(f32x8::ZERO, f32x8::ZERO); GROUP];
        for (direction, vertex) in directions.iter_mut().zip(vertices) {
            *direction =
                ctx.sampler
                    .pair(vertex.vertex().path_key(), Dimension::BsdfDirection, edge);
        }
        for ((live, surface), direction) in live.iter().zip(vertices).zip(&directions) {
            let vertex = surface.vertex();
            let path = vertex.path_key();
            let bsdf: B = surface.bsdf(&ctx.scene.materials);
            let (normal, frame) = vertex.frame::<B>();
            let wo = frame.to_local(vertex.wo);

            let sample = if ctx.strategy == Strategy::Uniform && !B::SPECULAR {
                let wi = warp::uniform_hemisphere(*direction);
                let density = f32x8::splat(warp::UNIFORM_HEMISPHERE_PDF);
                SampleX8 {
                    wi,
                    weight: bsdf.eval(wo, wi).value * (f32x8::ONE / density),
                    pdf: density,
                }
            } else {
                let lobe = ctx.sampler.single(path, Dimension::BsdfLobe, edge);
                bsdf.sample(wo, *direction, lobe)
            };

            let mut throughput = vertex.throughput * sample.weight;
            let mut goes_on = *live & throughput.max_channel().simd_gt(f32x8::ZERO);
            if ctx.roulette.is_some_and(|first| edge >= first) {
                let chance = throughput.max_channel().fast_min(f32x8::ONE);
                let u = ctx.sampler.single(path, Dimension::Roulette, edge);
                goes_on &= u.simd_lt(chance);
                throughput = throughput * (f32x8::ONE / chance);
            }
            let direction = frame.to_world(sample.wi);
            let ng = surface.ng(normal);
            let height = if V::SMOOTH {
                ng.dot(direction)
            } else {
                sample.wi.z
            };
            if V::SMOOTH && !B::TRANSMISSIVE {
                // What leaves an opaque surface to its other side would light up what is in the dark there.
                goes_on &= height.simd_gt(f32x8::ZERO);
            }
            // Off the surface, to the side that the ray leaves by.
            let offset = vertex.offset.copysign(height);
            rays.push(
                goes_on,
                &PathRayX8 {
                    origin: ng.mul_add(offset, vertex.position),
                    direction,
                    throughput,
                    pdf: sample.pdf,
                    path: vertex.path,
                    key: vertex.key,
                    index: vertex.index,
                },
            );
        }
    }
}

impl VertexX8 {
    /// What the sampler knows its paths by.
    #[inline]
    pub fn path_key(&self) -> PathKeyX8 {
        PathKeyX8 {
            key: self.key,
            index: self.index,
        }
    }

    /// The shading normal and its frame: towards `wo` on an opaque material, outwards where light passes through.
    #[inline]
    pub fn frame<B: Bsdf>(&self) -> (Vec3x8, FrameX8) {
        let normal = if B::TRANSMISSIVE {
            self.normal
        } else {
            let behind = self.normal.dot(self.wo).simd_lt(f32x8::ZERO);
            Vec3x8::select(behind, -self.normal, self.normal)
        };
        (normal, FrameX8::new(normal))
    }
}
