//! Materials and their textures.

use super::Reader;
use super::file::AGAIN;
use crate::error::Result;
use crate::lanes::Rgb;
use crate::material::Material;
use crate::scene::description::{Alpha, Image, Maps, NamedMaterial, Texture, Wrap};
use crate::scene::image::{self, ColorSpace};
use glam::{Affine2, Mat2, Vec2};
use gltf::json::extensions::texture::TextureTransform;
use gltf::material::{AlphaMode, PbrMetallicRoughness};
use gltf::texture::{MagFilter, WrappingMode};
use sha2::Digest;
use std::sync::Arc;

/// Least transmission of what is rendered as glass.
const GLASSY: f32 = 0.5;
/// Alpha at which blending becomes a cut-out.
const HALF: f32 = 0.5;
/// Beyond all matter, and still a number to work with.
const LARGEST_IOR: f32 = 1e3;
/// Greatest size of an image file, bytes.
const LARGEST: u64 = 1 << 30;

/// A material as primitives use it.
#[derive(Clone, Copy)]
pub(super) struct Surface {
    /// Index into the description's materials.
    pub(super) material: usize,
    pub(super) emission: Option<Emission>,
    /// Which TEXCOORD its textures use.
    pub(super) uv_set: u32,
}

#[derive(Clone, Copy)]
pub(super) struct Emission {
    pub(super) radiance: Rgb,
    pub(super) texture: Option<usize>,
    pub(super) two_sided: bool,
}

/// A texture as a material uses it.
struct Slot<'a> {
    texture: gltf::Texture<'a>,
    set: u32,
    transform: Affine2,
}

/// What tells textures apart: the file's texture, its colour space, the bits of its transform.
pub(super) type TextureKey = (usize, ColorSpace, [u32; 6]);

impl<'a> Reader<'a> {
    /// The material, read when the first primitive needs it.
    pub(super) fn surface(&mut self, material: &gltf::Material<'a>) -> Result<Surface> {
        if let Some(&surface) = self.surfaces.get(&material.index()) {
            return Ok(surface);
        }
        let place = material.index().map_or("materials".to_owned(), |index| {
            format!("materials[{index}]")
        });
        let pbr = material.pbr_metallic_roughness();
        let normal = material.normal_texture();
        let mut slots = [
            pbr.base_color_texture().map(|info| Slot::of(&info)),
            pbr.metallic_roughness_texture().map(|info| Slot::of(&info)),
            normal.as_ref().map(Slot::of_normals),
            material.emissive_texture().map(|info| Slot::of(&info)),
        ];
        let uv_set = slots
            .iter()
            .flatten()
            .map(|slot| slot.set)
            .next()
            .unwrap_or(0);
        let mut dark = false;
        for (index, slot) in slots.iter_mut().enumerate() {
            if slot.as_ref().is_some_and(|slot| slot.set != uv_set) {
                self.notes.tell(&place, "textures with another TEXCOORD than the material's first are left out, and so is light that they shape");
                *slot = None;
                dark |= index == 3;
            }
        }
        let [color, metallic_roughness, normals, emissive] = slots;
        let color = self.texture(color, ColorSpace::Srgb, &place)?;
        let alpha = self.alpha(material, color, &place);
        let ior = material.ior().unwrap_or(1.5);
        if ior < 1.0 {
            self.notes.tell(&place, "an ior below 1 is taken as 1");
        }
        let ior = ior.clamp(1.0, LARGEST_IOR);
        let transmission = material.transmission();
        let transmission = transmission.map_or(0.0, |all| all.transmission_factor());
        let (scattering, maps) = if transmission >= GLASSY {
            self.notes.tell(&place, "transmission is rendered as solid, smooth and clear glass, whatever its tint, roughness and thickness");
            let maps = Maps {
                alpha,
                ..Maps::default()
            };
            (Material::Glass { ior }, maps)
        } else {
            if transmission > 0.0 {
                self.notes
                    .tell(&place, "transmission below 0.5 is left out");
            }
            let scale = normal.map_or(1.0, |normal| normal.scale());
            if !scale.is_finite() {
                let message = format!("its normalTexture.scale is not finite; {AGAIN}");
                return Err(self.file.error(&place, message));
            }
            let normals = self.texture(normals, ColorSpace::Linear, &place)?;
            let maps = Maps {
                color,
                metallic_roughness: self.texture(metallic_roughness, ColorSpace::Linear, &place)?,
                normal: normals.map(|texture| (texture, scale)),
                alpha,
            };
            (self.principled(&pbr, ior, &place), maps)
        };
        let emission = match dark {
            true => None,
            false => self.emission(material, emissive, &place)?,
        };
        let surface = Surface {
            material: self.description.materials.len(),
            emission,
            uv_set,
        };
        self.description.materials.push(NamedMaterial {
            name: match (material.name(), material.index()) {
                (Some(name), _) => name.to_owned(),
                (None, Some(index)) => format!("material {index}"),
                (None, None) => "default material".to_owned(),
            },
            material: scattering,
            maps,
        });
        self.surfaces.insert(material.index(), surface);
        Ok(surface)
    }

    fn principled(&mut self, pbr: &PbrMetallicRoughness, ior: f32, place: &str) -> Material {
        let [r, g, b, _] = pbr.base_color_factor();
        let factors = [r, g, b, pbr.metallic_factor(), pbr.roughness_factor()];
        if factors.iter().any(|factor| !(0.0..=1.0).contains(factor)) {
            self.notes.tell(place, "factors are clamped to [0, 1]");
        }
        let [r, g, b, metallic, roughness] = factors.map(|factor| factor.clamp(0.0, 1.0));
        Material::Principled {
            base_color: Rgb::new(r, g, b),
            metallic,
            roughness,
            ior,
        }
    }

    fn alpha(
        &mut self,
        material: &gltf::Material,
        texture: Option<usize>,
        place: &str,
    ) -> Option<Alpha> {
        let [.., factor] = material.pbr_metallic_roughness().base_color_factor();
        let cutoff = match material.alpha_mode() {
            AlphaMode::Opaque => return None,
            AlphaMode::Mask => material.alpha_cutoff().unwrap_or(HALF),
            AlphaMode::Blend if texture.is_none() && factor >= 1.0 => return None,
            AlphaMode::Blend => {
                let message = "alphaMode BLEND is rendered as a cut-out at alpha 0.5";
                self.notes.tell(place, message);
                HALF
            }
        };
        Some(Alpha {
            texture,
            factor,
            cutoff,
        })
    }

    fn emission(
        &mut self,
        material: &gltf::Material,
        texture: Option<Slot<'a>>,
        place: &str,
    ) -> Result<Option<Emission>> {
        let strength = material.emissive_strength().unwrap_or(1.0);
        let radiance = material.emissive_factor().map(|factor| factor * strength);
        if !radiance
            .iter()
            .all(|&channel| channel.is_finite() && channel >= 0.0)
        {
            let message = format!(
                "its emission is {radiance:?}, and radiance is finite and at least 0; {AGAIN}"
            );
            return Err(self.file.error(place, message));
        }
        if radiance == [0.0; 3] {
            return Ok(None);
        }
        Ok(Some(Emission {
            radiance: radiance.into(),
            texture: self.texture(texture, ColorSpace::Srgb, place)?,
            two_sided: material.double_sided(),
        }))
    }

    /// Index into the description's textures.
    fn texture(
        &mut self,
        slot: Option<Slot<'a>>,
        space: ColorSpace,
        place: &str,
    ) -> Result<Option<usize>> {
        let Some(Slot {
            texture, transform, ..
        }) = slot
        else {
            return Ok(None);
        };
        if !transform.is_finite() {
            let message = format!("its KHR_texture_transform is not finite; {AGAIN}");
            return Err(self.file.error(place, message));
        }
        let key = (
            texture.index(),
            space,
            transform.to_cols_array().map(f32::to_bits),
        );
        if let Some(&known) = self.textures.get(&key) {
            return Ok(Some(known));
        }
        let sampler = texture.sampler();
        let wrap = |mode| match mode {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        };
        let image = self.image(&texture.source(), space)?;
        let index = self.description.textures.len();
        self.description.textures.push(Texture {
            image,
            wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
            nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
            transform,
        });
        self.textures.insert(key, index);
        Ok(Some(index))
    }

    fn image(&mut self, image: &gltf::Image, space: ColorSpace) -> Result<Arc<Image>> {
        let key = (image.index(), space);
        if let Some(known) = self.images.get(&key) {
            return Ok(known.clone());
        }
        let place = format!("images[{}]", image.index());
        let document = &self.file.document;
        // The crate's own `source` takes for granted that there is one, with a type.
        let json = &document.as_json().images[image.index()];
        let view = json
            .buffer_view
            .and_then(|view| document.views().nth(view.value()));
        let read;
        let bytes = match (&json.uri, view) {
            (Some(uri), _) => {
                read = self.file.resource(uri, LARGEST, &place)?;
                self.hasher.update(&read);
                &read
            }
            (None, Some(view)) => self.file.view(&view)?,
            (None, None) => {
                let message = format!("it has neither a uri nor a bufferView; {AGAIN}");
                return Err(self.file.error(place, message));
            }
        };
        let mut decoded = image::decode(bytes, &self.file.name(&place), space)?;
        let uri = json.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
        if let Some(path) = uri.and_then(|uri| self.file.beside(uri)) {
            decoded.file = path.display().to_string();
        }
        let decoded = Arc::new(decoded);
        self.images.insert(key, decoded.clone());
        Ok(decoded)
    }
}

impl<'a> Slot<'a> {
    fn of(info: &gltf::texture::Info<'a>) -> Self {
        let transform = info.texture_transform();
        Self {
            texture: info.texture(),
            set: transform
                .as_ref()
                .and_then(|t| t.tex_coord())
                .unwrap_or(info.tex_coord()),
            transform: transform.map_or(Affine2::IDENTITY, |t| {
                affine(t.offset(), t.rotation(), t.scale())
            }),
        }
    }

    fn of_normals(info: &gltf::material::NormalTexture<'a>) -> Self {
        let json = info.extension_value("KHR_texture_transform").cloned();
        let transform: TextureTransform = json
            .and_then(|json| serde_json::from_value(json).ok())
            .unwrap_or_default();
        Self {
            texture: info.texture(),
            set: transform.tex_coord.unwrap_or(info.tex_coord()),
            transform: affine(transform.offset.0, transform.rotation.0, transform.scale.0),
        }
    }
}

/// Scaled, turned, moved (KHR_texture_transform). A turn is counter-clockwise where v points down: the extension's own
/// example, half the size and turned by 90° about (0, 1), is the lower left quarter of the image.
fn affine(offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> Affine2 {
    let (sin, cos) = (libm::sinf(rotation), libm::cosf(rotation));
    let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    Affine2::from_mat2_translation(turn * Mat2::from_diagonal(scale.into()), offset.into())
}
