//! What noise the images' own variances announce, and pixels against it.

use super::blocks::{beyond, self_normalised};
use super::image::{Image, Layer};
use rayon::prelude::*;

/// Variances of both images, a channel at a time.
pub struct Noise {
    /// Variance of d in each pixel, R, G, B.
    pub expected: [Vec<f32>; 3],
    /// Samples of each pixel of the image that has fewer there; none where neither file says how many it has.
    pub samples: Option<Vec<f32>>,
}

impl Noise {
    /// None where one of the images has no variances, or zeros alone.
    ///
    /// Of rare events each image may have missed some, so the greater of the two variances of a single sample counts for
    /// both. How many samples one image has for each of the other follows from the counts, or from the mean variances.
    pub fn new(images: [&Image; 2], layers: [&Layer; 2]) -> Option<Self> {
        let [reference, test] = layers.map(|layer| layer.variance.as_ref());
        let (reference, test) = (reference?, test?);
        let total = |planes: &[Vec<f32>; 3]| planes.iter().map(|plane| sum(plane)).sum::<f64>();
        let (noise, other) = (total(reference), total(test));
        if noise == 0.0 || other == 0.0 {
            return None;
        }
        let share = (noise / other) as f32;
        let counts = images.map(|image| image.samples.as_ref());
        // Samples of the test image for each of the reference.
        let ratio = |i: usize| match counts {
            [Some(a), Some(b)] => b[i] / a[i],
            _ => share,
        };
        let expected = std::array::from_fn(|c| {
            let both = reference[c].par_iter().zip(&test[c]).enumerate();
            both.map(|(i, (&a, &b))| {
                let ratio = ratio(i);
                match ratio.is_finite() && ratio > 0.0 {
                    true => a.max(b * ratio) * (1.0 + 1.0 / ratio),
                    false => 0.0,
                }
            })
            .collect()
        });
        let fewer = |a: &[f32], b: &(dyn Fn(usize) -> f32 + Sync)| -> Vec<f32> {
            let all = a.par_iter().enumerate();
            all.map(|(i, &a)| a.min(b(i))).collect()
        };
        let samples = match counts {
            [Some(a), Some(b)] => Some(fewer(a, &|i| b[i])),
            [Some(a), None] => Some(fewer(a, &|i| a[i] * share)),
            [None, Some(b)] => Some(fewer(b, &|i| b[i] / share)),
            [None, None] => None,
        };
        Some(Self { expected, samples })
    }
}

/// Whether the files say that both images have about as many samples, so that d is symmetric.
pub fn equally_sampled(images: [&Image; 2]) -> bool {
    let [Some(a), Some(b)] = images.map(|image| image.samples.as_ref()) else {
        return false;
    };
    let ratio = sum(a) / sum(b);
    (0.8..=1.25).contains(&ratio)
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
