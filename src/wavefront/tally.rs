//! What a worker counts while it traces: seconds, items and lanes of each stage.

use crate::lanes::WIDTH;
use std::time::{Duration, Instant};

/// The five stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Camera rays.
    Generate,
    /// Closest hits, last-edge lights and shadow rays.
    Intersect,
    /// BSDF sampling.
    Shade,
    /// Next-event estimation: light sampling.
    Nee,
    /// Sums, in the wave and in the film.
    Accumulate,
}

impl Stage {
    /// Every stage, in the order of the loop.
    pub const ALL: [Stage; 5] = [
        Stage::Generate,
        Stage::Intersect,
        Stage::Shade,
        Stage::Nee,
        Stage::Accumulate,
    ];

    /// The stage's name.
    pub const fn name(self) -> &'static str {
        match self {
            Stage::Generate => "generate",
            Stage::Intersect => "intersect",
            Stage::Shade => "shade",
            Stage::Nee => "nee",
            Stage::Accumulate => "accumulate",
        }
    }
}

/// One stage's sums.
#[derive(Clone, Copy, Debug, Default)]
pub struct StageTally {
    /// Time spent in it.
    pub time: Duration,
    /// Records it was given.
    pub items: u64,
    /// Lanes of the batches that held them.
    pub lanes: u64,
}

/// A worker's sums.
#[derive(Clone, Debug)]
pub struct Tally {
    /// By [`Stage`].
    pub stages: [StageTally; 5],
    /// Closest-hit rays alive at each path edge, from the first.
    pub alive: Vec<u64>,
    /// Shadow rays.
    pub shadow_rays: u64,
    clock: Instant,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            stages: Default::default(),
            alive: Vec::new(),
            shadow_rays: 0,
            clock: Instant::now(),
        }
    }
}

impl Tally {
    /// A wave begins: what passed before belongs to no stage.
    pub fn start(&mut self) {
        self.clock = Instant::now();
    }

    /// A stage ends: the time since the last end is its own.
    pub fn end(&mut self, stage: Stage, items: usize) {
        let now = Instant::now();
        let sums = &mut self.stages[stage as usize];
        sums.time += now - self.clock;
        sums.items += items as u64;
        sums.lanes += (items.div_ceil(WIDTH) * WIDTH) as u64;
        self.clock = now;
    }

    /// Counts the rays alive at a path edge, which counts from 1.
    pub fn alive(&mut self, edge: u32, rays: usize) {
        let edge = edge as usize;
        if self.alive.len() < edge {
            self.alive.resize(edge, 0);
        }
        self.alive[edge - 1] += rays as u64;
    }

    /// Counts shadow rays.
    pub fn shadows(&mut self, rays: usize) {
        self.shadow_rays += rays as u64;
    }

    /// Adds another worker's sums.
    pub fn merge(&mut self, other: &Tally) {
        for (mine, theirs) in self.stages.iter_mut().zip(&other.stages) {
            mine.time += theirs.time;
            mine.items += theirs.items;
            mine.lanes += theirs.lanes;
        }
        if self.alive.len() < other.alive.len() {
            self.alive.resize(other.alive.len(), 0);
        }
        for (mine, theirs) in self.alive.iter_mut().zip(&other.alive) {
            *mine += theirs;
        }
        self.shadow_rays += other.shadow_rays;
    }
}
