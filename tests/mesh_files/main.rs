//! Files of meshes and images: what is read, and what is refused with which words.

mod changes;
#[path = "../common/mod.rs"]
mod common;
mod framing;
mod images;
mod obj;
mod ply;
