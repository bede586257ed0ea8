//! Images to be compared: of any OpenEXR file, the channels that matter.

use crate::error::Result;
use std::path::{Path, PathBuf};

/// Three planes of linear radiance, and their variances where the file has them. Pixels row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// R, G, B: the mean of each pixel, W·sr⁻¹·m⁻².
    pub radiance: [Vec<f32>; 3],
    /// Variance of that mean.
    pub variance: Option<[Vec<f32>; 3]>,
}

/// What a comparison reads of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The file.
    pub path: PathBuf,
    /// Left column of the data window, in pixels of the full image.
    pub x0: i32,
    /// Top row.
    pub y0: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The image itself.
    pub image: Layer,
    /// Light by path length in edges, ascending (the `length.N` layers).
    pub lengths: Vec<(u32, Layer)>,
    /// Samples of each pixel, where the file says them.
    pub samples: Option<Vec<u32>>,
}

/// Reads an image: `R G B`, or those of the named layer.
///
/// # Errors
/// [`Error::Read`](crate::error::Error::Read) where the system refuses,
/// [`Error::Format`](crate::error::Error::Format) where the file is no EXR, is damaged, or has no such channels.
pub fn read(path: &Path, _layer: Option<&str>) -> Result<Image> {
    Err(crate::error::Error::format(path, "not built yet"))
}
