//! Spherical harmonics: each topic against a textbook in double precision.

#[path = "../common/mod.rs"]
mod common;

mod draws;
mod oracle;
mod probe;
mod project;
mod rotate;
mod shade;
