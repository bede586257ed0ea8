//! What the program runs on and what it was compiled by; and how quiet it is there.

use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::time::Instant;

/// What a measurement was made on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Model name of the processor.
    pub cpu: String,
    /// Processors that the program may use.
    pub processors: usize,
    /// Caches of the first processor, as in `L1d 32K, L2 512K, L3 32M`; empty where the system does not tell.
    pub caches: String,
    /// Bytes; none where the system does not tell.
    pub memory_bytes: Option<u64>,
    /// The system and its version.
    pub system: String,
    /// Instruction sets that the program was compiled for.
    pub target_features: String,
    /// Version of rustc, and of the LLVM in it.
    pub compiler: String,
    /// Level of optimisation, and flags given to rustc.
    pub flags: String,
    /// Version of this program.
    pub program: String,
}

impl Machine {
    /// This one; the caller knows what features it was compiled for.
    pub fn here(target_features: String) -> Self {
        Self {
            cpu: cpu(),
            processors: crate::render::all_processors(),
            caches: caches(),
            memory_bytes: memory(),
            system: system(),
            target_features,
            compiler: format!("{}, LLVM {}", env!("ONDINE_RUSTC"), env!("ONDINE_LLVM")),
            flags: format!(
                "opt-level {} {}",
                env!("ONDINE_OPT_LEVEL"),
                env!("ONDINE_RUSTFLAGS")
            ),
            program: format!("ondine {}", env!("CARGO_PKG_VERSION")),
        }
    }

    /// What else than the program is another machine's: measurements of two such say nothing of the program.
    pub fn differs(&self, other: &Self) -> bool {
        let about = |m: &Self| (m.cpu.clone(), m.processors, m.caches.clone());
        about(self) != about(other)
    }
}

fn read(path: &str) -> Option<String> {
    Some(std::fs::read_to_string(path).ok()?.trim().to_owned())
}

fn cpu() -> String {
    let told = read("/proc/cpuinfo").and_then(|info| {
        let line = info.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    told.unwrap_or_else(|| format!("{} processor", std::env::consts::ARCH))
}

fn caches() -> String {
    let one = |index: usize| {
        let of = |what: &str| {
            read(&format!(
                "/sys/devices/system/cpu/cpu0/cache/index{index}/{what}"
            ))
        };
        let kind = match of("type")?.as_str() {
            "Data" => "d",
            "Instruction" => return Some(None),
            _ => "",
        };
        Some(Some(format!("L{}{kind} {}", of("level")?, of("size")?)))
    };
    let all: Vec<String> = (0..8).map_while(one).flatten().collect();
    all.join(", ")
}

fn memory() -> Option<u64> {
    let info = read("/proc/meminfo")?;
    let line = info.lines().find(|line| line.starts_with("MemTotal:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

fn system() -> String {
    let release = read("/proc/sys/kernel/osrelease").unwrap_or_default();
    format!("{} {release}", std::env::consts::OS)
        .trim_end()
        .to_owned()
}

/// Cycles per second, in units of 10⁹, as one core had them just now: a chain of shifts and exclusive ors, each of which takes
/// a cycle and waits for the one before, as on every x86-64 processor. Takes about five milliseconds.
pub fn clock() -> f64 {
    const ROUNDS: u32 = 2_500_000;
    /// Three shifts and three exclusive ors.
    const CYCLES: f64 = 6.0;
    let begin = Instant::now();
    let mut x: u64 = black_box(0x9e37_79b9_7f4a_7c15);
    for _ in 0..ROUNDS {
        // Marsaglia 2003, "Xorshift RNGs": no compiler finds a shorter way.
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
    }
    black_box(x);
    f64::from(ROUNDS) * CYCLES / begin.elapsed().as_secs_f64() / 1e9
}

/// Linux counts in hundredths of a second, whatever its own clock.
const TICK: f64 = 0.01;

/// What the machine's processors do: watched from the beginning of a measurement to its end.
pub struct Watch {
    begin: Instant,
    busy: Option<(f64, f64)>,
}

impl Watch {
    /// From now on.
    pub fn start() -> Self {
        Self {
            busy: busy(),
            begin: Instant::now(),
        }
    }

    /// Whether others, programs or, where the machine is virtual, other machines, left the processors alone meanwhile. True
    /// where the system does not tell.
    pub fn is_quiet(&self) -> bool {
        /// The part of all processors that others may keep busy.
        const MOST: f64 = 0.05;
        let processors = crate::render::all_processors() as f64;
        let seconds = self.begin.elapsed().as_secs_f64();
        let Some(((all, own), (all_before, own_before))) = busy().zip(self.busy) else {
            return true;
        };
        let others = (all - all_before) - (own - own_before);
        // Each processor's count, and this program's, may be off by a tick.
        others <= MOST * processors * seconds + TICK * (processors + 1.0)
    }
}

/// Seconds that all processors were busy with anything, and those of this program.
fn busy() -> Option<(f64, f64)> {
    let sum = |fields: &[&str], places: &[usize]| -> Option<f64> {
        let numbers = places
            .iter()
            .map(|&place| fields.get(place)?.parse::<f64>().ok());
        Some(TICK * numbers.sum::<Option<f64>>()?)
    };
    let all = read("/proc/stat")?;
    let all: Vec<&str> = all.lines().next()?.split_whitespace().skip(1).collect();
    let own = read("/proc/self/stat")?;
    // The name of the program stands in parentheses, and may hold blanks.
    let own: Vec<&str> = own.rsplit_once(')')?.1.split_whitespace().collect();
    // user, nice, system, irq, softirq, steal; utime, stime.
    Some((sum(&all, &[0, 1, 2, 5, 6, 7])?, sum(&own, &[11, 12])?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_ticks() {
        let clock = clock();
        assert!((0.01..100.0).contains(&clock), "{clock} GHz");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_system_counts_this_program_among_all() {
        let before = busy().expect("Linux tells");
        let begin = Instant::now();
        let worked = || busy().is_some_and(|now| now.1 - before.1 >= 0.05);
        while !worked() && begin.elapsed().as_secs_f64() < 60.0 {
            black_box(clock());
        }
        let now = busy().expect("Linux tells");
        assert!(now.1 - before.1 >= 0.05, "{before:?} {now:?}");
        // Either count may be off by a tick for each processor.
        let ticks = TICK * (crate::render::all_processors() + 1) as f64;
        assert!(
            now.0 - before.0 >= now.1 - before.1 - ticks,
            "{before:?} {now:?}"
        );
    }
}
