//! Materials: the closest match to each of pbrt's.

use super::files::Files;
use super::gallery::{Gallery, Use};
use super::lexer::At;
use super::names::quoted;
use super::parameters::{Parameters, Textured};
use super::spectra::{Spectrum, conductor_reflectance};
use super::textures::{Map, Textures, Value};
use super::warnings::Warnings;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::material::Material;
use crate::scene::description::{Maps, NamedMaterial};

/// A material as the file has it.
#[derive(Debug)]
pub(super) struct Definition {
    /// What `info` calls it.
    pub name: String,
    /// `diffuse`, `conductor`, ...
    pub kind: String,
    pub parameters: Parameters,
}

/// What materials are made from.
pub(super) struct Studio<'a> {
    pub textures: &'a Textures,
    pub gallery: &'a mut Gallery,
    pub files: &'a mut Files,
    pub warnings: &'a mut Warnings,
}

impl Studio<'_> {
    /// The material; none where light passes as if nothing were there.
    pub fn material(&mut self, definition: &Definition) -> Result<Option<NamedMaterial>> {
        let Definition {
            name,
            kind,
            parameters,
        } = definition;
        let mut maps = Maps::default();
        let material = match kind.as_str() {
            "diffuse" => Some(self.matte(parameters, "reflectance", 0.5, &mut maps)?),
            "coateddiffuse" => {
                let base_color = self.color(parameters, "reflectance", 0.5, &mut maps)?;
                Some(Material::Principled {
                    base_color,
                    metallic: 0.0,
                    roughness: self.alpha(parameters, "", 0.0)?.sqrt(),
                    ior: self.ior(parameters)?.max(1.0),
                })
            }
            "conductor" => Some(self.conductor(parameters, &mut maps)?),
            "coatedconductor" => {
                self.tell(definition, "the metal stands without its coat");
                let base_color = self.metal(parameters, "conductor.", &mut maps)?;
                Some(Material::Principled {
                    base_color,
                    metallic: 1.0,
                    roughness: self.alpha(parameters, "conductor.", 0.0)?.sqrt(),
                    ior: 1.5,
                })
            }
            "dielectric" => {
                if self.alpha(parameters, "", 0.0)? > 0.0 {
                    self.warnings
                        .tell(&parameters.at, "rough glass is not supported; it is smooth");
                }
                Some(Material::Glass {
                    ior: self.ior(parameters)?,
                })
            }
            // A pane is too thin to bend light, which a body of glass does.
            "thindielectric" | "" | "none" | "interface" => None,
            "diffusetransmission" => {
                self.tell(definition, "it reflects, and nothing passes through");
                Some(self.matte(parameters, "reflectance", 0.25, &mut maps)?)
            }
            _ => {
                self.tell(definition, "it is matte");
                Some(self.matte(parameters, "reflectance", 0.5, &mut maps)?)
            }
        };
        if parameters.has("displacement") {
            self.warnings.tell(
                &parameters.at,
                "displacement is not supported; the surface stays as it is",
            );
        }
        if let (Some(file), true) = (parameters.text("normalmap")?, material.is_some()) {
            let map = Map::of_file(self.files.path(file), false, parameters.at.clone());
            let index = self.gallery.add(&map, Use::Normals, self.files)?;
            maps.normal = Some((index, 1.0));
        }
        if KNOWN.contains(&kind.as_str()) {
            let owner = format!("the material {}", quoted(kind));
            self.warnings.tell_unused(parameters, &owner);
        }
        Ok(material.map(|material| NamedMaterial {
            name: name.clone(),
            material,
            maps,
        }))
    }

    /// One line for each kind of material that is not pbrt's own.
    fn tell(&mut self, definition: &Definition, instead: &str) {
        let kind = &definition.kind;
        self.warnings.tell_once(
            format!("material {kind}"),
            &definition.parameters.at,
            || format!("the material {} is not supported; {instead}", quoted(kind)),
        );
    }

    /// A constant, or an image and its factor.
    pub fn value(&mut self, textured: &Textured, at: &At) -> Result<Value> {
        self.textures.resolve(textured, self.warnings, at)
    }

    /// The colour of a surface, each channel in [0, 1], times the image that enters the maps.
    fn paint(&mut self, textured: &Textured, at: &At, maps: &mut Maps) -> Result<Rgb> {
        let value = self.value(textured, at)?;
        if let Some(map) = &value.map {
            maps.color = Some(self.gallery.add(map, Use::Color, self.files)?);
        }
        let [r, g, b] = value
            .factor
            .to_array()
            .map(|channel| channel.clamp(0.0, 1.0));
        Ok(Rgb::new(r, g, b))
    }

    fn color(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: f32,
        maps: &mut Maps,
    ) -> Result<Rgb> {
        match parameters.textured(name)? {
            Some(textured) => self.paint(&textured, &parameters.at, maps),
            None => Ok(Rgb::splat(default)),
        }
    }

    fn matte(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: f32,
        maps: &mut Maps,
    ) -> Result<Material> {
        let albedo = self.color(parameters, name, default, maps)?;
        Ok(Material::Lambert { albedo })
    }

    fn conductor(&mut self, parameters: &Parameters, maps: &mut Maps) -> Result<Material> {
        let reflectance = self.metal(parameters, "", maps)?;
        let alpha = self.alpha(parameters, "", 0.0)?;
        Ok(if alpha < SMOOTH {
            Material::Mirror { reflectance }
        } else {
            Material::Conductor {
                roughness: alpha,
                reflectance,
            }
        })
    }

    /// Reflectance of a conductor: as given, or by η and k, copper's where nothing is said.
    fn metal(&mut self, parameters: &Parameters, prefix: &str, maps: &mut Maps) -> Result<Rgb> {
        let at = &parameters.at;
        if let Some(reflectance) = parameters.textured("reflectance")? {
            return self.paint(&reflectance, at, maps);
        }
        let copper = |part: &str| Spectrum::Named(format!("metal-Cu-{part}"));
        let mut optical = |part: &str| {
            let textured = parameters.textured(&format!("{prefix}{part}"))?;
            Ok::<Spectrum, crate::error::Error>(match textured {
                None => copper(part),
                Some(Textured::Constant(spectrum)) => spectrum,
                Some(texture) => {
                    self.warnings.tell(
                        at,
                        "a texture of eta or k is not supported; the metal is copper",
                    );
                    let _ = self.textures.resolve(&texture, self.warnings, at)?;
                    copper(part)
                }
            })
        };
        let (eta, k) = (optical("eta")?, optical("k")?);
        if let Some(reflectance) = conductor_reflectance(&eta, &k) {
            return Ok(reflectance);
        }
        self.warnings.tell_once("metal".to_owned(), at, || {
            "the spectra of this metal are not known; it is copper, write \"rgb reflectance\" for another colour".to_owned()
        });
        Ok(conductor_reflectance(&copper("eta"), &copper("k")).unwrap_or(Rgb::WHITE))
    }

    /// GGX alpha, in [0, 1]: pbrt takes the root of its roughness (`TrowbridgeReitzDistribution::RoughnessToAlpha`)
    /// unless told not to.
    fn alpha(&mut self, parameters: &Parameters, prefix: &str, default: f32) -> Result<f32> {
        let named = |name: &str| format!("{prefix}{name}");
        let both = self.number(parameters, &named("roughness"))?;
        let u = self.number(parameters, &named("uroughness"))?;
        let v = self.number(parameters, &named("vroughness"))?;
        let fallback = both.unwrap_or(default);
        let (u, v) = (u.unwrap_or(fallback), v.unwrap_or(fallback));
        if u != v {
            self.warnings.tell(
                &parameters.at,
                "a roughness that differs by direction is not supported; it is the mean",
            );
        }
        let roughness = (0.5 * (u + v)).clamp(0.0, 1.0);
        Ok(match parameters.flag("remaproughness")? {
            Some(false) => roughness,
            _ => roughness.sqrt(),
        })
    }

    /// A number, or the mean of the image it is.
    fn number(&mut self, parameters: &Parameters, name: &str) -> Result<Option<f32>> {
        let Some(textured) = parameters.textured(name)? else {
            return Ok(None);
        };
        let value = self.value(&textured, &parameters.at)?;
        let mean = match &value.map {
            None => 1.0,
            Some(map) => {
                self.warnings
                    .tell_once(format!("image of {name}"), &parameters.at, || {
                        format!("an image for {name} is not supported; it is its mean")
                    });
                self.gallery.mean(map, self.files)?
            }
        };
        Ok(Some(value.factor.luminance() * mean))
    }

    fn ior(&mut self, parameters: &Parameters) -> Result<f32> {
        const DEFAULT: f32 = 1.5;
        let Some(spectrum) = parameters.spectrum("eta")? else {
            return Ok(DEFAULT);
        };
        match spectrum.ior() {
            Some(ior) if (1e-3..=1e3).contains(&ior) => Ok(ior),
            Some(ior) => Err(parameters.at.error(format!(
                "eta is {ior}; an index of refraction is from 0.001 to 1000, 1.5 for window glass"
            ))),
            None => {
                self.warnings
                    .tell_once("glass".to_owned(), &parameters.at, || {
                        "the spectrum of eta is not known; it is 1.5".to_owned()
                    });
                Ok(DEFAULT)
            }
        }
    }
}

/// Below this alpha a conductor is a mirror to the eye (pbrt-v4, `TrowbridgeReitzDistribution::EffectivelySmooth`).
const SMOOTH: f32 = 1e-3;

/// The materials of which every parameter is looked at.
const KNOWN: [&str; 4] = ["diffuse", "coateddiffuse", "conductor", "dielectric"];
