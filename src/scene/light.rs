//! Light sources, eight lanes at a time: which, where, and with what density.

use super::NONE;
use super::alias::{Alias, chances};
use super::description::{self, Description, Shape};
use super::environment::Sky;
use super::luminaire::{LightX8, sphere_cone};
use super::mesh_light::{MeshLight, MeshLights};
use super::punctual::Punctuals;
use crate::lanes::{Rgbx8, Table, Vec3x8, f32x8, square, u32x8};
use crate::sampling::warp::Pair;
use crate::shape::NO_PRIMITIVE;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// The light sources of a scene; their ids are their places in the file, then comes the sky's, then those without a surface.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Position (3), radius (0 for a quad, −1 for a mesh), area (0 for a sphere), chance of being chosen, primitive id (bits;
    /// of a mesh, its first triangle's), 1 if two-sided.
    place: Table,
    /// Radiance (3), unit normal of a quad (3), 1 ÷ chance of being chosen, number of the mesh light (bits).
    radiance: Table,
    /// Edges of a quad (3, 3).
    edges: Table,
    /// The rows of the only light, in all lanes: nothing to gather.
    only: Option<LightX8>,
    /// Which id.
    choice: Alias,
    has_spheres: bool,
    has_quads: bool,
    /// The sky's chance of being chosen.
    sky_chance: f32,
    meshes: MeshLights,
    punctual: Punctuals,
}

/// A point on a light source, seen from a point of the scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightSampleX8 {
    /// Unit, towards the light.
    pub direction: Vec3x8,
    /// To the light, scene units; +∞ for the sky.
    pub distance: f32x8,
    /// Arriving radiance, were nothing between.
    pub radiance: Rgbx8,
    /// 1 ÷ density (steradians), choice of the light included; 0 where no light was found.
    pub inverse_pdf: f32x8,
    /// The light's primitive, which casts no shadow on its own light.
    pub primitive: u32x8,
    /// Mask of the lights that no ray can meet.
    pub is_punctual: f32x8,
}

impl Lights {
    /// From a description, with the id of each light's (first) primitive, the sky, and the radius of a sphere around the
    /// scene.
    pub fn new(
        description: &Description,
        ids: &[u32],
        sky: Option<&Sky>,
        scene_radius: f32,
    ) -> Self {
        let lights = &description.lights;
        let mut all = Self {
            meshes: MeshLights::new(description),
            punctual: Punctuals::new(&description.punctual, scene_radius),
            ..Self::default()
        };
        let mesh = |id: usize| all.meshes.find(id).map(|(_, mesh)| mesh);
        let mut powers: Vec<f64> = (0..lights.len())
            .map(|id| power(&lights[id], mesh(id)))
            .collect();
        if let Some(sky) = sky {
            let disk = f64::from(PI * scene_radius * scene_radius);
            powers.push(f64::from(sky.integral_luminance()) * disk);
        }
        let first_punctual = powers.len();
        powers.extend(all.punctual.powers());
        let chances = chances(&powers);

        let (mut place, mut radiance, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        for (id, ((light, primitive), &chance)) in lights.iter().zip(ids).zip(&chances).enumerate()
        {
            let mut number = NONE;
            let (at, radius, area, normal, u, v) = match (all.meshes.find(id), light.shape) {
                (Some((found, mesh)), _) => {
                    number = found;
                    (
                        Vec3::ZERO,
                        -1.0,
                        mesh.area() as f32,
                        Vec3::ZERO,
                        Vec3::ZERO,
                        Vec3::ZERO,
                    )
                }
                (None, Shape::Sphere { center, radius }) => {
                    all.has_spheres = true;
                    (center, radius, 0.0, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO)
                }
                (None, Shape::Quad { corner, u, v }) => {
                    all.has_quads = true;
                    let n = u.as_dvec3().cross(v.as_dvec3());
                    let unit = n.normalize().as_vec3();
                    (corner, 0.0, n.length() as f32, unit, u, v)
                }
                // Without a triangle.
                (None, Shape::Mesh { .. }) => Default::default(),
            };
            let (rgb, n) = (light.radiance, normal);
            let side = if light.two_sided { 1.0 } else { 0.0 };
            let id = f32::from_bits(*primitive);
            let inverse = if chance > 0.0 {
                (1.0 / chance) as f32
            } else {
                0.0
            };
            let number = f32::from_bits(number);
            place.push([at.x, at.y, at.z, radius, area, chance as f32, id, side]);
            radiance.push([rgb.r, rgb.g, rgb.b, n.x, n.y, n.z, inverse, number]);
            edges.push([u.x, u.y, u.z, v.x, v.y, v.z, 0.0, 0.0]);
        }
        all.place = Table::new(place);
        all.radiance = Table::new(radiance);
        all.edges = Table::new(edges);
        if sky.is_some() {
            all.sky_chance = chances[lights.len()] as f32;
        }
        all.punctual.choose_among_all(first_punctual, &chances);
        all.choice = Alias::new(&chances);
        if !all.is_dark() {
            let is_plain = all.meshes.is_empty() && all.punctual.is_empty() && sky.is_none();
            if chances.len() == 1 && is_plain {
                all.only = Some(all.gather(u32x8::ZERO));
            }
        }
        all
    }

    /// The lights of these ids.
    #[inline]
    fn gather(&self, id: u32x8) -> LightX8 {
        let [px, py, pz, radius, area, chance, primitive, two_sided] = self.place.gather(id);
        let [r, g, b, nx, ny, nz, inverse_chance, mesh] = self.radiance.gather(id);
        let [ux, uy, uz, vx, vy, vz, ..] = if self.has_quads {
            self.edges.gather(id)
        } else {
            [f32x8::ZERO; 8]
        };
        LightX8 {
            position: Vec3x8::new(px, py, pz),
            radius,
            area,
            chance,
            inverse_chance,
            primitive: primitive.to_bits(),
            two_sided: two_sided.simd_gt(f32x8::ZERO),
            radiance: Rgbx8::new(r, g, b),
            mesh: mesh.to_bits(),
            normal: Vec3x8::new(nx, ny, nz),
            u: Vec3x8::new(ux, uy, uz),
            v: Vec3x8::new(vx, vy, vz),
        }
    }

    /// Whether no light can be chosen: next-event estimation finds nothing.
    pub fn is_dark(&self) -> bool {
        self.choice.is_empty()
    }

    /// Whether [`Lights::sample`] looks at the second number of its choice.
    pub fn has_meshes(&self) -> bool {
        !self.meshes.is_empty()
    }

    /// The lights that no ray can meet.
    pub fn punctual(&self) -> &Punctuals {
        &self.punctual
    }

    /// A light chosen by power, and a point of it, as seen from `from`. The second number of `choice` counts only
    /// [for meshes](Lights::has_meshes).
    #[inline]
    pub fn sample(
        &self,
        sky: Option<&Sky>,
        from: Vec3x8,
        choice: impl FnOnce() -> Pair,
        point: Pair,
    ) -> LightSampleX8 {
        let (id, gathered);
        let mut triangle = (f32x8::ZERO, f32x8::ZERO);
        let light = match &self.only {
            Some(only) => {
                id = u32x8::ZERO;
                only
            }
            None => {
                let choice = choice();
                let rest;
                (id, rest) = self.choice.choose(choice.0);
                if self.has_meshes() {
                    triangle = (choice.1, rest);
                }
                gathered = self.gather(id);
                &gathered
            }
        };
        let mut sample = LightSampleX8 {
            direction: Vec3x8::Z,
            distance: f32x8::splat(f32::INFINITY),
            radiance: light.radiance,
            inverse_pdf: f32x8::ZERO,
            primitive: light.primitive,
            is_punctual: f32x8::ZERO,
        };
        if self.has_spheres {
            (sample.direction, sample.distance, sample.inverse_pdf) =
                light.point_of_sphere(from, point);
        }
        if self.has_quads {
            let is_quad = light.radius.simd_eq(f32x8::ZERO);
            let (direction, distance, inverse_pdf) = light.point_of_quad(from, point);
            sample.direction = Vec3x8::select(is_quad, direction, sample.direction);
            sample.distance = is_quad.select(distance, sample.distance);
            sample.inverse_pdf = is_quad.select(inverse_pdf, sample.inverse_pdf);
        }
        if self.has_meshes() {
            let is_mesh = light.radius.simd_lt(f32x8::ZERO);
            // What was chosen may be no light of the table, but the sky, say.
            let is_mesh = is_mesh & self.is_of_table(id);
            if is_mesh.any() {
                let s = self.meshes.sample(is_mesh, light.mesh, triangle, point);
                let (direction, distance, inverse_pdf) =
                    light.point_of_mesh(from, s.point, s.normal);
                sample.direction = Vec3x8::select(is_mesh, direction, sample.direction);
                sample.distance = is_mesh.select(distance, sample.distance);
                sample.radiance = Rgbx8::select(is_mesh, light.radiance * s.color, sample.radiance);
                sample.inverse_pdf = is_mesh.select(inverse_pdf, sample.inverse_pdf);
                let primitive = light.primitive + s.triangle;
                sample.primitive = is_mesh.select(primitive, sample.primitive);
            }
        }
        sample.inverse_pdf *= light.inverse_chance;
        if !self.punctual.is_empty() {
            self.punctual.sample_among_all(id, from, &mut sample);
        }
        if let Some(sky) = sky.filter(|_| self.sky_chance > 0.0) {
            let is_sky = f32x8::from_bits(id.simd_eq(u32x8::splat(self.place.rows().len() as u32)));
            if is_sky.any() {
                let s = sky.sample(point);
                let inverse_pdf = f32x8::ONE / (s.pdf * self.sky_chance);
                let inverse_pdf = inverse_pdf & s.pdf.simd_gt(f32x8::ZERO);
                sample.direction = Vec3x8::select(is_sky, s.direction, sample.direction);
                sample.distance = is_sky.select(f32x8::splat(f32::INFINITY), sample.distance);
                sample.radiance = Rgbx8::select(is_sky, s.radiance, sample.radiance);
                sample.inverse_pdf = is_sky.select(inverse_pdf, sample.inverse_pdf);
                sample.primitive = is_sky.select(u32x8::splat(NO_PRIMITIVE), sample.primitive);
            }
        }
        sample
    }

    /// What a ray that meets light `id` at `distance` sees of it, and the density with which [`Lights::sample`] would have
    /// drawn that point, per steradian. `direction` is unit.
    #[inline]
    pub fn emitted(
        &self,
        id: u32x8,
        origin: Vec3x8,
        direction: Vec3x8,
        distance: f32x8,
    ) -> (Rgbx8, f32x8) {
        let light = self.gather(id);
        let squared = (light.position - origin).length_squared();
        let (spread, outside) = sphere_cone(square(light.radius) / squared);
        let facing = -direction.dot(light.normal);
        let is_quad = light.radius.simd_eq(f32x8::ZERO);
        let inverse_pdf =
            is_quad.select(facing.abs() * light.area / square(distance), spread * TAU);
        let front = is_quad.select(facing.simd_gt(f32x8::ZERO), outside);
        (
            light.radiance.masked(front | light.two_sided),
            light.chance / inverse_pdf,
        )
    }

    /// The same of a triangle of mesh light `id`, whose outward unit normal and texture coordinates are given.
    #[inline]
    pub fn emitted_by_mesh(
        &self,
        id: u32x8,
        direction: Vec3x8,
        distance: f32x8,
        normal: Vec3x8,
        uv: Pair,
    ) -> (Rgbx8, f32x8) {
        let light = self.gather(id);
        let facing = -direction.dot(normal);
        let inverse_pdf = facing.abs() * light.area / square(distance);
        let front = facing.simd_gt(f32x8::ZERO);
        let color = self.meshes.color(light.mesh, uv);
        (
            (light.radiance * color).masked(front | light.two_sided),
            light.chance / inverse_pdf,
        )
    }

    /// What a ray that leaves the scene sees, and the density with which [`Lights::sample`] would have drawn that direction,
    /// per steradian.
    #[inline]
    pub fn sky(&self, sky: &Sky, direction: Vec3x8) -> (Rgbx8, f32x8) {
        let (radiance, pdf) = sky.radiance_and_pdf(direction);
        (radiance, pdf * self.sky_chance)
    }

    /// Mask of the ids that are no sky's and no punctual light's.
    #[inline]
    fn is_of_table(&self, id: u32x8) -> f32x8 {
        f32x8::from_bits(id.simd_lt(u32x8::splat(self.place.rows().len() as u32)))
    }
}

impl LightSampleX8 {
    /// Density of the direction, per steradian, choice of the light included; 0 where no light was found.
    pub fn pdf(&self) -> f32x8 {
        (f32x8::ONE / self.inverse_pdf) & self.inverse_pdf.simd_gt(f32x8::ZERO)
    }
}

/// Emitted power by luminance, W.
fn power(light: &description::Light, mesh: Option<&MeshLight>) -> f64 {
    let area = match light.shape {
        Shape::Sphere { radius, .. } => 4.0 * f64::from(PI) * f64::from(radius).powi(2),
        Shape::Quad { u, v, .. } if mesh.is_none() => u.as_dvec3().cross(v.as_dvec3()).length(),
        Shape::Quad { .. } | Shape::Mesh { .. } => mesh.map_or(0.0, MeshLight::area),
    };
    let sides = if light.two_sided { 2.0 } else { 1.0 };
    let luminance = mesh.map_or(light.radiance, |mesh| mesh.mean_radiance(light.radiance));
    f64::from(luminance.luminance()) * area * sides * f64::from(PI)
}
