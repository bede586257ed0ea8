//! The tests of one layer.

use super::blocks::{self, Grid, Sums, beyond, self_normalised};
use super::distributions::{chi_square, least_of, score, two_sided};
use super::noise::{self, Noise};
use super::report::{
    BlockTest, ChannelReport, LayerReport, MeanTest, PixelTest, Relative, WorstBlock, WorstPixel,
};
use super::{Image, Layer};
use crate::lanes::Rgb;
use rayon::prelude::*;

/// The channels that are tested.
pub const CHANNELS: [&str; 4] = ["R", "G", "B", "luminance"];

/// Tests a layer of both images; what is biased is said once all tests are counted.
pub fn examine(
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
        let expected = noise.map(|noise| grid.totals(&noise.expected[c]));
        let symmetric = noise.is_some_and(|noise| noise.symmetric);
        let scatters = blocks::scatters(grid, &sums, expected.as_deref(), symmetric);
        let correlation = blocks::correlation(grid, &sums, expected.as_deref());
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
            biased: false,
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
    (r, g, b)
        .into_par_iter()
        .map(|(&r, &g, &b)| Rgb::new(r, g, b).luminance())
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
