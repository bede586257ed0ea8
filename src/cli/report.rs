//! What a render reports: as JSON, and for people.

use super::outputs::Outputs;
use super::progress::metric;
use super::target::target_features;
use crate::film::Metadata;
use crate::render::{Rendered, Settings};
use crate::scene::description::Description;
use crate::stats::{StageReport, peak_rss_bytes};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::time::Duration;

/// Samples that were traced for each pixel: the least and the greatest number of any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Samples {
    pub min: u32,
    pub max: u32,
}

impl Samples {
    /// Waves are traced in their order, block after block of samples, and each one that begins ends: so the number of
    /// paths tells how far every pixel got.
    pub fn traced(settings: &Settings, paths: u64) -> Self {
        let pixels = settings.region.pixels() as u64;
        let spp = settings.spp;
        if paths >= pixels * u64::from(spp) {
            return Self { min: spp, max: spp };
        }
        let block = u64::from(crate::film::BLOCK);
        let at_most = |samples: u64| u32::try_from(samples).map_or(spp, |samples| samples.min(spp));
        Self {
            min: at_most(paths / (pixels * block) * block),
            max: at_most(paths.div_ceil(pixels * block) * block),
        }
    }
}

/// The object that `render --json` prints.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub scene: String,
    pub scene_hash: String,
    pub camera: String,
    pub width: u32,
    pub height: u32,
    /// x0, y0, x1, y1.
    pub region: [u32; 4],
    pub spp: u32,
    pub samples: Samples,
    pub path_length: u32,
    pub strategy: String,
    pub sampler: String,
    pub seed: u64,
    pub roulette: Option<u32>,
    pub aovs: Vec<String>,
    pub threads: usize,
    pub wave: u32,
    pub paths: u64,
    pub rays: u64,
    pub load_s: f64,
    pub build_s: f64,
    pub render_s: f64,
    pub mpaths_per_s: f64,
    pub mrays_per_s: f64,
    pub peak_rss_bytes: Option<u64>,
    pub stages: BTreeMap<&'static str, StageReport>,
    pub queue_sizes: Vec<u64>,
    pub rejected_samples: u64,
    pub image_hash: String,
    pub outputs: Vec<String>,
    pub interrupted: bool,
    pub version: &'static str,
    pub target_features: String,
}

impl Report {
    /// Of a finished render; [`outputs`](Self::outputs) is what has been written, so nothing yet.
    pub fn new(
        scene: &Description,
        settings: &Settings,
        rendered: &Rendered,
        load: Duration,
        spp_asked: bool,
    ) -> Self {
        let (stats, film) = (&rendered.stats, &rendered.film);
        let samples = Samples::traced(settings, stats.paths());
        // Without an end of its own, a render's samples are as many as there was time for.
        let asked = spp_asked && rendered.interrupted;
        let first = || scene.cameras.first().map(|camera| camera.name.clone());
        let r = settings.region;
        Self {
            scene: scene.name.clone(),
            scene_hash: scene.hash.clone(),
            camera: settings.camera.clone().or_else(first).unwrap_or_default(),
            width: settings.width,
            height: settings.height,
            region: [r.x0, r.y0, r.x1, r.y1],
            spp: if asked { settings.spp } else { samples.max },
            samples,
            path_length: settings.path_length,
            strategy: settings.strategy.to_string(),
            sampler: settings.sampler.to_string(),
            seed: settings.seed,
            roulette: settings.roulette,
            aovs: layers(&settings.aovs.to_string()),
            threads: stats.threads,
            wave: settings.wave,
            paths: stats.paths(),
            rays: stats.rays(),
            load_s: load.as_secs_f64(),
            build_s: stats.build.as_secs_f64(),
            render_s: stats.render.as_secs_f64(),
            mpaths_per_s: stats.millions_per_second(stats.paths()),
            mrays_per_s: stats.millions_per_second(stats.rays()),
            peak_rss_bytes: peak_rss_bytes(),
            stages: stats.stages(),
            queue_sizes: stats.queue_sizes().to_vec(),
            rejected_samples: film.rejected(),
            image_hash: film.image_hash(),
            outputs: Vec::new(),
            interrupted: rendered.interrupted,
            version: env!("CARGO_PKG_VERSION"),
            target_features: target_features(),
        }
    }

    /// What the image file says of it.
    pub fn metadata(&self) -> Metadata {
        Metadata {
            scene: self.scene.clone(),
            scene_hash: self.scene_hash.clone(),
            camera: self.camera.clone(),
            seed: self.seed,
            spp: self.spp,
            sample_ranges: std::iter::once(0..self.samples.min).collect(),
            path_length: self.path_length,
            strategy: self.strategy.clone(),
            sampler: self.sampler.clone(),
            roulette: self.roulette,
            version: self.version.to_owned(),
            target_features: self.target_features.clone(),
            seconds: self.render_s,
            rays: self.rays,
            interrupted: self.interrupted,
        }
    }

    /// The files are there.
    pub fn wrote(&mut self, outputs: &Outputs) {
        self.outputs = outputs
            .paths()
            .map(|path| path.display().to_string())
            .collect();
        self.peak_rss_bytes = peak_rss_bytes();
    }

    /// `64`, or `16 to 32` where the last pass over the image was not finished.
    pub fn samples_per_pixel(&self) -> String {
        match self.samples {
            Samples { min, max } if min == max => max.to_string(),
            Samples { min, max } => format!("{min} to {max}"),
        }
    }

    /// For people: what was written, how fast, what bits.
    pub fn summary(&self) -> String {
        let [x0, y0, x1, y1] = self.region;
        let part = match (x0, y0, x1, y1) {
            (0, 0, x1, y1) if (x1, y1) == (self.width, self.height) => String::new(),
            _ => format!(" ({x0},{y0},{x1},{y1} of {}x{})", self.width, self.height),
        };
        format!(
            "Wrote {}: {}x{} pixels{part}, {} per pixel\n\
             Traced {}paths and {}rays in {}: {}paths/s and {}rays/s on {}\n\
             Image hash {}\n",
            self.outputs.join(" and "),
            x1 - x0,
            y1 - y0,
            counted(self.samples_per_pixel(), "sample"),
            count(self.paths as f64),
            count(self.rays as f64),
            seconds(self.render_s),
            count(self.mpaths_per_s * 1e6),
            count(self.mrays_per_s * 1e6),
            counted(self.threads, "thread"),
            self.image_hash
        )
    }

    /// That samples were kept out of the image, if any were.
    pub fn warning(&self) -> Option<String> {
        (self.rejected_samples > 0).then(|| {
            format!(
                "warning: {} of {} samples were not finite or not below 2^32, and are kept out of the image; \
                 look for radiances or shapes of absurd size in the scene",
                self.rejected_samples, self.paths
            )
        })
    }
}

/// `1 sample`, `64 samples`, `48 to 64 samples`.
pub(super) fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    let ending = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

fn layers(list: &str) -> Vec<String> {
    list.split(',')
        .filter(|name| !name.is_empty())
        .map(str::to_owned)
        .collect()
}

/// `4.19 M`, with the space that a prefix does without: `4.19 Mpaths`.
fn count(value: f64) -> String {
    let text = metric(value);
    if text.contains(' ') { text } else { text + " " }
}

/// `0.123 s`, `12.3 s`, `4 min 5 s`, `2 h 3 min`.
pub(super) fn seconds(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        _ if seconds < 9.995 => format!("{seconds:.2} s"),
        _ if seconds < 59.95 => format!("{seconds:.1} s"),
        0..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
