//! Spherical harmonics against the textbook.

#[path = "../common/mod.rs"]
mod common;

mod basis;
mod draws;
mod lobe;
mod oracle;
mod probe;
mod project;
mod quadrature;
mod rotate;
mod shade;
