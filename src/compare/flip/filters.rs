//! What the eye blurs, and where it sees edges and points: filters of rows and columns.

use std::f64::consts::PI;

/// Pixels in a degree of the visual field: 0.7 m from 3840 pixels that are 0.7 m wide
/// (the observer of Andersson et al. 2020).
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// The farthest pixel that any filter sees: three standard deviations of the widest, rounded up.
pub(super) const RADIUS: usize = 10;

/// Weights along a row or a column, in the order of pixels; an odd number of them.
#[derive(Clone, Debug)]
pub(super) struct Filter(Vec<f32>);

/// All filters of a look.
#[derive(Clone, Debug)]
pub(super) struct Filters {
    /// What contrast the eye sees in luminance, from red to green, and from yellow to blue: there two are added, each for rows and
    /// columns (Andersson et al. 2020, "Spatial Filtering"; Johnson & Fairchild 2003).
    pub luminance: Filter,
    pub red_green: Filter,
    pub yellow_blue: [Filter; 2],
    /// A Gaussian, and its first and second derivative ("Feature Detection").
    pub smooth: Filter,
    pub edge: Filter,
    pub point: Filter,
}

/// Weights of pixels at whole distances, as far as `radius`.
fn taps(radius: usize, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let radius = radius as i32;
    (-radius..=radius).map(|x| weight(f64::from(x))).collect()
}

fn sum(weights: &[f64]) -> f64 {
    weights.iter().sum()
}

impl Filter {
    /// Weights, times a factor. Those at the ends that change no result are left out.
    fn new(weights: &[f64], factor: f64) -> Self {
        const NEGLIGIBLE: f64 = 1e-9;
        let kept = |weight: &f64| (weight * factor).abs() > NEGLIGIBLE;
        let ends = weights.iter().position(kept).unwrap_or(0);
        let weights = &weights[ends..weights.len() - ends];
        Self(
            weights
                .iter()
                .map(|weight| (weight * factor) as f32)
                .collect(),
        )
    }

    /// Positive and negative weights scaled to add up to 1 and −1.
    fn balanced(weights: &[f64]) -> Self {
        let positive: f64 = weights.iter().filter(|&&weight| weight > 0.0).sum();
        let negative: f64 = -weights.iter().filter(|&&weight| weight < 0.0).sum::<f64>();
        let balanced: Vec<f64> = weights
            .iter()
            .map(|&weight| weight / if weight > 0.0 { positive } else { negative })
            .collect();
        Self::new(&balanced, 1.0)
    }

    /// The farthest pixel it sees.
    pub fn radius(&self) -> usize {
        self.0.len() / 2
    }

    /// The weights.
    pub fn weights(&self) -> &[f32] {
        &self.0
    }
}

impl Filters {
    pub fn new() -> Self {
        // exp(−π²x²/b), x in degrees: the transform of a Gaussian of contrast sensitivity.
        let gaussian = |b: f64| {
            taps(RADIUS, |x| {
                let degrees = x / PIXELS_PER_DEGREE;
                libm::exp(-PI * PI * degrees * degrees / b)
            })
        };
        let single = |b: f64| {
            let weights = gaussian(b);
            Filter::new(&weights, 1.0 / sum(&weights))
        };
        // a·sqrt(π/b) of each of the two; together their weights over the plane add up to 1.
        let terms = [(34.1, 0.04), (13.5, 0.025)].map(|(a, b)| (a * (PI / b).sqrt(), gaussian(b)));
        let total: f64 = terms
            .iter()
            .map(|(scale, weights)| scale * sum(weights) * sum(weights))
            .sum();
        let yellow_blue =
            terms.map(|(scale, weights)| Filter::new(&weights, (scale / total).sqrt()));

        // Features are as wide as 0.082 degrees.
        let deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as usize;
        let bell = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
        let smooth = taps(radius, bell);
        Self {
            luminance: single(0.0047),
            red_green: single(0.0053),
            yellow_blue,
            smooth: Filter::new(&smooth, 1.0 / sum(&smooth)),
            edge: Filter::balanced(&taps(radius, |x| -x * bell(x))),
            point: Filter::balanced(&taps(radius, |x| {
                (x * x / (deviation * deviation) - 1.0) * bell(x)
            })),
        }
    }
}
