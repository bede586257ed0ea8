//! Floor 5: what a render took.

use crate::wavefront::{Stage, Tally};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// What a render took.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// Workers.
    pub threads: usize,
    /// Compiling the scene and making film and workers.
    pub build: Duration,
    /// The render loop alone.
    pub render: Duration,
    /// The workers' sums.
    pub tally: Tally,
}

/// One stage, for the report.
#[derive(Clone, Debug, Serialize)]
pub struct StageReport {
    /// Seconds, all workers together.
    pub seconds: f64,
    /// Records that passed through.
    pub items: u64,
    /// Mean part of the lanes that were live, 0 to 1.
    pub lane_use: f64,
}

impl Stats {
    /// Camera paths traced.
    pub fn paths(&self) -> u64 {
        self.tally.edges().first().map_or(0, |edge| edge.alive)
    }

    /// Rays traced: closest hit, last edge and shadow.
    pub fn rays(&self) -> u64 {
        self.tally
            .edges()
            .iter()
            .map(|edge| edge.alive + edge.shadow_rays)
            .sum()
    }

    /// Rays alive at each bounce: place 0 holds the camera rays.
    pub fn queue_sizes(&self) -> Vec<u64> {
        self.tally.edges().iter().map(|edge| edge.alive).collect()
    }

    /// A count per second of the render loop, in millions.
    pub fn millions_per_second(&self, count: u64) -> f64 {
        count as f64 / self.render.as_secs_f64().max(1e-9) / 1e6
    }

    /// Each stage by name.
    pub fn stages(&self) -> BTreeMap<&'static str, StageReport> {
        Stage::ALL
            .iter()
            .map(|&stage| {
                let sums = self.tally.stage(stage);
                let report = StageReport {
                    seconds: sums.time.as_secs_f64(),
                    items: sums.items,
                    lane_use: sums.lane_use(),
                };
                (stage.name(), report)
            })
            .collect()
    }
}

/// The most memory this process has had resident, bytes; none where the system does not tell.
pub fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}
