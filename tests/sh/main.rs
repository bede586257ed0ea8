//! Spherical harmonics: each topic against a textbook in double precision.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/render.rs"]
mod render;

mod compare;
mod draws;
mod environment;
mod oracle;
mod probe;
mod probe_bake;
mod project;
mod rotate;
mod shade;
