//! MTL materials: what they say, in this program's terms.

use super::Rgb;
use crate::error::Result;
use crate::material::Material;
use crate::scene::description::{Alpha, Image, Maps, NamedMaterial, Pixels, Texture, Wrap};
use crate::scene::image::{self, ColorSpace};
use crate::scene::lines::Lines;
use crate::scene::toml::names::quoted;
use glam::{Affine2, Vec2};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The materials of all libraries that a file names.
#[derive(Default)]
pub(super) struct Library {
    pub materials: HashMap<String, Entry>,
    pub textures: Vec<Texture>,
    pub warnings: Vec<String>,
    images: HashMap<(PathBuf, Use), Option<Arc<Image>>>,
}

/// A material, and what it emits.
pub(super) struct Entry {
    pub named: NamedMaterial,
    pub emission: Rgb,
}

impl Library {
    /// Reads the library that line `number` of an OBJ file names. One that cannot be opened is told, not refused.
    pub fn read(
        &mut self,
        obj: &Path,
        named: &str,
        number: usize,
        hasher: &mut Sha256,
    ) -> std::result::Result<(), String> {
        let path = beside(obj, named);
        let file = match File::open(&path) {
            Ok(file) => file,
            Err(error) => {
                self.warnings.push(format!(
                    "{}:{number}: cannot read {}: {error}; its materials are white",
                    obj.display(),
                    path.display()
                ));
                return Ok(());
            }
        };
        let mut lines = Lines::after(0, BufReader::new(file));
        let mut block = String::new();
        loop {
            let at = |number, message| format!("{}, line {number}: {message}", path.display());
            let number = lines.number + 1;
            let Some(line) = lines.next().map_err(|message| at(number, message))? else {
                break;
            };
            hasher.update(line.as_bytes());
            check(&line).map_err(|message| at(number, message))?;
            if line.split_whitespace().next() == Some("newmtl") {
                self.add(&block, &path, hasher);
                block.clear();
            }
            block.push_str(&line);
            block.push('\n');
        }
        self.add(&block, &path, hasher);
        Ok(())
    }

    /// Adds the material of a block of lines that [`check`] has passed.
    fn add(&mut self, block: &str, path: &Path, hasher: &mut Sha256) {
        let Ok((materials, _)) = tobj::load_mtl_buf(&mut block.as_bytes()) else {
            return;
        };
        for material in materials {
            let maps = self.maps(&material, path, hasher);
            let entry = Entry {
                emission: color(material.emissive, 0.0, f32::MAX),
                named: NamedMaterial {
                    material: closest(&material, maps.color.is_some()),
                    name: material.name.clone(),
                    maps,
                },
            };
            self.materials.insert(material.name, entry);
        }
    }

    fn maps(&mut self, material: &tobj::Material, path: &Path, hasher: &mut Sha256) -> Maps {
        let mut texture = |library: &mut Self, value: Option<&str>, space| {
            library.texture(Reference::of(value?, path), space, hasher)
        };
        let color = material.diffuse_texture.as_deref();
        let color = texture(self, color, Use::Color);
        let cutout = texture(self, material.dissolve_texture.as_deref(), Use::Cutout);
        // `bump` maps are heights by the book, and normals in many files.
        let relief = material.normal_texture.as_deref();
        let relief = material
            .unknown_param
            .get("norm")
            .map(String::as_str)
            .or(relief);
        let normal = texture(self, relief, Use::Normals).filter(|&index| {
            let is_normals = is_normal_map(&self.textures[index].image);
            if !is_normals {
                self.warnings.push(format!(
                    "{}: material {}: {} holds heights, not normals; the surface is left smooth",
                    path.display(),
                    quoted(&material.name),
                    self.textures[index].image.file
                ));
            }
            is_normals
        });
        Maps {
            color,
            metallic_roughness: None,
            normal: normal.map(|index| (index, 1.0)),
            alpha: cutout.map(|index| Alpha {
                texture: Some(index),
                factor: 1.0,
                cutoff: 0.5,
            }),
        }
    }

    /// The index of a texture; none, and a warning, where its image cannot be read.
    fn texture(&mut self, reference: Reference, used: Use, hasher: &mut Sha256) -> Option<usize> {
        let Reference {
            path,
            transform,
            clamp,
        } = reference;
        let warnings = &mut self.warnings;
        let image = self.images.entry((path.clone(), used)).or_insert_with(|| {
            let mut read = || -> Result<Image> {
                let bytes = image::bytes(&path)?;
                hasher.update(&bytes);
                let space = match used {
                    Use::Color => ColorSpace::Srgb,
                    Use::Cutout | Use::Normals => ColorSpace::Linear,
                };
                let mut image = image::decode(&bytes, &path.display().to_string(), space)?;
                if used == Use::Cutout {
                    alpha_of_grey(&mut image);
                }
                Ok(image)
            };
            read()
                .map_err(|error| warnings.push(format!("{error}; the texture is left out")))
                .ok()
                .map(Arc::new)
        });
        let image = image.clone()?;
        self.textures.push(Texture {
            image,
            wrap: [if clamp { Wrap::Clamp } else { Wrap::Repeat }; 2],
            nearest: false,
            transform,
        });
        Some(self.textures.len() - 1)
    }
}

/// Refuses a line that tobj would refuse without its place, or stop at.
fn check(line: &str) -> std::result::Result<(), String> {
    let mut words = line.split_whitespace();
    let key = words.next().unwrap_or_default();
    if matches!(key, "Ka" | "Kd" | "Ks" | "Ke") {
        let numbers: Vec<_> = words.take(3).map(str::parse::<f32>).collect();
        let finite =
            |number: &std::result::Result<f32, _>| matches!(number, Ok(n) if n.is_finite());
        if numbers.len() < 3 || !numbers.iter().all(finite) {
            return Err(format!("{key} must be three numbers, red, green and blue"));
        }
    }
    match tobj::load_mtl_buf(&mut line.as_bytes()) {
        Ok(_) => Ok(()),
        Err(_) => Err(format!(
            "this is no {key} of a material; write a number, a name or a file after it"
        )),
    }
}

/// Each channel cut to a range; white where there is none.
fn color(channels: Option<[f32; 3]>, or: f32, most: f32) -> Rgb {
    let [r, g, b] = channels
        .unwrap_or([or; 3])
        .map(|channel| channel.clamp(0.0, most));
    Rgb::new(r, g, b)
}

/// The material that is nearest to what an MTL says.
fn closest(material: &tobj::Material, has_texture: bool) -> Material {
    let parameter = |key: &str| -> Option<f32> {
        let value = material.unknown_param.get(key)?;
        value.parse().ok().filter(|value: &f32| value.is_finite())
    };
    let white = if has_texture { 1.0 } else { 0.8 };
    let mut diffuse = color(material.diffuse, white, 1.0);
    if has_texture && diffuse == Rgb::BLACK {
        // Written by exporters whose texture takes the place of the colour.
        diffuse = Rgb::WHITE;
    }
    let specular = color(material.specular, 0.0, 1.0);
    let ior = material
        .optical_density
        .filter(|ior| ior.is_finite() && *ior > 1.0);
    let opacity = match (material.dissolve, parameter("Tr")) {
        (Some(opacity), _) => opacity,
        (None, Some(transparency)) => 1.0 - transparency,
        (None, None) => 1.0,
    };
    let illumination = material.illumination_model.unwrap_or(2);
    if matches!(illumination, 4 | 6 | 7 | 9) && opacity < 1.0 || opacity < 0.5 {
        return Material::Glass {
            ior: ior.unwrap_or(1.5),
        };
    }
    let (metallic, roughness) = (parameter("Pm"), parameter("Pr"));
    if metallic.is_some() || roughness.is_some() {
        return Material::Principled {
            base_color: diffuse,
            metallic: metallic.unwrap_or(0.0).clamp(0.0, 1.0),
            roughness: roughness.unwrap_or(0.5).clamp(0.0, 1.0),
            ior: ior.unwrap_or(1.5),
        };
    }
    let exponent = material.shininess.unwrap_or(0.0);
    let shines = illumination >= 2 && specular != Rgb::BLACK && exponent > 0.0;
    if matches!(illumination, 3 | 5) && diffuse == Rgb::BLACK && specular != Rgb::BLACK {
        return Material::Mirror {
            reflectance: specular,
        };
    }
    if !shines {
        return Material::Lambert { albedo: diffuse };
    }
    // Both are painters' numbers, and a surface reflects no more light than it gets.
    let rest = |specular: f32, diffuse: f32| specular.min(1.0 - diffuse);
    Material::Phong {
        diffuse,
        specular: Rgb::new(
            rest(specular.r, diffuse.r),
            rest(specular.g, diffuse.g),
            rest(specular.b, diffuse.b),
        ),
        exponent: exponent.min(1e6),
    }
}

/// A texture as MTL names it: options, then a file.
struct Reference {
    path: PathBuf,
    /// From OBJ's texture coordinates, whose v = 0 is the bottom row, to those of the image.
    transform: Affine2,
    clamp: bool,
}

impl Reference {
    fn of(value: &str, library: &Path) -> Self {
        let (mut scale, mut offset, mut clamp) = (Vec2::ONE, Vec2::ZERO, false);
        let mut rest = value.trim();
        let word = |text: &mut &str| -> String {
            let (first, after) = text.split_once(char::is_whitespace).unwrap_or((*text, ""));
            let first = first.to_owned();
            *text = after.trim_start();
            first
        };
        while rest.starts_with('-') {
            let option = word(&mut rest);
            // Up to three numbers, or one word.
            let mut numbers = Vec::new();
            if matches!(option.as_str(), "-s" | "-o" | "-t" | "-mm") {
                while let Some(number) = rest.split_whitespace().next().and_then(|w| w.parse().ok())
                    && numbers.len() < 3
                {
                    numbers.push(number);
                    word(&mut rest);
                }
            } else {
                clamp |= word(&mut rest) == "on" && option == "-clamp";
            }
            let pair = match numbers[..] {
                [u, v, ..] => Vec2::new(u, v),
                _ => continue,
            };
            match option.as_str() {
                _ if !pair.is_finite() => {}
                "-s" => scale = pair,
                "-o" => offset = pair,
                _ => {}
            }
        }
        let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
        Self {
            path: beside(library, rest),
            transform: flip * Affine2::from_scale_angle_translation(scale, 0.0, offset),
            clamp,
        }
    }
}

/// A file that another one names, relative to it; Windows' separators are understood.
fn beside(file: &Path, named: &str) -> PathBuf {
    let folder = file.parent().unwrap_or(Path::new(""));
    folder.join(named.replace('\\', "/"))
}

/// Whether the texels of an image are unit vectors, as a rule, that look away from the surface.
fn is_normal_map(image: &Image) -> bool {
    let texel = |[x, y, z]: [f32; 3]| {
        let normal = glam::Vec3::new(x, y, z) * 2.0 - 1.0;
        normal.z > 0.0 && (normal.length() - 1.0).abs() < 0.15
    };
    let eight = |[r, g, b, _]: &[u8; 4]| texel([*r, *g, *b].map(|c| f32::from(c) / 255.0));
    let (all, units) = match &image.pixels {
        Pixels::Srgb8(texels) | Pixels::Linear8(texels) => {
            (texels.len(), texels.iter().filter(|&t| eight(t)).count())
        }
        Pixels::Float(texels) => {
            let float = |[r, g, b, _]: &[f32; 4]| texel([*r, *g, *b]);
            (texels.len(), texels.iter().filter(|&t| float(t)).count())
        }
    };
    10 * units > 9 * all
}

/// What an image is for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Use {
    Color,
    Cutout,
    Normals,
}

/// A cut-out is the alpha of its image, or where that is opaque, its grey.
fn alpha_of_grey(image: &mut Image) {
    match &mut image.pixels {
        Pixels::Srgb8(texels) | Pixels::Linear8(texels) => {
            if texels.iter().all(|texel| texel[3] == 255) {
                texels.iter_mut().for_each(|texel| texel[3] = texel[0]);
            }
        }
        Pixels::Float(texels) => {
            if texels.iter().all(|texel| texel[3] == 1.0) {
                texels.iter_mut().for_each(|texel| texel[3] = texel[0]);
            }
        }
    }
}
