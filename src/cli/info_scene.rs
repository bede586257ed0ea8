//! What a scene holds.

use crate::error::Result;
use crate::material::Material;
use crate::render::Settings;
use crate::scene::builtin;
use crate::scene::description::{Description, Environment, Shape};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;

/// How many there are of each kind.
type Counts = BTreeMap<&'static str, usize>;

/// What `info` says of a scene.
#[derive(Debug, Serialize)]
pub(super) struct SceneInfo {
    kind: &'static str,
    scene: String,
    scene_hash: String,
    width: u32,
    height: u32,
    filter: String,
    cameras: Vec<CameraInfo>,
    objects: Counts,
    lights: Counts,
    materials: Counts,
    environment: Option<Value>,
    defaults: Defaults,
}

#[derive(Debug, Serialize)]
struct CameraInfo {
    name: String,
    position: [f32; 3],
    look_at: [f32; 3],
    up: [f32; 3],
    vertical_fov: f32,
    aperture_radius: f32,
    focus_distance: f32,
}

/// What it is rendered with unless the command line asks for something else.
#[derive(Debug, Serialize)]
struct Defaults {
    spp: u32,
    path_length: u32,
    strategy: String,
    sampler: String,
    seed: u64,
    roulette: Option<u32>,
}

pub(super) fn read(file: &str) -> Result<SceneInfo> {
    Ok(SceneInfo::of(&builtin::open(file)?))
}

impl SceneInfo {
    fn of(scene: &Description) -> Self {
        let settings = Settings::of(scene);
        let cameras = scene.cameras.iter().map(|named| CameraInfo {
            name: named.name.clone(),
            position: named.camera.position.to_array(),
            look_at: named.camera.look_at.to_array(),
            up: named.camera.up.to_array(),
            vertical_fov: named.camera.vertical_fov,
            aperture_radius: named.camera.aperture_radius,
            focus_distance: named.camera.focus_distance,
        });
        Self {
            kind: "scene",
            scene: scene.name.clone(),
            scene_hash: scene.hash.clone(),
            width: scene.film.width,
            height: scene.film.height,
            filter: scene.film.filter.to_string(),
            cameras: cameras.collect(),
            objects: count(scene.objects.iter().map(|object| shape(&object.shape))),
            lights: count(scene.lights.iter().map(|light| shape(&light.shape))),
            materials: count(scene.materials.iter().map(|named| kind(&named.material))),
            environment: scene.environment.as_ref().map(environment),
            defaults: Defaults {
                spp: settings.spp,
                path_length: settings.path_length,
                strategy: settings.strategy.to_string(),
                sampler: settings.sampler.to_string(),
                seed: settings.seed,
                roulette: settings.roulette,
            },
        }
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<13}{value}");
        };
        line("scene", &self.scene);
        line(
            "image",
            &format!("{}x{}, {} filter", self.width, self.height, self.filter),
        );
        for camera in &self.cameras {
            let [x, y, z] = camera.position;
            let lens = match camera.aperture_radius {
                0.0 => "pinhole".to_owned(),
                radius => format!("aperture {radius}, in focus at {}", camera.focus_distance),
            };
            let value = format!(
                "{}: at ({x}, {y}, {z}), field of view {}°, {lens}",
                camera.name, camera.vertical_fov
            );
            line("camera", &value);
        }
        line("objects", &counted(&self.objects));
        line("lights", &counted(&self.lights));
        line("materials", &counted(&self.materials));
        line(
            "environment",
            &self.environment.as_ref().map_or("none".to_owned(), spoken),
        );
        let d = &self.defaults;
        let roulette = d
            .roulette
            .map_or(String::new(), |edge| format!(", roulette from edge {edge}"));
        line(
            "defaults",
            &format!(
                "{} spp, path length {}, {}, {}, seed {}{roulette}",
                d.spp, d.path_length, d.strategy, d.sampler, d.seed
            ),
        );
        line("scene hash", &self.scene_hash);
        text
    }
}

fn shape(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Quad { .. } => "quad",
        Shape::Mesh { .. } => "mesh",
    }
}

fn kind(material: &Material) -> &'static str {
    match material {
        Material::Lambert { .. } => "lambert",
        Material::Mirror { .. } => "mirror",
        Material::Glass { .. } => "glass",
        Material::Phong { .. } => "phong",
        Material::Conductor { .. } => "conductor",
        Material::Principled { .. } => "principled",
    }
}

/// With the keys of the scene file.
fn environment(environment: &Environment) -> Value {
    match environment {
        Environment::Constant(radiance) => json!({ "constant": radiance.to_array() }),
        Environment::Gradient {
            zenith,
            horizon,
            ground,
        } => json!({ "gradient": {
            "zenith": zenith.to_array(), "horizon": horizon.to_array(), "ground": ground.to_array(),
        } }),
        Environment::Image {
            image,
            rotate_degrees,
        } => json!({
            "image": image.file, "width": image.width, "height": image.height,
            "rotate_degrees": rotate_degrees,
        }),
    }
}

/// An environment in a line.
fn spoken(environment: &Value) -> String {
    match environment.get("image").and_then(Value::as_str) {
        Some(file) => format!(
            "image {file}, {}x{}, turned by {}°",
            environment["width"], environment["height"], environment["rotate_degrees"]
        ),
        None if environment.get("gradient").is_some() => "gradient".to_owned(),
        None => format!("constant {}", environment["constant"]),
    }
}

fn count(kinds: impl Iterator<Item = &'static str>) -> Counts {
    let mut counts = Counts::new();
    kinds.for_each(|kind| *counts.entry(kind).or_default() += 1);
    counts
}

/// `7: 5 × quad, 2 × sphere`.
fn counted(counts: &Counts) -> String {
    let total: usize = counts.values().sum();
    let each: Vec<_> = counts
        .iter()
        .map(|(kind, count)| format!("{count} × {kind}"))
        .collect();
    match total {
        0 => "none".to_owned(),
        _ => format!("{total}: {}", each.join(", ")),
    }
}
