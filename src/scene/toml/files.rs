//! The files that a scene names: meshes and images, each read once.

use super::reader::Value;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::cache::Cache;
use crate::scene::description::{Description, Image, LatLong, Punctual, Shape, Texture};
use crate::scene::image::ColorSpace;
use glam::{Affine2, Affine3A, Vec2};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// What a scene file is read into, and the files it names.
pub(super) struct Files<'a> {
    base_dir: Option<&'a Path>,
    /// Of everything that was read so far.
    pub hasher: Sha256,
    pub scene: &'a mut Description,
    cache: &'a mut Cache,
    meshes: HashMap<PathBuf, Rc<Model>>,
    images: HashMap<(PathBuf, ColorSpace), Arc<Image>>,
}

/// What a mesh file holds, by index into the scene it has become part of.
pub(super) struct Model {
    pub parts: Vec<Part>,
    pub punctual: Vec<Punctual>,
}

/// A mesh of a file, where the file has it.
pub(super) struct Part {
    pub mesh: usize,
    pub transform: Affine3A,
    pub material: Option<usize>,
    pub emission: Option<Emission>,
}

/// What a mesh of a file emits.
#[derive(Clone, Copy)]
pub(super) struct Emission {
    pub radiance: Rgb,
    pub two_sided: bool,
    pub texture: Option<usize>,
}

impl<'a> Files<'a> {
    pub fn new(
        base_dir: Option<&'a Path>,
        hasher: Sha256,
        scene: &'a mut Description,
        cache: &'a mut Cache,
    ) -> Self {
        Self {
            base_dir,
            hasher,
            scene,
            cache,
            meshes: HashMap::new(),
            images: HashMap::new(),
        }
    }

    /// A lat-long image; the bytes of its file enter the hash.
    ///
    /// # Errors
    /// What is wrong and what to do, not with which file.
    pub fn lat_long(&mut self, path: &Path) -> std::result::Result<Arc<LatLong>, String> {
        let (image, bytes) = self.cache.lat_long(path)?;
        self.hasher.update(&bytes);
        Ok(image)
    }

    /// The path that a value names, relative to the scene file; `what` is to be named.
    pub fn path(&self, value: Value, what: &str) -> Result<PathBuf> {
        let named = value.text()?;
        let name = value.name();
        if named.is_empty() {
            return Err(value.error(format!("{name} is empty; name {what}")));
        }
        match self.base_dir {
            Some(folder) => Ok(folder.join(named)),
            None if Path::new(named).is_absolute() => Ok(named.into()),
            None => Err(value.error(format!(
                "{name} is relative to the scene file, and this scene is not a file; give an absolute path, or save the scene to a file"
            ))),
        }
    }

    /// A mesh file.
    pub fn model(&mut self, value: Value) -> Result<Rc<Model>> {
        let path = self.path(value, "a .ply, .obj, .gltf or .glb file")?;
        if let Some(model) = self.meshes.get(&path) {
            return Ok(model.clone());
        }
        let scene = self
            .cache
            .mesh(&path)
            .map_err(|error| value.error(error.to_string()))?;
        let model = Rc::new(self.add(Description::clone(&scene)));
        self.meshes.insert(path, model.clone());
        Ok(model)
    }

    /// Makes a mesh file part of the scene.
    fn add(&mut self, file: Description) -> Model {
        self.hasher.update(&file.hash);
        let scene = &mut *self.scene;
        let (meshes, textures) = (scene.meshes.len(), scene.textures.len());
        let materials = scene.materials.len();
        scene.meshes.extend(file.meshes);
        scene.textures.extend(file.textures);
        scene.warnings.extend(file.warnings);
        let shift = |texture: Option<usize>| texture.map(|index| index + textures);
        scene
            .materials
            .extend(file.materials.into_iter().map(|mut named| {
                let maps = &mut named.maps;
                maps.color = shift(maps.color);
                maps.metallic_roughness = shift(maps.metallic_roughness);
                maps.normal = maps
                    .normal
                    .map(|(index, strength)| (index + textures, strength));
                if let Some(alpha) = &mut maps.alpha {
                    alpha.texture = shift(alpha.texture);
                }
                named
            }));
        let mut parts = Vec::new();
        let mut add = |shape: Shape, material: Option<usize>, emission| {
            if let Shape::Mesh { mesh, transform } = shape {
                parts.push(Part {
                    mesh: mesh + meshes,
                    transform,
                    material: material.map(|index| index + materials),
                    emission,
                });
            }
        };
        for object in file.objects {
            add(object.shape, Some(object.material), None);
        }
        for light in file.lights {
            let emission = Emission {
                radiance: light.radiance,
                two_sided: light.two_sided,
                texture: shift(light.texture),
            };
            add(light.shape, light.material, Some(emission));
        }
        Model {
            parts,
            punctual: file.punctual,
        }
    }

    /// A texture, as `"wood.png"` or as a table of one.
    pub fn texture(&mut self, value: Value, space: ColorSpace, more: &[&str]) -> Result<usize> {
        let example = "{ texture = \"wood.png\" }";
        let (file, table) = match value.text() {
            Ok(_) => (value, None),
            Err(_) => {
                let table = value.table(example)?;
                let known = [&["texture", "wrap", "filter", "repeat"], more].concat();
                table.keys("a texture", &known)?;
                (
                    table.require("this texture", "texture", "texture = \"wood.png\"")?,
                    Some(table),
                )
            }
        };
        let get = |key| table.and_then(|table| table.get(key));
        let wrap = get("wrap").map_or(Ok(Default::default()), |value| value.choice())?;
        let nearest = get("filter").map_or(Ok(false), |value| match value.text()? {
            "nearest" => Ok(true),
            "bilinear" => Ok(false),
            _ => Err(value.error("unknown filter; use \"bilinear\" or \"nearest\"")),
        })?;
        let repeat = get("repeat").map_or(Ok(Vec2::ONE), |value| value.pair())?;
        let image = self.image(file, space)?;
        // Meshes count v upwards, images have their first row on top.
        let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
        self.scene.textures.push(Texture {
            image,
            wrap: [wrap; 2],
            nearest,
            transform: flip * Affine2::from_scale(repeat),
        });
        Ok(self.scene.textures.len() - 1)
    }

    fn image(&mut self, value: Value, space: ColorSpace) -> Result<Arc<Image>> {
        let key = (self.path(value, "an image file")?, space);
        if let Some(image) = self.images.get(&key) {
            return Ok(image.clone());
        }
        let (image, bytes) = self
            .cache
            .image(&key.0, space)
            .map_err(|error| value.error(error.to_string()))?;
        self.hasher.update(&bytes);
        self.images.insert(key, image.clone());
        Ok(image)
    }
}
