//! Spherical harmonics.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/render.rs"]
mod render;

mod compare;
mod environment;
mod oracle;
mod probe_bake;
