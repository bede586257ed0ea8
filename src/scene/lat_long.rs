//! Files of lat-long images.

use super::description::LatLong;
use super::exr;
use crate::error::{Error, Result};
use crate::lanes::Rgb;
use std::io::BufReader;
use std::path::Path;

/// Greatest width and height of an image, pixels: a header may claim any size.
const LARGEST: (usize, usize) = (16384, 8192);

/// Reads a lat-long image of radiance from an OpenEXR file.
///
/// # Errors
/// [`Error::Format`] where it cannot be read, is not twice as wide as high, or holds what is negative or not finite.
pub fn read(path: &Path) -> Result<LatLong> {
    explained(path).map_err(|message| Error::format(path, message))
}

/// The same; an error says what is wrong and what to do, and not with which file.
pub(super) fn explained(path: &Path) -> std::result::Result<LatLong, String> {
    let file = std::fs::File::open(path).map_err(|error| format!("cannot read: {error}"))?;
    let (width, height, pixels) = exr::read(BufReader::new(file), LARGEST, |[r, g, b, _]| {
        Rgb::new(r, g, b)
    })?;
    if width != 2 * height {
        return Err(format!(
            "is {width}×{height} pixels, and a lat-long image is twice as wide as high; resize it to {}×{height}",
            2 * height
        ));
    }
    Ok(LatLong {
        file: path.display().to_string(),
        width,
        height,
        pixels,
    })
}
