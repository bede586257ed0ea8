//! Meshes that emit: points of them, uniform over their area.
//!
//! A mesh is one light, whose triangles are chosen by area. Its density is then the same everywhere, and what a ray that
//! meets it has to know is the area of the whole alone.

use super::NONE;
use super::alias::alias_table;
use super::description::Description;
use super::maps::MapTable;
use super::mesh::Mesh;
use super::meshes::Cover;
use super::surface::TriangleX8;
use crate::lanes::{Rgb, Rgbx8, Vec3x8, WIDTH, f32x8, u32x8};
use crate::sampling::warp::{self, Pair};
use crate::texture::Textures;
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The lights that are meshes.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshLights {
    /// By number, with the ids of their lights, ascending.
    lights: Vec<(usize, MeshLight)>,
    textures: Option<Textures>,
    /// Where there are lights with holes, those.
    holes: Option<MapTable>,
}

/// A light that is a mesh.
#[derive(Clone, Debug)]
pub(super) struct MeshLight {
    mesh: Arc<Mesh>,
    to_world: Affine3A,
    /// −1 where the place mirrors.
    outwards: f32,
    /// Scene units squared, of all triangles.
    area: f64,
    /// Walker's alias table over the triangles, by area.
    columns: Vec<(f32, u32)>,
    /// Id of the emission texture, or [`NONE`], and its mean.
    texture: u32,
    mean: Rgb,
    /// Id of the material, where that has holes, or [`NONE`].
    pierced: u32,
}

/// Points of mesh lights.
pub(super) struct MeshPointX8 {
    /// World space.
    pub point: Vec3x8,
    /// Unit, outwards.
    pub normal: Vec3x8,
    /// Index in the mesh.
    pub triangle: u32x8,
    /// What multiplies the radiance.
    pub color: Rgbx8,
}

impl MeshLights {
    pub fn new(description: &Description) -> Self {
        let (sources, placed) = super::meshes::place(description);
        let mut means = HashMap::new();
        let mut mean = |id: usize| {
            let image = &description.textures[id].image;
            *means.entry(id).or_insert_with(|| image.mean())
        };
        let lights: Vec<(usize, MeshLight)> = placed
            .into_iter()
            .filter_map(|part| {
                let id = part.light?;
                let texture = description.lights[id].texture;
                let mean = texture.map_or(Rgb::WHITE, &mut mean);
                let bits = |id: Option<usize>| id.map_or(NONE, |id| id as u32);
                let has_holes = Cover::of(description, part.material) == Cover::Masked;
                let mesh = Arc::clone(&sources[part.mesh]);
                let light = MeshLight {
                    texture: bits(texture),
                    mean,
                    pierced: bits(part.material.filter(|_| has_holes)),
                    ..MeshLight::new(mesh, part.to_world)
                };
                Some((id, light))
            })
            .collect();
        let textured = lights.iter().any(|(_, light)| light.texture != NONE);
        let pierced = lights.iter().any(|(_, light)| light.pierced != NONE);
        Self {
            lights,
            holes: MapTable::of(description).filter(|_| pierced),
            textures: textured.then(|| Textures::new(description.textures.clone())),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// The mesh light of a light of the description, and its number here.
    pub fn find(&self, light: usize) -> Option<(u32, &MeshLight)> {
        let number = self
            .lights
            .binary_search_by_key(&light, |(id, _)| *id)
            .ok()?;
        Some((number as u32, &self.lights[number].1))
    }

    /// Points of the lights of these numbers, in the lanes of `mask`; each a triangle by two numbers, the first the finer.
    #[inline]
    pub fn sample(&self, mask: f32x8, numbers: u32x8, choice: Pair, point: Pair) -> MeshPointX8 {
        let mask = mask.to_bitmask();
        let numbers_of = numbers.to_array();
        let (coarse, fine) = (choice.0.to_array(), choice.1.to_array());
        let mut triangles = [0; WIDTH];
        let mut outwards = [1.0; WIDTH];
        let mut corners = [[[0.0; WIDTH]; 3]; 3];
        let mut uvs = [[[0.0; WIDTH]; 2]; 3];
        for lane in (0..WIDTH).filter(|lane| mask >> lane & 1 == 1) {
            let light = &self.lights[numbers_of[lane] as usize].1;
            let triangle = light.choose(coarse[lane], fine[lane]);
            triangles[lane] = triangle;
            outwards[lane] = light.outwards;
            for (i, vertex) in light.mesh.triangles[triangle as usize]
                .into_iter()
                .enumerate()
            {
                let vertex = vertex as usize;
                let p = light
                    .to_world
                    .transform_point3(light.mesh.positions[vertex]);
                let [x, y, z] = &mut corners[i];
                [x[lane], y[lane], z[lane]] = p.to_array();
                if let Some(uv) = light.mesh.uvs.get(vertex) {
                    [uvs[i][0][lane], uvs[i][1][lane]] = uv.to_array();
                }
            }
        }
        let corners = corners.map(|p| {
            let [x, y, z] = p.map(f32x8::new);
            Vec3x8::new(x, y, z)
        });
        let triangle = TriangleX8::new(corners, f32x8::new(outwards));
        let (b, c) = warp::uniform_triangle(point);
        let [p, q, r] = uvs.map(|uv| uv.map(f32x8::new));
        let along = |i: usize| (q[i] - p[i]).mul_add(b, (r[i] - p[i]).mul_add(c, p[i]));
        let uv = (along(0), along(1));
        let mut color = self.color(numbers, uv);
        if let Some(holes) = &self.holes {
            let pierced = self.ids(numbers, |light| light.pierced);
            let whole = f32x8::from_bits(pierced.simd_eq(u32x8::splat(NONE)));
            color = color.masked(whole | holes.is_there(pierced, uv));
        }
        MeshPointX8 {
            point: triangle.at(b, c),
            normal: triangle.normal.normalize(),
            triangle: u32x8::new(triangles),
            color,
        }
    }

    /// What the textures of the lights of these numbers multiply their radiance by.
    #[inline]
    pub fn color(&self, numbers: u32x8, (u, v): Pair) -> Rgbx8 {
        let Some(textures) = &self.textures else {
            return Rgbx8::ONE;
        };
        textures.color(self.ids(numbers, |light| light.texture), u, v)
    }

    /// An id of each of these lights; [`NONE`] for a number of none.
    #[inline]
    fn ids(&self, numbers: u32x8, id: impl Fn(&MeshLight) -> u32) -> u32x8 {
        let of = |number: u32| {
            let light = self.lights.get(number as usize);
            light.map_or(NONE, |(_, light)| id(light))
        };
        u32x8::new(numbers.to_array().map(of))
    }
}

impl MeshLight {
    /// White, without holes.
    fn new(mesh: Arc<Mesh>, to_world: Affine3A) -> Self {
        let corner = |c: u32| to_world.transform_point3(mesh.positions[c as usize]);
        let areas = mesh.triangles.iter().map(|&t| area(t.map(corner)));
        let area: f64 = areas.clone().sum();
        let per_area = if area > 0.0 { 1.0 / area } else { 0.0 };
        let chances: Vec<f64> = areas.map(|each| each * per_area).collect();
        Self {
            columns: alias_table(&chances),
            outwards: 1f32.copysign(to_world.matrix3.determinant()),
            texture: NONE,
            mean: Rgb::WHITE,
            pierced: NONE,
            area,
            mesh,
            to_world,
        }
    }

    /// Of all triangles, scene units squared.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Radiance times the mean of its texture.
    pub fn mean_radiance(&self, radiance: Rgb) -> Rgb {
        let Rgb { r, g, b } = self.mean;
        Rgb::new(radiance.r * r, radiance.g * g, radiance.b * b)
    }

    /// A triangle by area, from two numbers in [0, 1): the first leads, the second takes over where its 23 bits end, for
    /// there may be more triangles than those can tell apart.
    #[inline]
    fn choose(&self, first: f32, second: f32) -> u32 {
        const BITS: u32 = 23;
        let digits = |u: f32| (u * (1u32 << BITS) as f32) as u64 & ((1 << BITS) - 1);
        let all = u128::from(digits(first) << BITS | digits(second));
        let scaled = all * self.columns.len() as u128;
        let column = (scaled >> (2 * BITS)) as usize;
        let within = (scaled as u64 & ((1 << (2 * BITS)) - 1)) as f32 / (1u64 << (2 * BITS)) as f32;
        let (threshold, alias) = self.columns[column];
        if within < threshold {
            column as u32
        } else {
            alias
        }
    }
}

/// Area of a triangle of the world.
fn area([a, b, c]: [Vec3; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    0.5 * (b - a).cross(c - a).length()
}
