//! The channels of an image file, each declared once for writing and reading.
//!
//! `R G B` are the means, `variance.*` the variances of the means, AOVs their means: all 32-bit floats, for viewers.
//! `length.N.*` and `variance.length.N.*` are the same of paths of N edges alone.
//! `exact.*` are what a merge adds up: the sample count, and each exact sum as four 32-bit words, the least first.

use super::{AovSet, Film, exact};

/// One channel.
pub(super) struct Plane {
    /// Its name in the file.
    pub name: String,
    /// What it holds.
    pub content: Content,
}

/// What a channel holds.
#[derive(Clone, Copy)]
pub(super) enum Content {
    /// A float for viewers; it follows from the exact words.
    Shown(Shown),
    /// 32 bits of what is exact.
    Exact(Exact),
}

/// A float for viewers.
#[derive(Clone, Copy)]
pub(super) enum Shown {
    Mean(usize),
    Variance(usize),
    /// By place among the components that the film holds.
    Aov(usize),
    /// By length less 1, and channel.
    LengthMean(usize, usize),
    LengthVariance(usize, usize),
}

/// An exact number, or a word of one.
#[derive(Clone, Copy)]
pub(super) enum Exact {
    Samples,
    Sum(usize, u32),
    Square(usize, u32),
    Aov(usize, u32),
    LengthSum(usize, usize, u32),
    LengthSquare(usize, usize, u32),
}

/// Words of an `i128`.
const WORDS: u32 = 4;

/// All channels of a film with these AOVs, in the order of their names, as OpenEXR wants them.
pub(super) fn planes(aovs: AovSet) -> Vec<Plane> {
    let mut all = Vec::new();
    let mut plane = |name: String, content| all.push(Plane { name, content });
    plane("exact.samples".to_owned(), Content::Exact(Exact::Samples));
    for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
        plane(channel.to_owned(), Content::Shown(Shown::Mean(c)));
        plane(
            format!("variance.{channel}"),
            Content::Shown(Shown::Variance(c)),
        );
        for w in 0..WORDS {
            plane(
                format!("exact.sum.{channel}.{w}"),
                Content::Exact(Exact::Sum(c, w)),
            );
            plane(
                format!("exact.square.{channel}.{w}"),
                Content::Exact(Exact::Square(c, w)),
            );
        }
    }
    for (k, component) in aovs.present().enumerate() {
        let channel = component.channel;
        plane(channel.to_owned(), Content::Shown(Shown::Aov(k)));
        for w in 0..WORDS {
            plane(
                format!("exact.{channel}.{w}"),
                Content::Exact(Exact::Aov(k, w)),
            );
        }
    }
    for length in 0..aovs.lengths as usize {
        let number = length + 1;
        for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
            plane(
                format!("length.{number}.{channel}"),
                Content::Shown(Shown::LengthMean(length, c)),
            );
            plane(
                format!("variance.length.{number}.{channel}"),
                Content::Shown(Shown::LengthVariance(length, c)),
            );
            for w in 0..WORDS {
                plane(
                    format!("exact.length.{number}.sum.{channel}.{w}"),
                    Content::Exact(Exact::LengthSum(length, c, w)),
                );
                plane(
                    format!("exact.length.{number}.square.{channel}.{w}"),
                    Content::Exact(Exact::LengthSquare(length, c, w)),
                );
            }
        }
    }
    all.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    all
}

/// The AOVs whose exact channels are among `names`.
pub(super) fn aovs_among(names: &[String]) -> AovSet {
    let has = |name: &str| names.iter().any(|n| n == name);
    AovSet {
        albedo: has("exact.albedo.R.0"),
        normal: has("exact.normal.X.0"),
        depth: has("exact.depth.Z.0"),
        lengths: (0..AovSet::MAX_LENGTHS)
            .take_while(|length| has(&format!("exact.length.{}.sum.R.0", length + 1)))
            .count() as u32,
    }
}

/// The bits of a channel along row `y` of the region (absolute), from column `x` of the region on (relative to it).
pub(super) fn read_row(film: &Film, content: Content, y: u32, x: usize, out: &mut [u32]) {
    let (band, first) = film.band(y);
    let stride = film.aovs.components();
    let lengths = film.aovs.lengths as usize;
    let word = |value: i128, w: u32| (value >> (32 * w)) as u32;
    for (i, out) in (first + x..).zip(out) {
        *out = match content {
            Content::Exact(Exact::Samples) => band.counts[i],
            Content::Exact(Exact::Sum(c, w)) => word(band.sums[i].sum[c].0, w),
            Content::Exact(Exact::Square(c, w)) => word(band.sums[i].square[c].0, w),
            Content::Exact(Exact::Aov(k, w)) => word(band.aovs[i * stride + k].0, w),
            Content::Shown(Shown::Mean(c)) => band.mean(i)[c].to_bits(),
            Content::Shown(Shown::Variance(c)) => band.variance(i)[c].to_bits(),
            Content::Shown(Shown::Aov(k)) => {
                (exact::mean(band.aovs[i * stride + k], band.counts[i]) as f32).to_bits()
            }
            Content::Exact(Exact::LengthSum(n, c, w)) => {
                word(band.lengths[i * lengths + n].sum[c].0, w)
            }
            Content::Exact(Exact::LengthSquare(n, c, w)) => {
                word(band.lengths[i * lengths + n].square[c].0, w)
            }
            Content::Shown(Shown::LengthMean(n, c)) => {
                band.lengths[i * lengths + n].mean(band.counts[i])[c].to_bits()
            }
            Content::Shown(Shown::LengthVariance(n, c)) => {
                band.lengths[i * lengths + n].variance(band.counts[i])[c].to_bits()
            }
        };
    }
}

/// Puts the words of an exact channel where [`read_row`] found them; each into a film whose bits there are 0.
pub(super) fn write_row(film: &Film, content: Exact, y: u32, x: usize, words: &[u32]) {
    let (mut band, first) = film.band(y);
    let stride = film.aovs.components();
    let lengths = film.aovs.lengths as usize;
    let put = |value: &mut i128, w: u32, bits: u32| {
        *value |= (u128::from(bits) << (32 * w)).cast_signed();
    };
    for (i, &bits) in (first + x..).zip(words) {
        match content {
            Exact::Samples => band.counts[i] = bits,
            Exact::Sum(c, w) => put(&mut band.sums[i].sum[c].0, w, bits),
            Exact::Square(c, w) => put(&mut band.sums[i].square[c].0, w, bits),
            Exact::Aov(k, w) => put(&mut band.aovs[i * stride + k].0, w, bits),
            Exact::LengthSum(n, c, w) => {
                put(&mut band.lengths[i * lengths + n].sum[c].0, w, bits);
            }
            Exact::LengthSquare(n, c, w) => {
                put(&mut band.lengths[i * lengths + n].square[c].0, w, bits);
            }
        }
    }
}

/// Whether every number could have come from adding samples; a file can say anything, and a later merge must not overflow.
pub(super) fn is_possible(film: &Film) -> bool {
    let stride = film.aovs.components();
    let lengths = film.aovs.lengths as usize;
    (film.region.y0..film.region.y1).all(|y| {
        let (band, first) = film.band(y);
        (first..first + film.region.width() as usize).all(|i| {
            let count = band.counts[i];
            // |x| < 2^32 in units of 2^-64.
            let limit = u128::from(count) << 96;
            let fits = |sum: &exact::Sum| sum.0.unsigned_abs() <= limit;
            let possible = |sums: &super::PixelSums| {
                sums.sum.iter().all(fits) && sums.square.iter().all(|q| q.0 >= 0)
            };
            count <= exact::MAX_SAMPLES
                && possible(&band.sums[i])
                && band.lengths[i * lengths..(i + 1) * lengths]
                    .iter()
                    .all(possible)
                && band.aovs[i * stride..(i + 1) * stride].iter().all(fits)
        })
    })
}
