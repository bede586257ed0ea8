//! ꟻLIP: how different two images look to somebody who flips between them.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", for pictures, and 2021, "Visualizing
//! Errors in Rendered High Dynamic Range Images", for radiance: there the error of a pixel is the greatest over the
//! exposures at which the reference could be looked at.
//!
//! The observer is the papers' own: 0.7 m from a screen 0.7 m and 3840 pixels wide. Tiles are worked on each by itself,
//! all exposures in one go, so that what an exposure needs stays in the cache and the bits do not depend on threads.

mod colour;
mod filters;
mod tile;

use crate::lanes::{Rgb, f32x8};
use rayon::prelude::*;
use tile::{Tile, Workspace};

/// What ꟻLIP says of two images.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Mean of the map.
    pub mean: f64,
    /// The error of each pixel, 0 to 1, row after row.
    pub map: Vec<f32>,
}

/// Exposures at which an image is looked at: radiance is multiplied by 2^exposure.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Exposures {
    /// The first; the brightest pixel is then nearly white.
    pub start: f32,
    /// The last; half of the pixels are then nearly white.
    pub stop: f32,
    /// How many there are, evenly spaced; at least 2.
    pub count: u32,
}

/// The tone curve of the exposures: the fit of ACES by Narkowicz 2015, at 0.6 of the radiance
/// (Andersson et al. 2021).
#[derive(Clone, Copy, Debug)]
struct ToneCurve;

impl ToneCurve {
    /// Of x² and x above the fraction line, and of x², x and 1 below it.
    const ABOVE: [f32; 2] = [2.51 * 0.36, 0.03 * 0.6];
    const BELOW: [f32; 3] = [2.43 * 0.36, 0.59 * 0.6, 0.14];
    /// The curve is at 1 from about 13; larger radiance is cut off here, so that no square overflows.
    const LIMIT: f32 = 1e6;

    /// From radiance to [0, 1]; what is negative or no number gives 0.
    #[inline]
    fn apply(x: f32x8) -> f32x8 {
        // `fast_max` gives its argument where either is no number.
        let x = x.fast_max(f32x8::ZERO).fast_min(f32x8::splat(Self::LIMIT));
        let [square, linear] = Self::ABOVE.map(f32x8::splat);
        let above = x.mul_add(square, linear) * x;
        let [square, linear, constant] = Self::BELOW.map(f32x8::splat);
        let below = x.mul_add(x.mul_add(square, linear), constant);
        (above / below).fast_min(f32x8::ONE)
    }

    /// The radiance that the curve takes to 0.85 (Andersson et al. 2021, "Computing Start and Stop Exposures").
    fn nearly_white() -> f64 {
        const LEVEL: f64 = 0.85;
        let [a2, a1] = Self::ABOVE.map(f64::from);
        let [b2, b1, b0] = Self::BELOW.map(f64::from);
        let (a, b, c) = (a2 - LEVEL * b2, a1 - LEVEL * b1, -LEVEL * b0);
        (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
    }
}

impl Exposures {
    /// Those of a reference: from where its greatest luminance is nearly white to where its median is
    /// (Andersson et al. 2021, "Computing Start and Stop Exposures").
    ///
    /// Luminances below 2⁻²³ count as that: so a black image has exposures too.
    pub fn of(reference: &[Vec<f32>; 3]) -> Self {
        let [red, green, blue] = reference;
        let mut luminances: Vec<f32> = (red.iter().zip(green).zip(blue))
            .map(|((&r, &g), &b)| {
                Rgb::new(r, g, b)
                    .luminance()
                    .clamp(f32::EPSILON, f32::MAX)
                    // A NaN passes through `clamp`.
                    .max(f32::EPSILON)
            })
            .collect();
        let middle = luminances.len() / 2;
        let (median, greatest) = if luminances.is_empty() {
            (1.0, 1.0)
        } else {
            let (_, &mut median, above) = luminances.select_nth_unstable_by(middle, f32::total_cmp);
            (median, above.iter().fold(median, |a, &b| a.max(b)))
        };
        let exposure =
            |luminance: f32| libm::log2(ToneCurve::nearly_white() / f64::from(luminance)) as f32;
        let (start, stop) = (exposure(greatest), exposure(median));
        Self {
            start,
            stop,
            count: ((stop - start).ceil() as u32).max(2),
        }
    }

    /// What radiance is multiplied by, from the first exposure to the last.
    fn factors(self) -> impl Iterator<Item = f32> + Clone {
        let step = (self.stop - self.start) / (self.count.max(2) - 1) as f32;
        // Where start and stop are one, one picture says it all.
        let count = if step > 0.0 { self.count } else { 1 };
        (0..count).map(move |i| libm::exp2f(step.mul_add(i as f32, self.start)))
    }
}

/// ꟻLIP of two pictures as a screen shows them: linear R, G, B (sRGB's primaries), rows of `width` pixels. What lies outside
/// [0, 1] is cut off.
///
/// # Panics
/// Where the planes are not of one length.
pub fn ldr(reference: &[Vec<f32>; 3], test: &[Vec<f32>; 3], width: usize) -> Flip {
    flip(reference, test, width, |workspace, tile| {
        let clamp = |x: f32x8| x.fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
        workspace.look(tile, clamp);
    })
}

/// ꟻLIP of two images of radiance (linear R, G, B, sRGB's primaries), rows of `width` pixels: of each pixel the greatest
/// over the exposures. Negative radiance is shown as black.
///
/// # Panics
/// Where the planes are not of one length.
pub fn hdr(
    reference: &[Vec<f32>; 3],
    test: &[Vec<f32>; 3],
    width: usize,
    exposures: Exposures,
) -> Flip {
    flip(reference, test, width, |workspace, tile| {
        for factor in exposures.factors() {
            let factor = f32x8::splat(factor);
            workspace.look(tile, |x| ToneCurve::apply(x * factor));
        }
    })
}

/// Looks at each tile in the ways that `look` says.
fn flip(
    reference: &[Vec<f32>; 3],
    test: &[Vec<f32>; 3],
    width: usize,
    look: impl Fn(&mut Workspace, &Tile) + Sync,
) -> Flip {
    let pixels = reference[0].len();
    assert!(
        reference
            .iter()
            .chain(test)
            .all(|plane| plane.len() == pixels),
        "planes of one length"
    );
    let height = pixels.checked_div(width).unwrap_or(0);
    let tiles = Tile::all(width, height);
    let errors: Vec<Vec<f32>> = tiles
        .par_iter()
        .map_init(Workspace::new, |workspace, tile| {
            // Where nothing differs, nothing is seen.
            if workspace.load(tile, width, [reference, test]) {
                look(workspace, tile);
            }
            workspace.errors(tile)
        })
        .collect();
    let mut map = vec![0.0; pixels];
    for (tile, errors) in tiles.iter().zip(&errors) {
        tile.paste(errors, &mut map, width);
    }
    let sum: f64 = map.iter().map(|&error| f64::from(error)).sum();
    Flip {
        mean: sum / pixels.max(1) as f64,
        map,
    }
}
