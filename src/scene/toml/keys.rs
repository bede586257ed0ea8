//! The keys by which a scene's cameras and materials are changed.

use crate::scene::description::Description;
use toml_edit::Key;

/// The key of the camera of that name, as [`Change`](super::Change) and `--set` take it: `camera` where a .toml scene has
/// `[camera]`, or any other scene but one; else `cameras.NAME`, with quotes where TOML needs them.
pub fn camera_key(description: &Description, name: &str) -> String {
    match is_lone(description) {
        true => "camera".to_owned(),
        false => dotted("cameras", name),
    }
}

/// The key of the materials of that name: `materials.NAME`, with quotes where TOML needs them. `None` where
/// [`materials_named`] has none, for those cannot be changed.
pub fn material_key(description: &Description, name: &str) -> Option<String> {
    let can_be_changed = materials_named(description, name).next().is_some();
    can_be_changed.then(|| dotted("materials", name))
}

/// The materials that changes by that name concern, by index: all that are called so. In a .toml scene it is its own, for
/// materials of the mesh files that it names cannot be changed.
pub fn materials_named<'a>(
    description: &'a Description,
    name: &'a str,
) -> impl Iterator<Item = usize> + 'a {
    let all = description.materials.len();
    let own = description.written.map_or(all, |written| written.materials);
    let materials = description.materials.iter().enumerate().take(own);
    materials
        .filter(move |(_, material)| material.name == name)
        .map(|(index, _)| index)
}

/// Whether its camera needs no name.
pub(super) fn is_lone(description: &Description) -> bool {
    match description.written {
        Some(written) => written.lone_camera,
        None => description.cameras.len() == 1,
    }
}

/// `TABLE.NAME`.
pub(super) fn dotted(table: &str, name: &str) -> String {
    format!("{table}.{}", Key::new(name))
}
