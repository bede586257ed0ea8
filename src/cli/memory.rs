//! Whether an image fits in memory: better asked before than found out by the system's killer of processes.

use crate::error::{Error, Result};
use crate::film::{AovSet, BLOCK};
use crate::render::{Settings, all_processors};

/// Bytes of a pixel: six exact sums and a count in the film; its mean, twice, and three bytes while files are written.
const PIXEL: u64 = 6 * 16 + 4 + 2 * 12 + 3;
/// Bytes of a pixel for each number of an extra layer.
const AOV: u64 = 16;
/// Bytes of a pixel for each path length that is kept apart: six exact sums.
const LENGTH: u64 = 6 * 16;
/// Bytes of a path in a worker's queues: two rays, a vertex on a shape and one on a mesh for each of six kinds of material, a
/// ray to a light, encounters, what it takes to trace them and what they gather.
const PATH: u64 = 1536;

/// For so many images at a time; `remedy` says what makes them smaller.
///
/// # Errors
/// [`Error::Usage`] where the render needs more memory than the machine has to give. `Ok` where it does not tell.
pub(super) fn check(settings: &Settings, images: usize, remedy: &str) -> Result<()> {
    match available() {
        Some(available) => fits(settings, images, remedy, available),
        None => Ok(()),
    }
}

fn fits(settings: &Settings, images: usize, remedy: &str, available: u64) -> Result<()> {
    let (film, queues) = (film(settings) * images as u64, queues(settings));
    let free = gibibytes(available);
    if film > available {
        let (width, height) = (settings.region.width(), settings.region.height());
        let needed = gibibytes(film);
        return Err(Error::Usage(format!(
            "{width}x{height} pixels need about {needed} of memory and {free} are free; {remedy}"
        )));
    }
    if queues > available - film {
        let needed = gibibytes(film.saturating_add(queues));
        return Err(Error::Usage(format!(
            "waves of {} paths on each thread need about {needed} of memory and {free} are free; choose a smaller \
             --wave or fewer --threads",
            settings.wave
        )));
    }
    Ok(())
}

/// For what is no render: `what` needs that many bytes.
///
/// # Errors
/// [`Error::Usage`], with the remedy, where the machine has fewer to give. `Ok` where it does not tell.
pub(super) fn check_bytes(needed: u64, what: &str, remedy: &str) -> Result<()> {
    match available() {
        Some(available) => bytes_fit(needed, available, what, remedy),
        None => Ok(()),
    }
}

fn bytes_fit(needed: u64, available: u64, what: &str, remedy: &str) -> Result<()> {
    if needed > available {
        let [needed, free] = [needed, available].map(gibibytes);
        return Err(Error::Usage(format!(
            "{what} need about {needed} of memory and {free} are free; {remedy}"
        )));
    }
    Ok(())
}

fn film(settings: &Settings) -> u64 {
    // Of a shard no more is kept than the pixels that it reaches.
    let stored = settings.coverage().bounds(settings.region);
    let pixels = stored.unwrap_or(settings.region).pixels() as u64;
    pixels * pixel(settings.layers())
}

fn pixel(layers: AovSet) -> u64 {
    PIXEL + AOV * layers.components() as u64 + LENGTH * u64::from(layers.lengths)
}

/// For films that are not rendered: of so many pixels altogether.
///
/// # Errors
/// [`Error::Usage`], with the remedy, where the machine has less memory to give. `Ok` where it does not tell.
pub(super) fn check_films(pixels: u64, layers: AovSet, remedy: &str) -> Result<()> {
    let needed = pixels.saturating_mul(pixel(layers));
    check_bytes(needed, &format!("films of {pixels} pixels"), remedy)
}

fn queues(settings: &Settings) -> u64 {
    let threads = settings.threads.unwrap_or_else(all_processors);
    let samples = u64::from(settings.spp.min(BLOCK));
    let paths = u64::from(settings.wave).min(settings.region.pixels() as u64 * samples);
    threads as u64 * paths * PATH
}

fn gibibytes(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / (1u64 << 30) as f64)
}

/// What the films of images side by side may take: with one more, and what writing them takes, about half of what there is.
pub(super) fn for_films() -> u64 {
    available().map_or(u64::MAX, |available| available / 4)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn what_does_not_fit_is_refused_with_the_option_that_helps() {
        let scene = builtin::find("cornell").unwrap().load().unwrap();
        let mut settings = Settings::of(&scene);
        let refusal = |settings: &Settings, available| {
            let fits = fits(settings, 1, "choose a smaller --size", available);
            let message = fits.map_err(|error| error.to_string());
            message.err().unwrap_or_default()
        };
        assert_eq!(refusal(&settings, 1 << 30), "");
        settings.set_size(65535, 65535);
        assert!(refusal(&settings, 1 << 36).contains("--size"));
        settings.set_size(4096, 4096);
        assert_eq!(refusal(&settings, 1 << 32), "");
        (settings.threads, settings.wave) = (Some(1024), 1 << 20);
        assert!(refusal(&settings, 1 << 36).contains("--wave"));

        let bytes = |needed| bytes_fit(needed, 1 << 30, "9 pixels", "choose a smaller --size");
        assert!(bytes(1 << 30).is_ok());
        let message = bytes(3 << 29).unwrap_err().to_string();
        assert_eq!(
            message,
            "9 pixels need about 1.5 GiB of memory and 1.0 GiB are free; choose a smaller --size"
        );
    }
}
