//! From films to what a page draws: half floats, a layer of each side.

use super::look::Layer;
use crate::film::{Film, Region};
use axum::body::Bytes;
use half::f16;
use half::slice::HalfFloatSliceExt;
use serde::Serialize;
use std::sync::Arc;

/// What there is to be seen of a side.
#[derive(Clone, Default)]
pub struct Shown {
    /// The image; none while there are but coarse ones.
    pub film: Option<Arc<Film>>,
    /// A smaller or less exact image of the same, for pixels that have no sample yet.
    pub coarse: Option<Arc<Film>>,
}

/// Where sides begin in a message, bytes.
const ALIGNMENT: usize = 8;

impl Shown {
    /// Whether there is nothing yet.
    pub fn is_empty(&self) -> bool {
        self.film.is_none() && self.coarse.is_none()
    }
}

/// A picture of all sides, as it goes to the pages.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Grows from one to the next.
    pub number: u64,
    /// Header and pixels.
    pub message: Bytes,
}

#[derive(Serialize)]
struct Header {
    picture: u64,
    generation: u64,
    layer: Layer,
    sides: Vec<SideHeader>,
}

#[derive(Serialize)]
struct SideHeader {
    width: u32,
    height: u32,
    channels: usize,
    samples: u32,
    coarse: bool,
    offset: usize,
    bytes: usize,
}

/// A layer's values, row after row from the top.
struct Values {
    channels: usize,
    values: Vec<f32>,
}

/// The picture of a layer.
pub fn paint(number: u64, generation: u64, layer: Layer, sides: &[Shown]) -> Picture {
    let painted: Vec<Painted> = sides
        .iter()
        .filter_map(|side| paint_side(layer, side))
        .collect();
    let mut offset = 0;
    let headers = painted.iter().map(|side| {
        let bytes = side.values.values.len() * size_of::<f16>();
        let header = SideHeader {
            width: side.region.width(),
            height: side.region.height(),
            channels: side.values.channels,
            samples: side.samples,
            coarse: side.coarse,
            offset,
            bytes,
        };
        offset += bytes.next_multiple_of(ALIGNMENT);
        header
    });
    let header = Header {
        picture: number,
        generation,
        layer,
        sides: headers.collect(),
    };
    let mut text = serde_json::to_string(&header).unwrap_or_default();
    while !(4 + text.len()).is_multiple_of(ALIGNMENT) {
        text.push(' ');
    }
    let mut message = Vec::with_capacity(4 + text.len() + offset);
    message.extend((text.len() as u32).to_le_bytes());
    message.extend(text.as_bytes());
    for side in painted {
        let halves = to_halves(side.values.values);
        message.extend(halves.into_iter().flat_map(f16::to_le_bytes));
        message.resize(message.len().next_multiple_of(ALIGNMENT), 0);
    }
    Picture {
        number,
        message: message.into(),
    }
}

struct Painted {
    region: Region,
    values: Values,
    samples: u32,
    coarse: bool,
}

fn paint_side(layer: Layer, side: &Shown) -> Option<Painted> {
    let film = side.film.as_deref().or(side.coarse.as_deref())?;
    let counts = film.counts();
    let samples = counts.iter().copied().min().unwrap_or(0);
    let mut values = read(layer, film);
    let below = side.coarse.as_deref().filter(|_| side.film.is_some());
    if let (0, Some(coarse)) = (samples, below) {
        fill(&mut values, &counts, film.region(), layer, coarse);
    }
    Some(Painted {
        region: film.region(),
        values,
        samples,
        coarse: side.film.is_none(),
    })
}

/// Puts a coarse image where there is no sample.
fn fill(to: &mut Values, counts: &[u32], region: Region, layer: Layer, coarse: &Film) {
    let small = read(layer, coarse);
    let (width, height) = (coarse.region().width(), coarse.region().height());
    // The coarse pixel that a pixel's centre is in.
    let along = |at: usize, size: u32, from: u32| {
        ((2 * at as u64 + 1) * u64::from(size) / (2 * u64::from(from))) as usize
    };
    let columns: Vec<usize> = (0..region.width() as usize)
        .map(|x| along(x, width, region.width()))
        .collect();
    let rows = counts.chunks_exact(region.width() as usize);
    let n = to.channels;
    for (y, row) in rows.enumerate() {
        let from = along(y, height, region.height()) * width as usize;
        for (x, _) in row.iter().enumerate().filter(|(_, count)| **count == 0) {
            let pixel = (y * region.width() as usize + x) * n;
            let source = (from + columns[x]) * n;
            to.values[pixel..pixel + n].copy_from_slice(&small.values[source..source + n]);
        }
    }
}

fn read(layer: Layer, film: &Film) -> Values {
    let colors = |pixels: Vec<[f32; 3]>| Values {
        channels: 3,
        values: pixels.into_flattened(),
    };
    let each = |read: &dyn Fn(u32, u32) -> [f32; 3]| {
        colors(
            film.region()
                .coordinates()
                .map(|(x, y)| read(x, y))
                .collect(),
        )
    };
    match layer {
        Layer::Radiance => colors(film.means()),
        Layer::Error => {
            let variances = film.variances();
            colors(variances.into_iter().map(|v| v.map(f32::sqrt)).collect())
        }
        Layer::Albedo => each(&|x, y| film.aov(x, y).albedo),
        Layer::Normal => each(&|x, y| film.aov(x, y).normal),
        Layer::Depth => Values {
            channels: 1,
            values: film
                .region()
                .coordinates()
                .map(|(x, y)| film.aov(x, y).depth)
                .collect(),
        },
        Layer::Length(length) => {
            each(&|x, y| film.sums_of_length(length, x, y).mean(film.count(x, y)))
        }
    }
}

/// The nearest half floats; what is too large is the largest.
fn to_halves(mut values: Vec<f32>) -> Vec<f16> {
    let most = f16::MAX.to_f32();
    values.iter_mut().for_each(|x| *x = x.clamp(-most, most));
    let mut halves = vec![f16::ZERO; values.len()];
    halves.convert_from_f32_slice(&values);
    halves
}
