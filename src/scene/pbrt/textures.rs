//! Textures: what a name stands for, and the images of the description.

use super::files::Files;
use super::lexer::At;
use super::names::{did_you_mean, quoted};
use super::parameters::{Parameters, Textured};
use super::spectra::Spectrum;
use super::warnings::Warnings;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::{Image, Pixels, Texture, Wrap};
use crate::scene::image::{self, ColorSpace};
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
    picture: Picture,
    srgb: bool,
    wrap: Wrap,
    nearest: bool,
    /// From the UV of the shape to that of the image, whose v = 0 is its top row.
    transform: Affine2,
    at: At,
}

#[derive(Clone, Debug)]
enum Picture {
    File(PathBuf),
    /// Named, so that two that are alike are one.
    Made(String, Arc<Image>),
}

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Use {
    /// Its colour.
    Color,
    /// Its values as they are.
    Normals,
    /// Its brightness decides what is there: pbrt's float textures are the mean of an image's channels.
    Alpha,
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
                    let mut known: Vec<&str> = known.map(String::as_str).collect();
                    known.sort_unstable();
                    at.error(format!(
                        "texture {} is not defined{}",
                        quoted(name),
                        match did_you_mean(name, known) {
                            hint if hint.is_empty() => "; define it before".to_owned(),
                            hint => hint,
                        }
                    ))
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
                warnings.tell(
                    &parameters.at,
                    "the texture \"dots\" is not supported; what is outside the dots is everywhere",
                );
                part_of(self, parameters, "outside", warnings)
            }
            _ => {
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

fn part_of(
    textures: &Textures,
    parameters: &Parameters,
    name: &str,
    warnings: &mut Warnings,
) -> Result<Value> {
    textures.part(parameters, name, 0.0, warnings)
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

/// Product by channel.
pub(super) fn times(a: Rgb, b: Rgb) -> Rgb {
    Rgb::new(a.r * b.r, a.g * b.g, a.b * b.b)
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

/// The textures of the description; what is used twice is there once.
#[derive(Default)]
pub(super) struct Gallery {
    /// As the description has them.
    pub textures: Vec<Texture>,
    by_key: HashMap<String, usize>,
    images: HashMap<(String, bool, bool), Arc<Image>>,
}

impl Gallery {
    /// The index of a map's texture.
    pub fn add(&mut self, map: &Map, purpose: Use, files: &mut Files) -> Result<usize> {
        let (name, transform) = (map.picture.name(), map.transform);
        let srgb = map.srgb && purpose != Use::Normals;
        let key = format!(
            "{name:?} {srgb} {:?} {} {transform:?} {purpose:?}",
            map.wrap, map.nearest
        );
        if let Some(&index) = self.by_key.get(&key) {
            return Ok(index);
        }
        let image = self.image(map, srgb, purpose == Use::Alpha, files)?;
        self.by_key.insert(key, self.textures.len());
        self.textures.push(Texture {
            image,
            wrap: [map.wrap; 2],
            nearest: map.nearest,
            transform,
        });
        Ok(self.textures.len() - 1)
    }

    /// The mean of a map's channels.
    pub fn mean(&mut self, map: &Map, files: &mut Files) -> Result<f32> {
        let image = self.image(map, map.srgb, true, files)?;
        let (sum, count) = match &image.pixels {
            Pixels::Srgb8(pixels) | Pixels::Linear8(pixels) => (
                pixels.iter().map(|pixel| f64::from(pixel[3]) / 255.0).sum(),
                pixels.len(),
            ),
            Pixels::Float(pixels) => (
                pixels.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>(),
                pixels.len(),
            ),
        };
        Ok((sum / count.max(1) as f64) as f32)
    }

    fn image(
        &mut self,
        map: &Map,
        srgb: bool,
        alpha: bool,
        files: &mut Files,
    ) -> Result<Arc<Image>> {
        let key = (map.picture.name(), srgb, alpha);
        if let Some(image) = self.images.get(&key) {
            return Ok(Arc::clone(image));
        }
        let mut image = match &map.picture {
            Picture::Made(_, image) => Arc::clone(image),
            Picture::File(path) => {
                let space = if srgb {
                    ColorSpace::Srgb
                } else {
                    ColorSpace::Linear
                };
                let image =
                    image::read(path, space).map_err(|error| map.at.error(error.to_string()))?;
                let hashed = files.hash(path);
                hashed.map_err(|error| map.at.error(format!("{}: {error}", path.display())))?;
                Arc::new(image)
            }
        };
        if alpha {
            image = Arc::new(brightness_as_alpha(&image));
        }
        self.images.insert(key, Arc::clone(&image));
        Ok(image)
    }
}

impl Picture {
    fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Made(name, _) => name.clone(),
        }
    }
}

/// An image whose alpha is the mean of its colours, or its own alpha where it has one.
fn brightness_as_alpha(image: &Image) -> Image {
    let to_linear = |value: u8| {
        let value = f32::from(value) / 255.0;
        // IEC 61966-2-1.
        if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    };
    let bytes = |pixels: &[[u8; 4]], linear: &dyn Fn(u8) -> f32| {
        let has_alpha = pixels.iter().any(|pixel| pixel[3] < u8::MAX);
        let table: Vec<f32> = (0..=u8::MAX).map(linear).collect();
        let gray = |&[r, g, b, a]: &[u8; 4]| {
            let mean = [r, g, b]
                .iter()
                .map(|&c| table[usize::from(c)])
                .sum::<f32>()
                / 3.0;
            let alpha = if has_alpha {
                a
            } else {
                (mean * 255.0).round() as u8
            };
            [r, g, b, alpha]
        };
        pixels.iter().map(gray).collect::<Vec<_>>()
    };
    let pixels = match &image.pixels {
        Pixels::Srgb8(pixels) => Pixels::Srgb8(bytes(pixels, &to_linear)),
        Pixels::Linear8(pixels) => {
            Pixels::Linear8(bytes(pixels, &|value| f32::from(value) / 255.0))
        }
        Pixels::Float(pixels) => {
            let has_alpha = pixels.iter().any(|pixel| pixel[3] < 1.0);
            let gray =
                |&[r, g, b, a]: &[f32; 4]| [r, g, b, if has_alpha { a } else { (r + g + b) / 3.0 }];
            Pixels::Float(pixels.iter().map(gray).collect())
        }
    };
    Image {
        file: image.file.clone(),
        pixels,
        ..*image
    }
}
