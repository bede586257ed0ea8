//! Samplers: lane by lane equal to their oracles, and as uniform as they promise.

mod common;

use common::chi_square;
use ondine::lanes::{WIDTH, u32x8};
use ondine::sampling::{Dimension, Sampler, hash, pcg, sobol};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

fn lanes(f: impl Fn(u32) -> u32) -> u32x8 {
    u32x8::new(std::array::from_fn(|i| f(i as u32)))
}

#[test]
fn the_pcg_sampler_equals_rand_pcg_in_every_lane() {
    let states: [u64; WIDTH] =
        std::array::from_fn(|i| (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0xdead_beef);
    let low = lanes(|i| states[i as usize] as u32);
    let high = lanes(|i| (states[i as usize] >> 32) as u32);
    let mut oracles = states.map(|state| Pcg32::new(state, pcg::STREAM));
    for jump in pcg::Jump::table(200) {
        let wide = pcg::output(low, high, jump).to_array();
        for (lane, oracle) in oracles.iter_mut().enumerate() {
            assert_eq!(wide[lane], oracle.next_u32());
        }
    }
}

#[test]
fn a_pcg_number_is_reached_as_by_advancing_its_generator() {
    let sampler = Sampler::pcg(7, 6);
    let path = sampler.path_key(lanes(|i| i * 77), lanes(|i| i));
    for bounce in 0..6 {
        let (first, second) = sampler.pair(path, Dimension::BsdfDirection, bounce);
        for lane in 0..WIDTH {
            let low = u64::from(path.key.to_array()[lane]);
            let high = u64::from(path.index.to_array()[lane]);
            let mut oracle = Pcg32::new(high << 32 | low, pcg::STREAM);
            oracle.advance(Dimension::BsdfDirection.position(bounce).into());
            let mut number = || (oracle.next_u32() >> 9) as f32 / 8_388_608.0;
            assert_eq!(first.to_array()[lane], number());
            assert_eq!(second.to_array()[lane], number());
        }
    }
}

#[test]
fn the_sobol_sampler_equals_sobol_burley_in_every_lane() {
    for round in 0..4096u32 {
        let seed = lanes(|i| hash::hash_word(round * 8 + i));
        let index = lanes(|i| (round * 8 + i) * 2 + (i & 1));
        let (x, y) = sobol::pair(sobol::reverse_bits(index), seed);
        let single = sobol::single(sobol::reverse_bits(index), seed);
        for lane in 0..WIDTH {
            let (index, seed) = (index.to_array()[lane], seed.to_array()[lane]);
            assert_eq!(x.to_array()[lane], sobol_burley::sample(index, 0, seed));
            assert_eq!(y.to_array()[lane], sobol_burley::sample(index, 1, seed));
            assert_eq!(single.to_array()[lane], x.to_array()[lane]);
        }
    }
}

#[test]
fn bits_are_reversed_as_by_the_scalar_instruction() {
    for round in 0..1000 {
        let words = lanes(|i| hash::hash_word(round * 8 + i));
        let reversed = sobol::reverse_bits(words).to_array();
        assert_eq!(reversed, words.to_array().map(u32::reverse_bits));
    }
}

/// The points of one pair for samples `first..first + count` of a pixel.
fn points(sampler: &Sampler, pixel: u32, first: u32, count: u32) -> Vec<(f32, f32)> {
    (0..count)
        .step_by(WIDTH)
        .flat_map(|base| {
            let path = sampler.path_key(u32x8::splat(pixel), lanes(|i| first + base + i));
            let (x, y) = sampler.pair(path, Dimension::LightPoint, 2);
            x.to_array().into_iter().zip(y.to_array())
        })
        .collect()
}

#[test]
fn every_aligned_power_of_two_of_sobol_samples_is_a_net() {
    let sampler = Sampler::sobol(3, 6);
    for pixel in [0, 1, 70_000] {
        for log in [4u32, 6, 8] {
            let count = 1 << log;
            for block in [0, 1, 5, 255] {
                let points = points(&sampler, pixel, block * count, count);
                // Each elementary interval of area 1/count holds exactly one point.
                for across in 0..=log {
                    let (columns, rows) = (1u32 << across, count >> across);
                    let mut hit = vec![0; count as usize];
                    for &(x, y) in &points {
                        let column = (x * columns as f32) as u32;
                        let row = (y * rows as f32) as u32;
                        hit[(row * columns + column) as usize] += 1;
                    }
                    assert!(hit.iter().all(|&n| n == 1), "{log} {across} {block}");
                }
            }
        }
    }
}

/// Counts of a pair over a grid of 32 x 32 cells, for 64 samples of many pixels.
fn counts(sampler: &Sampler, dimension: Dimension, bounce: u32) -> Vec<u64> {
    let mut counts = vec![0; 32 * 32];
    for pixel in 0..8192 {
        for first in (0..64).step_by(WIDTH) {
            let path = sampler.path_key(u32x8::splat(pixel * 37), lanes(|i| first + i));
            let (x, y) = sampler.pair(path, dimension, bounce);
            for (x, y) in x.to_array().into_iter().zip(y.to_array()) {
                counts[(y * 32.0) as usize * 32 + (x * 32.0) as usize] += 1;
            }
        }
    }
    counts
}

#[test]
fn independent_pairs_are_uniform_at_every_bounce() {
    let expected = vec![8192.0 * 64.0 / 1024.0; 1024];
    for (name, sampler, bounces) in [
        ("pcg", Sampler::pcg(5, 64), [0, 1, 7, 63]),
        ("sobol", Sampler::sobol(5, 64), [4, 5, 7, 63]),
    ] {
        for bounce in bounces {
            for dimension in [Dimension::LightPoint, Dimension::BsdfDirection] {
                let p = chi_square(&counts(&sampler, dimension, bounce), &expected);
                // Sixteen tests: one in 600 runs of another seed would fail.
                assert!(p > 1e-4, "{name} {dimension:?} {bounce}: p = {p}");
            }
        }
    }
}

#[test]
fn two_decisions_share_nothing() {
    // One number of each of two pairs, on a grid: independent if the joint counts are uniform.
    let expected = vec![8192.0 * 64.0 / 1024.0; 1024];
    for (name, sampler, bounce) in [
        ("pcg", Sampler::pcg(6, 8), 1),
        ("sobol", Sampler::sobol(6, 8), 1),
        ("sobol, hashed", Sampler::sobol(6, 8), 6),
    ] {
        let mut counts = vec![0; 1024];
        // One sample of each pixel: the samples of a pixel are stratified, and not independent.
        for pixel in 0..8192 * 8 {
            let path = sampler.path_key(lanes(|i| pixel * 8 + i), u32x8::splat(pixel % 64));
            let (x, _) = sampler.pair(path, Dimension::LightPoint, bounce);
            let (y, _) = sampler.pair(path, Dimension::BsdfDirection, bounce);
            for (x, y) in x.to_array().into_iter().zip(y.to_array()) {
                counts[(y * 32.0) as usize * 32 + (x * 32.0) as usize] += 1;
            }
        }
        let p = chi_square(&counts, &expected);
        assert!(p > 1e-3, "{name}: p = {p}");
    }
}

#[test]
fn long_words_are_hashed_as_splitmix64_does() {
    // Its first numbers for the seed 0.
    let step = 0x9e37_79b9_7f4a_7c15_u64;
    let first = [
        0xe220_a839_7b1d_cdaf,
        0x6e78_9e6a_a1b9_65f4,
        0x06c4_5d18_8009_454f,
    ];
    assert_eq!(
        [0, 1, 2].map(|k| hash::hash_long(step.wrapping_mul(k))),
        first
    );
}
