//! From a job file to its jobs: each combination of scene, values of `set`, camera and settings, in that order, the last
//! of which varies fastest. So jobs that share a scene follow each other.

use super::file::{Asked, Cameras, Grid, JobFile, Setting};
use super::outputs;
use super::template::Field;
use crate::error::{Error, Result};
use crate::film::exr::ImageHeader;
use crate::film::tonemap::Tonemap;
use crate::render::{Settings, camera_of};
use crate::resume;
use crate::scene::builtin;
use crate::scene::description::Description;
use crate::scene::toml::Change;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The most jobs of a file: each is kept in memory, and written to the manifest.
pub const MOST_JOBS: u64 = 1_000_000;

/// One image to be made.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its place among all jobs of the file, from 0.
    pub index: usize,
    /// Its output as the job file names it, relative to the file's folder.
    pub name: String,
    /// The scene, as [`builtin::open_changed`] takes it.
    pub scene: Arc<str>,
    /// What is changed in it, one for each key of `set`.
    pub changes: Arc<[Arc<Change>]>,
    /// What is to be rendered; or why nothing can be.
    pub ready: std::result::Result<Ready, String>,
}

/// What is known of a job whose scene can be read.
#[derive(Clone, Debug)]
pub struct Ready {
    /// What the image is to say of itself; it leaves open what program makes it.
    pub header: ImageHeader,
    /// What is rendered; the camera is named.
    pub settings: Settings,
    /// The image.
    pub exr: PathBuf,
    /// The picture beside it, if there is to be one.
    pub png: Option<Tonemap>,
}

impl Ready {
    /// The hash of the scene, changes included.
    pub fn scene_hash(&self) -> &str {
        &self.header.metadata.scene_hash
    }

    /// Where the picture is.
    pub fn png_path(&self) -> PathBuf {
        self.exr.with_extension("png")
    }

    /// Camera paths of the whole image.
    pub fn paths(&self) -> u64 {
        self.settings.region.pixels() as u64 * u64::from(self.settings.spp)
    }
}

impl Job {
    /// What a field of a template stands for; `unknown` where the scene would have to say it and cannot be read.
    pub(super) fn value(&self, field: Field) -> String {
        let name = match field {
            Field::Change(place) => {
                let change = self.changes.get(place);
                return change.map_or(String::new(), |change| change.value.clone());
            }
            Field::Known(name) => name,
        };
        match name {
            "scene" => {
                let stem = Path::new(&*self.scene).file_stem().unwrap_or_default();
                return stem.display().to_string();
            }
            "index" => return self.index.to_string(),
            _ => {}
        }
        let Ok(Ready { settings, png, .. }) = &self.ready else {
            return "unknown".to_owned();
        };
        let tonemap = png.unwrap_or_default();
        match name {
            "camera" => settings.camera.clone().unwrap_or_default(),
            "width" => settings.width.to_string(),
            "height" => settings.height.to_string(),
            "size" => format!("{}x{}", settings.width, settings.height),
            "spp" => settings.spp.to_string(),
            "seed" => settings.seed.to_string(),
            "path_length" => settings.path_length.to_string(),
            "strategy" => settings.strategy.to_string(),
            "sampler" => settings.sampler.to_string(),
            "roulette" => settings
                .roulette
                .map_or("none".to_owned(), |edge| edge.to_string()),
            "crop" => settings.region.to_string(),
            "aov" => settings.aovs.to_string(),
            "tonemap" => tonemap.operator.to_string(),
            "exposure" => tonemap.exposure.to_string(),
            _ => png.is_some().to_string(),
        }
    }

    /// The scene and its changes, in one line.
    pub fn title(&self) -> String {
        let changes = self.changes.iter();
        changes.fold(self.scene.to_string(), |title, change| {
            format!("{title} {}={}", change.key, change.value)
        })
    }
}

/// How [`expand`] comes to a scene, changed.
pub type Open<'a> = dyn FnMut(&str, &[Arc<Change>]) -> Result<Arc<Description>> + 'a;

/// The jobs of a file. A job whose scene cannot be read, or whose settings do not fit it, is among them, with the reason.
///
/// # Errors
/// [`Error::Scene`] where there are more than [`MOST_JOBS`], or their outputs meet each other or a file that is read.
pub fn expand(file: &JobFile, open: &mut Open) -> Result<Vec<Job>> {
    check_count(file)?;
    let mut jobs = Vec::new();
    // The grid of each job, and the files that are read: the job file, and those of scenes.
    let mut grids = Vec::new();
    let mut inputs: HashSet<PathBuf> = file.path.canonicalize().into_iter().collect();
    for (grid, scene) in scenes(file) {
        let path: Arc<str> = located(file.folder(), scene).into();
        for changes in product(&grid.changes) {
            let changes: Arc<[Arc<Change>]> = changes.into();
            let description = open(&path, &changes).map_err(|error| error.to_string());
            if let Ok(description) = &description {
                inputs.extend(outputs::inputs(&path, description));
            }
            for camera in cameras(grid, description.as_deref()) {
                for settings in product(&grid.settings) {
                    if jobs.len() as u64 == MOST_JOBS {
                        return Err(too_many(grid));
                    }
                    let ready = ready(grid, description.as_deref(), camera.clone(), &settings);
                    let mut job = Job {
                        index: jobs.len(),
                        name: String::new(),
                        scene: path.clone(),
                        changes: changes.clone(),
                        ready,
                    };
                    job.name = grid.output.fill(|field| job.value(field));
                    if let Ok(ready) = &mut job.ready {
                        ready.exr = file.folder().join(&job.name);
                    }
                    jobs.push(job);
                    grids.push(grid);
                }
            }
        }
    }
    outputs::check(&jobs, &grids, &inputs)?;
    Ok(jobs)
}

fn scenes(file: &JobFile) -> impl Iterator<Item = (&Grid, &str)> {
    file.grids
        .iter()
        .flat_map(|grid| grid.scenes.iter().map(move |scene| (grid, scene.as_str())))
}

/// A scene of the job file: a file beside it before a built-in scene, as on the command line.
fn located(folder: &Path, scene: &str) -> String {
    let path = folder.join(scene);
    match builtin::find(scene) {
        // A folder of that name may be one of outputs.
        Some(_) if !path.is_file() => scene.to_owned(),
        _ => path.display().to_string(),
    }
}

/// Every combination of a value of each axis, the last of which varies fastest.
fn product<T: Clone>(axes: &[Vec<T>]) -> impl Iterator<Item = Vec<T>> {
    let count: usize = axes.iter().map(Vec::len).product();
    (0..count).map(move |number| {
        let mut rest = number;
        let mut values: Vec<T> = axes
            .iter()
            .rev()
            .map(|axis| {
                let value = axis[rest % axis.len()].clone();
                rest /= axis.len();
                value
            })
            .collect();
        values.reverse();
        values
    })
}

/// The names of the cameras that a grid asks for; none where they are not known.
fn cameras(grid: &Grid, scene: std::result::Result<&Description, &String>) -> Vec<Option<String>> {
    let names = scene.map_or(&[][..], |scene| &scene.cameras[..]);
    let names = names.iter().map(|camera| Some(camera.name.clone()));
    match &grid.cameras {
        Cameras::Named(names) => names.iter().cloned().map(Some).collect(),
        _ if scene.is_err() => vec![None],
        Cameras::First => names.take(1).collect(),
        Cameras::All => names.collect(),
    }
}

fn ready(
    grid: &Grid,
    scene: std::result::Result<&Description, &String>,
    camera: Option<String>,
    settings: &[Setting],
) -> std::result::Result<Ready, String> {
    let scene = scene.map_err(String::clone)?;
    let asked = Asked::new(settings);
    let settings = Settings {
        camera,
        ..asked.of(scene)
    };
    let checked = settings
        .check()
        .and_then(|()| camera_of(scene, &settings).map(drop));
    checked.map_err(|error| format!("{}: {error}", grid.place))?;
    Ok(Ready {
        header: resume::wanted(scene, &settings, ""),
        settings,
        exr: PathBuf::new(),
        png: asked.png(),
    })
}

/// How many jobs a grid has, all cameras of a scene counted as one.
fn count(grid: &Grid) -> u64 {
    let cameras = match &grid.cameras {
        Cameras::Named(names) => names.len(),
        Cameras::First | Cameras::All => 1,
    };
    let axes = grid.changes.iter().map(Vec::len);
    let axes = axes.chain(grid.settings.iter().map(Vec::len));
    axes.chain([grid.scenes.len(), cameras])
        .fold(1, |product, length| product.saturating_mul(length as u64))
}

fn check_count(file: &JobFile) -> Result<()> {
    let mut total = 0u64;
    for grid in &file.grids {
        total = total.saturating_add(count(grid));
        if total > MOST_JOBS {
            return Err(too_many(grid));
        }
    }
    Ok(())
}

fn too_many(grid: &Grid) -> Error {
    Error::Scene {
        place: grid.place.clone(),
        message: format!(
            "with this the file has more than {MOST_JOBS} jobs; shorten a list, or split the file"
        ),
    }
}
