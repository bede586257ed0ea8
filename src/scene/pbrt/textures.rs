//! Textures: what a name stands for, and the images of the description.

use super::files::Files;
use super::lexer::At;
use super::names::{quoted, undefined};
use super::parameters::{Parameters, Textured};
use super::spectra::Spectrum;
use super::warnings::Warnings;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::{Image, Pixels, Wrap};
use glam::{Affine2, Vec2};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What a texture is: a factor, times an image where there is one.
#[derive(Clone, Debug)]
pub(super) struct Value {
    pub factor: Rgb,
    pub map: Option<Map>,
}

impl Value {
    /// The same everywhere.
    pub fn constant(factor: Rgb) -> Self {
        Self { factor, map: None }
    }
}

/// An image on a surface.
#[derive(Clone, Debug)]
pub(super) struct Map {
    pub picture: Picture,
    pub srgb: bool,
    pub wrap: Wrap,
    pub nearest: bool,
    /// From the UV of the shape to that of the image, whose v = 0 is its top row.
    pub transform: Affine2,
    pub at: At,
}

#[derive(Clone, Debug)]
pub(super) enum Picture {
    File(PathBuf),
    /// Named, so that two that are alike are one.
    Made(String, Arc<Image>),
}

impl Map {
    /// An image file, as it is used where no texture says how.
    pub fn of_file(path: PathBuf, srgb: bool, at: At) -> Self {
        Self {
            picture: Picture::File(path),
            srgb,
            wrap: Wrap::Repeat,
            nearest: false,
            transform: from_uv(Vec2::ONE, Vec2::ZERO),
            at,
        }
    }
}

/// `(u, v)` scaled and shifted, then v turned round: pbrt's goes up.
fn from_uv(scale: Vec2, shift: Vec2) -> Affine2 {
    Affine2::from_cols(
        Vec2::new(scale.x, 0.0),
        Vec2::new(0.0, -scale.y),
        Vec2::new(shift.x, 1.0 - shift.y),
    )
}

/// The named textures, those of colours and those of numbers.
#[derive(Debug, Default)]
pub(super) struct Textures {
    colors: HashMap<String, Value>,
    numbers: HashMap<String, Value>,
}

impl Textures {
    /// `Texture "name" "class" "kind"`.
    pub fn define(
        &mut self,
        (name, class, kind): (String, &str, &str),
        parameters: &Parameters,
        files: &Files,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let value = self.value(kind, parameters, files, warnings)?;
        let named = if class == "float" {
            &mut self.numbers
        } else {
            &mut self.colors
        };
        named.insert(name, value);
        Ok(())
    }

    /// What a parameter is; a name that stands for nothing is an error.
    pub fn resolve(&self, textured: &Textured, warnings: &mut Warnings, at: &At) -> Result<Value> {
        match textured {
            Textured::Constant(spectrum) => {
                Ok(Value::constant(reflectance(spectrum, at, warnings)))
            }
            Textured::Texture(name, at) => {
                let found = self.colors.get(name).or_else(|| self.numbers.get(name));
                found.cloned().ok_or_else(|| {
                    let known = self.colors.keys().chain(self.numbers.keys());
                    let known = known.map(String::as_str);
                    at.error(undefined("texture", name, known, "define it before"))
                })
            }
        }
    }

    fn part(
        &self,
        parameters: &Parameters,
        name: &str,
        default: f32,
        warnings: &mut Warnings,
    ) -> Result<Value> {
        match parameters.textured(name)? {
            Some(textured) => self.resolve(&textured, warnings, &parameters.at),
            None => Ok(Value::constant(Rgb::splat(default))),
        }
    }

    fn value(
        &self,
        kind: &str,
        parameters: &Parameters,
        files: &Files,
        warnings: &mut Warnings,
    ) -> Result<Value> {
        let mut part = |name, default| self.part(parameters, name, default, warnings);
        match kind {
            "constant" => part("value", 1.0),
            "imagemap" => image_map(parameters, files, warnings),
            "scale" => {
                let (a, b) = (part("tex", 1.0)?, part("scale", 1.0)?);
                if a.map.is_some() && b.map.is_some() {
                    warnings.tell(
                        &parameters.at,
                        "a product of two images is not supported; the second is left out",
                    );
                }
                Ok(Value {
                    factor: times(a.factor, b.factor),
                    map: a.map.or(b.map),
                })
            }
            "mix" | "directionmix" => {
                let (a, b) = (part("tex1", 0.0)?, part("tex2", 1.0)?);
                let amount = part("amount", 0.5)?;
                let t = amount.factor.luminance().clamp(0.0, 1.0);
                if a.map.is_none() && b.map.is_none() && amount.map.is_none() && kind == "mix" {
                    return Ok(Value::constant(lerp(a.factor, b.factor, t)));
                }
                warnings.tell(
                    &parameters.at,
                    "a mix of textures is not supported; the one with more weight stands alone",
                );
                Ok(if t < 0.5 { a } else { b })
            }
            "checkerboard" => {
                let (a, b) = (part("tex1", 1.0)?, part("tex2", 0.0)?);
                if a.map.is_some()
                    || b.map.is_some()
                    || parameters.integer("dimension", 2..=3)? == Some(3)
                {
                    warnings.tell(&parameters.at, "a checkerboard of images, or in three dimensions, is not supported; its first texture stands alone");
                    return Ok(a);
                }
                let mut map = mapping(parameters, board(a.factor, b.factor), warnings)?;
                // Two fields a period.
                map.transform = Affine2::from_scale(Vec2::splat(0.5)) * map.transform;
                map.nearest = true;
                Ok(Value {
                    factor: Rgb::WHITE,
                    map: Some(map),
                })
            }
            "dots" => {
                let outside = part("outside", 1.0)?;
                parameters.ignore();
                let message =
                    "the texture \"dots\" is not supported; what is outside the dots is everywhere";
                warnings.tell(&parameters.at, message);
                Ok(outside)
            }
            _ => {
                parameters.ignore();
                warnings.tell_once(format!("texture {kind}"), &parameters.at, || {
                    format!(
                        "the texture {} is not supported; it is a grey of 0.5",
                        quoted(kind)
                    )
                });
                Ok(Value::constant(Rgb::splat(0.5)))
            }
        }
    }
}

/// A constant as a reflectance; grey, and told, where its name is unknown.
pub(super) fn reflectance(spectrum: &Spectrum, at: &At, warnings: &mut Warnings) -> Rgb {
    spectrum.reflectance().unwrap_or_else(|| {
        warnings.tell_once("reflectance".to_owned(), at, || {
            "this spectrum is not known as a reflectance; it is a grey of 0.5".to_owned()
        });
        Rgb::splat(0.5)
    })
}

/// Product by channel, finite.
fn times(a: Rgb, b: Rgb) -> Rgb {
    let product = |a: f32, b: f32| (a * b).min(f32::MAX);
    Rgb::new(product(a.r, b.r), product(a.g, b.g), product(a.b, b.b))
}

fn lerp(a: Rgb, b: Rgb, t: f32) -> Rgb {
    let mix = |a: f32, b: f32| a + (b - a) * t;
    Rgb::new(mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b))
}

/// Two by two fields, for UV that were halved after they were turned round: the one next to pbrt's (0, 0) is `a`.
fn board(a: Rgb, b: Rgb) -> Picture {
    let pixel = |c: Rgb| [c.r, c.g, c.b, 1.0];
    let (a, b) = (pixel(a), pixel(b));
    let image = Image {
        file: "checkerboard".to_owned(),
        width: 2,
        height: 2,
        pixels: Pixels::Float(vec![a, b, b, a]),
    };
    Picture::Made(format!("checkerboard {a:?} {b:?}"), Arc::new(image))
}

fn image_map(parameters: &Parameters, files: &Files, warnings: &mut Warnings) -> Result<Value> {
    let at = &parameters.at;
    let Some(name) = parameters.text("filename")? else {
        return Err(at.error("an imagemap needs \"string filename\" \"image.png\""));
    };
    let mut map = mapping(parameters, Picture::File(files.path(name)), warnings)?;
    map.wrap = match parameters.text("wrap")?.unwrap_or("repeat") {
        "repeat" => Wrap::Repeat,
        "clamp" => Wrap::Clamp,
        other => {
            warnings.tell_once("wrap".to_owned(), at, || {
                format!(
                    "wrap {} is not supported; the border goes on",
                    quoted(other)
                )
            });
            Wrap::Clamp
        }
    };
    map.nearest = parameters.text("filter")? == Some("point");
    let _ = parameters.get("maxanisotropy");
    map.srgb = match parameters.text("encoding")?.unwrap_or("sRGB") {
        "sRGB" => true,
        "linear" => false,
        other => {
            warnings.tell_once("encoding".to_owned(), at, || {
                format!(
                    "encoding {} is not supported; the image is read as sRGB",
                    quoted(other)
                )
            });
            true
        }
    };
    if parameters.flag("invert")? == Some(true) {
        warnings.tell(at, "invert is not supported; the image is used as it is");
    }
    let scale = parameters.float_in("scale", "at least 0", |scale| scale >= 0.0)?;
    Ok(Value {
        factor: Rgb::splat(scale.unwrap_or(1.0)),
        map: Some(map),
    })
}

/// A picture by the texture's mapping of UV.
fn mapping(parameters: &Parameters, picture: Picture, warnings: &mut Warnings) -> Result<Map> {
    let kind = parameters.text("mapping")?.unwrap_or("uv");
    if kind != "uv" {
        warnings.tell_once("mapping".to_owned(), &parameters.at, || {
            format!(
                "the mapping {} is not supported; the shape's uv is used",
                quoted(kind)
            )
        });
    }
    let within = |value: f32| value.abs() <= 1e9;
    let float = |name, default| {
        let value = parameters.float_in(name, "within ±1e9", within)?;
        Ok::<f32, crate::error::Error>(value.unwrap_or(default))
    };
    let scale = Vec2::new(float("uscale", 1.0)?, float("vscale", 1.0)?);
    let shift = Vec2::new(float("udelta", 0.0)?, float("vdelta", 0.0)?);
    Ok(Map {
        picture,
        srgb: true,
        wrap: Wrap::Repeat,
        nearest: false,
        transform: from_uv(scale, shift),
        at: parameters.at.clone(),
    })
}

impl Picture {
    /// What tells it from others.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Made(name, _) => name.clone(),
        }
    }
}
