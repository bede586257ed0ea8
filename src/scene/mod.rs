//! Floor 3: immutable scenes.

pub mod description;
pub mod toml;
