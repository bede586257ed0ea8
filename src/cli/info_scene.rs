//! What a scene holds.

use crate::error::Result;
use crate::render::Settings;
use crate::scene::builtin;
use crate::scene::description::{Description, Environment, Image, Pixels, Punctual, Shape};
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
    /// Of all instances, those that emit among them.
    triangles: u64,
    /// Meshes that stand in the scene.
    instances: usize,
    meshes: Stored,
    textures: Stored,
    /// Bytes of meshes and textures.
    memory_bytes: usize,
    environment: Option<Value>,
    defaults: Defaults,
    warnings: Vec<String>,
}

/// What is kept once, however often it is used.
#[derive(Debug, Serialize)]
struct Stored {
    count: usize,
    bytes: usize,
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
        let shapes = || {
            let objects = scene.objects.iter().map(|object| &object.shape);
            objects.chain(scene.lights.iter().map(|light| &light.shape))
        };
        let instances = shapes().filter_map(|shape| match shape {
            Shape::Mesh { mesh, .. } => Some(&scene.meshes[*mesh]),
            _ => None,
        });
        let meshes = Stored {
            count: scene.meshes.len(),
            bytes: scene.meshes.iter().map(|mesh| mesh.bytes()).sum(),
        };
        // Textures may share an image.
        let images: BTreeMap<_, &Image> = scene
            .textures
            .iter()
            .map(|texture| (std::sync::Arc::as_ptr(&texture.image), &*texture.image))
            .collect();
        let textures = Stored {
            count: scene.textures.len(),
            bytes: images.into_values().map(bytes).sum(),
        };
        Self {
            kind: "scene",
            scene: scene.name.clone(),
            scene_hash: scene.hash.clone(),
            width: scene.film.width,
            height: scene.film.height,
            filter: scene.film.filter.to_string(),
            cameras: cameras.collect(),
            objects: count(scene.objects.iter().map(|object| shape(&object.shape))),
            lights: count(
                (scene.lights.iter().map(|light| shape(&light.shape)))
                    .chain(scene.punctual.iter().map(punctual)),
            ),
            materials: count(
                scene
                    .materials
                    .iter()
                    .map(|named| named.material.kind().name()),
            ),
            triangles: instances
                .clone()
                .map(|mesh| mesh.triangles.len() as u64)
                .sum(),
            instances: instances.count(),
            memory_bytes: meshes.bytes + textures.bytes,
            meshes,
            textures,
            warnings: scene.warnings.clone(),
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
        if self.meshes.count > 0 {
            let value = format!(
                "{} (instances: {}, meshes: {}, {})",
                self.triangles,
                self.instances,
                self.meshes.count,
                size(self.meshes.bytes)
            );
            line("triangles", &value);
        }
        if self.textures.count > 0 {
            let textures = &self.textures;
            line(
                "textures",
                &format!("{}, {}", textures.count, size(textures.bytes)),
            );
        }
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
        for warning in &self.warnings {
            line("warning", warning);
        }
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

fn punctual(light: &Punctual) -> &'static str {
    match light {
        Punctual::Point { .. } => "point",
        Punctual::Spot { .. } => "spot",
        Punctual::Distant { .. } => "distant",
    }
}

fn bytes(image: &Image) -> usize {
    match &image.pixels {
        Pixels::Srgb8(texels) | Pixels::Linear8(texels) => size_of_val(&texels[..]),
        Pixels::Float(texels) => size_of_val(&texels[..]),
    }
}

/// `12.3 MiB`.
fn size(bytes: usize) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
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
        Environment::Harmonics(sh) => json!({
            "sh": sh.source, "l_max": sh.probe.degree,
            "coefficients": sh.probe.coefficients.len(),
            "rotate_degrees": sh.rotate_degrees, "clamp": sh.clamp,
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
        None if environment.get("sh").is_some() => format!(
            "spherical harmonics {} to l = {}, turned by {}°{}",
            environment["sh"].as_str().unwrap_or_default(),
            environment["l_max"],
            environment["rotate_degrees"],
            match environment["clamp"].as_bool() {
                Some(true) => ", cut off at 0",
                _ => "",
            }
        ),
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
