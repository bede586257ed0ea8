//! Scenes, meshes and images that are read several times, with one change or another: each file is read once, as long as
//! somebody keeps the cache.

use super::description::{Description, Image, LatLong};
use super::image::{self, ColorSpace};
use super::{lat_long, toml};
use crate::error::{Error, Result};
use crate::scene::builtin;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An image, and its file as it is.
type ImageAndBytes = (Arc<Image>, Arc<[u8]>);

/// A lat-long image, and its file as it is.
type LatLongAndBytes = (Arc<LatLong>, Arc<[u8]>);

/// What was read of files, by path. A file that changes on the disk is not read again.
#[derive(Debug, Default)]
pub struct Cache {
    scenes: HashMap<PathBuf, Arc<Description>>,
    images: HashMap<(PathBuf, ColorSpace), ImageAndBytes>,
    lat_longs: HashMap<PathBuf, LatLongAndBytes>,
    texts: HashMap<PathBuf, Arc<str>>,
}

impl Cache {
    /// A file of meshes, as the scene it is.
    pub(super) fn mesh(&mut self, path: &Path) -> Result<Arc<Description>> {
        let Some(load) = builtin::mesh_loader(path) else {
            return Err(Error::format(
                path,
                "is not a mesh that is read; name a .ply, .obj, .gltf or .glb file",
            ));
        };
        self.scene(path, load)
    }

    /// A scene that is no TOML, as it stands in its file.
    pub(super) fn scene(
        &mut self,
        path: &Path,
        read: impl FnOnce(&Path) -> Result<Description>,
    ) -> Result<Arc<Description>> {
        if let Some(scene) = self.scenes.get(path) {
            return Ok(scene.clone());
        }
        let scene = Arc::new(read(path)?);
        self.scenes.insert(path.to_owned(), scene.clone());
        Ok(scene)
    }

    /// An image, and the bytes of its file, which enter a scene's hash.
    pub(super) fn image(&mut self, path: &Path, space: ColorSpace) -> Result<ImageAndBytes> {
        let key = (path.to_owned(), space);
        if let Some(found) = self.images.get(&key) {
            return Ok(found.clone());
        }
        let bytes: Arc<[u8]> = image::bytes(path)?.into();
        let image = Arc::new(image::decode(&bytes, &path.display().to_string(), space)?);
        self.images.insert(key, (image.clone(), bytes.clone()));
        Ok((image, bytes))
    }

    /// A lat-long image, and the bytes of its file.
    ///
    /// # Errors
    /// What is wrong and what to do, not with which file.
    pub(super) fn lat_long(&mut self, path: &Path) -> std::result::Result<LatLongAndBytes, String> {
        if let Some(found) = self.lat_longs.get(path) {
            return Ok(found.clone());
        }
        let image = Arc::new(lat_long::explained(path)?);
        let bytes = std::fs::read(path).map_err(|error| format!("cannot read: {error}"))?;
        let both = (image, Arc::from(bytes));
        self.lat_longs.insert(path.to_owned(), both.clone());
        Ok(both)
    }

    /// The text of a .toml scene.
    pub(super) fn text(&mut self, path: &Path) -> Result<Arc<str>> {
        if let Some(text) = self.texts.get(path) {
            return Ok(text.clone());
        }
        let text: Arc<str> = toml::text(path)?.into();
        self.texts.insert(path.to_owned(), text.clone());
        Ok(text)
    }

    /// Keeps a scene that is no TOML and was read without changes.
    pub fn keep(&mut self, path: &Path, scene: &Description) {
        self.scenes.insert(path.to_owned(), Arc::new(scene.clone()));
    }
}
