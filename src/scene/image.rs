//! Images.
use super::description::{Image, Pixels};
use crate::error::{Error, Result};
use std::path::Path;

/// How the numbers of an image are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// By the sRGB curve.
    Srgb,
    /// As they are.
    Linear,
}

/// Decodes an image.
///
/// # Errors
/// [`Error::Format`].
pub fn decode(bytes: &[u8], name: &str, space: ColorSpace) -> Result<Image> {
    let image = image::load_from_memory(bytes)
        .map_err(|error| Error::format(Path::new(name), error.to_string()))?
        .to_rgba8();
    let pixels = image.pixels().map(|pixel| pixel.0).collect();
    Ok(Image {
        file: name.to_owned(),
        width: image.width() as usize,
        height: image.height() as usize,
        pixels: match space {
            ColorSpace::Srgb => Pixels::Srgb8(pixels),
            ColorSpace::Linear => Pixels::Linear8(pixels),
        },
    })
}
