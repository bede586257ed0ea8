//! What a page is told first: the scene, and what can be chosen.

use super::look::{Lens, View};
use super::values::{MaterialValues, Parameter};
use crate::film::tonemap::Operator;
use crate::lanes::Rgb;
use crate::material::{self, Kind, Material};
use crate::scene::description::{Description, NamedMaterial, SamplerKind, Strategy};
use crate::scene::framing;
use crate::scene::toml::material_key;
use serde::Serialize;

/// The first message to a page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "hello")]
pub struct Hello {
    version: &'static str,
    scene: String,
    threads: usize,
    cameras: Vec<CameraEntry>,
    materials: Vec<MaterialEntry>,
    material_types: Vec<MaterialType>,
    strategies: Vec<&'static str>,
    samplers: Vec<&'static str>,
    tonemaps: Vec<String>,
    bounds: Option<Bounds>,
    start: View,
}

#[derive(Clone, Debug, Serialize)]
struct CameraEntry {
    name: String,
    lens: Lens,
}

#[derive(Clone, Debug, Serialize)]
struct MaterialEntry {
    name: String,
    /// Which textures multiply its parameters.
    maps: Vec<&'static str>,
    material: MaterialValues,
}

#[derive(Clone, Debug, Serialize)]
struct MaterialType {
    #[serde(rename = "type")]
    kind: &'static str,
    parameters: Vec<ParameterType>,
}

/// A parameter, the range that a slider has for it, and what it is before anybody has chosen.
#[derive(Clone, Debug, Serialize)]
struct ParameterType {
    name: &'static str,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    low: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<f32>,
    value: Parameter,
}

/// A sphere around all that has a surface, world space.
#[derive(Clone, Copy, Debug, Serialize)]
struct Bounds {
    center: [f32; 3],
    radius: f32,
}

impl Bounds {
    /// None where nothing has a surface.
    fn of(scene: &Description) -> Option<Self> {
        let (low, high) = framing::bounds(scene);
        (low.x <= high.x).then(|| Self {
            center: ((low + high) / 2.0).to_array(),
            radius: (high - low).length() / 2.0,
        })
    }
}

impl Hello {
    /// Of a scene that is first looked at like this.
    pub fn new(scene: &Description, start: View, threads: usize) -> Self {
        let entry = |named: &NamedMaterial| {
            let maps = [
                ("color", named.maps.color.is_some()),
                (
                    "metallic_roughness",
                    named.maps.metallic_roughness.is_some(),
                ),
                ("normal", named.maps.normal.is_some()),
                ("alpha", named.maps.alpha.is_some()),
            ];
            MaterialEntry {
                name: named.name.clone(),
                maps: maps.iter().filter(|map| map.1).map(|map| map.0).collect(),
                material: (&named.material).into(),
            }
        };
        let materials = scene.materials.iter();
        let changeable = materials.filter(|named| material_key(scene, &named.name).is_some());
        let cameras = scene.cameras.iter().map(|named| CameraEntry {
            name: named.name.clone(),
            lens: named.camera.into(),
        });
        let tonemaps = [Operator::Linear, Operator::Reinhard, Operator::Aces];
        Self {
            version: env!("CARGO_PKG_VERSION"),
            scene: scene.name.clone(),
            threads,
            cameras: cameras.collect(),
            materials: changeable.map(entry).collect(),
            material_types: Kind::ALL.into_iter().map(material_type).collect(),
            strategies: Strategy::NAMES.iter().map(|&(name, _)| name).collect(),
            samplers: SamplerKind::NAMES.iter().map(|&(name, _)| name).collect(),
            tonemaps: tonemaps.iter().map(ToString::to_string).collect(),
            bounds: Bounds::of(scene),
            start,
        }
    }
}

/// A material of each kind that looks like something, and the ranges of its parameters.
fn material_type(kind: Kind) -> MaterialType {
    let grey = |x: f32| Rgb::new(x, x, x);
    let material = match kind {
        Kind::Lambert => Material::Lambert { albedo: grey(0.73) },
        Kind::Mirror => Material::Mirror {
            reflectance: grey(0.95),
        },
        Kind::Glass => Material::Glass { ior: 1.5 },
        Kind::Phong => Material::Phong {
            diffuse: grey(0.4),
            specular: grey(0.5),
            exponent: 50.0,
        },
        Kind::Conductor => Material::Conductor {
            roughness: 0.2,
            reflectance: grey(0.9),
        },
        Kind::Principled => Material::Principled {
            base_color: grey(0.73),
            metallic: 0.0,
            roughness: 0.4,
            ior: 1.5,
        },
    };
    let parameter = |(name, value): (&'static str, material::Parameter)| {
        let value = Parameter::from(value);
        let range = match (name, value) {
            (_, Parameter::Color(_)) => None,
            ("exponent", _) => Some((0.0, 1000.0)),
            ("ior", _) => Some((1.0, 3.0)),
            ("roughness", _) if kind == Kind::Conductor => Some((0.01, 1.0)),
            _ => Some((0.0, 1.0)),
        };
        ParameterType {
            name,
            kind: match range {
                None => "color",
                Some(_) => "number",
            },
            low: range.map(|range| range.0),
            high: range.map(|range| range.1),
            value,
        }
    };
    MaterialType {
        kind: kind.name(),
        parameters: material.parameters().into_iter().map(parameter).collect(),
    }
}
