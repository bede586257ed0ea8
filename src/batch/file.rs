//! The job file: TOML to grids of jobs, checked as far as that goes without the scenes.

use super::template::Template;
use crate::error::{Error, Place, Result};
use crate::film::tonemap::{Operator, Tonemap};
use crate::film::{AovSet, MAX_SAMPLES, Region, parse_size};
use crate::render::Settings;
use crate::scene::description::{Description, MAX_EDGES, MAX_SIDE, SamplerKind, Strategy};
use crate::scene::toml::reader::{Source, Table, Value};
use crate::scene::toml::{self, Change};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The keys of a job.
const KEYS: [&str; 17] = [
    "scene",
    "cameras",
    "camera",
    "set",
    "output",
    "size",
    "spp",
    "seed",
    "path_length",
    "strategy",
    "sampler",
    "roulette",
    "crop",
    "aov",
    "png",
    "tonemap",
    "exposure",
];

/// Those that are axes by themselves, the last of which varies fastest.
const SETTINGS: [&str; 12] = [
    "size",
    "crop",
    "aov",
    "path_length",
    "strategy",
    "sampler",
    "roulette",
    "spp",
    "tonemap",
    "exposure",
    "png",
    "seed",
];

/// A job file.
#[derive(Clone, Debug)]
pub struct JobFile {
    /// Where it is, as the user named it.
    pub path: PathBuf,
    /// One for each `[[jobs]]`, in file order.
    pub grids: Vec<Grid>,
}

/// A table of `[[jobs]]`, completed by the defaults: the product of its axes.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Where the file has it.
    pub place: Place,
    /// The scenes as the file names them.
    pub scenes: Vec<String>,
    /// An axis for each key of `set`.
    pub changes: Vec<Vec<Arc<Change>>>,
    /// The cameras.
    pub cameras: Cameras,
    /// An axis for each setting that the file gives.
    pub settings: Vec<Vec<Setting>>,
    /// How outputs are called.
    pub output: Template,
    /// Where the file says so; the grid's own place where it does not.
    pub output_place: Place,
}

/// The cameras of a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cameras {
    /// The first of the scene.
    First,
    /// Each of the scene.
    All,
    /// Those of these names.
    Named(Vec<String>),
}

/// One value of one setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Pixels.
    Size(u32, u32),
    /// Samples per pixel.
    Spp(u32),
    /// Seed.
    Seed(u64),
    /// Greatest number of edges of a path.
    PathLength(u32),
    /// Estimator.
    Strategy(Strategy),
    /// Source of random numbers.
    Sampler(SamplerKind),
    /// First edge of Russian roulette.
    Roulette(u32),
    /// The pixels that are rendered.
    Crop(Region),
    /// Extra layers.
    Aov(AovSet),
    /// Whether there is a PNG.
    Png(bool),
    /// Its tone curve.
    Tonemap(Operator),
    /// Its exposure.
    Exposure(f32),
}

impl Setting {
    /// The field of a template that shows it.
    pub fn field(&self) -> &'static str {
        match self {
            Self::Size(..) => "size",
            Self::Spp(_) => "spp",
            Self::Seed(_) => "seed",
            Self::PathLength(_) => "path_length",
            Self::Strategy(_) => "strategy",
            Self::Sampler(_) => "sampler",
            Self::Roulette(_) => "roulette",
            Self::Crop(_) => "crop",
            Self::Aov(_) => "aov",
            Self::Png(_) => "png",
            Self::Tonemap(_) => "tonemap",
            Self::Exposure(_) => "exposure",
        }
    }

    fn read(value: Value) -> Result<Self> {
        let parsed = |error: Error| value.error(format!("{}: {error}", value.key));
        Ok(match value.key {
            "size" => {
                let size = parse_size(value.text()?);
                let (width, height) = size.map_err(|wrong| value.error(wrong))?;
                let sides = 1..=MAX_SIDE;
                if !(sides.contains(&width) && sides.contains(&height)) {
                    return Err(value.error(format!(
                        "each side of size must be from 1 to {MAX_SIDE} pixels, and this is {width}x{height}"
                    )));
                }
                Self::Size(width, height)
            }
            "spp" => Self::Spp(value.count(MAX_SAMPLES)?),
            "seed" => Self::Seed(value.integer(0, u64::MAX)?),
            "path_length" => Self::PathLength(value.count(MAX_EDGES)?),
            "strategy" => Self::Strategy(value.choice()?),
            "sampler" => Self::Sampler(value.choice()?),
            "roulette" => Self::Roulette(value.count(MAX_EDGES)?),
            "crop" => Self::Crop(value.text()?.parse().map_err(parsed)?),
            "aov" => Self::Aov(value.text()?.parse().map_err(parsed)?),
            "png" => Self::Png(value.flag()?),
            "tonemap" => Self::Tonemap(value.choice()?),
            _ => Self::Exposure(value.number_where("from -64 to 64", Tonemap::can_expose)?),
        })
    }
}

/// What the settings of a job add to those of its scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked<'a>(&'a [Setting]);

impl<'a> Asked<'a> {
    /// Of one value of each axis.
    pub fn new(settings: &'a [Setting]) -> Self {
        Self(settings)
    }

    /// The scene's settings, with what the job changes.
    pub fn of(&self, scene: &Description) -> Settings {
        let mut settings = Settings::of(scene);
        // The size comes first: it resets the region.
        for setting in self.0 {
            match *setting {
                Setting::Size(width, height) => settings.set_size(width, height),
                Setting::Spp(spp) => settings.spp = spp,
                Setting::Seed(seed) => settings.seed = seed,
                Setting::PathLength(edges) => settings.path_length = edges,
                Setting::Strategy(strategy) => settings.strategy = strategy,
                Setting::Sampler(sampler) => settings.sampler = sampler,
                Setting::Roulette(first) => settings.roulette = Some(first),
                Setting::Crop(region) => settings.region = region,
                Setting::Aov(aovs) => settings.aovs = aovs,
                Setting::Png(_) | Setting::Tonemap(_) | Setting::Exposure(_) => {}
            }
        }
        settings
    }

    /// How the PNG is to be, if there is to be one.
    pub fn png(&self) -> Option<Tonemap> {
        let mut tonemap = Some(Tonemap::default());
        for setting in self.0 {
            match (setting, &mut tonemap) {
                (Setting::Png(false), _) => return None,
                (Setting::Tonemap(operator), Some(tonemap)) => tonemap.operator = *operator,
                (Setting::Exposure(exposure), Some(tonemap)) => tonemap.exposure = *exposure,
                _ => {}
            }
        }
        tonemap
    }
}

impl JobFile {
    /// Reads a job file.
    ///
    /// # Errors
    /// [`Error::Read`] where it cannot be read, [`Error::Scene`], with line and column, at the first thing that is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&toml::text(path)?, path)
    }

    /// The same from its text; `path` is what errors call it and outputs are relative to.
    ///
    /// # Errors
    /// [`Error::Scene`], as [`read`](Self::read).
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let source = Source { file: &name, text };
        let document = source.document()?;
        let root = Table::root(&source, &document);
        toml::version(&root)?;
        root.keys("the job file", &["version", "defaults", "jobs"])?;
        let defaults = root
            .get("defaults")
            .map(|value| value.table("[defaults]"))
            .transpose()?;
        if let Some(defaults) = &defaults {
            defaults.keys("[defaults]", &KEYS)?;
        }
        let jobs = root.require("the job file", "jobs", "[[jobs]] with scene = \"cornell\"")?;
        let grids = jobs
            .tables("[[jobs]]")?
            .iter()
            .map(|job| {
                job.keys("[[jobs]]", &KEYS)?;
                grid(job, defaults.as_ref())
            })
            .collect::<Result<Vec<_>>>()?;
        if grids.is_empty() {
            return Err(jobs.error("there are no jobs; add [[jobs]] with scene = \"cornell\""));
        }
        Ok(Self {
            path: path.to_owned(),
            grids,
        })
    }

    /// The folder that scenes and outputs are relative to.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }
}

/// A job, completed by the defaults.
fn grid(job: &Table, defaults: Option<&Table>) -> Result<Grid> {
    let get = |key| job.get(key).or_else(|| defaults?.get(key));
    let texts = |value: Value| -> Result<Vec<String>> {
        let items = value.one_or_more()?;
        items
            .iter()
            .map(|item| Ok(item.text()?.to_owned()))
            .collect()
    };
    let scene = get("scene")
        .ok_or_else(|| job.error("this job has no scene; add scene = \"cornell\", or a path"))?;
    let changes = get("set").map_or(Ok(Vec::new()), changes)?;
    let settings = SETTINGS
        .into_iter()
        .filter_map(get)
        .map(|value| {
            value
                .one_or_more()?
                .into_iter()
                .map(Setting::read)
                .collect()
        })
        .collect::<Result<Vec<Vec<Setting>>>>()?;
    let cameras = cameras(job, defaults)?;
    let (output, output_place) = match get("output") {
        None => {
            let output = Template::default_of(&changes, &cameras, &settings);
            (output, job.place())
        }
        Some(value) => {
            let keys: Vec<&str> = keys(&changes).collect();
            let output = Template::parse(value.text()?, &keys);
            (output.map_err(|wrong| value.error(wrong))?, value.place())
        }
    };
    Ok(Grid {
        place: job.place(),
        scenes: texts(scene)?,
        changes,
        cameras,
        settings,
        output,
        output_place,
    })
}

/// `cameras`, or `camera` for one.
fn cameras(job: &Table, defaults: Option<&Table>) -> Result<Cameras> {
    for table in std::iter::once(job).chain(defaults) {
        let value = match (table.get("cameras"), table.get("camera")) {
            (None, None) => continue,
            (Some(_), Some(one)) => {
                return Err(one.key_error("there are both camera and cameras; keep one"));
            }
            (many, one) => many.or(one),
        };
        let Some(value) = value else { continue };
        if !value.is_list() && value.text()? == "all" {
            return Ok(Cameras::All);
        }
        let items = value.one_or_more()?;
        let names = items.iter().map(|item| Ok(item.text()?.to_owned()));
        return Ok(Cameras::Named(names.collect::<Result<_>>()?));
    }
    Ok(Cameras::First)
}

/// `set`: keys with dots, in quotes or as tables within tables, and one or more values of each.
fn changes(value: Value) -> Result<Vec<Vec<Arc<Change>>>> {
    const EXAMPLE: &str = "{ \"materials.ball.roughness\" = [0.1, 0.2] }";
    let mut axes = Vec::new();
    // In quotes or as tables, it is one key.
    let mut named = HashSet::new();
    let mut waiting = vec![(String::new(), value)];
    while let Some((path, value)) = waiting.pop() {
        let nested = value.is_table() || path.is_empty();
        if nested {
            let inner = value.table(EXAMPLE)?.values();
            // Without any key at all, `set` of the defaults is undone.
            if inner.is_empty() && !path.is_empty() {
                return Err(value.error(format!(
                    "set {path} is an empty table; name a key and its values, as in {EXAMPLE}, or remove it"
                )));
            }
            let keys = inner.into_iter().rev().map(|value| {
                let key = match path.as_str() {
                    "" => value.key.to_owned(),
                    path => format!("{path}.{}", value.key),
                };
                (key, value)
            });
            waiting.extend(keys);
            continue;
        }
        let axis = value.one_or_more()?.into_iter().map(|item| {
            let change = Change {
                value: item.written().to_owned(),
                origin: format!("{}: set {path} = {}", item.place(), item.written()),
                key: path.clone(),
            };
            change.check()?;
            Ok(Arc::new(change))
        });
        let axis = axis.collect::<Result<Vec<_>>>()?;
        if let Some(change) = axis.first()
            && !named.insert(change.names()?)
        {
            return Err(value.key_error(format!(
                "set names {path} twice; give all of its values in one list"
            )));
        }
        axes.push(axis);
    }
    Ok(axes)
}

/// The key of each axis of `set`.
fn keys(changes: &[Vec<Arc<Change>>]) -> impl Iterator<Item = &str> {
    let first = changes.iter().filter_map(|axis| axis.first());
    first.map(|change| change.key.as_str())
}
