//! The built-in scenes: those of `scenes/`, embedded, so that a first render needs no file.

use super::cache::Cache;
use super::description::{Description, MOST_OBJECTS};
use super::toml::{self, Change, names};
use super::{framing, gltf, obj, pbrt, ply};
use crate::error::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// A scene that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// What it is called on the command line.
    pub name: &'static str,
    /// Its text, as `ondine scenes NAME` prints it.
    pub text: &'static str,
}

macro_rules! builtins {
    ($($name:literal),+ $(,)?) => {
        &[$(Builtin {
            name: $name,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
        }),+]
    };
}

/// Every built-in scene, in the order a newcomer should meet them.
pub const ALL: &[Builtin] = builtins![
    "cornell",
    "mirror",
    "glass",
    "glossy",
    "phong",
    "blur",
    "materials",
    "many-lights",
    "sky",
    "sh-grace",
    "sh-eucalyptus",
    "furnace",
];

impl Builtin {
    /// What it shows, in one line: the first comment of its text.
    pub fn title(&self) -> &'static str {
        let line = self.text.lines().next().unwrap_or_default();
        line.trim_start_matches('#').trim()
    }

    /// The scene.
    ///
    /// # Errors
    /// None that a test of this crate would not have met.
    pub fn load(&self) -> Result<Description> {
        self.load_changed(&[], &mut Cache::default())
    }

    fn load_changed(&self, changes: &[Arc<Change>], cache: &mut Cache) -> Result<Description> {
        let name = format!("built-in scene {}", self.name);
        let description = toml::parse_changed(self.text, &name, None, changes, cache)?;
        Ok(Description {
            name: self.name.to_owned(),
            ..description
        })
    }
}

/// The built-in scene of that name.
pub fn find(name: &str) -> Option<&'static Builtin> {
    ALL.iter().find(|builtin| builtin.name == name)
}

/// A scene as it is named on the command line: the path of a file, or the name of a built-in scene.
///
/// # Errors
/// [`Error::Usage`] where there is no such scene, [`Error::Format`] for a kind of file that is not read, and those of the
/// loaders.
pub fn open(scene: &str) -> Result<Description> {
    open_changed(scene, &[], &mut Cache::default())
}

/// The same with some values changed, and files from a cache. The hash of a .toml scene is that of the changed text. In any
/// other scene, cameras and materials can be changed, as if they stood in it as TOML: `camera`, where there is but one, or
/// `cameras.NAME`, and `materials.NAME`, which changes all materials of that name. A material keeps its textures while its
/// type stays; of another type it has only its cut-out left. The scene's hash is then that of its hash and of what is other than
/// before.
///
/// # Errors
/// As [`open()`]; and [`Error::Usage`], with the change's origin, for what cannot be changed so.
pub fn open_changed(
    scene: &str,
    changes: &[Arc<Change>],
    cache: &mut Cache,
) -> Result<Description> {
    let description = read(scene, changes, cache)?;
    let lights = description.lights.len() + description.punctual.len();
    for (count, most, what) in [
        (
            description.objects.len() + lights,
            MOST_OBJECTS,
            "objects and lights",
        ),
        (lights, MOST_LIGHTS, "lights"),
    ] {
        if count > most {
            let message = format!("has {count} {what}; at most {most} can be told apart");
            return Err(Error::format(Path::new(scene), message));
        }
    }
    Ok(description)
}

/// The most lights: the alias table they are chosen by has 22 bits for a column, and the sky may be one.
const MOST_LIGHTS: usize = (1 << 22) - 2;

fn read(scene: &str, changes: &[Arc<Change>], cache: &mut Cache) -> Result<Description> {
    let path = Path::new(scene);
    if path.exists() {
        if extension(path) == "toml" {
            return toml::load_changed(path, changes, cache);
        }
        if let Some(load) = loader(path) {
            let found = match changes {
                [] => load(path)?,
                // More of it may be to come, with other changes.
                _ => Description::clone(&*cache.scene(path, load)?),
            };
            return toml::edit::change(framing::complete(found), path, changes, cache);
        }
    }
    if let Some(builtin) = find(scene) {
        return builtin.load_changed(changes, cache);
    }
    if path.exists() {
        return Err(Error::format(
            path,
            "is not a scene file; scenes are .toml, .pbrt, .gltf, .glb, .obj and .ply files (`ondine scenes cornell` prints one to start from)",
        ));
    }
    let known = || ALL.iter().map(|builtin| builtin.name);
    // `cornel.toml` and `scenes/cornell.toml` are attempts at a name too.
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let hint = names::did_you_mean(stem.unwrap_or(scene), known());
    let quoted = names::quoted(scene);
    let list = names::list(known());
    Err(Error::Usage(format!(
        "there is no file and no built-in scene {quoted}{} Built-in scenes: {list}",
        if hint.is_empty() { "." } else { &hint },
    )))
}

/// Reads a scene as it stands in its file.
type Load = fn(&Path) -> Result<Description>;

/// What reads a file that is no .toml scene, by its name.
fn loader(path: &Path) -> Option<Load> {
    let is_packed = || path.to_string_lossy().to_lowercase().ends_with(".pbrt.gz");
    match extension(path).as_str() {
        "pbrt" => Some(pbrt::load),
        // `pbrt::load` unpacks it.
        "gz" if is_packed() => Some(pbrt::load),
        _ => mesh_loader(path),
    }
}

/// What reads a file of meshes, by its name, as the scene it is. What has neither light nor camera is left so.
pub(super) fn mesh_loader(path: &Path) -> Option<Load> {
    match extension(path).as_str() {
        "ply" => Some(ply::scene),
        "obj" => Some(obj::load),
        "gltf" | "glb" => Some(gltf::load),
        _ => None,
    }
}

fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.unwrap_or_default().to_lowercase()
}
