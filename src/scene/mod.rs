//! Floor 3: immutable scenes.

pub mod builtin;
pub mod description;
pub mod toml;
