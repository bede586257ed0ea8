//! What noise the images' own variances announce, and pixels against it.

use super::blocks::{beyond, self_normalised};
use super::image::{Image, Layer};
use crate::lanes::Rgb;
use rayon::prelude::*;

/// By how much the variances of single samples may differ between images of one estimator.
const ALIKE: f64 = 1.5;

/// Variances of both images, a channel at a time.
pub struct Noise {
    /// Variance of d in each pixel: R, G, B, and what luminance has at most.
    pub expected: [Vec<f32>; 4],
    /// Samples of each pixel of the image that has fewer there; none where not both files say how many they have, or where
    /// the variances of a single sample are not alike, so that the images come from different estimators: then a pixel
    /// can lack in both what only one of them finds.
    pub samples: Option<Vec<f32>>,
    /// Whether the images have about as many samples of one estimator, so that d is symmetric.
    pub symmetric: bool,
}

impl Noise {
    /// None where one of the images has no variances, or zeros alone.
    ///
    /// Of rare events each image may have missed some, so for images of one estimator the greater of the two variances of a
    /// single sample counts for both. Whether they are, the whole images say: a layer of rare paths may have missed too many.
    pub fn new(images: [&Image; 2], layers: [&Layer; 2]) -> Option<Self> {
        let total = |layer: &Layer| {
            let planes = layer.variance.iter().flatten();
            planes.map(|plane| sum(plane)).sum::<f64>()
        };
        if layers.iter().any(|layer| total(layer) == 0.0) {
            return None;
        }
        let [reference, test] = layers.map(|layer| layer.variance.as_ref());
        let (reference, test) = (reference?, test?);
        let counts = match images.map(|image| image.samples.as_ref()) {
            [Some(a), Some(b)] => Some((a, b, sum(b) / sum(a))),
            _ => None,
        };
        let within = |ratio: f64, bound: f64| (1.0 / bound..=bound).contains(&ratio);
        let [noise, other] = images.map(|image| total(&image.image));
        let counts = counts.filter(|(.., ratio)| within(noise / other / ratio, ALIKE));
        let of = |c: usize| -> Vec<f32> {
            let both = reference[c].par_iter().zip(&test[c]).enumerate();
            both.map(|(i, (&a, &b))| match counts {
                Some((n, m, _)) if n[i] > 0.0 && m[i] > 0.0 => {
                    let ratio = m[i] / n[i];
                    a.max(b * ratio) * (1.0 + 1.0 / ratio)
                }
                Some(_) => 0.0,
                None => a + b,
            })
            .collect()
        };
        let [r, g, b] = [0, 1, 2].map(of);
        // A weighted sum varies most where its terms vary together.
        let luminance = (&r, &g, &b).into_par_iter().map(|(&r, &g, &b)| {
            let deviation = Rgb::new(r.sqrt(), g.sqrt(), b.sqrt()).luminance();
            deviation * deviation
        });
        let luminance = luminance.collect();
        let fewer = |(a, b, _): (&Vec<f32>, &Vec<f32>, f64)| {
            let pairs = a.par_iter().zip(b);
            pairs.map(|(&a, &b)| a.min(b)).collect()
        };
        Some(Self {
            expected: [r, g, b, luminance],
            samples: counts.map(fewer),
            symmetric: counts.is_some_and(|(.., ratio)| within(ratio, 1.25)),
        })
    }
}

/// The sum of a plane, in its order.
fn sum(plane: &[f32]) -> f64 {
    plane.iter().copied().map(f64::from).sum()
}

/// The pixel that is farthest from what noise allows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Farthest {
    /// Pixels tested.
    pub count: usize,
    /// Its place in the planes.
    pub index: usize,
    /// Its normal score.
    pub z: f64,
}

/// Tests each pixel of a channel that has samples. As for blocks, Σd² of the samples and not their scatter is what a mean is
/// judged by: a pixel of n samples has no score above √n, for so few may all have missed the same rare event.
pub fn farthest(pair: [&[f32]; 2], expected: &[f32], samples: &[f32], tolerance: f64) -> Farthest {
    const RUN: usize = 1 << 14;
    let runs: Vec<Farthest> = (0..expected.len().div_ceil(RUN))
        .into_par_iter()
        .map(|run| {
            let mut farthest = Farthest::default();
            for i in run * RUN..expected.len().min((run + 1) * RUN) {
                let n = f64::from(samples[i]);
                if n < 2.0 {
                    continue;
                }
                farthest.count += 1;
                let [a, b] = pair.map(|plane| f64::from(plane[i]));
                // As sums over n samples.
                let sum = beyond(b - a, tolerance * a.abs()) * n;
                let z = self_normalised(sum, f64::from(expected[i]) * n * n, n, 1.0);
                if z.abs() > farthest.z.abs() {
                    (farthest.index, farthest.z) = (i, z);
                }
            }
            farthest
        })
        .collect();
    runs.into_iter().fold(Farthest::default(), |best, run| {
        let count = best.count + run.count;
        let farther = if run.z.abs() > best.z.abs() {
            run
        } else {
            best
        };
        Farthest { count, ..farther }
    })
}
