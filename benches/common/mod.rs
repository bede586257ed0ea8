//! What the benchmarks share: two scenes, compiled, and waves through them.

pub mod case;
pub mod landscape;

use landscape::Landscape;
use ondine::film::{AovSet, BLOCK};
use ondine::lanes::Rgb;
use ondine::material::Material;
use ondine::sampling::Sampler;
use ondine::scene::Scene;
use ondine::scene::builtin;
use ondine::scene::camera::Camera;
use ondine::scene::description::{
    Alpha, Description, Image, Light, Object, Pixels, SamplerKind, Shape, Strategy, Texture, Wrap,
};
use ondine::scene::sensor::Sensor;
use ondine::wavefront::{Context, Wave};
use std::sync::Arc;

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
        let mut description = cornell();
        if let Some(material) = material {
            for named in &mut description.materials {
                named.material = material;
            }
        }
        Self::new(&description, size, sampler)
    }

    /// A [small landscape](Landscape::small) with a texture, under a lamp that is a mesh too. Nothing else is there: all
    /// that rays meet is triangles.
    pub fn landscape(size: u32, sampler: SamplerKind, material: Option<Material>) -> Self {
        let mut description = landscape();
        if let Some(material) = material {
            description.materials[0].material = material;
        }
        Self::new(&description, size, sampler)
    }

    /// The same, of which half is holes: squares, as on a chessboard.
    pub fn lattice(size: u32, sampler: SamplerKind) -> Self {
        let mut description = landscape();
        description.materials[0].maps.alpha = Some(Alpha {
            texture: Some(0),
            factor: 1.0,
            cutoff: 0.5,
        });
        Self::new(&description, size, sampler)
    }

    fn new(description: &Description, size: u32, sampler: SamplerKind) -> Self {
        let camera = &description.cameras[0].camera;
        Self {
            scene: Scene::compile(description),
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

fn cornell() -> Description {
    builtin::find("cornell")
        .expect("a built-in scene")
        .load()
        .expect("built-in scenes are valid")
}

fn landscape() -> Description {
    let mut description = cornell();
    let camera = &mut description.cameras[0].camera;
    camera.position = Landscape::VIEWPOINT;
    camera.look_at = Landscape::CENTRE;
    let place = |mesh| Shape::Mesh {
        mesh,
        transform: glam::Affine3A::IDENTITY,
    };
    description.meshes = vec![
        Arc::new(Landscape::small().mesh()),
        Arc::new(landscape::lamp()),
    ];
    description.objects = vec![Object {
        shape: place(0),
        material: 0,
    }];
    description.lights = vec![Light {
        shape: place(1),
        radiance: Rgb::WHITE,
        two_sided: false,
        material: None,
        texture: None,
    }];
    description.textures = vec![chessboard()];
    description.materials[0].maps.color = Some(0);
    description
}

/// Eight squares a side, grey and white; the grey ones are transparent where alpha counts.
fn chessboard() -> Texture {
    const SIDE: usize = 64;
    let texel = |index: usize| match (index % SIDE / 8 + index / SIDE / 8) % 2 {
        0 => [255; 4],
        _ => [128, 128, 128, 0],
    };
    Texture {
        image: Arc::new(Image {
            file: "chessboard".to_owned(),
            width: SIDE,
            height: SIDE,
            pixels: Pixels::Srgb8((0..SIDE * SIDE).map(texel).collect()),
        }),
        wrap: [Wrap::Repeat; 2],
        nearest: false,
        transform: glam::Affine2::IDENTITY,
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
