//! The images under way, one for each side of the view, and what they are made of.

use super::look::{Balance, View};
use super::picture::Shown;
use super::side::{Side, Tracers};
use super::values::MaterialValues;
use super::wish::{Format, Picked, Saved};
use crate::error::{Error, Result};
use crate::film::tonemap::Tonemap;
use crate::film::{exr, png};
use crate::render::{Rendered, Settings, find_camera, shell_line};
use crate::resume;
use crate::scene::Scene;
use crate::scene::builtin::{self, open_changed};
use crate::scene::cache::Cache;
use crate::scene::description::{self, Description};
use crate::scene::toml::Change;
use crate::scene::trees::Trees;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Paths per second and thread, until some were traced.
const GUESS: f64 = 5e5;

/// Where a scene comes from, and how it is rendered but for what the view says.
pub struct Source {
    /// The scene as it is named on the command line.
    pub scene: String,
    /// What is changed in it from the beginning.
    pub changes: Vec<Arc<Change>>,
    /// The files that were read. However they change on the disk, every view is of what they were.
    pub cache: Cache,
    /// Threads, waves, trees; all else is the view's.
    pub settings: Settings,
    /// The instruction sets that the program was compiled for.
    pub target_features: String,
    /// Makes sure that so many images of these settings fit in memory.
    pub fits: fn(&Settings, usize) -> Result<()>,
}

/// The sides of the view.
pub struct Sides {
    source: Source,
    /// With the source's own changes alone.
    original: Description,
    pool: rayon::ThreadPool,
    trees: Trees,
    /// The scene compiled, and with which materials.
    compiled: Option<(BTreeMap<String, MaterialValues>, Arc<Scene>)>,
    /// Paths per second, as last measured.
    speed: f64,
    open: Option<Open>,
}

/// What is rendered of a view.
struct Open {
    description: Description,
    /// Of all changes of the scene, those of the view too.
    changes: Vec<Arc<Change>>,
    lens: description::Camera,
    sides: Vec<Side>,
}

/// Who looks on while a round is rendered.
pub struct Watcher<'a> {
    /// Is given what there is to be seen meanwhile.
    pub begun: &'a dyn Fn(Vec<Shown>),
    /// Is told by workers of the paths of each wave.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

impl Sides {
    /// Of a scene that is read already.
    pub fn new(mut source: Source, original: Description, pool: rayon::ThreadPool) -> Self {
        if source.changes.is_empty() {
            source.cache.keep(Path::new(&source.scene), &original);
        }
        Self {
            speed: GUESS * pool.current_num_threads() as f64,
            source,
            original,
            pool,
            trees: Trees::default(),
            compiled: None,
            open: None,
        }
    }

    /// The scene before any view changed it.
    pub fn original(&self) -> &Description {
        &self.original
    }

    /// Whether there are images.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Frees the images.
    pub fn close(&mut self) {
        self.open = None;
    }

    /// Begins the images of a view.
    ///
    /// # Errors
    /// [`Error::Usage`] where there can be no such view, and those of reading the scene; the old images stay then.
    pub fn set(&mut self, view: &View) -> Result<()> {
        let settings = view.settings(&self.source.settings)?;
        for side in &settings {
            (self.source.fits)(side, settings.len())?;
        }
        let own = view.changes(&self.original)?;
        let begun = self.source.changes.iter().cloned();
        let changes: Vec<_> = begun.chain(own.iter().cloned()).collect();
        let description = match own[..] {
            [] => self.original.clone(),
            _ => open_changed(&self.source.scene, &changes, &mut self.source.cache)?,
        };
        let lens = find_camera(&description, Some(&view.camera))?.camera;
        let compiled = self.compiled.take();
        let scene = match compiled.filter(|(materials, _)| *materials == view.materials) {
            Some((_, scene)) => scene,
            None => {
                let (quality, trees) = (self.source.settings.bvh, &mut self.trees);
                let compile = || Scene::compile_sharing(&description, quality, trees);
                Arc::new(self.pool.install(compile))
            }
        };
        self.compiled = Some((view.materials.clone(), scene.clone()));
        let filter = description.film.filter;
        let sides = settings.into_iter();
        self.open = Some(Open {
            sides: sides
                .map(|settings| Side::new(settings, lens, filter, scene.clone()))
                .collect(),
            description,
            changes,
            lens,
        });
        Ok(())
    }

    /// Goes over to a view of the same images.
    ///
    /// # Errors
    /// As [`Sides::set`].
    pub fn adjust(&mut self, view: &View) -> Result<()> {
        let settings = view.settings(&self.source.settings)?;
        for (side, settings) in self.sides_mut().iter_mut().zip(settings) {
            side.settings = settings;
        }
        Ok(())
    }

    /// What they are, while they are open.
    pub fn sides(&self) -> &[Side] {
        self.open.as_ref().map_or(&[], |open| &open.sides)
    }

    fn sides_mut(&mut self) -> &mut [Side] {
        self.open.as_mut().map_or(&mut [], |open| &mut open.sides)
    }

    /// What there is to be seen.
    pub fn shown(&self) -> Vec<Shown> {
        self.sides().iter().map(Side::shown).collect()
    }

    /// Whether what comes next are coarse pictures.
    pub fn is_coarse(&self) -> bool {
        let mut sides = self.sides().iter();
        sides.any(|side| side.next_coarse(self.speed).is_some())
    }

    /// The side that is to be rendered next; none where all are done.
    pub fn next(&self, balance: Balance) -> Option<usize> {
        let sides = self.sides();
        let coarse = |side: &Side| side.next_coarse(self.speed).is_some();
        let waiting = sides.iter().enumerate().filter(|(_, side)| coarse(side));
        let coarsest = waiting.max_by_key(|(index, side)| (side.coarseness(), usize::MAX - index));
        match coarsest {
            Some((index, _)) => Some(index),
            None => balance.turn(sides),
        }
    }

    /// Renders a round of a side, or its next coarse picture.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is no such image.
    pub fn render(&mut self, index: usize, stop: &AtomicBool, watcher: &Watcher) -> Result<()> {
        let Some(open) = &mut self.open else {
            return Ok(());
        };
        let mut tracers = Tracers {
            pool: &self.pool,
            stop,
            progress: watcher.progress,
            speed: &mut self.speed,
        };
        let side = open.sides.get_mut(index).ok_or_else(|| no_side(index))?;
        if let Some(scale) = side.next_coarse(*tracers.speed) {
            tracers.progress = &|_| ();
            return side.render_coarse(scale, &mut tracers);
        }
        side.make_room()?;
        let samples = side.next_round(*tracers.speed);
        (watcher.begun)(open.sides.iter().map(Side::shown).collect());
        open.sides[index].render(samples, &mut tracers)
    }

    /// Goes on with the pass of a side that is under way, or with its first. Whether it is whole then.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is no such side.
    pub fn make_whole(&mut self, index: usize, stop: &AtomicBool) -> Result<bool> {
        let mut tracers = Tracers {
            pool: &self.pool,
            stop,
            progress: &|_| (),
            speed: &mut self.speed,
        };
        let sides = self.open.as_mut().map(|open| &mut open.sides);
        let side = sides.and_then(|sides| sides.get_mut(index));
        let side = side.ok_or_else(|| no_side(index))?;
        if let Some(samples) = side.missing() {
            side.make_room()?;
            side.render(samples, &mut tracers)?;
        }
        Ok(side.missing().is_none())
    }

    /// What is at a pixel; none where that is nothing.
    ///
    /// # Errors
    /// [`Error::Usage`] where the pixel is not in the image.
    pub fn pick(&self, x: u32, y: u32) -> Result<Option<Picked>> {
        let Some(open) = &self.open else {
            return Ok(None);
        };
        let side = open.sides.first().ok_or_else(|| no_side(0))?;
        let (lens, materials) = (&open.lens, &open.description.materials);
        Ok(side.first_hit(x, y)?.map(|hit| {
            let offset = hit.position - lens.position;
            let axis = (lens.look_at - lens.position).normalize_or_zero();
            let material = hit.material.and_then(|id| materials.get(id));
            Picked {
                position: hit.position.to_array(),
                depth: offset.dot(axis),
                distance: offset.length(),
                material: material.map(|named| named.name.clone()),
            }
        }))
    }

    /// The command line that renders what there is of a side.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is no such side, or it is not [whole](Self::make_whole).
    pub fn command_line(&self, index: usize, tonemap: Option<Tonemap>) -> Result<String> {
        let (open, settings, _) = self.whole(index)?;
        let mut words = vec![
            "ondine".to_owned(),
            "render".to_owned(),
            match self.source.scene.starts_with('-') {
                // It is no option.
                true => format!("./{}", self.source.scene),
                false => self.source.scene.clone(),
            },
        ];
        if let (Some(camera), true) = (&settings.camera, open.description.cameras.len() > 1) {
            words.push(format!("--camera={camera}"));
        }
        if builtin::find(&self.source.scene).is_none() {
            // Its file may be another by now.
            words.push(format!("--scene-hash={}", open.description.hash));
        }
        let changes = open.changes.iter();
        words.extend(changes.map(|change| format!("--set={}={}", change.key, change.value)));
        words.extend(settings.words());
        if let Some(Tonemap { operator, exposure }) = tonemap {
            words.push(format!("--tonemap={operator}"));
            words.push(format!("--exposure={exposure}"));
        }
        words.push(format!("--output={}.exr", self.name(&settings)));
        Ok(shell_line(&words))
    }

    /// Writes a file of what there is of a side.
    ///
    /// # Errors
    /// As [`Sides::command_line`]; [`Error::Write`] where there is no room for it.
    pub fn save(&self, index: usize, format: Format) -> Result<Saved> {
        let (open, settings, rendered) = self.whole(index)?;
        let folder = tempfile::tempdir().map_err(|source| Error::Write {
            path: std::env::temp_dir(),
            source,
        })?;
        let (extension, tonemap) = match format {
            Format::Exr => ("exr", None),
            Format::Png(tonemap) => ("png", Some(tonemap)),
        };
        let name = format!("{}.{extension}", self.name(&settings));
        let path = folder.path().join(&name);
        let write = || match tonemap {
            None => {
                let features = &self.source.target_features;
                let wanted = resume::wanted(&open.description, &settings, features);
                let metadata = resume::reached(&wanted.metadata, &rendered, None);
                exr::write(&path, &rendered.film, &metadata).map(drop)
            }
            Some(tonemap) => png::write(&path, &rendered.film, tonemap),
        };
        self.pool.install(write)?;
        let file = File::open(&path).map_err(|source| Error::Read { path, source })?;
        Ok(Saved {
            command_line: self.command_line(index, tonemap)?,
            file,
            // Where a file that is open can be deleted, it goes with the program however that ends.
            folder: cfg!(not(unix)).then_some(folder),
            name,
        })
    }

    fn whole(&self, index: usize) -> Result<(&Open, Settings, Rendered)> {
        let open = self.open.as_ref();
        let whole = open.and_then(|open| {
            let (settings, rendered) = open.sides.get(index)?.whole()?;
            Some((open, settings, rendered))
        });
        whole.ok_or_else(|| no_side(index))
    }

    /// What the file of an image is called, without its ending: letters that any system takes.
    fn name(&self, settings: &Settings) -> String {
        let stem = Path::new(&self.source.scene)
            .file_stem()
            .unwrap_or_default();
        let plain = |c: char| match c.is_ascii_alphanumeric() || "-_".contains(c) {
            true => c,
            false => '_',
        };
        let stem: String = stem.to_string_lossy().chars().map(plain).collect();
        format!("{stem}-{}-{}spp", settings.strategy, settings.spp)
    }
}

fn no_side(index: usize) -> Error {
    Error::Usage(format!("there is no image of side {index}"))
}
