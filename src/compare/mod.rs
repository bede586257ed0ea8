//! Floor 3: whether two images are of one scene, up to noise: metrics, and tests that tell noise from bias.
//!
//! For each of R, G, B and luminance, and for each path length that both images hold: the mean of d = test − reference;
//! means of blocks, all together by χ² and the worst by Šidák's inequality; and pixels, where both images have variances and
//! one has sample counts. All are self-normalised sums ([`blocks`]), which fireflies do not mislead. The family of all tests
//! has the significance that was asked for (Bonferroni).
//!
//! What is assumed: pixels more than a few apart have independent noise. An image whose pixels all use the same random
//! numbers is called biased, for nothing in it tells its noise from a bias.

pub mod blocks;
pub mod distributions;

mod image;
mod metrics;
mod noise;
mod pick;
mod report;
mod summary;

pub use image::{Image, Layer, read};
pub use report::{
    Bias, BlockTest, Blocks, ChannelReport, LayerReport, MeanTest, Metrics, PixelTest, Relative,
    Report, Test, Verdict, WorstBlock, WorstPixel,
};

pub use summary::percent;

use crate::error::{Error, Result};
use blocks::{Grid, Sums, beyond, self_normalised};
use distributions::{chi_square, least_of, score, two_sided};
use noise::Noise;
use rayon::prelude::*;

/// The channels that are tested.
pub const CHANNELS: [&str; 4] = ["R", "G", "B", "luminance"];

/// Luminance of linear Rec. 709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// What decides a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Probability that a pair of unbiased images is called biased, all tests together.
    pub alpha: f64,
    /// Relative bias below which a difference is not called one, of the image, a block or a pixel.
    pub tolerance: f64,
}

impl Default for Options {
    /// One false alarm in a thousand; and a bias that a thousandth of a display's brightest step would not show. Half floats
    /// round a pixel by up to 5·10⁻⁴, but in both directions: a block's mean by 2·10⁻⁵.
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
    // 95 of 100 normal scores lie above -1.645.
    let reach = score(threshold) + score(0.1);
    let detectable = image
        .channels
        .iter()
        .map(|channel| &channel.mean)
        .filter(|mean| mean.reference > 0.0 && mean.standard_error > 0.0)
        .map(|mean| options.tolerance + reach * mean.standard_error / mean.reference)
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

/// Tests a layer; what is biased is said once all tests are counted.
fn examine(
    length: Option<u32>,
    pair: [&Image; 2],
    layers: [&Layer; 2],
    noise: Option<&Noise>,
    grid: &Grid,
    tolerance: f64,
) -> LayerReport {
    let luminances = layers.map(|layer| luminance(&layer.radiance));
    let mut channels = Vec::new();
    let mut z = Vec::new();
    for (c, name) in CHANNELS.into_iter().enumerate() {
        let planes = match c {
            3 => [&luminances[0][..], &luminances[1][..]],
            _ => layers.map(|layer| &layer.radiance[c][..]),
        };
        let sums = blocks::sums(grid, planes);
        let scatters = blocks::scatters(grid, &sums, noise::equally_sampled(pair));
        let correlation = blocks::correlation(&sums);
        let scores: Vec<f64> = sums
            .iter()
            .zip(&scatters)
            .map(|(sums, &scatter)| {
                let sum = beyond(sums.difference, tolerance * sums.magnitude);
                self_normalised(sum, scatter, sums.pixels, correlation)
            })
            .collect();
        channels.push(ChannelReport {
            channel: name,
            mean: mean_test(&sums, &scatters, correlation, tolerance),
            blocks: block_test(pair[0], grid, &sums, &scores),
            pixels: noise.and_then(|noise| pixel_test(pair[0], c, planes, noise, tolerance)),
        });
        z.push(scores);
    }
    LayerReport {
        length,
        biased: false,
        channels,
        blocks: grid.with_scores(z),
    }
}

fn luminance([r, g, b]: &[Vec<f32>; 3]) -> Vec<f32> {
    let weighted = |(r, g, b)| LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b;
    (r, g, b)
        .into_par_iter()
        .map(|(r, g, b)| weighted((*r, *g, *b)))
        .collect()
}

fn mean_test(sums: &[Sums], scatters: &[f64], correlation: f64, tolerance: f64) -> MeanTest {
    let total = |of: fn(&Sums) -> f64| sums.iter().map(of).sum::<f64>();
    let pixels = total(|block| block.pixels);
    let [reference, test, difference] = [
        total(|b| b.reference),
        total(|b| b.test),
        total(|b| b.difference),
    ]
    .map(|sum| sum / pixels);
    let scatter: f64 = scatters.iter().sum();
    let sum = beyond(
        difference * pixels,
        tolerance * total(|block| block.magnitude),
    );
    let z = self_normalised(sum, scatter, pixels, correlation);
    // Each block's mean takes one degree of freedom.
    let free = (pixels - sums.len() as f64).max(1.0);
    let standard_error = (correlation * scatter / (free * pixels)).sqrt();
    let relative = (reference > 0.0).then(|| {
        let around = |scores: f64| (difference + scores * standard_error) / reference;
        Relative {
            value: around(0.0),
            interval: [around(-score(0.05)), around(score(0.05))],
        }
    });
    MeanTest {
        reference,
        test,
        difference,
        standard_error,
        relative,
        z,
        p: two_sided(z),
        correlation,
    }
}

fn block_test(image: &Image, grid: &Grid, sums: &[Sums], z: &[f64]) -> BlockTest {
    let chi = z.iter().map(|z| z * z).sum();
    let worst = (0..z.len())
        .max_by(|&a, &b| z[a].abs().total_cmp(&z[b].abs()).then(b.cmp(&a)))
        .unwrap_or(0);
    let [x0, y0, x1, y1] = grid.region(worst);
    let (x, y) = (i64::from(image.x0), i64::from(image.y0));
    BlockTest {
        count: z.len(),
        chi_square: chi,
        p: chi_square(chi, z.len()),
        outstanding: 0,
        worst: WorstBlock {
            region: [x + x0 as i64, y + y0 as i64, x + x1 as i64, y + y1 as i64],
            difference: sums[worst].difference / sums[worst].pixels,
            reference: sums[worst].reference / sums[worst].pixels,
            z: z[worst],
            p: least_of(two_sided(z[worst]), z.len()),
        },
    }
}

/// Luminance is left out: its variance is not known from those of the colours.
fn pixel_test(
    image: &Image,
    channel: usize,
    planes: [&[f32]; 2],
    noise: &Noise,
    tolerance: f64,
) -> Option<PixelTest> {
    let (expected, samples) = (noise.expected.get(channel)?, noise.samples.as_ref()?);
    let farthest = noise::farthest(planes, expected, samples, tolerance);
    let i = farthest.index;
    let [reference, test] = planes.map(|plane| f64::from(plane[i]));
    (farthest.count > 0).then(|| PixelTest {
        count: farthest.count,
        worst: WorstPixel {
            x: i64::from(image.x0) + (i % image.width) as i64,
            y: i64::from(image.y0) + (i / image.width) as i64,
            difference: test - reference,
            reference,
            z: farthest.z,
            p: least_of(two_sided(farthest.z), farthest.count),
        },
    })
}

impl LayerReport {
    /// Each test with its channel and its probability under noise alone.
    fn tests(&self) -> impl Iterator<Item = (&'static str, Test, f64)> {
        self.channels.iter().flat_map(|channel| {
            let pixels = channel.pixels.as_ref();
            [
                Some((Test::Mean, channel.mean.p)),
                Some((Test::Blocks, channel.blocks.p)),
                Some((Test::Block, channel.blocks.worst.p)),
                pixels.map(|pixels| (Test::Pixel, pixels.worst.p)),
            ]
            .into_iter()
            .flatten()
            .map(|(test, p)| (channel.channel, test, p))
        })
    }

    /// Says what lies below the threshold of a single test.
    fn judge(&mut self, threshold: f64) {
        let biased = self.tests().any(|(_, _, p)| p < threshold);
        self.biased = biased;
        for (channel, z) in self.channels.iter_mut().zip(&self.blocks.z) {
            let shows = |z: &&f64| least_of(two_sided(**z), channel.blocks.count) < threshold;
            channel.blocks.outstanding = z.iter().filter(shows).count();
        }
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
