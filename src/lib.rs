//! Ondine: a data-oriented wavefront path tracer for the CPU.

pub mod cli;
pub mod error;
pub mod film;
pub mod lanes;
pub mod material;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shape;
pub mod stats;
pub mod wavefront;
