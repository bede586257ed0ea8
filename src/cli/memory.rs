//! Whether an image fits in memory: better asked before than found out by the system's killer of processes.

use crate::error::{Error, Result};
use crate::film::BLOCK;
use crate::render::Settings;

/// Bytes of a pixel: six exact sums and a count in the film; its mean, twice, and three bytes while files are written.
const PIXEL: u64 = 6 * 16 + 4 + 2 * 12 + 3;
/// Bytes of a pixel for each number of an extra layer.
const AOV: u64 = 16;
/// Bytes of a path in a worker's queues: two rays, a vertex for each of five kinds of material, a ray to a light, an
/// encounter and what it gathers.
const PATH: u64 = 768;

/// # Errors
/// [`Error::Usage`] where the render needs more memory than the machine has to give. `Ok` where it does not tell.
pub(super) fn check(settings: &Settings) -> Result<()> {
    let needed = needed(settings);
    match available() {
        Some(available) if needed > available => Err(Error::Usage(format!(
            "an image of {} pixels needs about {} of memory and {} are free; choose a smaller --size, or render \
             parts with --crop",
            settings.region.pixels(),
            gibibytes(needed),
            gibibytes(available)
        ))),
        _ => Ok(()),
    }
}

fn needed(settings: &Settings) -> u64 {
    let pixels = settings.region.pixels() as u64;
    let threads = settings
        .threads
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get));
    let paths = u64::from(settings.wave).min(pixels * u64::from(settings.spp.min(BLOCK)));
    pixels * (PIXEL + AOV * settings.aovs.components() as u64) + threads as u64 * paths * PATH
}

fn gibibytes(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / (1u64 << 30) as f64)
}

/// Bytes that a program can have without swapping; none where the system does not tell.
fn available() -> Option<u64> {
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info
        .lines()
        .find(|line| line.starts_with("MemAvailable:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}
