//! What a tree is asked with.

use super::NO_TRIANGLE;
use super::ready::FAR;
use crate::lanes::{Batch, Vec3x8, f32x8, u32x8};
use crate::record;
use glam::Vec3;

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

record! {
    /// A ray of which everything can be said, for either question.
    pub struct Ray, RayX8 {
        /// World space.
        origin: Vec3,
        /// World space; need not be unit.
        direction: Vec3,
        /// Nothing at this distance or nearer is met.
        nearest: f32,
        /// Nothing at this distance or farther casts a shadow.
        farthest: f32,
        /// Triangle (of instance 0) that casts no shadow, or [`NO_TRIANGLE`].
        ignored: u32,
    }
}

impl Ray {
    /// All the way.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin,
            direction,
            nearest: 0.0,
            farthest: f32::INFINITY,
            ignored: NO_TRIANGLE,
        }
    }
}

impl Rays for RayX8 {
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

impl ShadowRays for RayX8 {
    fn farthest(&self) -> f32x8 {
        self.farthest
    }
    fn ignored(&self) -> u32x8 {
        self.ignored
    }
}

impl RayX8 {
    /// Eight of any rays, up to `farthest`.
    #[inline(always)]
    pub(super) fn of(rays: &impl Rays, farthest: f32x8, ignored: u32x8) -> Self {
        Self {
            origin: *rays.origin(),
            direction: *rays.direction(),
            // Not −0: its bits are below all others.
            nearest: rays.nearest() + f32x8::ZERO,
            farthest,
            ignored,
        }
    }

    /// Whether no origin is far from a tree of this reach.
    #[inline(always)]
    pub(super) fn begins_near(&self, reach: f32) -> bool {
        let near = self.origin.max_abs().simd_le(f32x8::splat(FAR * reach));
        near.all()
    }
}
