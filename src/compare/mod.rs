//! Floor 3: whether two images are of one scene, up to noise: metrics, and tests that tell noise from bias.

pub mod flip;

mod image;
mod report;

pub use image::{Image, Layer, read};
pub use report::{
    Bias, BlockTest, Blocks, ChannelReport, LayerReport, MeanTest, Metrics, PixelTest, Report,
    Verdict, WorstBlock, WorstPixel,
};

use crate::error::Result;

/// What decides a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Probability that a pair of unbiased images is called biased, all tests together.
    pub alpha: f64,
    /// Relative bias below which a difference is not called one.
    pub tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            alpha: 1e-3,
            tolerance: 1e-4,
        }
    }
}

/// Compares `test` with `reference`.
///
/// # Errors
/// [`Error::Usage`](crate::error::Error::Usage) where their windows differ.
pub fn compare(_reference: &Image, _test: &Image, _options: &Options) -> Result<Report> {
    Err(crate::error::Error::Usage(
        "compare is not built yet".to_owned(),
    ))
}
