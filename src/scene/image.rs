//! Images of textures: PNG, JPEG, TGA, BMP, Radiance HDR and OpenEXR.

use super::description::{Image, Pixels};
use super::exr;
use crate::error::{Error, Result};
use ::image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};
use std::io::{Cursor, Read};
use std::panic::catch_unwind;
use std::path::Path;

/// Greatest width and height, pixels: a header may claim any size.
const LARGEST: u32 = 16384;
/// Greatest size of a file, bytes.
const LARGEST_FILE: u64 = 1 << 30;
/// Most memory of a decoder, bytes: the largest image in floats.
const LARGEST_RASTER: u64 = 16 * LARGEST as u64 * LARGEST as u64;
/// The first bytes of an OpenEXR file.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// What the numbers of an image with integer channels stand for. Images of floats are linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Colour by the sRGB curve (IEC 61966-2-1), alpha linear.
    Srgb,
    /// Data: normals, roughness.
    Linear,
}

/// Reads an image.
///
/// # Errors
/// [`Error::Read`], and [`Error::Format`] where it is no image that is understood, or a side of it has more than 16384
/// pixels.
pub fn read(path: &Path, space: ColorSpace) -> Result<Image> {
    decode(&bytes(path)?, &path.display().to_string(), space)
}

/// The bytes of an image file.
///
/// # Errors
/// [`Error::Read`], and [`Error::Format`] where there are too many.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>> {
    let cannot_read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let file = std::fs::File::open(path).map_err(cannot_read)?;
    let mut bytes = Vec::new();
    file.take(LARGEST_FILE + 1)
        .read_to_end(&mut bytes)
        .map_err(cannot_read)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(Error::format(path, "is larger than 1 GiB; scale it down"));
    }
    Ok(bytes)
}

/// Decodes an image. Errors call it by its name, whose ending also tells a TGA, which nothing else does.
///
/// # Errors
/// As [`read`].
pub fn decode(bytes: &[u8], name: &str, space: ColorSpace) -> Result<Image> {
    let side = LARGEST as usize;
    let raster = if bytes.starts_with(EXR_MAGIC) {
        let read = exr::read(Cursor::new(bytes), (side, side), |rgba| rgba);
        read.map(|(width, height, pixels)| (width, height, Pixels::Float(pixels)))
    } else {
        // As for the EXR decoder: a panic becomes an error.
        catch_unwind(|| others(bytes, name, space)).unwrap_or_else(|_| {
            Err("the image decoder gave up; the file is damaged, write it again".to_owned())
        })
    };
    let (width, height, pixels) =
        raster.map_err(|message| Error::format(Path::new(name), message))?;
    Ok(Image {
        file: name.to_owned(),
        width,
        height,
        pixels,
    })
}

fn others(
    bytes: &[u8],
    name: &str,
    space: ColorSpace,
) -> std::result::Result<(usize, usize, Pixels), String> {
    let explain = |error| match error {
        ImageError::Limits(_) => {
            format!("is too large; scale it down to at most {LARGEST}×{LARGEST}")
        }
        error => format!("cannot decode it: {error}; convert it to PNG"),
    };
    let format = ::image::guess_format(bytes)
        .or_else(|error| ImageFormat::from_path(name).map_err(|_| error))
        .map_err(|_| {
            "is not an image that is read: PNG, JPEG, TGA, BMP, HDR or EXR; convert it".to_owned()
        })?;
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(explain)?;
    let (w, h, side) = (width as usize, height as usize, LARGEST as usize);
    if width > LARGEST || height > LARGEST {
        return Err(exr::too_large(w, h, (side, side)));
    }
    if w * h == 0 {
        return Err("has no pixels; write it again".to_owned());
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(LARGEST_RASTER);
    let mut reader = reader();
    reader.limits(limits);
    let image = reader.decode().map_err(explain)?;
    let is_float = matches!(
        image,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let pixels = match image {
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => {
            let texels = image.into_rgba8().into_raw().as_chunks().0.to_vec();
            match space {
                ColorSpace::Srgb => Pixels::Srgb8(texels),
                ColorSpace::Linear => Pixels::Linear8(texels),
            }
        }
        // Sixteen bits, or floats.
        image => {
            let mut texels = image.into_rgba32f().into_raw().as_chunks().0.to_vec();
            if is_float {
                finite(&texels, w)?;
            } else if space == ColorSpace::Srgb {
                for [r, g, b, _] in &mut texels {
                    [*r, *g, *b] = [*r, *g, *b].map(linear);
                }
            }
            Pixels::Float(texels)
        }
    };
    Ok((w, h, pixels))
}

fn finite(texels: &[[f32; 4]], width: usize) -> std::result::Result<(), String> {
    for (index, texel) in texels.iter().enumerate() {
        for (&value, channel) in texel.iter().zip(['R', 'G', 'B', 'A']) {
            if !(value.is_finite() && value >= 0.0) {
                return Err(exr::not_light(index % width, index / width, channel, value));
            }
        }
    }
    Ok(())
}

/// The linear value of an sRGB one in [0, 1] (IEC 61966-2-1).
pub fn linear(srgb: f32) -> f32 {
    let s = f64::from(srgb);
    let linear = if s <= 0.040_45 {
        s / 12.92
    } else {
        libm::pow((s + 0.055) / 1.055, 2.4)
    };
    linear as f32
}
