//! Floor 3: whether two images are of one scene, up to noise: metrics, and tests that tell noise from bias.
//!
//! For each of R, G, B and luminance, and for each path length that both images hold: the mean of d = test − reference;
//! means of blocks, all together by χ² and the worst by Šidák's inequality; and pixels, where both images have variances and
//! one has sample counts. All are self-normalised sums ([`blocks`]), which fireflies seldom mislead. The family of all tests
//! has the significance that was asked for (Bonferroni).
//!
//! What is assumed: pixels more than a few apart have independent noise. An image whose pixels all use the same random
//! numbers is called biased, for nothing in it tells its noise from a bias.

pub mod blocks;
pub mod distributions;
pub mod flip;

mod examine;
mod image;
mod metrics;
mod noise;
mod pick;
mod report;
mod summary;

pub use examine::CHANNELS;
pub use image::{Image, Layer, read};
pub use report::{
    Bias, BlockTest, Blocks, ChannelReport, LayerReport, MeanTest, Metrics, PixelTest, Relative,
    Report, Test, Verdict, WorstBlock, WorstPixel,
};

pub use summary::percent;

use crate::error::{Error, Result};
use blocks::Grid;
use distributions::{least_of, score, two_sided};
use examine::examine;
use noise::Noise;

/// What decides a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Probability that a pair of unbiased images is called biased, all tests together.
    pub alpha: f64,
    /// Relative bias below which a difference is not called one, of the image, a block or a pixel.
    pub tolerance: f64,
}

impl Default for Options {
    /// One false alarm in a thousand. And 10⁻⁴, a fortieth of a display's step: half floats round a pixel by up to 5·10⁻⁴, but
    /// both ways, so a block's mean by 2·10⁻⁵; single precision adds up 10⁵ samples to some 3·10⁻⁵.
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
/// [`Error::Usage`] where their data windows differ, or they have no pixels.
pub fn compare(reference: &Image, test: &Image, options: &Options) -> Result<Report> {
    let window = |image: &Image| (image.width, image.height, image.x0, image.y0);
    if window(reference) != window(test) || reference.width * reference.height == 0 {
        let said = |image: &Image| {
            let (width, height, x, y) = window(image);
            format!(
                "{} has {width}x{height} pixels from {x},{y}",
                image.path.display()
            )
        };
        return Err(Error::Usage(format!(
            "{}, {}: only images of the same pixels can be compared; render or crop one of them again",
            said(reference),
            said(test)
        )));
    }
    let pair = [reference, test];
    let grid = Grid::new(reference.width, reference.height);
    let shared = reference.lengths.iter().filter_map(|(length, layer)| {
        let other = test.lengths.iter().find(|(other, _)| other == length);
        Some((*length, [layer, &other?.1]))
    });
    let layers = [reference, test].map(|image| &image.image);
    let noise = Noise::new(pair, layers);
    let metrics = metrics::metrics(layers, reference.width);
    let mut image = examine(None, pair, layers, noise.as_ref(), &grid, options.tolerance);
    let mut bit_equal = same_bits(layers);
    let mut lengths: Vec<LayerReport> = shared
        .map(|(length, layers)| {
            bit_equal &= same_bits(layers);
            let noise = Noise::new(pair, layers);
            let length = Some(length);
            examine(
                length,
                pair,
                layers,
                noise.as_ref(),
                &grid,
                options.tolerance,
            )
        })
        .collect();

    let tests = std::iter::once(&image)
        .chain(&lengths)
        .flat_map(LayerReport::tests);
    let count = tests.count();
    let threshold = options.alpha / count as f64;
    for layer in std::iter::once(&mut image).chain(&mut lengths) {
        layer.judge(threshold);
    }
    let bias = bias(&image, &lengths, count);
    let verdict = match (bit_equal, &bias) {
        (true, _) => Verdict::BitEqual,
        (false, None) => Verdict::Consistent,
        (false, Some(_)) => Verdict::Biased,
    };
    // No mean of n pixels has a score above √n: see `self_normalised`.
    let pixels = (reference.width * reference.height) as f64;
    let limit = score(threshold);
    let room = 1.0 - limit * limit / pixels;
    let means = image.channels.iter().map(|channel| &channel.mean);
    let detectable = means
        .filter(|mean| mean.reference > 0.0 && room > 0.0)
        .map(|mean| {
            // 95 of 100 normal scores lie above -1.645.
            let reach = limit / room.sqrt() + score(0.1);
            options.tolerance + reach * mean.standard_error / mean.reference
        })
        .min_by(f64::total_cmp);
    let mut report = Report {
        verdict,
        summary: String::new(),
        notes: summary::notes(pair, &image, noise.as_ref()),
        width: reference.width,
        height: reference.height,
        alpha: options.alpha,
        tolerance: options.tolerance,
        detectable,
        metrics,
        bias,
        image,
        lengths,
    };
    report.summary = summary::sentence(&report);
    Ok(report)
}

fn same_bits([reference, test]: [&Layer; 2]) -> bool {
    let planes = reference.radiance.iter().zip(&test.radiance);
    planes.into_iter().all(|(a, b)| {
        let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits();
        a.iter().zip(b).all(same)
    })
}

impl ChannelReport {
    /// Each test with its probability under noise alone.
    fn tests(&self) -> impl Iterator<Item = (Test, f64)> + use<> {
        let pixels = self.pixels.as_ref();
        let tests = [
            Some((Test::Mean, self.mean.p)),
            Some((Test::Blocks, self.blocks.p)),
            Some((Test::Block, self.blocks.worst.p)),
            pixels.map(|pixels| (Test::Pixel, pixels.worst.p)),
        ];
        tests.into_iter().flatten()
    }
}

impl LayerReport {
    /// Each test with its channel and its probability under noise alone.
    fn tests(&self) -> impl Iterator<Item = (&'static str, Test, f64)> {
        self.channels.iter().flat_map(|channel| {
            let name = channel.channel;
            channel.tests().map(move |(test, p)| (name, test, p))
        })
    }

    /// Says what lies below the threshold of a single test.
    fn judge(&mut self, threshold: f64) {
        for (channel, z) in self.channels.iter_mut().zip(&self.blocks.z) {
            channel.biased = channel.tests().any(|(_, p)| p < threshold);
            let count = z.len();
            let shows = |z: &&f64| least_of(two_sided(**z), count) < threshold;
            channel.blocks.outstanding = z.iter().filter(shows).count();
        }
        self.biased = self.channels.iter().any(|channel| channel.biased);
    }
}

/// The clearest sign of a bias, of the first path length that has one; of the image where no length tells.
fn bias(image: &LayerReport, lengths: &[LayerReport], count: usize) -> Option<Bias> {
    let layer = lengths.iter().chain([image]).find(|layer| layer.biased)?;
    // The first of equals: the simplest test.
    let (channel, test, p) = layer.tests().min_by(|a, b| a.2.total_cmp(&b.2))?;
    Some(Bias {
        length: layer.length,
        channel,
        test,
        p: (p * count as f64).min(1.0),
    })
}
