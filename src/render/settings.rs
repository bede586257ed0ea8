//! What is rendered, and how.

use super::DEFAULT_WAVE;
use crate::bvh::Quality;
use crate::error::{Error, Result};
use crate::film::{AovSet, BLOCK, Coverage, MAX_SAMPLES, Region, Shard};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::description::{Description, MAX_EDGES, MAX_SIDE, SamplerKind, Strategy};
use crate::scene::sensor::Sensor;
use crate::wavefront::Context;
use std::time::Duration;

/// Everything that decides what is rendered and how. All but `threads`, `wave` and `bvh` (and `time`, by how far it lets the
/// samples get) decide the image's bits.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The part of the image that is rendered.
    pub region: Region,
    /// Name of the camera; the scene's first without it.
    pub camera: Option<String>,
    /// Samples per pixel of the whole image, at least 1.
    pub spp: u32,
    /// The first of them that is rendered, a multiple of [`BLOCK`]: those before it are another image's.
    pub first_sample: u32,
    /// The part of the image that is rendered; all of it without one.
    pub shard: Option<Shard>,
    /// Greatest number of edges of a path, at least 1.
    pub path_length: u32,
    /// How light is looked for.
    pub strategy: Strategy,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Seed.
    pub seed: u64,
    /// First path edge at which Russian roulette may end a path, at least 1; none without it.
    pub roulette: Option<u32>,
    /// Extra layers.
    pub aovs: AovSet,
    /// Workers; as many as the machine has cores without it.
    pub threads: Option<usize>,
    /// Paths of a wave, at least [`BLOCK`].
    pub wave: u32,
    /// How trees of triangles are built.
    pub bvh: Quality,
    /// No wave begins later than this.
    pub time: Option<Duration>,
}

impl Settings {
    /// What a scene asks for, the program's defaults elsewhere.
    pub fn of(scene: &Description) -> Self {
        let (film, wishes) = (&scene.film, &scene.render);
        Self {
            width: film.width,
            height: film.height,
            region: Region::full(film.width, film.height),
            camera: None,
            spp: wishes.spp.unwrap_or(64),
            first_sample: 0,
            shard: None,
            path_length: wishes.path_length.unwrap_or(5),
            strategy: wishes.strategy.unwrap_or_default(),
            sampler: wishes.sampler.unwrap_or_default(),
            seed: wishes.seed.unwrap_or(0),
            roulette: wishes.roulette,
            aovs: AovSet::default(),
            threads: None,
            wave: DEFAULT_WAVE,
            bvh: Quality::default(),
            time: None,
        }
    }

    /// Changes the size, and the region to all of it.
    pub fn set_size(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width, height);
        self.region = Region::full(width, height);
    }

    /// The sample blocks that are rendered.
    pub fn coverage(&self) -> Coverage {
        let pixels = self.region.pixels() as u64;
        let all = Coverage::of_samples(self.first_sample..self.spp, pixels);
        match self.shard {
            Some(shard) => all.part(shard),
            None => all,
        }
    }

    /// The extra layers, one for each path length that there can be.
    pub fn layers(&self) -> AovSet {
        self.aovs.up_to(self.path_length)
    }

    /// Where random numbers come from.
    pub(crate) fn random_numbers(&self) -> Sampler {
        match self.sampler {
            SamplerKind::Pcg => Sampler::pcg(self.seed, self.path_length),
            SamplerKind::Sobol => Sampler::sobol(self.seed, self.path_length),
        }
    }

    /// What the stages read.
    pub(crate) fn context<'a>(
        &self,
        scene: &'a Scene,
        sensor: Sensor<'a>,
        sampler: &'a Sampler,
    ) -> Context<'a> {
        let origins = sensor.origins();
        Context {
            scene,
            sensor,
            enclosed: origins.iter().all(|&origin| scene.encloses(origin)),
            sampler,
            strategy: self.strategy,
            path_length: self.path_length,
            roulette: self.roulette,
            aovs: self.layers(),
        }
    }

    /// What [`render`](super::render()) asks of its settings before it begins.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the first setting out of its range.
    pub fn check(&self) -> Result<()> {
        let wrong = |message: String| Err(Error::Usage(message));
        let within = |what: &str, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            wrong(format!("{what} is {value}; it can be {low} to {high}"))
        };
        within("the width", self.width, 1, MAX_SIDE)?;
        within("the height", self.height, 1, MAX_SIDE)?;
        within(
            "the number of samples per pixel (spp)",
            self.spp,
            1,
            MAX_SAMPLES,
        )?;
        if !self.first_sample.is_multiple_of(BLOCK) || self.first_sample >= self.spp {
            return wrong(format!(
                "the samples {}..{} cannot be rendered: the first must be a multiple of {BLOCK} and below the end",
                self.first_sample, self.spp
            ));
        }
        within("the path length", self.path_length, 1, MAX_EDGES)?;
        self.layers().check()?;
        within("the wave size", self.wave, BLOCK, 1 << 20)?;
        if let Some(first) = self.roulette {
            within("the first edge of Russian roulette", first, 1, MAX_EDGES)?;
        }
        if let Some(threads) = self.threads {
            within(
                "the number of threads",
                threads.try_into().unwrap_or(u32::MAX),
                1,
                1024,
            )?;
        }
        let all = Region::full(self.width, self.height);
        if self.region.is_empty() || !all.contains(self.region) {
            return wrong(format!(
                "the crop {} is empty or reaches outside the {}x{} image; give x0,y0,x1,y1 with x0 < x1 <= {} and y0 < y1 <= {}",
                self.region, self.width, self.height, self.width, self.height
            ));
        }
        if let (Some(shard), true) = (self.shard, self.coverage().is_empty()) {
            let pixels = self.region.pixels() as u64;
            let blocks = Coverage::of_samples(self.first_sample..self.spp, pixels).len();
            return wrong(format!(
                "shard {shard} is empty: the image has {blocks} blocks of a pixel and up to {BLOCK} samples; ask for at most so many shards"
            ));
        }
        Ok(())
    }
}
