//! `scene.json`: what the ids in the records mean, so that a port can tell its own by them.

use crate::scene::description::{Description, Punctual, Shape};
use crate::scene::numbered_primitives;
use serde::Serialize;

/// Materials, lights and primitives, by id.
#[derive(Clone, Debug, Serialize)]
pub struct SceneIds {
    materials: Vec<Material>,
    lights: Vec<Light>,
    /// Spheres and quads; ids from 2³¹ up are triangles of meshes.
    primitives: Vec<Primitive>,
}

#[derive(Clone, Debug, Serialize)]
struct Material {
    id: usize,
    name: String,
    kind: &'static str,
}

#[derive(Clone, Debug, Serialize)]
struct Light {
    id: usize,
    shape: &'static str,
}

#[derive(Clone, Debug, Serialize)]
struct Primitive {
    id: usize,
    shape: &'static str,
    material: Option<usize>,
    light: Option<usize>,
}

impl SceneIds {
    /// Those of a scene.
    pub fn of(description: &Description) -> Self {
        let materials = description.materials.iter().enumerate();
        let materials = materials.map(|(id, named)| Material {
            id,
            name: named.name.clone(),
            kind: named.material.kind().name(),
        });
        let lights = description.lights.iter().map(|light| shape(&light.shape));
        let sky = description.environment.iter().map(|_| "sky");
        let punctual = description.punctual.iter().map(|light| match light {
            Punctual::Point { .. } => "point",
            Punctual::Spot { .. } => "spot",
            Punctual::Distant { .. } => "distant",
        });
        let lights = lights.chain(sky).chain(punctual).enumerate();
        let primitives = numbered_primitives(description).enumerate();
        Self {
            materials: materials.collect(),
            lights: lights.map(|(id, shape)| Light { id, shape }).collect(),
            primitives: primitives
                .map(|(id, (found, material, light))| Primitive {
                    id,
                    shape: shape(&found),
                    material,
                    light,
                })
                .collect(),
        }
    }
}

fn shape(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Quad { .. } => "quad",
        Shape::Mesh { .. } => "mesh",
    }
}
