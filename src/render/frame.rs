//! One image that is made ready to be rendered.

use super::Settings;
use super::plan::Plan;
use crate::error::Result;
use crate::film::{Coverage, Film, Layers, Region};
use crate::lanes::Rgbx8;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::sensor::Sensor;
use crate::wavefront::queues::Encounter;
use crate::wavefront::{Context, Wave, Workspace, trace_first};
use glam::Vec3;
use std::sync::Arc;
use std::time::Duration;

/// The first point of a path that is on something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// World space.
    pub position: Vec3,
    /// Index into [`Description::materials`](crate::scene::description::Description::materials); none of what only emits.
    pub material: Option<usize>,
}

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
        Self::on(settings, camera, scene, Arc::new(film), before)
    }

    /// The same on a film that holds what was before already, and room for the rest.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::error::Error::Usage) for a setting out of its range.
    ///
    /// # Panics
    /// While it is traced, where the film is not of the settings' size, region and layers.
    pub fn on(
        settings: &Settings,
        camera: Camera,
        scene: Arc<Scene>,
        film: Arc<Film>,
        before: Coverage,
    ) -> Result<Self> {
        settings.check()?;
        let todo = settings.coverage().without(&before);
        Ok(Self {
            plan: Plan::new(settings.region, settings.spp, &todo, settings.wave),
            sampler: settings.random_numbers(),
            settings: settings.clone(),
            checkpoint_every: None,
            film,
            before,
            camera,
            scene,
        })
    }

    /// The film that it fills.
    pub fn film(&self) -> &Arc<Film> {
        &self.film
    }

    /// What the first path of the first pixel of its region meets; none where that is nothing.
    pub fn first_hit(&self) -> Option<FirstHit> {
        let Region { x0, y0, .. } = self.settings.region;
        let wave = Wave {
            x: x0,
            y: y0,
            width: 1,
            height: 1,
            first_sample: 0,
            samples: 1,
        };
        let sensor = Sensor::Camera(&self.camera);
        let ctx = self.settings.context(&self.scene, sensor, &self.sampler);
        let mut ws = Workspace::new(1, &self.scene, self.settings.layers());
        trace_first(&ctx, &wave, &mut ws, |_| Rgbx8::ZERO);
        let on_meshes = ws.mesh_vertices.iter().filter(|queue| !queue.is_empty());
        let on_shapes = ws.vertices.iter().filter(|queue| !queue.is_empty());
        let vertices = on_shapes
            .map(|queue| queue.get(0))
            .chain(on_meshes.map(|queue| queue.get(0).vertex));
        let surface = vertices.map(|vertex| FirstHit {
            position: vertex.position,
            material: usize::try_from(vertex.material).ok(),
        });
        let met = |encounter: Encounter| {
            encounter.distance.is_finite().then(|| FirstHit {
                position: encounter.origin + encounter.direction * encounter.distance,
                material: None,
            })
        };
        let (encounters, on_meshes) = (&ws.encounters, &ws.mesh_encounters);
        let lamp = (!encounters.is_empty()).then(|| met(encounters.get(0)));
        let mesh = (!on_meshes.is_empty()).then(|| met(on_meshes.get(0).encounter));
        surface.chain(lamp.flatten()).chain(mesh.flatten()).next()
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
        ws.tally.added();
    }
}
