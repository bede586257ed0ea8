//! Shading by the double sum, on the queues of the path tracer, and the estimators it is held to.
//!
//! What equals what, on a convex object:
//!
//! - cosine lobe ÷ π: the path tracer's `lambert` of albedo 1, with paths of two edges;
//! - Phong lobe: [`Estimator::Lobe`], a ray for each sample, drawn from the lobe. The path tracer's `phong` material is another
//!   model: it has the cosine of the incident light beside the lobe, is normalised by `n + 2`, and cuts off what lies below
//!   the horizon.

use super::{Control, Rendered, Settings, render_by};
use crate::error::Result;
use crate::lanes::{FrameX8, Rgb, Rgbx8, Vec3x8, f32x8};
use crate::material::Lambert;
use crate::sampling::{Dimension, warp};
use crate::scene::description::Description;
use crate::sh::{Lobe, Probe, Shading};
use crate::wavefront::queues::VertexX8;
use crate::wavefront::{self, Context, Wave, Workspace};

/// How the same is found with rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// The path tracer, with the materials of the scene.
    PathTracer,
    /// One ray for each sample, drawn from the lobe, that sees the environment whatever is between.
    Lobe,
}

/// A white surface under light given by coefficients.
#[derive(Clone, Debug)]
pub struct DoubleSum {
    lobe: Lobe,
    shading: Shading,
}

impl DoubleSum {
    /// For light and a lobe.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::error::Error::Usage) where the light was convolved before.
    pub fn new(light: &Probe, lobe: Lobe) -> Result<Self> {
        Ok(Self {
            lobe,
            shading: Shading::new(light, lobe, Rgb::WHITE)?,
        })
    }

    /// Reflected radiance of a hit.
    #[inline]
    fn shade(&self, vertex: &VertexX8) -> Rgbx8 {
        let (normal, _) = vertex.frame::<Lambert>();
        self.shading.shade(normal, vertex.wo)
    }

    /// The image of a scene whose every surface is white: the environment where rays meet nothing. Lights are as they are,
    /// but light nothing.
    ///
    /// # Errors
    /// As [`render`](super::render).
    pub fn render(
        &self,
        description: &Description,
        settings: &Settings,
        control: &Control,
    ) -> Result<Rendered> {
        let trace = |ctx: &Context, wave: &Wave, ws: &mut Workspace| {
            wavefront::trace_first(ctx, wave, ws, |vertex| self.shade(vertex));
        };
        render_by(trace, description, settings, control)
    }

    /// An estimator's image minus the double sum's, sample by sample of the same camera rays: so the variance of each pixel is
    /// that of the difference.
    ///
    /// # Errors
    /// As [`render`](super::render).
    pub fn difference(
        &self,
        estimator: Estimator,
        description: &Description,
        settings: &Settings,
        control: &Control,
    ) -> Result<Rendered> {
        let trace = |ctx: &Context, wave: &Wave, ws: &mut Workspace| {
            wavefront::trace_first(ctx, wave, ws, |vertex| self.shade(vertex));
            let sums = ws.radiance[..wave.paths()].to_vec();
            estimator.trace(self.lobe, ctx, wave, ws);
            for (radiance, sum) in ws.radiance.iter_mut().zip(sums) {
                (0..3).for_each(|c| radiance[c] -= sum[c]);
            }
        };
        render_by(trace, description, settings, control)
    }
}

impl Estimator {
    /// The image of a scene.
    ///
    /// # Errors
    /// As [`render`](super::render).
    pub fn render(
        self,
        lobe: Lobe,
        description: &Description,
        settings: &Settings,
        control: &Control,
    ) -> Result<Rendered> {
        let trace = |ctx: &Context, wave: &Wave, ws: &mut Workspace| {
            self.trace(lobe, ctx, wave, ws);
        };
        render_by(trace, description, settings, control)
    }

    fn trace(self, lobe: Lobe, ctx: &Context, wave: &Wave, ws: &mut Workspace) {
        match self {
            Estimator::PathTracer => wavefront::trace(ctx, wave, ws),
            Estimator::Lobe => {
                let exponent = match lobe {
                    Lobe::Cosine => 1.0,
                    Lobe::Phong(exponent) => exponent as f32,
                };
                wavefront::trace_first(ctx, wave, ws, |vertex| {
                    let path = vertex.path_key();
                    let u = ctx.sampler.pair(path, Dimension::BsdfDirection, 1);
                    let around = warp::cosine_power(u, f32x8::splat(exponent));
                    let direction = FrameX8::new(axis(lobe, vertex)).to_world(around);
                    let sky = ctx.scene.sky.as_ref();
                    sky.map_or(Rgbx8::ZERO, |sky| sky.radiance(direction))
                });
            }
        }
    }
}

/// The direction that the lobe is symmetric about.
#[inline]
fn axis(lobe: Lobe, vertex: &VertexX8) -> Vec3x8 {
    let (normal, _) = vertex.frame::<Lambert>();
    match lobe {
        Lobe::Cosine => normal,
        Lobe::Phong(_) => normal.mul_add(normal.dot(vertex.wo) * 2.0, -vertex.wo),
    }
}
