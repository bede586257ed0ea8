//! The channels of an image file, each declared once for writing and reading.
//!
//! `R G B` are the means, `variance.*` the variances of the means, AOVs their means: all 32-bit floats, for viewers.
//! `length.N.*` and `variance.length.N.*` are the same of paths of N edges alone.
//! `exact.*` are what a merge adds up: the sample count, and each exact sum as four 32-bit words, the least first.

use super::{AovSet, Band, Film, exact};

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
    /// The number of samples.
    Samples,
    /// 32 bits of an exact sum, by place from the least.
    Word(Number, u32),
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

/// An exact sum of a pixel.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Sum(usize),
    Square(usize),
    /// By place among the components that the film holds.
    Aov(usize),
    /// By length less 1, and channel.
    LengthSum(usize, usize),
    LengthSquare(usize, usize),
}

/// Words of an `i128`.
pub(super) const WORDS: u32 = 4;

/// All channels of a film with these AOVs, in the order of their names, as OpenEXR wants them.
pub(super) fn planes(aovs: AovSet) -> Vec<Plane> {
    let mut all = Vec::new();
    let mut plane = |name: String, content| all.push(Plane { name, content });
    plane("exact.samples".to_owned(), Content::Samples);
    for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
        plane(channel.to_owned(), Content::Shown(Shown::Mean(c)));
        plane(
            format!("variance.{channel}"),
            Content::Shown(Shown::Variance(c)),
        );
        for w in 0..WORDS {
            plane(
                format!("exact.sum.{channel}.{w}"),
                Content::Word(Number::Sum(c), w),
            );
            plane(
                format!("exact.square.{channel}.{w}"),
                Content::Word(Number::Square(c), w),
            );
        }
    }
    for (k, component) in aovs.present().enumerate() {
        let channel = component.channel;
        plane(channel.to_owned(), Content::Shown(Shown::Aov(k)));
        for w in 0..WORDS {
            plane(
                format!("exact.{channel}.{w}"),
                Content::Word(Number::Aov(k), w),
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
                    Content::Word(Number::LengthSum(length, c), w),
                );
                plane(
                    format!("exact.length.{number}.square.{channel}.{w}"),
                    Content::Word(Number::LengthSquare(length, c), w),
                );
            }
        }
    }
    all.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
    all
}

/// The AOVs whose exact channels a file has.
pub(super) fn aovs_among(has: impl Fn(&str) -> bool) -> AovSet {
    AovSet {
        albedo: has("exact.albedo.R.0"),
        normal: has("exact.normal.X.0"),
        depth: has("exact.depth.Z.0"),
        lengths: (0..AovSet::MAX_LENGTHS)
            .take_while(|length| has(&format!("exact.length.{}.sum.R.0", length + 1)))
            .count() as u32,
    }
}

/// The bytes of a channel along row `y` (absolute) of the film's region, in the machine's own order.
pub(super) fn read_row(film: &Film, content: Content, y: u32, out: &mut [u8]) {
    /// The choice of what is read is made outside of the loop.
    fn fill(out: &mut [u8], first: usize, word: impl Fn(usize) -> u32) {
        for (i, bytes) in (first..).zip(out.as_chunks_mut().0) {
            *bytes = word(i).to_ne_bytes();
        }
    }
    let (band, first) = film.band(y);
    let (counts, sums, aovs, lengths) = (&band.counts, &band.sums, &band.aovs, &band.lengths);
    let aov = |k| move |i| i * film.aovs.components() + k;
    let length = |n| move |i| i * film.aovs.lengths as usize + n;
    match content {
        Content::Samples => fill(out, first, |i| counts[i]),
        Content::Word(number, w) => {
            let word = |value: i128| (value >> (32 * w)) as u32;
            match number {
                Number::Sum(c) => fill(out, first, |i| word(sums[i].sum[c].0)),
                Number::Square(c) => fill(out, first, |i| word(sums[i].square[c].0)),
                Number::Aov(k) => fill(out, first, |i| word(aovs[aov(k)(i)].0)),
                Number::LengthSum(n, c) => {
                    fill(out, first, |i| word(lengths[length(n)(i)].sum[c].0));
                }
                Number::LengthSquare(n, c) => {
                    fill(out, first, |i| word(lengths[length(n)(i)].square[c].0));
                }
            }
        }
        Content::Shown(shown) => match shown {
            Shown::Mean(c) => fill(out, first, |i| sums[i].mean_of(c, counts[i]).to_bits()),
            Shown::Variance(c) => fill(out, first, |i| sums[i].variance_of(c, counts[i]).to_bits()),
            Shown::Aov(k) => fill(out, first, |i| {
                (exact::mean(aovs[aov(k)(i)], counts[i]) as f32).to_bits()
            }),
            Shown::LengthMean(n, c) => fill(out, first, |i| {
                lengths[length(n)(i)].mean_of(c, counts[i]).to_bits()
            }),
            Shown::LengthVariance(n, c) => fill(out, first, |i| {
                lengths[length(n)(i)].variance_of(c, counts[i]).to_bits()
            }),
        },
    }
}

/// Puts an exact sum of every pixel of a row where [`read_row`] found it, from the bytes of its [`WORDS`], the least
/// word first.
pub(super) fn write_row(
    row: &mut Band,
    aovs: AovSet,
    number: Number,
    words: [&[u8]; WORDS as usize],
) {
    let [first, second, third, last] = words.map(|bytes| bytes.as_chunks().0);
    let wide = |low: &[u8; 4], high: &[u8; 4]| {
        u64::from(u32::from_ne_bytes(*low)) | u64::from(u32::from_ne_bytes(*high)) << 32
    };
    let low = first.iter().zip(second).map(|(low, high)| wide(low, high));
    let high = third.iter().zip(last).map(|(low, high)| wide(low, high));
    let values = low
        .zip(high)
        .map(|(low, high)| (u128::from(low) | u128::from(high) << 64).cast_signed());
    let lengths = aovs.lengths.max(1) as usize;
    match number {
        Number::Sum(c) => row
            .sums
            .iter_mut()
            .zip(values)
            .for_each(|(to, x)| to.sum[c].0 = x),
        Number::Square(c) => row
            .sums
            .iter_mut()
            .zip(values)
            .for_each(|(to, x)| to.square[c].0 = x),
        Number::Aov(k) => {
            let to = row.aovs.iter_mut().skip(k).step_by(aovs.components());
            to.zip(values).for_each(|(to, x)| to.0 = x);
        }
        Number::LengthSum(n, c) => {
            let to = row.lengths.iter_mut().skip(n).step_by(lengths);
            to.zip(values).for_each(|(to, x)| to.sum[c].0 = x);
        }
        Number::LengthSquare(n, c) => {
            let to = row.lengths.iter_mut().skip(n).step_by(lengths);
            to.zip(values).for_each(|(to, x)| to.square[c].0 = x);
        }
    }
}

/// Whether every number of a row could have come from adding samples; a file can say anything, and a merge must not
/// overflow.
pub(super) fn is_possible(row: &Band, aovs: AovSet) -> bool {
    let (stride, lengths) = (aovs.components(), aovs.lengths as usize);
    row.counts.iter().enumerate().all(|(i, &count)| {
        // |x| < 2^32 in units of 2^-64.
        let limit = u128::from(count) << 96;
        let fits = |sum: &exact::Sum| sum.0.unsigned_abs() <= limit;
        let possible = |sums: &super::PixelSums| {
            sums.sum.iter().all(fits) && sums.square.iter().all(|q| q.0 >= 0)
        };
        count <= exact::MAX_SAMPLES
            && possible(&row.sums[i])
            && row.lengths[i * lengths..(i + 1) * lengths]
                .iter()
                .all(possible)
            && row.aovs[i * stride..(i + 1) * stride].iter().all(fits)
    })
}
