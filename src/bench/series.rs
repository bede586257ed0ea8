//! What was measured several times.

use crate::compare::distributions::two_sided;
use serde::{Deserialize, Serialize};

/// Measurements of one thing, in the order they were taken.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Samples", into = "Summary")]
pub struct Series(Vec<f64>);

/// How a series is written.
#[derive(Serialize)]
struct Summary {
    median: f64,
    spread: f64,
    samples: Vec<f64>,
}

/// What is read of it: the rest follows.
#[derive(Deserialize)]
struct Samples {
    samples: Vec<f64>,
}

impl From<Samples> for Series {
    fn from(written: Samples) -> Self {
        Self(written.samples)
    }
}

impl From<Series> for Summary {
    fn from(series: Series) -> Self {
        Self {
            median: series.median(),
            spread: series.spread(),
            samples: series.0,
        }
    }
}

impl FromIterator<f64> for Series {
    fn from_iter<I: IntoIterator<Item = f64>>(samples: I) -> Self {
        Self(samples.into_iter().collect())
    }
}

impl Series {
    /// Adds a measurement.
    pub fn push(&mut self, sample: f64) {
        self.0.push(sample);
    }

    /// The measurements.
    pub fn samples(&self) -> &[f64] {
        &self.0
    }

    /// The median; of an even number, the mean of the two in the middle; 0 without any.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// The greatest: of what a machine can do, the best that was seen; 0 without any.
    pub fn greatest(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }

    /// From the first quartile to the third, relative to the median; 0 without any.
    pub fn spread(&self) -> f64 {
        match self.median() {
            0.0 => 0.0,
            median => (self.quantile(0.75) - self.quantile(0.25)) / median,
        }
    }

    /// Between two measurements, in proportion.
    fn quantile(&self, part: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        let Some(last) = sorted.len().checked_sub(1) else {
            return 0.0;
        };
        let place = part * last as f64;
        let (low, high) = (place.floor() as usize, place.ceil() as usize);
        sorted[low] + (sorted[high] - sorted[low]) * (place - place.floor())
    }

    /// Probability that two series of one distribution lie as far apart as these or farther: the rank test of Mann & Whitney
    /// 1947 (Annals of Mathematical Statistics 18), two-sided, by its normal limit with the correction for continuity; ties
    /// count as halves. 1 where either has none.
    pub fn same(&self, other: &Self) -> f64 {
        let (n, m) = (self.0.len() as f64, other.0.len() as f64);
        if n * m == 0.0 {
            return 1.0;
        }
        let above = |a: f64, b: f64| match a.total_cmp(&b) {
            std::cmp::Ordering::Greater => 1.0,
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Less => 0.0,
        };
        let pairs = self
            .0
            .iter()
            .flat_map(|&a| other.0.iter().map(move |&b| above(a, b)));
        let u: f64 = pairs.sum();
        let deviation = (n * m * (n + m + 1.0) / 12.0).sqrt();
        two_sided(((u - n * m / 2.0).abs() - 0.5).max(0.0) / deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(samples: &[f64]) -> Series {
        samples.iter().copied().collect()
    }

    #[test]
    fn median_and_quartiles() {
        assert_eq!(series(&[]).median(), 0.0);
        assert_eq!(series(&[3.0]).median(), 3.0);
        assert_eq!(series(&[4.0, 7.0, 3.0]).greatest(), 7.0);
        assert_eq!(series(&[4.0, 1.0, 3.0, 2.0]).median(), 2.5);
        assert_eq!(series(&[5.0, 1.0, 4.0, 2.0, 3.0]).spread(), 2.0 / 3.0);
    }

    #[test]
    fn ranks_tell_series_apart() {
        let low: Series = (0..9).map(f64::from).collect();
        let high: Series = (9..18).map(f64::from).collect();
        // All 81 pairs one way: z = (40.5 - 0.5) / sqrt(81 * 19 / 12).
        let z: f64 = 40.0 / (81.0_f64 * 19.0 / 12.0).sqrt();
        assert!((low.same(&high) - two_sided(z)).abs() < 1e-15);
        assert!(low.same(&high) < 1e-3);
        assert_eq!(low.same(&high), high.same(&low));
        assert_eq!(low.same(&low), 1.0);
        assert_eq!(low.same(&Series::default()), 1.0);
    }

    #[test]
    fn what_is_written_is_read() {
        let written = serde_json::to_string(&series(&[2.0, 1.0, 4.0])).unwrap();
        assert!(
            written.starts_with(r#"{"median":2.0,"spread":"#),
            "{written}"
        );
        let read: Series = serde_json::from_str(&written).unwrap();
        assert_eq!(read, series(&[2.0, 1.0, 4.0]));
    }
}
