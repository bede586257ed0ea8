//! What is looked at: everything that decides the picture, as the page says it and as `ondine render` is told it.

use super::values::MaterialValues;
use crate::error::{Error, Result};
use crate::film::{AovSet, BLOCK, MAX_SAMPLES};
use crate::render::{Settings, find_camera};
use crate::scene::description::{Camera, Description};
use crate::scene::toml::write::{float, material_changes};
use crate::scene::toml::{Change, camera_key};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is looked at. All pages of a server see the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The camera of the scene that it began from.
    pub camera: String,
    /// That camera as it stands now.
    pub lens: Lens,
    /// One, or two to compare.
    pub sides: Vec<Side>,
    /// What two sides have the same of.
    pub balance: Balance,
    /// Materials that are others than the scene says, by name.
    pub materials: BTreeMap<String, MaterialValues>,
    /// What is recorded beside radiance.
    pub aovs: Aovs,
    /// What is shown.
    pub layer: Layer,
    /// Samples of a pixel at which it ends.
    pub limit: u32,
}

/// A [`Camera`], as JSON has it: world space, degrees, scene units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// As [`Camera::position`].
    pub position: [f32; 3],
    /// As [`Camera::look_at`].
    pub look_at: [f32; 3],
    /// As [`Camera::up`].
    pub up: [f32; 3],
    /// As [`Camera::vertical_fov`].
    pub vertical_fov: f32,
    /// As [`Camera::aperture_radius`].
    pub aperture_radius: f32,
    /// As [`Camera::focus_distance`].
    pub focus_distance: f32,
}

/// How one side is rendered; each field as in [`Settings`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Side {
    /// How light is looked for.
    pub strategy: String,
    /// Where random numbers come from.
    pub sampler: String,
    /// Greatest number of edges of a path.
    pub path_length: u32,
    /// Seed.
    pub seed: u64,
    /// First edge at which Russian roulette may end a path.
    pub roulette: Option<u32>,
}

/// What two sides have the same of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Balance {
    /// Samples of a pixel.
    Samples,
    /// Seconds of rendering.
    Time,
}

/// What is recorded beside radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Aovs {
    /// Albedo, normal and depth of the first surface.
    pub first_hits: bool,
    /// Radiance of each path length by itself.
    pub lengths: bool,
}

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Layer {
    /// Mean radiance.
    Radiance,
    /// Standard error of the mean.
    Error,
    /// Albedo of the first surface.
    Albedo,
    /// Its shading normal, world space.
    Normal,
    /// Its distance, scene units.
    Depth,
    /// Mean radiance on paths of so many edges.
    Length(u32),
}

impl View {
    /// What a render with these settings would show.
    ///
    /// # Errors
    /// [`Error::Usage`] for a camera that the scene does not have.
    pub fn of(description: &Description, settings: &Settings) -> Result<Self> {
        let named = find_camera(description, settings.camera.as_deref())?;
        Ok(Self {
            size: [settings.width, settings.height],
            camera: named.name.clone(),
            lens: named.camera.into(),
            sides: vec![Side {
                strategy: settings.strategy.to_string(),
                sampler: settings.sampler.to_string(),
                path_length: settings.path_length,
                seed: settings.seed,
                roulette: settings.roulette,
            }],
            balance: Balance::Samples,
            materials: BTreeMap::new(),
            aovs: Aovs::default(),
            layer: Layer::Radiance,
            limit: settings.spp,
        })
    }

    /// The settings of each side, with all else as in `base`; samples up to the limit, in whole blocks.
    ///
    /// # Errors
    /// [`Error::Usage`] naming what is out of its range.
    pub fn settings(&self, base: &Settings) -> Result<Vec<Settings>> {
        if !(1..=2).contains(&self.sides.len()) {
            return Err(Error::Usage(format!(
                "{} sides are asked for; a view has one or two",
                self.sides.len()
            )));
        }
        let asks = |layer: Layer| match layer {
            Layer::Radiance | Layer::Error => true,
            Layer::Albedo | Layer::Normal | Layer::Depth => self.aovs.first_hits,
            Layer::Length(_) => self.aovs.lengths,
        };
        if !asks(self.layer) {
            return Err(Error::Usage(format!(
                "the layer {} is not recorded; record it first",
                self.layer
            )));
        }
        let sides = self.sides.iter().map(|side| {
            let Aovs {
                first_hits,
                lengths,
            } = self.aovs;
            let mut settings = base.clone();
            let [width, height] = self.size;
            settings.set_size(width, height);
            settings.camera = Some(self.camera.clone());
            settings.strategy = side.strategy.parse()?;
            settings.sampler = side.sampler.parse()?;
            settings.path_length = side.path_length;
            settings.seed = side.seed;
            settings.roulette = side.roulette;
            settings.spp = self.limit.min(MAX_SAMPLES).next_multiple_of(BLOCK);
            settings.aovs = AovSet {
                albedo: first_hits,
                normal: first_hits,
                depth: first_hits,
                lengths: match lengths {
                    true => AovSet::EVERY_LENGTH,
                    false => 0,
                },
            };
            if lengths && side.path_length > AovSet::MAX_LENGTHS {
                return Err(Error::Usage(format!(
                    "path lengths are recorded up to {}; choose a path length of at most so many",
                    AovSet::MAX_LENGTHS
                )));
            }
            settings.check()?;
            if let Layer::Length(length) = self.layer
                && !(1..=side.path_length).contains(&length)
            {
                return Err(Error::Usage(format!(
                    "there are no paths of {length} edges; the path length is {}",
                    side.path_length
                )));
            }
            Ok(settings)
        });
        sides.collect()
    }

    /// What is to be changed in the scene, as `--set` says it.
    ///
    /// # Errors
    /// [`Error::Usage`] for a camera or a material that the scene does not have.
    pub fn changes(&self, scene: &Description) -> Result<Vec<Arc<Change>>> {
        let named = find_camera(scene, Some(&self.camera))?;
        let key = camera_key(scene, &named.name);
        let mut changes = Vec::new();
        let (now, before) = (self.lens.values(), Lens::from(named.camera).values());
        for ((name, now), (_, before)) in now.into_iter().zip(before) {
            if now != before {
                let text = format!("{key}.{name}={now}");
                changes.push(change(&text, "the camera".to_owned())?);
            }
        }
        for (name, wanted) in &self.materials {
            let material = wanted.material()?;
            let Some(texts) = material_changes(scene, name, &material) else {
                return Err(Error::Usage(format!(
                    "the scene has no material {name:?} that could be changed"
                )));
            };
            for text in texts {
                changes.push(change(&text, format!("the material {name:?}"))?);
            }
        }
        Ok(changes)
    }

    /// Whether going from one to the other leaves the samples right.
    pub fn keeps_samples(&self, other: &Self) -> bool {
        let with = |view: &Self| Self {
            balance: Balance::Samples,
            layer: Layer::Radiance,
            limit: 0,
            ..view.clone()
        };
        with(self) == with(other)
    }
}

/// From `KEY=VALUE`; `origin` is what errors begin with.
fn change(text: &str, origin: String) -> Result<Arc<Change>> {
    let change = Change::parse(text)?;
    Ok(Arc::new(Change { origin, ..change }))
}

impl Lens {
    /// Each key and its value, as scene files have them.
    fn values(&self) -> [(&'static str, String); 6] {
        let point = |point: [f32; 3]| format!("[{}]", point.map(float).join(", "));
        [
            ("position", point(self.position)),
            ("look_at", point(self.look_at)),
            ("up", point(self.up)),
            ("vertical_fov", float(self.vertical_fov)),
            ("aperture_radius", float(self.aperture_radius)),
            ("focus_distance", float(self.focus_distance)),
        ]
    }
}

impl From<Camera> for Lens {
    fn from(camera: Camera) -> Self {
        Self {
            position: camera.position.to_array(),
            look_at: camera.look_at.to_array(),
            up: camera.up.to_array(),
            vertical_fov: camera.vertical_fov,
            aperture_radius: camera.aperture_radius,
            focus_distance: camera.focus_distance,
        }
    }
}

impl From<Lens> for Camera {
    fn from(lens: Lens) -> Self {
        Self {
            position: Vec3::from(lens.position),
            look_at: Vec3::from(lens.look_at),
            up: Vec3::from(lens.up),
            vertical_fov: lens.vertical_fov,
            aperture_radius: lens.aperture_radius,
            focus_distance: lens.focus_distance,
        }
    }
}

impl std::fmt::Display for Layer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Radiance => f.write_str("radiance"),
            Self::Error => f.write_str("error"),
            Self::Albedo => f.write_str("albedo"),
            Self::Normal => f.write_str("normal"),
            Self::Depth => f.write_str("depth"),
            Self::Length(length) => write!(f, "length:{length}"),
        }
    }
}

impl From<Layer> for String {
    fn from(layer: Layer) -> Self {
        layer.to_string()
    }
}

impl TryFrom<String> for Layer {
    type Error = String;

    fn try_from(name: String) -> std::result::Result<Self, String> {
        Ok(match name.as_str() {
            "radiance" => Self::Radiance,
            "error" => Self::Error,
            "albedo" => Self::Albedo,
            "normal" => Self::Normal,
            "depth" => Self::Depth,
            other => {
                let length = other.strip_prefix("length:").and_then(|n| n.parse().ok());
                Self::Length(length.ok_or_else(|| format!("there is no layer {other:?}"))?)
            }
        })
    }
}
