//! Which sample blocks there are, against sets of numbers.

use crate::Random;
use ondine::film::{BLOCK, Coverage, Passes, Region, Shard};
use std::collections::BTreeSet;
use std::ops::Range;

const REGION: Region = Region {
    x0: 3,
    y0: 5,
    x1: 10,
    y1: 9,
};
const PIXELS: u64 = 28;

fn set(coverage: &Coverage) -> BTreeSet<u64> {
    coverage.ranges().iter().cloned().flatten().collect()
}

fn some_ranges(random: &mut Random, most: u64) -> Vec<Range<u64>> {
    let count = random.below(9);
    let mut below = |most: u64| random.below(most as usize) as u64;
    (0..count)
        .map(|_| {
            let start = below(most);
            start..start + below(most / 3)
        })
        .collect()
}

/// The samples of each pixel, counted one block at a time.
fn counts(coverage: &Coverage, spp: u32) -> Vec<u32> {
    let mut counts = vec![0; PIXELS as usize];
    for block in set(coverage) {
        let (pass, pixel) = ((block / PIXELS) as u32, block % PIXELS);
        counts[pixel as usize] += spp.saturating_sub(pass * BLOCK).min(BLOCK);
    }
    counts
}

#[test]
fn it_is_a_set_of_numbers() {
    let mut random = Random(1);
    for _ in 0..2000 {
        let (a, b) = (some_ranges(&mut random, 60), some_ranges(&mut random, 60));
        let (one, two) = (Coverage::of(a.clone()), Coverage::of(b.clone()));
        let (s, t): (BTreeSet<u64>, BTreeSet<u64>) = (
            a.into_iter().flatten().collect(),
            b.into_iter().flatten().collect(),
        );
        assert_eq!(set(&one), s);
        assert!(
            one.ranges()
                .windows(2)
                .all(|pair| pair[0].end < pair[1].start),
            "{one}"
        );
        assert_eq!((one.len(), one.is_empty()), (s.len() as u64, s.is_empty()));
        assert_eq!(set(&one.union(&two)), &s | &t, "{one} and {two}");
        assert_eq!(set(&one.without(&two)), &s - &t, "{one} without {two}");
        assert_eq!(set(&one.intersection(&two)), &s & &t, "{one} in {two}");
        assert_eq!(one.contains(&two), t.is_subset(&s), "{one} has {two}");
        assert_eq!(one.to_string().parse(), Ok(one.clone()));
    }
    for wrong in [
        "3..3",
        "5..4",
        "4..6,6..8",
        "4..6,1..2",
        "a..b",
        "1",
        "1..2..3",
        "-1..2",
    ] {
        assert!(wrong.parse::<Coverage>().is_err(), "{wrong}");
    }
}

#[test]
fn shards_are_disjoint_even_and_the_whole() {
    let mut random = Random(2);
    for _ in 0..300 {
        let whole = Coverage::of(some_ranges(&mut random, 200));
        let of = 1 + random.below(70) as u32;
        let parts: Vec<Coverage> = Shard::all(of).map(|shard| whole.part(shard)).collect();
        let together = parts
            .iter()
            .fold(Coverage::default(), |sum, part| sum.union(part));
        assert_eq!(together, whole);
        assert_eq!(parts.iter().map(Coverage::len).sum::<u64>(), whole.len());
        let (least, most) = (
            whole.len() / u64::from(of),
            whole.len().div_ceil(u64::from(of)),
        );
        assert!(
            parts
                .iter()
                .all(|part| (least..=most).contains(&part.len()))
        );
    }
    // Numbers near the greatest do not overflow.
    let all = Coverage::of(std::iter::once(0..u64::MAX));
    let last = Shard::all(1 << 20).last().unwrap();
    assert_eq!(all.part(last).ranges().last().unwrap().end, u64::MAX);
}

#[test]
fn rectangles_are_its_blocks_in_their_order() {
    let mut random = Random(3);
    for _ in 0..2000 {
        let coverage = Coverage::of(some_ranges(&mut random, 200));
        let rectangles = coverage.rectangles(REGION);
        let whole = |part: &Passes| Coverage::of_passes(REGION, part);
        let together = rectangles
            .iter()
            .map(whole)
            .fold(Coverage::default(), |sum, part| {
                assert!(sum.intersection(&part).is_empty(), "{coverage} twice");
                sum.union(&part)
            });
        assert_eq!(together, coverage);
        assert!(rectangles.len() <= 7 * coverage.ranges().len());
        let firsts: Vec<u64> = rectangles
            .iter()
            .map(|part| whole(part).ranges()[0].start)
            .collect();
        assert!(firsts.is_sorted(), "{coverage}");

        let pixels: BTreeSet<u64> = set(&coverage).iter().map(|block| block % PIXELS).collect();
        let coordinates: Vec<(u32, u32)> = REGION.coordinates().collect();
        let bounds = pixels
            .iter()
            .map(|&pixel| coordinates[pixel as usize])
            .map(|(x, y)| Region {
                x0: x,
                y0: y,
                x1: x + 1,
                y1: y + 1,
            })
            .reduce(Region::bounding);
        // Runs are cut into rectangles, so the bounds are those of the pixels.
        assert_eq!(coverage.bounds(REGION), bounds, "{coverage}");
    }
}

#[test]
fn samples_are_those_of_each_block() {
    let mut random = Random(4);
    for _ in 0..2000 {
        let spp = 1 + random.below(120) as u32;
        let all = Coverage::of_samples(0..spp, PIXELS);
        assert_eq!(all.len(), PIXELS * u64::from(spp.div_ceil(BLOCK)));
        let coverage = all.intersection(&Coverage::of(some_ranges(&mut random, 250)));
        let counts = counts(&coverage, spp);
        let (min, max) = (*counts.iter().min().unwrap(), *counts.iter().max().unwrap());
        assert_eq!(
            coverage.samples(PIXELS, spp),
            (min, max),
            "{coverage} of {spp}"
        );
        let paths: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        assert_eq!(coverage.paths(PIXELS, spp), paths, "{coverage} of {spp}");

        let everywhere = |pass: u32| {
            let first = u64::from(pass) * PIXELS;
            (first..first + PIXELS).all(|block| set(&coverage).contains(&block))
        };
        let passes = (0..spp.div_ceil(BLOCK)).filter(|&pass| everywhere(pass));
        let samples: BTreeSet<u32> = passes
            .flat_map(|pass| pass * BLOCK..spp.min((pass + 1) * BLOCK))
            .collect();
        let told: Vec<Range<u32>> = coverage.sample_ranges(PIXELS, spp);
        assert_eq!(told.into_iter().flatten().collect::<BTreeSet<_>>(), samples);
    }
    let whole = Coverage::of_samples(0..40, PIXELS);
    assert_eq!(
        (whole.samples(PIXELS, 40), whole.paths(PIXELS, 40)),
        ((40, 40), 40 * PIXELS)
    );
    assert_eq!(Coverage::default().samples(PIXELS, 40), (0, 0));
}

#[test]
fn a_shard_is_written_as_it_is_asked_for() {
    let shard: Shard = "3/16".parse().unwrap();
    assert_eq!(
        (shard.number(), shard.of(), shard.to_string().as_str()),
        (3, 16, "3/16")
    );
    for wrong in [
        "0/4",
        "5/4",
        "1/0",
        "1",
        "1/",
        "/2",
        "-1/4",
        "1/4294967295",
        "a/b",
        "1/2/3",
    ] {
        let message = wrong.parse::<Shard>().unwrap_err().to_string();
        assert!(message.contains("write K/N"), "{message}");
    }
}
