//! One image that is made ready to be rendered.

use super::Settings;
use super::plan::Plan;
use crate::error::Result;
use crate::film::{Coverage, Film, Layers};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::sensor::Sensor;
use crate::wavefront::{Context, Stage, Wave, Workspace};
use std::sync::Arc;
use std::time::Duration;

/// An image before its first wave: scene, camera and film. Images of one scene share it.
pub struct Frame {
    scene: Arc<Scene>,
    camera: Camera,
    sampler: Sampler,
    settings: Settings,
    before: Coverage,
    checkpoint_every: Option<Duration>,
    pub(super) plan: Plan,
    pub(super) film: Arc<Film>,
}

impl Frame {
    /// The image that the settings ask for, less what `before` has of it: a film of the same image, and its sample blocks.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::error::Error::Usage) for a setting out of its range, and where what was before is another
    /// image.
    pub fn new(
        settings: &Settings,
        camera: Camera,
        scene: Arc<Scene>,
        before: Option<(Film, Coverage)>,
    ) -> Result<Self> {
        settings.check()?;
        let wanted = settings.coverage();
        let mut region = wanted.bounds(settings.region).unwrap_or(settings.region);
        if let Some((old, _)) = &before {
            region = region.bounding(old.region());
        }
        let (width, height) = (settings.width, settings.height);
        let mut film = Film::new(width, height, region, settings.layers())?;
        let before = match before {
            None => Coverage::default(),
            Some((old, coverage)) => {
                film.merge(&old)?;
                coverage
            }
        };
        let todo = wanted.without(&before);
        Ok(Self {
            plan: Plan::new(settings.region, settings.spp, &todo, settings.wave),
            sampler: settings.random_numbers(),
            settings: settings.clone(),
            film: Arc::new(film),
            checkpoint_every: None,
            before,
            camera,
            scene,
        })
    }

    /// The same, with a checkpoint from time to time.
    pub fn checkpoint_every(self, checkpoint_every: Option<Duration>) -> Self {
        Self {
            checkpoint_every,
            ..self
        }
    }

    /// Time from one checkpoint to the next.
    pub(super) fn interval(&self) -> Option<Duration> {
        self.checkpoint_every
    }

    /// The blocks that the film has after so many waves.
    pub(super) fn coverage(&self, waves: u64) -> Coverage {
        self.before.union(&self.plan.done(waves))
    }

    /// Queues for its waves.
    pub(super) fn workspace(&self) -> Workspace {
        Workspace::new(
            self.plan.largest_wave(),
            &self.scene,
            self.settings.layers(),
        )
    }

    /// Traces a wave, and adds it to the film.
    pub(super) fn trace(
        &self,
        wave: &Wave,
        ws: &mut Workspace,
        trace: &impl Fn(&Context, &Wave, &mut Workspace),
    ) {
        let sensor = Sensor::Camera(&self.camera);
        let ctx = self.settings.context(&self.scene, sensor, &self.sampler);
        trace(&ctx, wave, ws);
        let paths = wave.paths();
        let layers = Layers {
            first_hits: ws.first_hits.get(..paths).unwrap_or_default(),
            by_length: &ws.by_length,
        };
        self.film
            .add(wave.tile(), wave.samples, &ws.radiance[..paths], layers);
        ws.tally.end(Stage::Accumulate, 0);
    }
}
