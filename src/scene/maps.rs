//! Textures of materials, eight lanes at a time.

use super::NONE;
use super::description::{Description, Maps};
use super::surface::MappedX8;
use crate::lanes::{Table, Vec3x8, f32x8, u32x8};
use crate::texture::Textures;

/// The maps of each material of a scene.
#[derive(Clone, Debug)]
pub struct MapTable {
    textures: Textures,
    /// Ids of colour, roughness and normal textures, the factor of normals; id of the alpha texture, its factor, the
    /// cut-off.
    rows: Table,
    /// The linear part of the normal texture's transform, by column.
    turns: Table,
    bends: bool,
}

type Uv = (f32x8, f32x8);

impl MapTable {
    /// None where no material has a map.
    pub(super) fn of(description: &Description) -> Option<Self> {
        let all = || description.materials.iter().map(|named| &named.maps);
        if all().all(|maps| *maps == Maps::default()) {
            return None;
        }
        let bits = |id: Option<usize>| f32::from_bits(id.map_or(NONE, |id| id as u32));
        let row = |maps: &Maps| {
            let (normal, scale) = maps
                .normal
                .map_or((None, 1.0), |(id, scale)| (Some(id), scale));
            let (alpha, factor, cutoff) = maps.alpha.map_or((None, 1.0, 0.0), |alpha| {
                (alpha.texture, alpha.factor, alpha.cutoff)
            });
            let (color, rough) = (bits(maps.color), bits(maps.metallic_roughness));
            let (normal, alpha) = (bits(normal), bits(alpha));
            [color, rough, normal, scale, alpha, factor, cutoff, 0.0]
        };
        let turn = |maps: &Maps| {
            let matrix = maps.normal.map_or(glam::Mat2::IDENTITY, |(id, _)| {
                description.textures[id].transform.matrix2
            });
            let [a, b, c, d] = matrix.to_cols_array();
            [a, b, c, d, 0.0, 0.0, 0.0, 0.0]
        };
        Some(Self {
            textures: Textures::new(description.textures.clone()),
            rows: Table::new(all().map(row).collect()),
            turns: Table::new(all().map(turn).collect()),
            bends: all().any(|maps| maps.normal.is_some()),
        })
    }

    /// What the colour and the metallic-roughness texture say.
    #[inline]
    pub fn look_up(&self, material: u32x8, (u, v): Uv) -> MappedX8 {
        let [color, rough, ..] = self.rows.gather(material);
        let (roughness, metallic) = self.textures.roughness_metallic(rough.to_bits(), u, v);
        MappedX8 {
            color: self.textures.color(color.to_bits(), u, v),
            roughness,
            metallic,
        }
    }

    /// Mask of the points whose alpha reaches the cut-off.
    #[inline]
    pub fn is_there(&self, material: u32x8, (u, v): Uv) -> f32x8 {
        let [_, _, _, _, texture, factor, cutoff, _] = self.rows.gather(material);
        let alpha = self.textures.alpha(texture.to_bits(), u, v) * factor;
        alpha.simd_ge(cutoff)
    }

    /// Normals as the normal map has them around `ns`; `ns` where there is none, or no direction of u.
    ///
    /// `tangents` are dp/du and dp/dv of the mesh's coordinates. The map's y is up in its image, where v grows downwards.
    #[inline]
    pub(super) fn bend(
        &self,
        material: u32x8,
        (u, v): Uv,
        ns: Vec3x8,
        tangents: impl FnOnce() -> [Vec3x8; 2],
    ) -> Vec3x8 {
        if !self.bends {
            return ns;
        }
        let [_, _, texture, scale, ..] = self.rows.gather(material);
        let texture = texture.to_bits();
        let local = self.textures.normal(texture, scale, u, v);
        // By the image's coordinates s, t: dp/ds = (dp/du dt/dv − dp/dv dt/du) / det, and so on.
        let [du, dv] = tangents();
        let [a, b, c, d, ..] = self.turns.gather(material);
        let sign = f32x8::ONE.copysign(a.mul_sub(d, b * c));
        let (ds, dt) = ((du * d - dv * b) * sign, (dv * a - du * c) * sign);
        let along = ds - ns * ds.dot(ns);
        let along = along * (f32x8::ONE / along.max_abs());
        let along = along.normalize();
        let up = ns.cross(along);
        let up = up * f32x8::ONE.copysign(-up.dot(dt));
        let bent = along
            .mul_add(local.x, up.mul_add(local.y, ns * local.z))
            .normalize();
        let mapped = f32x8::from_bits(texture.simd_ne(u32x8::splat(NONE)));
        let valid = bent.length_squared().simd_gt(f32x8::ZERO);
        Vec3x8::select(mapped & valid, bent, ns)
    }
}
