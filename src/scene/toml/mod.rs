//! The TOML scene format, version 1: text to a checked [`Description`].
//!
//! Every error names file, line and column, says what is wrong and what to do; unknown keys are errors.

mod change;
pub(super) mod edit;
mod environment;
mod files;
mod keys;
mod lights;
mod materials;
pub(crate) mod names;
pub(crate) mod reader;
mod transform;
mod world;
pub mod write;

use super::cache::Cache;
use super::description::{
    Camera, Description, FilmDescription, Filter, MAX_EDGES, MAX_SIDE, NamedCamera, RenderDefaults,
    Written,
};
use super::{framing, hash};
use crate::error::{Error, Result};
use crate::film::MAX_SAMPLES;
pub use change::Change;
use files::Files;
use glam::Vec3;
pub use keys::{camera_key, maps_kept, material_key, materials_named};
use reader::{Source, Table, Value};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
pub use transform::rotation;

/// The version of the format that this program reads.
const VERSION: u64 = 1;
/// Greatest size of a scene file, bytes: what is larger is not a scene written by hand or script, but a mistake.
const LARGEST: u64 = 256 << 20;
/// Sine of the smallest angle between the up vector and the optical axis.
const PARALLEL: f64 = 1e-4;

/// Reads a scene file. Images and meshes it names are relative to its folder.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read, and all of [`parse`].
pub fn load(path: &Path) -> Result<Description> {
    load_changed(path, &[], &mut Cache::default())
}

/// The same with some values changed; the scene's hash is that of the changed text.
pub(super) fn load_changed(
    path: &Path,
    changes: &[Arc<Change>],
    cache: &mut Cache,
) -> Result<Description> {
    let text = cache.text(path)?;
    parse_changed(
        &text,
        &path.display().to_string(),
        path.parent(),
        changes,
        cache,
    )
}

/// The text of a TOML file, which a user may have named by mistake.
///
/// # Errors
/// [`Error::Read`] where it cannot be read, [`Error::Format`] where it is too large, [`Error::Scene`] where it is not UTF-8.
pub(crate) fn text(path: &Path) -> Result<String> {
    let cannot_read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let file = std::fs::File::open(path).map_err(cannot_read)?;
    let mut bytes = Vec::new();
    file.take(LARGEST + 1)
        .read_to_end(&mut bytes)
        .map_err(cannot_read)?;
    if bytes.len() as u64 > LARGEST {
        let message = "is larger than 256 MiB; a scene file is text that describes a scene";
        return Err(Error::format(path, message));
    }
    let name = path.display().to_string();
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let valid = String::from_utf8_lossy(&error.as_bytes()[..valid]);
        let source = Source {
            file: &name,
            text: &valid,
        };
        source.error(
            valid.len(),
            "this is not UTF-8 text; save the file as UTF-8",
        )
    })
}

/// Reads the text of a scene. `file_name` is what errors call it; files it names are relative to `base_dir`, and
/// without one only absolute paths are found.
///
/// # Errors
/// [`Error::Scene`], with line and column, at the first thing that cannot be rendered as written.
pub fn parse(text: &str, file_name: &str, base_dir: Option<&Path>) -> Result<Description> {
    read(text, file_name, base_dir, &mut Cache::default())
}

/// The same with some values changed, and files from a cache.
pub(super) fn parse_changed(
    text: &str,
    file_name: &str,
    base_dir: Option<&Path>,
    changes: &[Arc<Change>],
    cache: &mut Cache,
) -> Result<Description> {
    if changes.is_empty() {
        return read(text, file_name, base_dir, cache);
    }
    let edits = changes
        .iter()
        .map(|change| Ok((change.clone(), change.names()?)));
    let edits = edits.collect::<Result<Vec<_>>>()?;
    let changed = change::apply(text, file_name, &edits)?;
    read(&changed, file_name, base_dir, cache).map_err(|error| {
        // What is wrong without the changes too is not their fault.
        match read(text, file_name, base_dir, cache) {
            Ok(_) => change::blame(error, changes.iter().map(Arc::as_ref)),
            Err(original) => original,
        }
    })
}

fn read(
    text: &str,
    file_name: &str,
    base_dir: Option<&Path>,
    cache: &mut Cache,
) -> Result<Description> {
    let source = Source {
        file: file_name,
        text,
    };
    let document = source.document()?;
    let root = Table::root(&source, &document);
    // First of all: a later version may have keys that this one does not know.
    version(&root)?;
    root.keys(
        "the scene",
        &[
            "version",
            "camera",
            "cameras",
            "film",
            "render",
            "materials",
            "objects",
            "lights",
            "environment",
        ],
    )?;
    let mut scene = Description {
        cameras: cameras(&root)?,
        ..framing::nothing(file_name)
    };
    if let Some(value) = root.get("film") {
        scene.film = film(value)?;
    }
    if let Some(value) = root.get("render") {
        scene.render = render(value)?;
    }
    let mut files = Files::new(base_dir, Sha256::new_with_prefix(text), &mut scene, cache);
    if let Some(value) = root.get("materials") {
        files.scene.materials = materials::materials(value, &mut files)?;
    }
    files.scene.written = Some(Written {
        lone_camera: root.get("camera").is_some(),
        materials: files.scene.materials.len(),
    });
    let names: Vec<String> = files
        .scene
        .materials
        .iter()
        .map(|material| material.name.clone())
        .collect();
    let defined = names
        .iter()
        .enumerate()
        .map(|(index, name)| (name.as_str(), index))
        .collect();
    if let Some(value) = root.get("objects") {
        world::objects(value, &defined, &mut files)?;
    }
    if let Some(value) = root.get("lights") {
        lights::lights(value, &defined, &mut files)?;
    }
    if let Some(value) = root.get("environment") {
        files.scene.environment = Some(environment::environment(value, &mut files)?);
    }
    let hash = hash::finish(files.hasher);
    scene.hash = hash;
    if scene.lights.is_empty() && scene.punctual.is_empty() && scene.environment.is_none() {
        let what = if scene.objects.is_empty() {
            "the scene is empty"
        } else {
            "the scene has no light"
        };
        return Err(root.error(format!(
            "{what}; add [[lights]] with a shape and a radiance, or an [environment] such as constant = [1.0, 1.0, 1.0]"
        )));
    }
    Ok(scene)
}

/// Refuses another version than the one of these formats.
pub(crate) fn version(root: &Table) -> Result<()> {
    let value = root.require("the file", "version", "`version = 1` as its first line")?;
    match value.integer(0, u64::MAX)? {
        VERSION => Ok(()),
        other => Err(value.error(format!(
            "version {other} is not supported; this program reads version {VERSION}"
        ))),
    }
}

fn cameras(root: &Table) -> Result<Vec<NamedCamera>> {
    const EXAMPLE: &str = "[camera] with position, look_at and vertical_fov";
    match (root.get("camera"), root.get("cameras")) {
        (Some(one), Some(many)) => {
            let later = if one.key_at > many.key_at { one } else { many };
            Err(later.key_error(
                "the scene has both [camera] and [cameras]; rename [camera] to [cameras.NAME] to have several",
            ))
        }
        (Some(one), None) => Ok(vec![NamedCamera {
            name: "camera".to_owned(),
            camera: camera(one, "[camera]")?,
        }]),
        (None, Some(many)) => {
            let cameras = many.table("[cameras.NAME]")?.values();
            if cameras.is_empty() {
                return Err(many.key_error(format!("[cameras] is empty; add {EXAMPLE}")));
            }
            cameras
                .into_iter()
                .map(|value| {
                    Ok(NamedCamera {
                        name: value.key.to_owned(),
                        camera: camera(value, &format!("[cameras.{}]", value.name()))?,
                    })
                })
                .collect()
        }
        (None, None) => Err(root.error(format!("the scene has no camera; add {EXAMPLE}"))),
    }
}

fn camera(value: Value, owner: &str) -> Result<Camera> {
    let table = value.table(owner)?;
    table.keys(
        owner,
        &[
            "position",
            "look_at",
            "up",
            "vertical_fov",
            "aperture_radius",
            "focus_distance",
        ],
    )?;
    let position = table
        .require(owner, "position", "position = [x, y, z]")?
        .point()?;
    let look_at_value = table.require(owner, "look_at", "look_at = [x, y, z]")?;
    let look_at = look_at_value.point()?;
    let vertical_fov = table
        .require(owner, "vertical_fov", "vertical_fov = 50.0, in degrees")?
        .number_where("above 0 and below 180 degrees", |fov| {
            fov > 0.0 && fov < 180.0
        })?;
    let axis = look_at.as_dvec3() - position.as_dvec3();
    // Below this a direction cannot be normalised in 32-bit floats.
    if axis.length() < 1e-15 {
        return Err(look_at_value.error(
            "look_at is the same point as position, so the camera looks nowhere; move either",
        ));
    }
    let up_value = table.get("up");
    let up = up_value.map_or(Ok(Vec3::Y), |value| value.point())?;
    let up_length = up.as_dvec3().length();
    let at_up = |message| up_value.unwrap_or(look_at_value).error(message);
    if up_length < 1e-15 {
        return Err(at_up(
            "up has no direction; write up = [0.0, 1.0, 0.0]".to_owned(),
        ));
    }
    if axis.cross(up.as_dvec3()).length() < PARALLEL * axis.length() * up_length {
        let other = if axis.y.abs() > 0.9 * axis.length() {
            "[0.0, 0.0, -1.0]"
        } else {
            "[0.0, 1.0, 0.0]"
        };
        return Err(at_up(format!(
            "up is parallel to the view direction, so the camera has no right side; write up = {other}"
        )));
    }
    let aperture_radius = table.get("aperture_radius").map_or(Ok(0.0), |value| {
        value.number_where("at least 0 (0 is a pinhole) and at most 1e9", |radius| {
            (0.0..=1e9).contains(&radius)
        })
    })?;
    let focus_distance = table
        .get("focus_distance")
        .map_or(Ok(axis.length() as f32), |value| {
            value.number_where("above 0 and at most 1e9", |distance| {
                distance > 0.0 && distance <= 1e9
            })
        })?;
    Ok(Camera {
        position,
        look_at,
        up,
        vertical_fov,
        aperture_radius,
        focus_distance,
    })
}

fn film(value: Value) -> Result<FilmDescription> {
    let table = value.table("[film]")?;
    table.keys("[film]", &["width", "height", "filter"])?;
    let pixels = |key, example| {
        let value = table.require("[film]", key, example)?;
        value.count(MAX_SIDE)
    };
    Ok(FilmDescription {
        width: pixels("width", "width = 256, in pixels")?,
        height: pixels("height", "height = 256, in pixels")?,
        filter: table
            .get("filter")
            .map_or(Ok(Filter::default()), |value| value.choice())?,
    })
}

fn render(value: Value) -> Result<RenderDefaults> {
    let table = value.table("[render]")?;
    table.keys(
        "[render]",
        &[
            "spp",
            "path_length",
            "strategy",
            "sampler",
            "seed",
            "roulette",
        ],
    )?;
    Ok(RenderDefaults {
        spp: table
            .get("spp")
            .map(|value| value.count(MAX_SAMPLES))
            .transpose()?,
        path_length: table
            .get("path_length")
            .map(|value| value.count(MAX_EDGES))
            .transpose()?,
        strategy: table
            .get("strategy")
            .map(|value| value.choice())
            .transpose()?,
        sampler: table
            .get("sampler")
            .map(|value| value.choice())
            .transpose()?,
        seed: table
            .get("seed")
            .map(|value| value.integer(0, u64::MAX))
            .transpose()?,
        roulette: table
            .get("roulette")
            .map(|value| value.count(MAX_EDGES))
            .transpose()?,
    })
}
