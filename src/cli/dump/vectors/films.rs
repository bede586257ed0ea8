//! The exact film: samples of a pixel, and its sums.

use super::page::{Case, Section, Topic};
use crate::error::Result;
use crate::film::{AovSet, BLOCK, Film, Layers, Region, block_sum};

pub(super) fn topic() -> Result<Topic> {
    Ok(Topic {
        name: "film",
        about: "The exact film: specification, section 11. A pixel (0, 0) of an image of 1 x 1 gets samples, W/(sr m^2), in blocks \
                of 16: samples are red, green, blue, red, ... block_sums and block_squares are the bits of f64, three a block. sum \
                and square are two's complement integers of 128 bits, in units of 2^-64 and 2^-40; count is the samples kept, \
                rejected those kept out; mean and variance (of the mean) are what the image shows.",
        sections: vec![Section::new("pixel", "One pixel.", cases()?)],
    })
}

fn cases() -> Result<Vec<Case>> {
    // A multiple of 2^-24 in [0, 1), by a golden-section rotation.
    let rotation = |i: u32, by: u32| (i.wrapping_mul(by) >> 8) as f32 / 16_777_216.0;
    let spread = |count: u32| -> Vec<[f32; 3]> {
        let sample = |i| [0x9e37_79b9, 0x6a09_e667, 0xbb67_ae85].map(|by| rotation(i + 1, by));
        (0..count).map(sample).collect()
    };
    let gray = |values: &[f32]| -> Vec<[f32; 3]> { values.iter().map(|&v| [v; 3]).collect() };
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    [
        ("none", Vec::new()),
        ("one", gray(&[0.5])),
        ("two", gray(&[1.0, 3.0])),
        ("a block", spread(BLOCK)),
        ("two blocks and a part", spread(2 * BLOCK + 5)),
        ("negative", vec![[-1.0, 0.25, -0.125], [0.5, -0.75, 2.0]]),
        ("large beside small", gray(&[4e9, 1e-3, 1e-7, 1e-12, 1e-20])),
        (
            "below a unit",
            gray(&[2.7e-20, 2.8e-20, 8.1e-20, 1e-30, 1e-40]),
        ),
        (
            "ties",
            // Halves of 2^-64, and of 2^-40 when squared.
            gray(&[2.710_505_4e-20, 8.131_516e-20, 6.743_496e-7, 1.168_008e-6]),
        ),
        (
            "rejected",
            vec![
                [1.0, 2.0, 3.0],
                [inf, 0.0, 0.0],
                [0.0, nan, 0.0],
                [0.0, 0.0, -inf],
                [4_294_967_296.0, 0.0, 0.0],
                [4_294_967_040.0, 0.0, 0.0],
            ],
        ),
    ]
    .map(|(name, samples)| case(name, &samples))
    .into_iter()
    .collect()
}

fn case(name: &str, samples: &[[f32; 3]]) -> Result<Case> {
    let film = Film::new(1, 1, Region::full(1, 1), AovSet::default())?;
    let (mut block_sums, mut block_squares) = (Vec::new(), Vec::new());
    for block in samples.chunks(BLOCK as usize) {
        let radiance: Vec<[f32; 4]> = block.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        let added = block_sum(&radiance);
        let words = |sums: [f64; 4]| sums.map(|sum| u128::from(sum.to_bits()));
        block_sums.extend_from_slice(&words(added.sum.to_array())[..3]);
        block_squares.extend_from_slice(&words(added.square.to_array())[..3]);
        let samples = block.len() as u32;
        film.add(Region::full(1, 1), samples, &radiance, Layers::default());
    }
    let sums = film.sums(0, 0);
    let words = |sums: [i128; 3]| sums.map(i128::cast_unsigned);
    Ok(Case::new()
        .text("name", name)
        .floats("samples", samples.as_flattened())
        .wide_words("block_sums", &block_sums, 16)
        .wide_words("block_squares", &block_squares, 16)
        .whole("count", film.count(0, 0))
        .whole("rejected", film.rejected() as u32)
        .wide_words("sum", &words(sums.sum.map(|sum| sum.0)), 32)
        .wide_words("square", &words(sums.square.map(|square| square.0)), 32)
        .floats("mean", &film.mean(0, 0))
        .floats("variance", &film.variance(0, 0))
        .text("image_hash", &film.image_hash()))
}
