//! Plain images: what was not rendered sample by sample, and has no exact sums to keep.

use super::tonemap::Tonemap;
use super::{png, write_whole};
use crate::error::{Error, Result};
use crate::lanes::Rgb;
use ::exr::error::Error as ExrError;
use ::exr::prelude::{Encoding, Image, SpecificChannels, WritableImage};
use ::png::ColorType;
use std::io;
use std::path::Path;

/// An image of linear RGB, row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    width: usize,
    pixels: Vec<Rgb>,
}

impl Raster {
    /// Of rows of `width` pixels.
    ///
    /// # Errors
    /// [`Error::Usage`] where the last row is not whole, or there is none.
    pub fn new(width: usize, pixels: Vec<Rgb>) -> Result<Self> {
        if pixels.is_empty() || !pixels.len().is_multiple_of(width.max(1)) {
            return Err(Error::Usage(format!(
                "{} pixels make no image {width} wide",
                pixels.len()
            )));
        }
        Ok(Self { width, pixels })
    }

    /// Pixels in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// The pixels, row after row.
    #[must_use]
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// The least value of any channel, and the part of the pixels that have a negative one.
    #[must_use]
    pub fn negative(&self) -> (f32, f64) {
        let least = |pixel: &Rgb| pixel.r.min(pixel.g).min(pixel.b);
        let count = self
            .pixels
            .iter()
            .filter(|pixel| least(pixel) < 0.0)
            .count();
        let all = self.pixels.iter().map(least);
        (
            all.fold(f32::INFINITY, f32::min),
            count as f64 / self.pixels.len() as f64,
        )
    }

    /// With 0 for what is negative.
    #[must_use]
    pub fn clamped(mut self) -> Self {
        for pixel in &mut self.pixels {
            *pixel = pixel.to_array().map(|value| value.max(0.0)).into();
        }
        self
    }

    /// Images of one height in a row, from left to right.
    ///
    /// # Errors
    /// [`Error::Usage`] where there are none, or their heights differ.
    pub fn strip(images: &[&Self]) -> Result<Self> {
        let height = images.first().map_or(0, |image| image.height());
        if images.iter().any(|image| image.height() != height) {
            return Err(Error::Usage("images in a row are of one height".to_owned()));
        }
        let rows = (0..height).flat_map(|y| {
            let row = move |image: &&Self| image.pixels[y * image.width..][..image.width].to_vec();
            images.iter().flat_map(row)
        });
        let width = images.iter().map(|image| image.width).sum();
        Self::new(width, rows.collect())
    }

    /// Writes an OpenEXR image of 32-bit floats, ZIP: whole, or [`Error::Write`] and nothing.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        let pixel = |at: ::exr::math::Vec2<usize>| {
            let Rgb { r, g, b } = self.pixels[at.y() * self.width + at.x()];
            (r, g, b)
        };
        let image = Image::from_encoded_channels(
            (self.width, self.height()),
            Encoding::SMALL_LOSSLESS,
            SpecificChannels::rgb(pixel),
        );
        write_whole(path, |file| {
            image
                .write()
                .to_buffered(file)
                .map_err(|error| match error {
                    ExrError::Io(source) => source,
                    other => io::Error::other(other.to_string()),
                })
        })
    }

    /// Writes a PNG of eight bits, sRGB: whole, or [`Error::Write`] and nothing.
    pub fn write_png(&self, path: &Path, tonemap: Tonemap) -> Result<()> {
        let encode = tonemap.encoder();
        let channels = self.pixels.iter().flat_map(|pixel| pixel.to_array());
        let bytes: Vec<u8> = channels.map(encode).collect();
        let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
        write_whole(path, |file| {
            let size = (side(self.width), side(self.height()));
            png::encode_bytes(file, size, ColorType::Rgb, &bytes)
        })
    }
}
