//! pbrt-v4 scenes (<https://pbrt.org/fileformat-v4>): the part of the format that published scenes use.
//!
//! The directives fill a `reader::Reader`; `assemble::World` makes the description when all was read, for materials
//! and objects may be named before they are defined. What is not supported is replaced by the closest match or left
//! out, with one warning for each kind.
//!
//! pbrt's camera space is left-handed, and so is the world of a file whose transformations do not mirror. Such a world is
//! mirrored as a whole, in x: the image is that of pbrt.
//!
//! Light: `L = 1` in `rgb` is a radiance of 1 in linear sRGB, which is what pbrt-v4's film makes of it, sensors aside.

mod assemble;
mod files;
mod gallery;
mod lexer;
mod library;
mod lights;
mod makers;
mod materials;
mod names;
mod options;
mod parameters;
mod reader;
mod shapes;
mod sky;
mod spectra;
mod state;
mod tessellate;
mod textures;
mod variants;
mod warnings;

use super::description::Description;
use crate::error::Result;
use std::path::Path;

/// Reads a scene.
///
/// # Errors
/// Whatever cannot be rendered, with place and remedy.
pub fn load(path: &Path) -> Result<Description> {
    reader::read(path)
}
