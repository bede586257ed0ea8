//! What the benchmarks share: the Cornell box, compiled, and waves through it.

use ondine::film::{AovSet, BLOCK};
use ondine::material::Material;
use ondine::sampling::Sampler;
use ondine::scene::Scene;
use ondine::scene::builtin;
use ondine::scene::camera::Camera;
use ondine::scene::description::{SamplerKind, Strategy};
use ondine::scene::sensor::Sensor;
use ondine::wavefront::{Context, Wave};

/// Edges of the paths.
pub const PATH_LENGTH: u32 = 6;

/// Pixels on a side of a tile: with a block of samples each, a wave of the size that renders use.
pub const TILE: u32 = 11;

/// What a [`Context`] borrows.
pub struct Setup {
    pub scene: Scene,
    camera: Camera,
    sampler: Sampler,
}

impl Setup {
    /// The Cornell box seen on `size` × `size` pixels; with a material, everything in it is made of that.
    pub fn cornell(size: u32, sampler: SamplerKind, material: Option<Material>) -> Self {
        let mut description = builtin::find("cornell")
            .expect("a built-in scene")
            .load()
            .expect("built-in scenes are valid");
        if let Some(material) = material {
            for named in &mut description.materials {
                named.material = material;
            }
        }
        let camera = &description.cameras[0].camera;
        Self {
            scene: Scene::compile(&description),
            camera: Camera::new(camera, size, size, description.film.filter),
            sampler: match sampler {
                SamplerKind::Pcg => Sampler::pcg(0, PATH_LENGTH),
                SamplerKind::Sobol => Sampler::sobol(0, PATH_LENGTH),
            },
        }
    }

    /// As a render with the strategy `mis` would make it.
    pub fn context(&self) -> Context<'_> {
        Context {
            scene: &self.scene,
            sensor: Sensor::Camera(&self.camera),
            enclosed: self
                .camera
                .origins()
                .iter()
                .all(|&origin| self.scene.encloses(origin)),
            sampler: &self.sampler,
            strategy: Strategy::Mis,
            path_length: PATH_LENGTH,
            roulette: None,
            aovs: AovSet::default(),
        }
    }
}

/// The first block of samples of the tile at this column and row of tiles.
pub fn wave(column: u32, row: u32) -> Wave {
    Wave {
        x: column * TILE,
        y: row * TILE,
        width: TILE,
        height: TILE,
        first_sample: 0,
        samples: BLOCK,
    }
}
