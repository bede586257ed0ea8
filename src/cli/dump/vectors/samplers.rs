//! Random numbers: hashes, path keys, both samplers.

use super::one;
use super::page::{Case, Section, Topic};
use crate::lanes::u32x8;
use crate::sampling::{Dimension, Sampler, hash, pcg};

/// A path: seed, column, row, sample.
type Path = (u64, u32, u32, u32);

/// Paths of which every number up to edge 4 is written.
const WHOLE: [Path; 2] = [(0, 0, 0, 0), (0xdead_beef_cafe_f00d, 255, 127, 13)];

/// Paths of which a few numbers are written: each part of a key is varied by itself, and to its end.
const OTHERS: [Path; 9] = [
    (0, 0, 0, 1),
    (0, 1, 0, 0),
    (0, 0, 1, 0),
    (1, 0, 0, 0),
    (1 << 32, 0, 0, 0),
    (u64::MAX, 65_534, 65_534, 65_535),
    (7, 12, 34, 65_535),
    (7, 12, 34, 65_536),
    (7, 12, 34, 134_217_727),
];

/// The numbers of the others.
const FEW: [(Dimension, u32); 5] = [
    (Dimension::PixelFilter, 0),
    (Dimension::LightChoice, 1),
    (Dimension::LightPoint, 2),
    (Dimension::BsdfDirection, 3),
    (Dimension::BsdfDirection, 4),
];

/// Edges of the longest path that is asked for.
const EDGES: u32 = 5;

pub(super) fn topic() -> Topic {
    Topic {
        name: "samplers",
        about: "Random numbers: specification, section 4. Words are unsigned and of 32 bits; seeds have 64. Numbers are \
                multiples of 2^-23 in [0, 1). A decision that needs one number alone takes the first.",
        sections: vec![
            Section::new(
                "hash",
                "hash(word), a bijection of 32-bit words.",
                [0, 1, 2, 0x1234_5678, 0xe6fe_3beb, 0x8000_0000, u32::MAX]
                    .map(|word| {
                        Case::new()
                            .word("word", word)
                            .word("hash", hash::hash_word(word))
                    })
                    .into(),
            ),
            Section::new(
                "pcg",
                "The path of (seed, column, row, sample) has a key and an index, low and high half of its generator's state; \
                 words are outputs number position and position + 1, numbers what a decision gets.",
                cases(Sampler::pcg, true),
            ),
            Section::new(
                "sobol",
                "The path of (seed, column, row, sample) has a key and an index, the reversed bits of its place in a sequence. \
                 Edges above 3 have independent numbers.",
                cases(Sampler::sobol, false),
            ),
        ],
    }
}

fn cases(sampler: fn(u64, u32) -> Sampler, is_pcg: bool) -> Vec<Case> {
    let every = |path| {
        let edges = 0..EDGES;
        edges.flat_map(move |edge| Dimension::ALL.map(|dimension| (path, dimension, edge)))
    };
    let few = |path| FEW.map(|(dimension, edge)| (path, dimension, edge));
    let whole = WHOLE.into_iter().flat_map(every);
    let others = OTHERS.into_iter().flat_map(few);
    let case = |(path, dimension, edge)| case(sampler, is_pcg, path, dimension, edge);
    whole.chain(others).map(case).collect()
}

fn case(
    sampler: fn(u64, u32) -> Sampler,
    is_pcg: bool,
    (seed, column, row, sample): Path,
    dimension: Dimension,
    edge: u32,
) -> Case {
    let sampler = sampler(seed, EDGES);
    let key = sampler.path_key(u32x8::splat(row << 16 | column), u32x8::splat(sample));
    let position = dimension.position(edge);
    let (first, second) = sampler.pair(key, dimension, edge);
    let case = Case::new()
        .wide_word("seed", seed.into(), 16)
        .whole("column", column)
        .whole("row", row)
        .whole("sample", sample)
        .word("key", key.key.to_array()[0])
        .word("index", key.index.to_array()[0])
        .whole("edge", edge)
        .text("dimension", &format!("{dimension:?}"))
        .whole("position", position);
    let case = if is_pcg {
        let jumps = pcg::Jump::table(position as usize + 2);
        let word = |jump| pcg::output(key.key, key.index, jump).to_array()[0];
        let words: Vec<u32> = jumps
            .into_iter()
            .skip(position as usize)
            .map(word)
            .collect();
        case.words("words", &words)
    } else {
        case
    };
    case.floats("numbers", &[one(first), one(second)])
}
