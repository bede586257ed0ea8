//! pbrt-v4 scenes.

use super::description::Description;
use crate::error::{Error, Result};
use std::path::Path;

/// Reads a scene.
///
/// # Errors
/// Whatever cannot be rendered, with place and remedy.
pub fn load(path: &Path) -> Result<Description> {
    Err(Error::format(path, "not read yet"))
}
