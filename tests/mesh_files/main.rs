//! Files of meshes and images: what is read, and what is refused with which words.

#[path = "../common/mod.rs"]
mod common;
mod images;
mod ply;
