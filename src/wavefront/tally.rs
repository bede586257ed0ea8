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

impl StageTally {
    /// Mean part of the lanes that were live, 0 to 1.
    pub fn lane_use(&self) -> f64 {
        self.items as f64 / self.lanes.max(1) as f64
    }

    fn add(&mut self, other: &Self) {
        self.time += other.time;
        self.items += other.items;
        self.lanes += other.lanes;
    }
}

/// What a worker counts of one path edge.
#[derive(Clone, Copy, Debug, Default)]
pub struct EdgeTally {
    /// By [`Stage`].
    pub stages: [StageTally; 5],
    /// Closest-hit rays that were alive at its beginning.
    pub alive: u64,
    /// Shadow rays from its end.
    pub shadow_rays: u64,
}

/// A worker's sums.
#[derive(Clone, Debug)]
pub struct Tally {
    /// By path edge; place 0 is what belongs to no edge: the first rays are made, the film adds.
    edges: Vec<EdgeTally>,
    waves: u64,
    /// The edge under way.
    edge: usize,
    clock: Instant,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            edges: vec![EdgeTally::default()],
            waves: 0,
            edge: 0,
            clock: Instant::now(),
        }
    }
}

impl Tally {
    /// A wave begins: what passed before belongs to no stage.
    pub fn start(&mut self) {
        self.waves += 1;
        self.edge = 0;
        self.clock = Instant::now();
    }

    /// A path edge begins, counted from 1, with that many rays; the stages that end from now on are its own.
    pub fn begin(&mut self, edge: u32, rays: usize) {
        self.edge = edge as usize;
        if self.edges.len() <= self.edge {
            self.edges.resize(self.edge + 1, EdgeTally::default());
        }
        self.edges[self.edge].alive += rays as u64;
    }

    /// A stage ends: the time since the last end is its own.
    pub fn end(&mut self, stage: Stage, items: usize) {
        let now = Instant::now();
        let sums = &mut self.edges[self.edge].stages[stage as usize];
        sums.time += now - self.clock;
        sums.items += items as u64;
        sums.lanes += (items.div_ceil(WIDTH) * WIDTH) as u64;
        self.clock = now;
    }

    /// The whole wave has entered the film, or what takes its place.
    pub fn added(&mut self) {
        self.edge = 0;
        self.end(Stage::Accumulate, 0);
    }

    /// Counts shadow rays.
    pub fn shadows(&mut self, rays: usize) {
        self.edges[self.edge].shadow_rays += rays as u64;
    }

    /// Adds another worker's sums.
    pub fn merge(&mut self, other: &Tally) {
        if self.edges.len() < other.edges.len() {
            self.edges.resize(other.edges.len(), EdgeTally::default());
        }
        self.waves += other.waves;
        for (mine, theirs) in self.edges.iter_mut().zip(&other.edges) {
            mine.alive += theirs.alive;
            mine.shadow_rays += theirs.shadow_rays;
            for (mine, theirs) in mine.stages.iter_mut().zip(&theirs.stages) {
                mine.add(theirs);
            }
        }
    }

    /// Waves that began.
    pub fn waves(&self) -> u64 {
        self.waves
    }

    /// Each path edge, from the first.
    pub fn edges(&self) -> &[EdgeTally] {
        &self.edges[1..]
    }

    /// A stage of all edges together.
    pub fn stage(&self, stage: Stage) -> StageTally {
        let mut sums = StageTally::default();
        for edge in &self.edges {
            sums.add(&edge.stages[stage as usize]);
        }
        sums
    }
}
