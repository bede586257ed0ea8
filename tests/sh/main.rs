//! Spherical harmonics against the textbook.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/render.rs"]
mod render;

mod basis;
mod compare;
mod draws;
mod environment;
mod lobe;
mod oracle;
mod probe;
mod probe_bake;
mod project;
mod quadrature;
mod rotate;
mod shade;
