//! Eight texture look-ups at a time, each lane in a texture of its own.

use super::{Texture, Wrap};
use crate::lanes::{Rgbx8, Table, Vec3x8, WIDTH, f32x8, u32x8};

/// The greatest f32 below 1.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// Least z of a tangent-space normal before it is made unit: normals stay above the surface.
const MIN_NORMAL_Z: f32 = 1e-3;

/// The textures of a scene, by id.
///
/// An id of no texture, such as `u32::MAX`, reads 1 in every channel, so that what a texture multiplies stays as it is.
/// Coordinates may be anything; what is not a number reads as 0.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    textures: Vec<Texture>,
    /// A texture's transform by column, and its size in pixels.
    places: Table,
    /// Masks of a texture: whether it repeats by u and v, is mirrored by u and v, is read at the nearest texel.
    modes: Table,
}

/// Where eight look-ups fall along one side of their images.
struct Side {
    /// The texels before and after.
    texels: [[u32; WIDTH]; 2],
    /// How far it is from the first to the second, in [0, 1].
    between: [f32; WIDTH],
}

impl Textures {
    /// From textures; their ids are their places.
    pub fn new(textures: Vec<Texture>) -> Self {
        let place = |texture: &Texture| {
            let [a, b, c, d, x, y] = texture.transform.to_cols_array();
            let (width, height) = (texture.image.width, texture.image.height);
            [a, b, c, d, x, y, width as f32, height as f32]
        };
        let mode = |texture: &Texture| {
            let mask = |on: bool| f32::from_bits(if on { u32::MAX } else { 0 });
            let [u, v] = texture.wrap;
            let [repeat_u, repeat_v, mirror_u, mirror_v] = [
                u == Wrap::Repeat,
                v == Wrap::Repeat,
                u == Wrap::Mirror,
                v == Wrap::Mirror,
            ]
            .map(mask);
            let nearest = mask(texture.nearest);
            [
                repeat_u, repeat_v, mirror_u, mirror_v, nearest, 0.0, 0.0, 0.0,
            ]
        };
        Self {
            places: Table::new(textures.iter().map(place).collect()),
            modes: Table::new(textures.iter().map(mode).collect()),
            textures,
        }
    }

    /// Linear colour and alpha at texture coordinates of the mesh.
    #[inline]
    pub fn sample(&self, ids: u32x8, u: f32x8, v: f32x8) -> (Rgbx8, f32x8) {
        let [r, g, b, a] = self.look_up(ids, u, v, |texel| texel);
        (Rgbx8::new(r, g, b), a)
    }

    /// The colour of [`Textures::sample`] alone.
    #[inline]
    pub fn color(&self, ids: u32x8, u: f32x8, v: f32x8) -> Rgbx8 {
        let [r, g, b] = self.look_up(ids, u, v, |[r, g, b, _]| [r, g, b]);
        Rgbx8::new(r, g, b)
    }

    /// The alpha of [`Textures::sample`] alone.
    #[inline]
    pub fn alpha(&self, ids: u32x8, u: f32x8, v: f32x8) -> f32x8 {
        let [a] = self.look_up(ids, u, v, |[_, _, _, a]| [a]);
        a
    }

    /// Roughness and metallic, green and blue, as glTF packs them (2.0, sec. 3.9.2).
    #[inline]
    pub fn roughness_metallic(&self, ids: u32x8, u: f32x8, v: f32x8) -> (f32x8, f32x8) {
        let [roughness, metallic] = self.look_up(ids, u, v, |[_, g, b, _]| [g, b]);
        (roughness, metallic)
    }

    /// Unit normals in tangent space, z > 0: `(2 rgb − 1) · (scale, scale, 1)` (glTF 2.0, sec. 3.9.3); +z where there is no
    /// texture.
    #[inline]
    pub fn normal(&self, ids: u32x8, scale: f32x8, u: f32x8, v: f32x8) -> Vec3x8 {
        let Rgbx8 { r, g, b } = self.color(ids, u, v);
        let signed = |c: f32x8| c.mul_sub(f32x8::splat(2.0), f32x8::ONE);
        let z = signed(b).fast_max(f32x8::splat(MIN_NORMAL_Z));
        let normal = Vec3x8::new(signed(r) * scale, signed(g) * scale, z).normalize();
        let known = f32x8::from_bits(ids.simd_lt(u32x8::splat(self.textures.len() as u32)));
        Vec3x8::select(known, normal, Vec3x8::Z)
    }

    /// What `pick` takes of each texel, interpolated.
    #[inline]
    fn look_up<const N: usize>(
        &self,
        ids: u32x8,
        u: f32x8,
        v: f32x8,
        pick: impl Fn([f32; 4]) -> [f32; N],
    ) -> [f32x8; N] {
        let [a, b, c, d, x, y, width, height] = self.places.gather(ids);
        let [repeat_u, repeat_v, mirror_u, mirror_v, nearest, ..] = self.modes.gather(ids);
        let (u, v) = (a.mul_add(u, c.mul_add(v, x)), b.mul_add(u, d.mul_add(v, y)));
        let across = Side::of(u, width, repeat_u, mirror_u, nearest);
        let down = Side::of(v, height, repeat_v, mirror_v, nearest);

        let mut picked = [[1.0; WIDTH]; N];
        for (lane, id) in ids.to_array().into_iter().enumerate() {
            let Some(texture) = self.textures.get(id as usize) else {
                continue;
            };
            let image = &*texture.image;
            let row = |row: usize| {
                let first = down.texels[row][lane] as usize * image.width;
                let [left, right] = across.texels.map(|texels| {
                    let texel = image.pixels.get(first + texels[lane] as usize);
                    texel.map_or([1.0; N], &pick)
                });
                mix(left, right, across.between[lane])
            };
            let mixed = mix(row(0), row(1), down.between[lane]);
            for (picked, mixed) in picked.iter_mut().zip(mixed) {
                picked[lane] = mixed;
            }
        }
        picked.map(f32x8::new)
    }
}

/// From `a` to `b`, exact where they are equal.
#[inline]
fn mix<const N: usize>(a: [f32; N], b: [f32; N], t: f32) -> [f32; N] {
    std::array::from_fn(|i| (b[i] - a[i]).mul_add(t, a[i]))
}

impl Side {
    /// The texels to both sides of a coordinate, along a side of `size` texels, whose centres are at halves.
    #[inline]
    fn of(coordinate: f32x8, size: f32x8, repeat: f32x8, mirror: f32x8, nearest: f32x8) -> Self {
        // What is left of a large number when a whole number near it is taken away is exact.
        let repeated = coordinate - coordinate.floor();
        let pair = coordinate - (coordinate * 0.5).floor() * 2.0;
        let mirrored = pair.fast_min(f32x8::splat(2.0) - pair);
        let inside = repeat.select(repeated, mirror.select(mirrored, coordinate));
        // What is not a number becomes 0; what rounded up to 1 falls into the last texel.
        let inside = inside & inside.simd_gt(f32x8::ZERO);
        let inside = inside.fast_min(f32x8::splat(BELOW_ONE));

        let at = inside.mul_sub(size, nearest.select(f32x8::ZERO, f32x8::HALF));
        let before = at.floor();
        let after = before + f32x8::ONE;
        let last = size - f32x8::ONE;
        // Beyond the border is the other border or, mirrored and clamped, the same one.
        let low = repeat.select(last, f32x8::ZERO);
        let high = repeat.select(f32x8::ZERO, last);
        let texels = [
            before.simd_lt(f32x8::ZERO).select(low, before),
            after.simd_gt(last).select(high, after),
        ];
        Self {
            texels: texels.map(|texel| texel.to_array().map(|texel| texel as u32)),
            between: nearest.select(f32x8::ZERO, at - before).to_array(),
        }
    }
}
