//! What a render reports: as JSON, and for people.

use super::outputs::Outputs;
use super::progress::metric;
use super::target::target_features;
use crate::film::{Coverage, Metadata, Shard};
use crate::render::{Rendered, Settings};
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

impl Display for Samples {
    /// `64`, or `16 to 32` where a pass over the image is not whole.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Samples { min, max } if min == max => max.fmt(f),
            Samples { min, max } => write!(f, "{min} to {max}"),
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
    pub shard: Option<Shard>,
    /// The sample blocks that the image holds.
    pub blocks: Coverage,
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
        metadata: &Metadata,
        settings: &Settings,
        rendered: &Rendered,
        load: Duration,
    ) -> Self {
        let (stats, film) = (&rendered.stats, &rendered.film);
        let r = settings.region;
        let (min, max) = metadata.samples();
        Self {
            scene: metadata.scene.clone(),
            scene_hash: metadata.scene_hash.clone(),
            camera: metadata.camera.clone(),
            width: settings.width,
            height: settings.height,
            region: [r.x0, r.y0, r.x1, r.y1],
            spp: metadata.spp,
            samples: Samples { min, max },
            shard: settings.shard,
            blocks: metadata.blocks.clone(),
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
            queue_sizes: stats.queue_sizes(),
            rejected_samples: film.rejected(),
            image_hash: film.image_hash(),
            outputs: Vec::new(),
            interrupted: rendered.interrupted,
            version: env!("CARGO_PKG_VERSION"),
            target_features: target_features(),
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

    /// For people: what was written, how fast, what bits.
    pub fn summary(&self) -> String {
        let [x0, y0, x1, y1] = self.region;
        let crop = match (x0, y0, x1, y1) {
            (0, 0, x1, y1) if (x1, y1) == (self.width, self.height) => String::new(),
            _ => format!(" ({x0},{y0},{x1},{y1} of {}x{})", self.width, self.height),
        };
        let shard = self.shard.map(|shard| format!(", shard {shard}"));
        let part = crop + &shard.unwrap_or_default();
        format!(
            "Wrote {}: {}x{} pixels{part}, {} per pixel\n\
             Traced {}paths and {}rays in {}: {}paths/s and {}rays/s on {}\n\
             Image hash {}\n",
            self.outputs.join(" and "),
            x1 - x0,
            y1 - y0,
            counted(self.samples, "sample"),
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
