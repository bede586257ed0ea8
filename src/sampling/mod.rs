//! Floor 1: random numbers with names, and the warps that turn them into points and directions.
//!
//! Every number is a pure function of (seed, pixel, sample, bounce, dimension): nothing is drawn "next".

mod dimension;
pub mod hash;
pub mod mis;
pub mod pcg;
pub mod sobol;
pub mod warp;

pub use dimension::Dimension;

use crate::lanes::{f32x8, u32x8};
use hash::{hash, hash_word};

/// The last bounce whose numbers are Sobol' points; later ones are independent hashes, at a third of the cost.
///
/// What a path meets by then depends on so many numbers that the strata of one pair are lost: on the box (path length 6, 64
/// samples) the relative error is the same to 0.1 % with Sobol' points up to bounce 2, 3 and 5. One more is kept for paths
/// that pass through glass first.
pub const LAST_SOBOL_BOUNCE: u32 = 3;

/// Which numbers a sampler gives.
#[derive(Clone, Debug)]
enum Source {
    Pcg { jumps: Vec<pcg::Jump> },
    Sobol { seeds: Vec<u32> },
}

/// The random numbers of an image.
#[derive(Clone, Debug)]
pub struct Sampler {
    source: Source,
    /// The seed's halves, hashed.
    seed: [u32; 2],
}

/// Which path a lane is on: what a sampler needs to give it its numbers. The two words mean what the sampler wants.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathKeyX8 {
    /// First word.
    pub key: u32x8,
    /// Second word.
    pub index: u32x8,
}

impl Sampler {
    /// Independent numbers: each path has a PCG32 generator.
    pub fn pcg(seed: u64, path_length: u32) -> Self {
        let jumps = pcg::Jump::table(Self::numbers(path_length));
        Self {
            source: Source::Pcg { jumps },
            seed: Self::hashed(seed),
        }
    }

    /// Owen-scrambled Sobol' pairs up to [`LAST_SOBOL_BOUNCE`], independent numbers beyond.
    pub fn sobol(seed: u64, path_length: u32) -> Self {
        let seeds = (0..Self::numbers(path_length) as u32)
            .map(|position| hash_word(hash_word(position)))
            .collect();
        Self {
            source: Source::Sobol { seeds },
            seed: Self::hashed(seed),
        }
    }

    /// Numbers that a path of that many edges may ask for.
    fn numbers(path_length: u32) -> usize {
        (path_length as usize + 1) * Dimension::PER_BOUNCE as usize
    }

    fn hashed(seed: u64) -> [u32; 2] {
        let low = hash_word(seed as u32);
        let high = hash_word((seed >> 32) as u32 ^ low);
        [hash_word(low ^ high.rotate_left(16)), high]
    }

    /// Who each lane is: `pixel` is any number that is unique in the image, `sample` counts from 0.
    #[inline]
    pub fn path_key(&self, pixel: u32x8, sample: u32x8) -> PathKeyX8 {
        let [a, b] = self.seed.map(u32x8::splat);
        match self.source {
            // A 64-bit state: two chains of hashes, so that equal states are as rare as 2^-64 allows.
            Source::Pcg { .. } => PathKeyX8 {
                key: hash(sample ^ hash(pixel ^ a)),
                index: hash(hash(sample ^ b) ^ pixel),
            },
            Source::Sobol { .. } => {
                let sequence = sample >> 16;
                PathKeyX8 {
                    key: hash(hash(pixel ^ a) ^ sequence ^ b),
                    index: sobol::reverse_bits(sample & u32x8::splat(sobol::SEQUENCE_LENGTH - 1)),
                }
            }
        }
    }

    /// Two numbers in [0, 1) for a decision at a bounce.
    #[inline(always)]
    pub fn pair(&self, path: PathKeyX8, dimension: Dimension, bounce: u32) -> warp::Pair {
        let position = dimension.position(bounce) as usize;
        match &self.source {
            Source::Pcg { jumps } => (
                pcg::number(path.key, path.index, jumps[position]),
                pcg::number(path.key, path.index, jumps[position + 1]),
            ),
            Source::Sobol { seeds } => {
                let seed = hash(path.key ^ u32x8::splat(seeds[position]));
                if bounce <= LAST_SOBOL_BOUNCE {
                    sobol::pair(path.index, seed)
                } else {
                    let word = hash(seed ^ path.index);
                    (sobol::unit(word), sobol::unit(hash(word)))
                }
            }
        }
    }

    /// One number in [0, 1) for a decision at a bounce.
    #[inline]
    pub fn single(&self, path: PathKeyX8, dimension: Dimension, bounce: u32) -> f32x8 {
        let position = dimension.position(bounce) as usize;
        match &self.source {
            Source::Pcg { jumps } => pcg::number(path.key, path.index, jumps[position]),
            Source::Sobol { seeds } => {
                let seed = hash(path.key ^ u32x8::splat(seeds[position]));
                if bounce <= LAST_SOBOL_BOUNCE {
                    sobol::single(path.index, seed)
                } else {
                    sobol::unit(hash(seed ^ path.index))
                }
            }
        }
    }
}
