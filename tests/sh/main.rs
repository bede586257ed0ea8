//! Spherical harmonics against the textbook.

#[path = "../common/mod.rs"]
mod common;

mod basis;
mod lobe;
mod quadrature;
