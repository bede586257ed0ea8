//! Who looks on while a wave is traced.

use super::{Context, Workspace};

/// What has just been done, and so what is new in the workspace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// `rays` are the sensor's.
    Generated,
    /// What `rays` met is in `vertices` and `mesh_vertices`, `encounters` and `mesh_encounters`; where only lights were looked
    /// for, in `encounters` alone.
    Met {
        /// Whether the other three hold what they held before.
        only_lights: bool,
    },
    /// The light of the encounters is in `radiance`. Where only lights were looked for, they become shadow rays instead.
    AddedEncounters,
    /// `next_rays` and `shadow_rays` are complete.
    Scattered,
    /// `visible` says which shadow rays reached their lights, and their light is in `radiance`.
    AddedShadowRays,
}

/// Sees the workspace between stages. `()` sees nothing, which costs nothing.
pub trait Observer {
    /// After a step on edge `edge`, which counts from 1.
    #[inline(always)]
    fn see(&mut self, _ctx: &Context, _edge: u32, _step: Step, _ws: &Workspace) {}
}

impl Observer for () {}
