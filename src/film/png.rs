//! The picture for people: eight bits, sRGB.

use super::tonemap::Tonemap;
use super::{Film, write_whole};
use crate::error::Result;
use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, SrgbRenderingIntent};
use std::io::{self, Write};
use std::path::Path;

/// Writes the film's region as a PNG: whole, or [`Error::Write`](crate::error::Error::Write) and nothing.
pub fn write(path: &Path, film: &Film, tonemap: Tonemap) -> Result<()> {
    write_whole(path, |file| encode(file, film, tonemap))
}

/// The PNG of the film's region, with an `sRGB` chunk.
pub fn encode(to: impl Write, film: &Film, tonemap: Tonemap) -> io::Result<()> {
    let region = film.region();
    let size = (region.width(), region.height());
    encode_bytes(to, size, ColorType::Rgb, &pixels(film, tonemap))
}

/// The PNG of columns and rows of pixels, one byte for each channel.
pub(crate) fn encode_bytes(
    to: impl Write,
    (width, height): (u32, u32),
    channels: ColorType,
    bytes: &[u8],
) -> io::Result<()> {
    let mut encoder = Encoder::new(to, width, height);
    encoder.set_color(channels);
    encoder.set_depth(BitDepth::Eight);
    // Noise packs badly whatever the effort, and a batch writes thousands.
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header().map_err(plain)?;
    writer.write_image_data(bytes).map_err(plain)?;
    writer.finish().map_err(plain)
}

/// The tone-mapped region: three bytes a pixel, row after row.
pub fn pixels(film: &Film, tonemap: Tonemap) -> Vec<u8> {
    let encode = tonemap.encoder();
    film.means().iter().flatten().map(|&x| encode(x)).collect()
}

fn plain(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(source) => source,
        other => io::Error::other(other.to_string()),
    }
}
