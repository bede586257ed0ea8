//! glTF 2.0: `.gltf` and `.glb` (ISO/IEC 12113:2022).
//!
//! Nodes become instances, mesh primitives meshes, metallic-roughness materials [`Principled`](crate::material::Material)
//! ones. Units are taken as they stand: a unit of length is a unit of the scene, 1 nit (emission) is 1 W·sr⁻¹·m⁻² in each
//! channel, 1 candela (point and spot lights) 1 W·sr⁻¹, 1 lux (directional lights) 1 W·m⁻². The optional `range` of a light
//! is not used: light falls off with the square of the distance, and never ends.
//!
//! Errors name the file and the place in its JSON. What is read differently or not at all is told once, however often it
//! occurs, in [`Description::warnings`].

mod accessor;
mod file;
mod material;
mod mesh;
mod node;

use super::description::{Description, Image};
use super::image::ColorSpace;
use super::mesh::without_area;
use super::toml::names::quoted;
use super::{framing, hash};
use crate::error::Result;
use file::{AGAIN, File};
use material::{Surface, TextureKey};
use mesh::Part;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The extensions that are read.
const EXTENSIONS: [&str; 8] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Pixels on the longer side of an image.
const LONGER_SIDE: u32 = 512;

/// Reads a scene as it stands in the file: there may be no camera and no light.
///
/// # Errors
/// [`Error::Read`](crate::error::Error::Read) where the file cannot be read,
/// [`Error::Scene`](crate::error::Error::Scene) where it is not the JSON of glTF, and
/// [`Error::Format`](crate::error::Error::Format) at the first thing that cannot be rendered.
pub fn load(path: &Path) -> Result<Description> {
    let mut hasher = Sha256::new();
    let file = File::open(path, &mut hasher)?;
    let name = path.display().to_string();
    let mut description = framing::nothing(&name);
    description.film.width = LONGER_SIDE;
    description.film.height = LONGER_SIDE;
    let mut reader = Reader {
        description,
        file: &file,
        hasher,
        notes: Notes::default(),
        flat: 0,
        surfaces: HashMap::new(),
        textures: HashMap::new(),
        images: HashMap::new(),
        parts: HashMap::new(),
    };
    reader.extensions()?;
    reader.nodes()?;
    let Reader {
        mut description,
        notes,
        flat,
        hasher,
        ..
    } = reader;
    if description.objects.is_empty() && description.lights.is_empty() {
        let message =
            format!("there are no triangles to render; {AGAIN}, with meshes in its scene");
        return Err(file.error("scene", message));
    }
    description.hash = hash::finish(hasher);
    description.warnings = notes.lines(&name);
    description.warnings.extend(without_area(&name, flat));
    Ok(description)
}

/// What is read, and what is known of it while the rest is read.
struct Reader<'a> {
    file: &'a File<'a>,
    description: Description,
    hasher: Sha256,
    notes: Notes,
    /// Triangles without an area.
    flat: usize,
    /// By the file's material; none is the default one.
    surfaces: HashMap<Option<usize>, Surface>,
    textures: HashMap<TextureKey, usize>,
    /// By the file's image.
    images: HashMap<(usize, ColorSpace), Arc<Image>>,
    /// By the file's mesh.
    parts: HashMap<usize, Vec<Part>>,
}

impl Reader<'_> {
    fn extensions(&mut self) -> Result<()> {
        let is_known = |name: &str| EXTENSIONS.contains(&name);
        let document = &self.file.document;
        if let Some(name) = document.extensions_required().find(|name| !is_known(name)) {
            let message = format!("{} is not read; export the file without it", quoted(name));
            return Err(self.file.error("extensionsRequired", message));
        }
        for name in document.extensions_used().filter(|name| !is_known(name)) {
            let message = format!("{} is not read", quoted(name));
            self.notes.tell("extensionsUsed", message);
        }
        if document.animations().len() > 0 {
            self.notes
                .tell("animations", "nodes stand as they do without animation");
        }
        Ok(())
    }
}

/// What is told once, however often it occurs.
#[derive(Default)]
struct Notes(Vec<Note>);

struct Note {
    message: String,
    first: String,
    others: usize,
}

impl Notes {
    fn tell(&mut self, place: &str, message: impl Into<String>) {
        let message = message.into();
        match self.0.iter_mut().find(|note| note.message == message) {
            Some(note) => note.others += 1,
            None => self.0.push(Note {
                message,
                first: place.to_owned(),
                others: 0,
            }),
        }
    }

    fn lines(self, file: &str) -> Vec<String> {
        let line = |note: Note| {
            let others = match note.others {
                0 => String::new(),
                others => format!(" and {others} more"),
            };
            format!("{file}: {}{others}: {}", note.first, note.message)
        };
        self.0.into_iter().map(line).collect()
    }
}
