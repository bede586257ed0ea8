//! Changes of a scene that is no TOML: its cameras and its materials are written as TOML, changed, and read again.

use super::change::{self, Change, Edit};
use super::files::Files;
use super::keys::{camera_key, dotted, is_lone, maps_kept, materials_named};
use super::names::{did_you_mean, list, quoted};
use super::reader::{Source, Table};
use super::{cameras, materials, write};
use crate::error::{Error, Result};
use crate::material::Kind;
use crate::scene::cache::Cache;
use crate::scene::description::{Description, NamedCamera, NamedMaterial};
use crate::scene::{builtin, hash};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// What can be changed, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Camera(usize),
    Material(usize),
}

/// The scene of a file with the changes made, in their order, as if the file had its cameras as `[camera]`, where there is but
/// one, or `[cameras.NAME]`, and its materials as `[materials.NAME]`. What no change names keeps its bits. Materials of one
/// name are changed together. A material keeps its textures while its type stays; of another type it has only its cut-out
/// left. Images that a change names are relative to the file's folder.
///
/// The scene's hash becomes that of its hash before and of all that is other than before, if anything is.
///
/// # Errors
/// [`Error::Usage`] with a change's origin, for what is not there or cannot be.
pub(in crate::scene) fn change(
    mut scene: Description,
    path: &Path,
    changes: &[Arc<Change>],
    cache: &mut Cache,
) -> Result<Description> {
    let file = path.display().to_string();
    let mut edits: BTreeMap<Target, Vec<Edit>> = BTreeMap::new();
    for change in changes {
        let (targets, names) = targets(&scene, path, change)?;
        for target in targets {
            let edit = (change.clone(), names.clone());
            edits.entry(target).or_default().push(edit);
        }
    }
    let hasher = Sha256::new_with_prefix(&scene.hash);
    let mut files = Files::new(path.parent(), hasher, &mut scene, cache);
    let mut differs = false;
    for (&target, edits) in &edits {
        let before = told(files.scene, target);
        edit(&mut files, target, &file, edits)?;
        let after = told(files.scene, target);
        if after != before {
            files.hasher.update(after);
            differs = true;
        }
    }
    let hash = hash::finish(files.hasher);
    if differs {
        scene.hash = hash;
    }
    Ok(scene)
}

/// What a change changes, and its key, part by part, as [`edit`] writes it; what is wrong otherwise.
fn targets(
    scene: &Description,
    path: &Path,
    change: &Change,
) -> Result<(Vec<Target>, Vec<String>)> {
    let names = change.names()?;
    let refuse = |message| Err(change.error(format!("{}: {message}", path.display())));
    let cameras = || scene.cameras.iter().map(|named| named.name.as_str());
    let materials = || scene.materials.iter().map(|named| named.name.as_str());
    let words: Vec<&str> = names.iter().map(String::as_str).collect();
    match words[..] {
        ["camera", ..] if is_lone(scene) => Ok((vec![Target::Camera(0)], names)),
        ["camera", ..] => refuse(format!(
            "the scene has {} cameras; name one of them, as in {}: {}",
            scene.cameras.len(),
            dotted("cameras", cameras().next().unwrap_or_default()),
            list(cameras())
        )),
        ["cameras"] => refuse(change::is_table("cameras", cameras())),
        ["materials"] => refuse(change::is_table("materials", materials())),
        ["cameras", name, ..] => match cameras().position(|known| known == name) {
            Some(_) if is_lone(scene) => {
                let within = names[2..].iter().cloned();
                let names = std::iter::once("camera".to_owned()).chain(within);
                Ok((vec![Target::Camera(0)], names.collect()))
            }
            Some(index) => Ok((vec![Target::Camera(index)], names)),
            None => refuse(change::unknown(name, "cameras", cameras())),
        },
        ["materials", name, ..] => {
            let targets: Vec<_> = materials_named(scene, name).map(Target::Material).collect();
            match targets.is_empty() {
                true => refuse(change::unknown(name, "materials", materials())),
                false => Ok((targets, names)),
            }
        }
        _ => {
            let other = words.first().copied().unwrap_or_default();
            let hint = match did_you_mean(other, ["camera", "cameras", "materials"]) {
                hint if hint.is_empty() => {
                    format!("; write a .toml scene{} for the rest", naming(path))
                }
                hint => hint,
            };
            refuse(format!(
                "{} cannot be changed, for this is no .toml scene; its keys are camera, cameras.NAME and materials.NAME{hint}",
                quoted(other)
            ))
        }
    }
}

/// How a .toml scene shows a file, where it can.
fn naming(path: &Path) -> String {
    match builtin::mesh_loader(path) {
        Some(_) => format!(
            " with [[objects]] and mesh = {{ file = {:?} }}",
            path.display().to_string()
        ),
        None => String::new(),
    }
}

/// Makes the changes of one camera or material.
fn edit(files: &mut Files, target: Target, file: &str, edits: &[Edit]) -> Result<()> {
    let scene = &*files.scene;
    let (key, table) = match target {
        Target::Camera(index) => {
            let NamedCamera { name, camera } = &scene.cameras[index];
            (camera_key(scene, name), write::camera(camera))
        }
        Target::Material(index) => {
            let NamedMaterial { name, material, .. } = &scene.materials[index];
            (dotted("materials", name), write::material(material))
        }
    };
    let text = change::apply(&format!("{key} = {table}\n"), file, edits)?;
    read(files, target, &Source { file, text: &text }).map_err(|error| {
        // Its place is in a text that nobody has seen.
        let message = match error {
            Error::Scene { message, .. } => message,
            other => other.to_string(),
        };
        let error = Error::Usage(format!("{file}: {key}: {message}"));
        change::blame(error, edits.iter().map(|(change, _)| &**change))
    })
}

/// Reads one camera or material from a text that says nothing else.
fn read(files: &mut Files, target: Target, source: &Source) -> Result<()> {
    let document = source.document()?;
    let root = Table::root(source, &document);
    match target {
        Target::Camera(index) => {
            for named in cameras(&root)? {
                files.scene.cameras[index].camera = named.camera;
            }
        }
        Target::Material(index) => {
            let all = root.require("the scene", "materials", "[materials.NAME]")?;
            for value in all.table("[materials.NAME]")?.values() {
                let said = value.entry("type").and_then(|kind| kind.text().ok());
                let kind = Kind::ALL.into_iter().find(|kind| Some(kind.name()) == said);
                // The reader refuses what is no type.
                let maps = kind.map(|kind| maps_kept(files.scene, index, kind));
                let maps = maps.unwrap_or_default();
                files.scene.materials[index] = materials::named(value, files, maps)?;
            }
        }
    }
    Ok(())
}

/// All that a camera or material says, for the scene's hash.
fn told(scene: &Description, target: Target) -> String {
    match target {
        Target::Camera(index) => {
            let camera = write::camera(&scene.cameras[index].camera);
            format!("camera {index} {camera}\n")
        }
        Target::Material(index) => {
            let NamedMaterial { material, maps, .. } = &scene.materials[index];
            let material = write::material(material);
            let textures = maps.textures().map(|texture| {
                let texture = &scene.textures[texture];
                format!(
                    "{:?} {} {:?}",
                    texture.wrap, texture.nearest, texture.transform
                )
            });
            let textures: Vec<String> = textures.collect();
            format!("material {index} {material} {maps:?} {textures:?}\n")
        }
    }
}
