//! Floor 1: images on surfaces. [`Textures`] looks eight of them up at once.

mod image;
mod lookup;

pub use image::{Image, Pixels};
pub use lookup::Textures;

use glam::Affine2;
use std::sync::Arc;

/// An image on a surface.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Its pixels.
    pub image: Arc<Image>,
    /// Outside [0, 1], by u and v.
    pub wrap: [Wrap; 2],
    /// Nearest texel instead of bilinear interpolation.
    pub nearest: bool,
    /// From the mesh's UV to those of the image, whose v = 0 is its top row.
    pub transform: Affine2,
}

/// What a texture is outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeats.
    #[default]
    Repeat,
    /// Repeats, every other one mirrored.
    Mirror,
    /// The texel of the border goes on.
    Clamp,
}
