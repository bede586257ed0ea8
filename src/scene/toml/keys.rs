//! The keys by which a scene's cameras and materials are changed, and what materials keep then.

use crate::material::Kind;
use crate::scene::description::{Description, Maps};
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

/// The textures that a material, by index, has left when it is changed to this kind: all, where it is of that kind already.
/// Else a .toml scene says what it has anew, which is none, and in any other scene the cut-out stays.
pub fn maps_kept(description: &Description, index: usize, kind: Kind) -> Maps {
    let Some(before) = description.materials.get(index) else {
        return Maps::default();
    };
    match description.written {
        _ if before.material.kind() == kind => before.maps,
        Some(_) => Maps::default(),
        None => Maps {
            alpha: before.maps.alpha,
            ..Maps::default()
        },
    }
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
