//! The textures of the description.

use super::files::Files;
use super::textures::{Map, Picture};
use crate::error::Result;
use crate::scene::description::{Image, Pixels, Texture};
use crate::scene::image::{self, ColorSpace};
use std::collections::HashMap;
use std::sync::Arc;

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

/// An image whose alpha is the mean of its colours, or its own alpha where it has one.
fn brightness_as_alpha(picture: &Image) -> Image {
    let to_linear = |value: u8| image::linear(f32::from(value) / 255.0);
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
    let pixels = match &picture.pixels {
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
        file: picture.file.clone(),
        pixels,
        ..*picture
    }
}
