//! What the page shows of two images: PNGs of eight bits.

use crate::compare::Image;
use crate::compare::flip::Flip;
use crate::film::png::encode_bytes;
use crate::film::tonemap::{Operator, Tonemap};
use crate::lanes::Rgb;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use png::ColorType;
use rayon::prelude::*;
use std::io;

/// The most pixels of a picture, and the longest side that browsers draw: larger images are shown smaller.
const MOST_PIXELS: usize = 1 << 22;
const LONGEST_SIDE: usize = 1 << 14;

/// Stops that are kept beyond white, in a picture of their own: what is white can be looked at with less exposure.
const HEADROOM: f32 = 6.0;

/// A picture of the page.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    /// Its name in the page's script.
    pub name: &'static str,
    /// What somebody reads who does not see it.
    pub title: &'static str,
    /// Whether it means anything by itself.
    pub alone: bool,
    /// The PNG as a URI.
    pub uri: String,
}

/// All pictures of two images, of the same size.
#[derive(Clone, Debug)]
pub(super) struct Pictures {
    /// Pixels of a picture.
    pub columns: usize,
    /// Rows of a picture.
    pub rows: usize,
    /// Pixels of the images, in x and in y, that one pixel of a picture stands for.
    pub scale: usize,
    /// Exposure, in stops, of the images.
    pub exposure: f32,
    /// What is brighter than white is divided by this.
    pub headroom: f32,
    /// The relative difference that has the last colour.
    pub relative_range: f32,
    /// The pictures.
    pub all: Vec<Picture>,
}

/// Images made smaller by a whole factor.
struct Shrink {
    width: usize,
    height: usize,
    scale: usize,
    columns: usize,
    rows: usize,
}

impl Shrink {
    fn new(width: usize, height: usize) -> Self {
        let fits = |scale: &usize| {
            let (columns, rows) = (width.div_ceil(*scale), height.div_ceil(*scale));
            columns.max(rows) <= LONGEST_SIDE && columns * rows <= MOST_PIXELS
        };
        let scale = (1..).find(fits).unwrap_or(1);
        Self {
            width,
            height,
            scale,
            columns: width.div_ceil(scale),
            rows: height.div_ceil(scale),
        }
    }

    /// A plane's means over the pixels that become one.
    fn plane(&self, plane: &[f32]) -> Vec<f32> {
        if self.scale == 1 {
            return plane.to_vec();
        }
        let pixel = |i: usize| {
            let (x, y) = (i % self.columns * self.scale, i / self.columns * self.scale);
            let (x1, y1) = (
                (x + self.scale).min(self.width),
                (y + self.scale).min(self.height),
            );
            let rows = (y..y1).flat_map(|y| &plane[y * self.width + x..y * self.width + x1]);
            let sum: f64 = rows.map(|&value| f64::from(value)).sum();
            (sum / ((x1 - x) * (y1 - y)) as f64) as f32
        };
        (0..self.columns * self.rows)
            .into_par_iter()
            .map(pixel)
            .collect()
    }

    fn colours(&self, image: &Image) -> Vec<Rgb> {
        let [r, g, b] = image
            .image
            .radiance
            .each_ref()
            .map(|plane| self.plane(plane));
        r.into_iter()
            .zip(g)
            .zip(b)
            .map(|((r, g), b)| Rgb::new(r, g, b))
            .collect()
    }
}

/// The pictures of two images, and of ꟻLIP where there is one.
///
/// # Errors
/// What the PNG encoder says.
pub(super) fn pictures(
    [reference, test]: [&Image; 2],
    flip: Option<&Flip>,
) -> io::Result<Pictures> {
    let shrink = Shrink::new(reference.width, reference.height);
    let images = [reference, test].map(|image| shrink.colours(image));
    let exposure = exposure(&images[0]);
    let (relative, relative_range) = relative(&images);
    let shown = |image: &[Rgb]| {
        encode_colours(
            image,
            Tonemap {
                operator: Operator::Linear,
                exposure,
            },
        )
    };
    let bright = |image: &[Rgb], shown: &[u8]| {
        let darker = Tonemap {
            operator: Operator::Linear,
            exposure: exposure - HEADROOM,
        };
        let mut codes = encode_colours(image, darker);
        // Nothing where the first picture says it: so it packs well.
        codes
            .iter_mut()
            .zip(shown)
            .filter(|(_, shown)| **shown < u8::MAX)
            .for_each(|(code, _)| *code = 0);
        codes
    };
    let mut plates: Vec<(&str, &str, bool, ColorType, Vec<u8>)> = Vec::new();
    let names = [
        (
            "reference",
            "Reference",
            "reference-bright",
            "Reference, beyond white",
        ),
        ("test", "Test", "test-bright", "Test, beyond white"),
    ];
    for (image, (name, title, bright_name, bright_title)) in images.iter().zip(names) {
        let codes = shown(image);
        let brighter = bright(image, &codes);
        plates.push((name, title, true, ColorType::Rgb, codes));
        if brighter.iter().any(|&code| code > 0) {
            plates.push((bright_name, bright_title, false, ColorType::Rgb, brighter));
        }
    }
    plates.push((
        "relative",
        "Relative difference of luminance, grey where there is none",
        true,
        ColorType::Grayscale,
        relative,
    ));
    if let Some(flip) = flip {
        let codes = shrink
            .plane(&flip.map)
            .iter()
            .map(|&error| (error * 255.0).round() as u8)
            .collect();
        plates.push((
            "flip",
            "ꟻLIP, from 0, black, to 1, white",
            true,
            ColorType::Grayscale,
            codes,
        ));
    }
    let size = (shrink.columns as u32, shrink.rows as u32);
    let all = plates
        .into_par_iter()
        .map(|(name, title, alone, kind, bytes)| {
            let mut file = Vec::new();
            encode_bytes(&mut file, size, kind, &bytes)?;
            let uri = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(file));
            Ok(Picture {
                name,
                title,
                alone,
                uri,
            })
        })
        .collect::<io::Result<_>>()?;
    Ok(Pictures {
        columns: shrink.columns,
        rows: shrink.rows,
        scale: shrink.scale,
        exposure,
        headroom: libm::exp2f(HEADROOM),
        relative_range,
        all,
    })
}

/// Half stops that bring all but the brightest twentieth below white; 0 for a black image.
fn exposure(image: &[Rgb]) -> f32 {
    const NEARLY_WHITE: f32 = 0.8;
    let mut luminances: Vec<f32> = image
        .iter()
        .map(|pixel| pixel.luminance())
        .filter(|&y| y > 0.0)
        .collect();
    if luminances.is_empty() {
        return 0.0;
    }
    let rank = (luminances.len() * 19 / 20).min(luminances.len() - 1);
    let (_, &mut bright, _) = luminances.select_nth_unstable_by(rank, f32::total_cmp);
    ((libm::log2f(NEARLY_WHITE / bright) * 2.0).round() / 2.0).clamp(-64.0, 64.0)
}

fn encode_colours(image: &[Rgb], tonemap: Tonemap) -> Vec<u8> {
    let encode = tonemap.encoder();
    image
        .par_iter()
        .flat_map_iter(|pixel| pixel.to_array().map(&encode))
        .collect()
}

/// Codes of the difference of luminances over the reference's, 128 for none, 1 and 255 for the range or more; and the range:
/// 1, 2 or 5 times a power of ten that holds 98 % of the pixels.
fn relative([reference, test]: &[Vec<Rgb>; 2]) -> (Vec<u8>, f32) {
    let mean = reference
        .iter()
        .map(|pixel| f64::from(pixel.luminance().abs()))
        .sum::<f64>()
        / reference.len().max(1) as f64;
    // Black pixels have no relative difference; a hundredth of the mean is as good as black.
    let floor = (0.01 * mean).max(f64::from(f32::MIN_POSITIVE));
    let differences: Vec<f64> = (reference.iter().zip(test))
        .map(|(a, b)| {
            let [a, b] = [a, b].map(|pixel| f64::from(pixel.luminance()));
            (b - a) / (a.abs() + floor)
        })
        .collect();
    let mut sizes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
    let rank = (sizes.len() * 98 / 100).min(sizes.len().saturating_sub(1));
    let most = match sizes.is_empty() {
        true => 0.0,
        false => *sizes.select_nth_unstable_by(rank, f64::total_cmp).1,
    };
    let range = round_up(most.clamp(1e-4, 1e4));
    let code = |d: &f64| (128.0 + 127.0 * (d / range).clamp(-1.0, 1.0)).round() as u8;
    (differences.iter().map(code).collect(), range as f32)
}

/// The next of 1, 2, 5 times a power of ten.
fn round_up(x: f64) -> f64 {
    let power = libm::pow(10.0, libm::log10(x).floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * power);
    steps
        .into_iter()
        .find(|&step| step >= x)
        .unwrap_or(10.0 * power)
}
