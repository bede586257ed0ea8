//! Scenes that several jobs share.

use crate::error::Result;
use crate::scene::builtin;
use crate::scene::cache::Cache;
use crate::scene::description::Description;
use crate::scene::toml::Change;
use std::collections::HashSet;
use std::sync::Arc;

/// Opens scenes; keeps the last one, and the meshes and images of its file, since jobs of one scene follow each other.
#[derive(Debug, Default)]
pub struct Scenes {
    file: String,
    cache: Cache,
    last: Option<(Vec<Arc<Change>>, Arc<Description>)>,
    warned: HashSet<String>,
    warnings: Vec<String>,
}

impl Scenes {
    /// A scene with some of its values changed.
    ///
    /// # Errors
    /// As [`builtin::open_changed`].
    pub fn open(&mut self, scene: &str, changes: &[Arc<Change>]) -> Result<Arc<Description>> {
        if self.file != scene {
            (self.cache, self.last) = (Cache::default(), None);
            self.file = scene.to_owned();
        }
        if let Some((of, description)) = &self.last
            && of == changes
        {
            return Ok(description.clone());
        }
        let description = Arc::new(builtin::open_changed(scene, changes, &mut self.cache)?);
        for warning in &description.warnings {
            if self.warned.insert(warning.clone()) {
                self.warnings.push(warning.clone());
            }
        }
        self.last = Some((changes.to_vec(), description.clone()));
        Ok(description)
    }

    /// What reading them warned of since the last call, each warning once.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}
