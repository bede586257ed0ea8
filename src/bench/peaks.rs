//! What this machine can do at most, measured: the roofs of the roofline model (Williams, Waterman & Patterson 2009,
//! Communications of the ACM 52).

use super::series::Series;
use crate::lanes::f32x8;
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::sync::Barrier;
use std::time::Instant;

/// Operations and bytes per second, all threads together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peaks {
    /// 10⁹ single-precision operations per second; a fused multiply-add is two.
    pub gflops: Series,
    /// 10⁹ bytes per second, read from arrays of each size.
    pub read: Vec<Bandwidth>,
}

/// How fast an array is read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bandwidth {
    /// Where it lies: `L1`, `L2` or `memory`.
    pub level: String,
    /// Bytes that each thread reads over and over.
    pub bytes: usize,
    /// 10⁹ bytes per second.
    pub gbytes: Series,
}

/// Times of everything.
const REPEATS: usize = 5;
/// Independent sums: enough to hide the latency of an addition.
const CHAINS: usize = 12;

/// Bytes that lie in anybody's first cache.
const FIRST_CACHE: usize = 16 << 10;

/// How fast a pool's threads are just now.
pub struct Pace<'a> {
    pool: &'a ThreadPool,
    arrays: Vec<Vec<f32x8>>,
}

impl<'a> Pace<'a> {
    /// Of a pool.
    pub fn new(pool: &'a ThreadPool) -> Self {
        Self {
            arrays: arrays(pool, FIRST_CACHE),
            pool,
        }
    }

    /// 10⁹ bytes per second that all threads read from their first caches. Takes some milliseconds. Whoever shares a core
    /// with this program, as a neighbour on a virtual machine may, is in its cache too: by this it is noticed, and by clocks not.
    pub fn now(&self) -> f64 {
        read(self.pool, &self.arrays, 1 << 28) / 1e9
    }
}

/// Measures the peaks of a pool's threads.
pub fn measure(pool: &ThreadPool) -> Peaks {
    let threads = pool.current_num_threads();
    let mut peaks = Peaks::default();
    // The first is to warm up.
    let _ = flops(pool);
    for _ in 0..REPEATS {
        peaks.gflops.push(flops(pool) / 1e9);
    }
    // What lies in memory is larger than the last cache, whosever share.
    for (level, bytes) in [
        ("L1", FIRST_CACHE),
        ("L2", 192 << 10),
        ("memory", ((256 << 20) / threads).max(8 << 20)),
    ] {
        let arrays = arrays(pool, bytes);
        let gbytes = (0..REPEATS).map(|_| read(pool, &arrays, 1 << 30) / 1e9);
        peaks.read.push(Bandwidth {
            level: level.to_owned(),
            bytes,
            gbytes: gbytes.collect(),
        });
    }
    peaks
}

/// One for each thread.
fn arrays(pool: &ThreadPool, bytes: usize) -> Vec<Vec<f32x8>> {
    let numbers = bytes / size_of::<f32x8>();
    // Each by its thread, which is then near it.
    pool.broadcast(|_| vec![f32x8::ONE; numbers])
}

/// Has all threads do something at once; seconds until the last was done.
fn together(pool: &ThreadPool, work: impl Fn(usize) + Sync) -> f64 {
    let threads = pool.current_num_threads();
    let barrier = Barrier::new(threads);
    let times = pool.broadcast(|context| {
        barrier.wait();
        let begin = Instant::now();
        work(context.index());
        (begin, Instant::now())
    });
    let begin = times.iter().map(|(begin, _)| *begin).min();
    let end = times.iter().map(|(_, end)| *end).max();
    begin
        .zip(end)
        .map_or(0.0, |(begin, end)| (end - begin).as_secs_f64())
}

fn flops(pool: &ThreadPool) -> f64 {
    const ROUNDS: usize = 2_000_000;
    let seconds = together(pool, |_| {
        let (factor, term) = (
            black_box(f32x8::splat(0.999)),
            black_box(f32x8::splat(0.001)),
        );
        let mut sums = [f32x8::ONE; CHAINS];
        for _ in 0..ROUNDS {
            for sum in &mut sums {
                *sum = sum.mul_add(factor, term);
            }
        }
        black_box(sums);
    });
    let operations = ROUNDS * CHAINS * 8 * 2 * pool.current_num_threads();
    operations as f64 / seconds
}

/// Bytes per second of all threads, each of which reads its array over and over until it has read so many.
fn read(pool: &ThreadPool, arrays: &[Vec<f32x8>], each: usize) -> f64 {
    let bytes = size_of_val(&arrays[0][..]);
    let rounds = each.div_ceil(bytes);
    let seconds = together(pool, |thread| {
        let mut sums = [f32x8::ZERO; CHAINS];
        for _ in 0..rounds {
            let (whole, _) = black_box(&arrays[thread][..]).as_chunks::<CHAINS>();
            for chunk in whole {
                for (sum, number) in sums.iter_mut().zip(chunk) {
                    *sum += *number;
                }
            }
        }
        black_box(sums);
    });
    (rounds * bytes * arrays.len()) as f64 / seconds
}
