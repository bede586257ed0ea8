//! What a comparison found.

use super::flip::Exposures;
use serde::Serialize;

/// What two images are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every number that was compared has the same bits.
    BitEqual,
    /// They differ by no more than noise and the tolerance explain.
    Consistent,
    /// They do not converge to the same image.
    Biased,
}

/// A comparison. Differences are test − reference, in the images' own unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The answer.
    pub verdict: Verdict,
    /// The answer in one sentence.
    pub summary: String,
    /// What was assumed or could not be tested, one sentence each.
    pub notes: Vec<String>,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Probability of a false alarm, all tests together.
    pub alpha: f64,
    /// Relative bias below which a difference is not called one.
    pub tolerance: f64,
    /// The smallest uniform relative bias that this pair would have shown, at `alpha`, in 95 of 100 cases; none where noise
    /// or a black reference hide any.
    pub detectable: Option<f64>,
    /// Error figures.
    pub metrics: Metrics,
    /// Where a bias is surest; only with [`Verdict::Biased`].
    pub bias: Option<Bias>,
    /// The image.
    pub image: LayerReport,
    /// Each path length that both images hold, ascending.
    pub lengths: Vec<LayerReport>,
}

/// Error figures, over pixels and R, G, B.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Mean of d².
    pub mse: f64,
    /// What the variances of both images announce of it, as if samples were independent.
    pub expected_mse: Option<f64>,
    /// Mean of d² / (reference² + 0.01).
    pub rel_mse: f64,
    /// Mean of |d|.
    pub mae: f64,
    /// Mean ꟻLIP, 0 to 1; none where it was not asked for.
    pub flip: Option<f64>,
    /// The exposures at which it looked.
    pub flip_exposures: Option<Exposures>,
}

/// The clearest sign of a bias.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// First path length that is biased, where both images have those layers.
    pub length: Option<u32>,
    /// `R`, `G`, `B` or `luminance`.
    pub channel: &'static str,
    /// The test that found it.
    pub test: Test,
    /// Probability, under noise alone, of so clear a sign in any of all the tests.
    pub p: f64,
}

/// What is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// The mean over the image.
    Mean,
    /// All blocks together, by χ².
    Blocks,
    /// The worst block.
    Block,
    /// The worst pixel.
    Pixel,
}

/// The tests of one layer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerReport {
    /// Path length in edges; none for the image.
    pub length: Option<u32>,
    /// Whether one of its channels is biased.
    pub biased: bool,
    /// R, G, B, luminance.
    pub channels: Vec<ChannelReport>,
    /// z of every block, for pictures.
    #[serde(skip)]
    pub blocks: Blocks,
}

/// The blocks of an image: a grid whose last column and row may be larger.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    /// First pixel of each column of blocks, then the width.
    pub columns: Vec<usize>,
    /// First pixel of each row of blocks, then the height.
    pub rows: Vec<usize>,
    /// For R, G, B and luminance: the normal score of each block, row after row.
    pub z: Vec<Vec<f64>>,
}

/// The tests of one channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelReport {
    /// `R`, `G`, `B` or `luminance`.
    pub channel: &'static str,
    /// Whether one of its tests shows a bias.
    pub biased: bool,
    /// The mean over the image.
    pub mean: MeanTest,
    /// The blocks.
    pub blocks: BlockTest,
    /// The pixels; only where both images have variances.
    pub pixels: Option<PixelTest>,
}

/// The mean difference of all pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeanTest {
    /// Mean of the reference.
    pub reference: f64,
    /// Mean of the test image.
    pub test: f64,
    /// Mean difference.
    pub difference: f64,
    /// Standard error of that.
    pub standard_error: f64,
    /// Difference over the reference's mean, none where that is not above 0; and its 95 % confidence interval.
    pub relative: Option<Relative>,
    /// Normal score.
    pub z: f64,
    /// Its two-sided probability under noise alone.
    pub p: f64,
    /// By how much neighbouring pixels that share their noise raise the variance of a mean.
    pub correlation: f64,
}

/// A relative difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Relative {
    /// Test over reference, less 1.
    pub value: f64,
    /// Its 95 % confidence interval.
    pub interval: [f64; 2],
}

/// Block means against their scatter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlockTest {
    /// Blocks tested.
    pub count: usize,
    /// Sum of z².
    pub chi_square: f64,
    /// Probability of so great a sum under noise alone.
    pub p: f64,
    /// Blocks that each alone show a bias.
    pub outstanding: usize,
    /// The block with the greatest |z|.
    pub worst: WorstBlock,
}

/// A block; pixels of the data window, the last two past the end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstBlock {
    /// x0, y0, x1, y1.
    pub region: [i64; 4],
    /// Mean difference in it.
    pub difference: f64,
    /// Mean of the reference in it.
    pub reference: f64,
    /// Normal score.
    pub z: f64,
    /// Probability of so great a |z| in any block (Šidák).
    pub p: f64,
}

/// Pixels against their variances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelTest {
    /// Pixels tested.
    pub count: usize,
    /// The pixel with the greatest |z|.
    pub worst: WorstPixel,
}

/// A pixel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstPixel {
    /// Column.
    pub x: i64,
    /// Row.
    pub y: i64,
    /// Difference.
    pub difference: f64,
    /// The reference there.
    pub reference: f64,
    /// Normal score.
    pub z: f64,
    /// Probability of so great a |z| in any pixel (Šidák).
    pub p: f64,
}
