//! Error figures.

use super::image::Layer;
use super::report::Metrics;
use rayon::prelude::*;

/// Of all pixels and of R, G, B. Sums are of rows, and these are added in their order.
pub fn metrics(layers: [&Layer; 2], width: usize) -> Metrics {
    let variances = layers.map(|layer| layer.variance.as_ref());
    let mut total = [0.0; 4];
    let mut numbers = 0;
    for c in 0..3 {
        let [reference, test] = layers.map(|layer| &layer.radiance[c]);
        numbers += reference.len();
        let rows: Vec<[f64; 3]> = reference
            .par_chunks(width)
            .zip(test.par_chunks(width))
            .map(|(reference, test)| errors(reference, test))
            .collect();
        for row in rows {
            (0..3).for_each(|k| total[k] += row[k]);
        }
        for planes in variances.into_iter().flatten() {
            let rows: Vec<f64> = planes[c].par_chunks(width).map(sum).collect();
            total[3] += rows.iter().sum::<f64>();
        }
    }
    let [mse, rel_mse, mae, expected] = total.map(|sum| sum / numbers as f64);
    Metrics {
        mse,
        expected_mse: variances.iter().all(Option::is_some).then_some(expected),
        rel_mse,
        mae,
        flip: None,
    }
}

fn sum(row: &[f32]) -> f64 {
    row.iter().copied().map(f64::from).sum()
}

/// Σd², Σd² / (reference² + 0.01), Σ|d|.
fn errors(reference: &[f32], test: &[f32]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (&a, &b) in reference.iter().zip(test) {
        let (a, d) = (f64::from(a), f64::from(b) - f64::from(a));
        sums[0] += d * d;
        sums[1] += d * d / (a * a + 0.01);
        sums[2] += d.abs();
    }
    sums
}
