//! Queues, records and tables against the plain loop, and random numbers that share nothing but their seed.

mod common;

use common::Random;
use glam::Vec3;
use ondine::lanes::{Batch, Queue, Rgb, Row, Shuffle, Table, WIDTH, f32x8, first_lanes, u32x8};
use ondine::record;
use ondine::sampling::{Dimension, Sampler};
use std::collections::HashSet;

record! {
    /// One field of each type.
    pub struct Probe, ProbeX8 {
        /// A number.
        number: f32,
        /// A word.
        word: u32,
        /// A vector.
        vector: Vec3,
        /// A colour.
        color: Rgb,
    }
}

fn probe(id: u32) -> Probe {
    let x = id as f32;
    Probe {
        number: x,
        word: id.wrapping_mul(0x9e37_79b9),
        vector: Vec3::new(x + 0.25, -x, x * 0.5),
        color: Rgb::new(x + 0.5, x * 2.0, -x - 1.0),
    }
}

fn batch(first: u32) -> ProbeX8 {
    let mut batch = ProbeX8::default();
    (0..WIDTH).for_each(|lane| batch.set_lane(lane, probe(first + lane as u32)));
    batch
}

fn assert_same(got: Probe, want: Probe) {
    assert_eq!(
        (got.number, got.word, got.vector, got.color),
        (want.number, want.word, want.vector, want.color)
    );
}

fn mask(bits: u32) -> f32x8 {
    f32x8::new(std::array::from_fn(|lane| {
        f32::from_bits(if bits >> lane & 1 == 1 { u32::MAX } else { 0 })
    }))
}

#[test]
fn pushing_under_every_mask_at_every_offset_is_the_scalar_filter() {
    for offset in 0..WIDTH as u32 {
        for bits in 0..256 {
            let mut queue = Queue::<ProbeX8>::with_capacity(24);
            (0..offset).for_each(|id| queue.push_one(probe(1000 + id)));
            queue.push(mask(bits), &batch(0));
            queue.push(mask(!bits & 0xff), &batch(100));
            let kept = |first: u32, bits: u32| {
                (0..8)
                    .filter(move |i| bits >> i & 1 == 1)
                    .map(move |i| first + i)
            };
            let want: Vec<u32> = (1000..1000 + offset)
                .chain(kept(0, bits))
                .chain(kept(100, !bits))
                .collect();
            let mut got: Vec<Probe> = (0..queue.len()).map(|i| queue.get(i)).collect();
            got.sort_by(|a, b| a.number.total_cmp(&b.number));
            let mut want = want;
            want.sort();
            assert_eq!(got.len(), want.len());
            got.into_iter()
                .zip(want)
                .for_each(|(got, id)| assert_same(got, probe(id)));
        }
    }
}

#[test]
fn a_queue_filled_by_random_masks_holds_what_a_list_would() {
    let mut random = Random::new(400);
    for _ in 0..50 {
        let mut want = Vec::new();
        let mut queue = Queue::<ProbeX8>::with_capacity(8 * 300);
        for first in (0..8 * 300).step_by(WIDTH) {
            let bits = (random.one() * 256.0) as u32 & (random.one() * 512.0) as u32;
            queue.push(mask(bits), &batch(first));
            want.extend((0..8).filter(|i| bits >> i & 1 == 1).map(|i| first + i));
        }
        let mut got = Vec::new();
        for (live, batch) in queue.batches() {
            let live = live.to_bitmask();
            assert_eq!(live & (live + 1), 0, "live lanes come first");
            got.extend(
                (0..8)
                    .filter(|i| live >> i & 1 == 1)
                    .map(|i| batch.lane(i).number as u32),
            );
        }
        got.sort();
        assert_eq!(got, want);
        assert_eq!(
            (queue.len(), queue.is_empty()),
            (want.len(), want.is_empty())
        );
        queue.clear();
        assert!(queue.is_empty() && queue.batches().next().is_none());
    }
}

#[test]
fn a_queue_takes_as_many_records_as_it_was_made_for() {
    for capacity in [1, 7, 8, 9, 16, 100] {
        let mut queue = Queue::<ProbeX8>::with_capacity(capacity);
        for id in 0..capacity as u32 {
            queue.push(mask(1 << (id % 8)), &batch(id / 8 * 8));
        }
        assert_eq!(queue.len(), capacity);
        (0..capacity).for_each(|id| assert_same(queue.get(id), probe(id as u32)));
    }
}

#[test]
fn a_record_comes_back_from_its_batch_as_it_went_in() {
    let mut all = batch(0);
    for lane in 0..WIDTH {
        assert_same(all.lane(lane), probe(lane as u32));
    }
    all.set_lane(5, probe(77));
    for lane in 0..WIDTH {
        assert_same(
            all.lane(lane),
            probe(if lane == 5 { 77 } else { lane as u32 }),
        );
    }
    let turned = all.shuffle(u32x8::new([7, 6, 5, 4, 3, 2, 1, 0]));
    let either = ProbeX8::select(mask(0b1010_0101), &all, &turned);
    for lane in 0..WIDTH {
        assert_same(turned.lane(lane), all.lane(7 - lane));
        let from = if 0b1010_0101 >> lane & 1 == 1 {
            &all
        } else {
            &turned
        };
        assert_same(either.lane(lane), from.lane(lane));
    }
}

#[test]
fn first_lanes_are_the_first() {
    for count in 0..20 {
        let want = if count >= 8 { 0xff } else { (1 << count) - 1 };
        assert_eq!(first_lanes(count).to_bitmask(), want);
    }
}

#[test]
fn gathered_rows_are_the_rows_in_tables_of_every_size() {
    let mut random = Random::new(401);
    for size in [1, 2, 7, 8, 9, 15, 16, 17, 37] {
        let rows: Vec<Row> = (0..size)
            .map(|row| std::array::from_fn(|field| (row * 100 + field) as f32))
            .collect();
        let table = Table::new(rows.clone());
        assert_eq!(table.rows(), rows);
        for _ in 0..1000 {
            let ids: [u32; 8] =
                std::array::from_fn(|_| (random.one() * size as f32) as u32 % size as u32);
            for (field, values) in table.gather(u32x8::new(ids)).iter().enumerate() {
                for (lane, id) in ids.into_iter().enumerate() {
                    assert_eq!(values.as_array()[lane], rows[id as usize][field]);
                }
            }
        }
    }
}

#[test]
fn an_id_of_no_row_is_no_panic() {
    let wild = u32x8::new([0, 1, 15, 16, 17, 1000, u32::MAX - 1, u32::MAX]);
    for size in [0, 1, 8, 9, 16, 17] {
        let table = Table::new(vec![[2.5; 8]; size]);
        assert!(
            table
                .gather(wild)
                .iter()
                .all(|values| values.is_finite().all())
        );
    }
}

#[test]
fn no_two_random_decisions_share_a_position() {
    let mut seen = HashSet::new();
    for bounce in 0..100 {
        for dimension in Dimension::ALL {
            // The two numbers of a pair.
            for number in 0..2 {
                assert!(
                    seen.insert(dimension.position(bounce) + number),
                    "{dimension:?} at {bounce}"
                );
            }
        }
    }
}

#[test]
fn no_two_random_decisions_of_a_path_are_correlated() {
    const PATHS: u32 = 4096;
    for sampler in [Sampler::pcg(9, 4), Sampler::sobol(9, 4)] {
        let mut streams: Vec<(String, Vec<f32>)> = Vec::new();
        for bounce in 0..3 {
            for dimension in Dimension::ALL {
                let mut pairs = [Vec::new(), Vec::new()];
                for first in (0..PATHS).step_by(WIDTH) {
                    // Of other pixels each, so that Sobol' points are not stratified against one another.
                    let pixel = u32x8::new(std::array::from_fn(|i| first + i as u32));
                    let path = sampler.path_key(pixel, u32x8::splat(3));
                    let (a, b) = sampler.pair(path, dimension, bounce);
                    pairs[0].extend(a.to_array());
                    pairs[1].extend(b.to_array());
                    assert_eq!(
                        sampler.single(path, dimension, bounce).to_array(),
                        a.to_array()
                    );
                }
                for (number, stream) in pairs.into_iter().enumerate() {
                    streams.push((format!("{dimension:?}.{number} at {bounce}"), stream));
                }
            }
        }
        for (i, (name, a)) in streams.iter().enumerate() {
            let n = f64::from(PATHS);
            let mean = a.iter().map(|x| f64::from(*x)).sum::<f64>() / n;
            assert!(
                (mean - 0.5).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(),
                "{name}: mean {mean}"
            );
            for (other, b) in &streams[..i] {
                let product = |(x, y): (&f32, &f32)| (f64::from(*x) - 0.5) * (f64::from(*y) - 0.5);
                let correlation = 12.0 * a.iter().zip(b).map(product).sum::<f64>() / n;
                // 861 pairs: |z| > 5 has probability 5e-4 in all of them together.
                assert!(
                    correlation.abs() < 5.0 / n.sqrt(),
                    "{name} and {other}: {correlation}"
                );
            }
        }
    }
}
