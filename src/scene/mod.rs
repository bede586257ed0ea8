//! Floor 3: scenes. A loader reads a file into a [`description::Description`]; [`Scene::compile`] turns that into the
//! immutable tables that the kernels read.

mod alias;
pub mod builtin;
pub mod cache;
pub mod camera;
mod cells;
pub mod description;
pub mod environment;
mod exr;
pub mod framing;
pub mod gltf;
pub mod harmonics;
mod hash;
mod hull;
pub mod image;
pub mod lat_long;
pub mod light;
mod lines;
mod luminaire;
pub mod maps;
pub mod mesh;
mod mesh_light;
pub mod meshes;
pub mod obj;
pub mod pbrt;
pub mod ply;
mod punctual;
pub mod sensor;
pub mod surface;
pub mod toml;
pub mod trees;

use crate::bvh::Quality;
use crate::lanes::{Rgb, Table, Vec3x8, f32x8, u32x8};
use crate::material::Kind;
use crate::shape::{Room, Shapes};
use description::{Description, Punctual, Shape};
use environment::Sky;
use glam::Vec3;
use hull::{add, bounding_radius, enclosing_room, is_hull, normal};
use light::Lights;
use meshes::Meshes;
use trees::Trees;

/// The id of no material and of no light.
pub const NONE: u32 = u32::MAX;

/// A compiled scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Everything that a ray can meet.
    pub shapes: Shapes,
    /// The room that encloses everything, if nothing passes through its walls, and what is in it.
    pub room: Option<(Room, Shapes)>,
    /// What can stand between two points of the scene: all shapes but those that have the whole scene on one side.
    pub blockers: Shapes,
    /// All other shapes: they can only stand between the scene and its sky.
    pub hull: Shapes,
    /// The shapes that emit.
    pub emitters: Shapes,
    /// All that is made of triangles; shapes above are not.
    pub meshes: Option<Meshes>,
    /// Parameters of the materials.
    pub materials: Table,
    /// The material kinds that occur, ascending.
    pub kinds: Vec<Kind>,
    /// The light sources.
    pub lights: Lights,
    /// What surrounds the scene.
    pub sky: Option<Sky>,
    /// Reflectance of each material, for the albedo layer.
    albedos: Vec<Rgb>,
    /// A primitive: centre of a sphere or normal of a quad (3), 1 / radius or 0, material, light, kind (bits).
    surfaces: Table,
}

/// What a ray met: the primitive at each lane's hit point.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceX8 {
    /// Unit, world space, outwards.
    pub normal: Vec3x8,
    /// Material id, or [`NONE`].
    pub material: u32x8,
    /// Light id, or [`NONE`].
    pub light: u32x8,
    /// The material's [`Kind`] as a number, or [`NONE`].
    pub kind: u32x8,
}

impl Scene {
    /// Compiles a description.
    pub fn compile(description: &Description) -> Self {
        Self::compile_with(description, Quality::default())
    }

    /// The same with trees built by choice, on the threads of the current rayon pool.
    pub fn compile_with(description: &Description, quality: Quality) -> Self {
        Self::compile_sharing(description, quality, &mut Trees::default())
    }

    /// The same, with trees of scenes before it that have the same meshes in the same places.
    pub fn compile_sharing(description: &Description, quality: Quality, trees: &mut Trees) -> Self {
        let (sources, placed) = meshes::place(description);
        let (meshes, mut light_ids) = Meshes::compile(description, sources, placed, quality, trees);
        let primitives: Vec<Primitive> = numbered_primitives(description).collect();
        let shapes: Vec<Shape> = primitives.iter().map(|primitive| primitive.0).collect();

        let sky = description.environment.as_ref().map(Sky::compile);
        let mut scene = Self {
            shapes: Shapes::default(),
            room: None,
            blockers: Shapes::default(),
            hull: Shapes::default(),
            emitters: Shapes::default(),
            meshes,
            materials: Table::default(),
            kinds: Vec::new(),
            lights: Lights::default(),
            sky,
            albedos: Vec::new(),
            surfaces: Table::default(),
        };
        let corners = scene.meshes.iter().flat_map(|meshes| meshes.corners);
        let corners: Vec<Vec3> = corners.collect();
        // A wall between a lamp and the scene is no hull.
        let lamps = description.punctual.iter().filter_map(Punctual::position);
        let points: Vec<Vec3> = corners.iter().copied().chain(lamps).collect();
        let hull: Vec<bool> = shapes
            .iter()
            .map(|&shape| is_hull(shape, &shapes, &points))
            .collect();
        let transmits = |material: usize| {
            let kind = description.materials[material].material.kind();
            kind.transmits()
        };
        let leaky = primitives
            .iter()
            .zip(&hull)
            .any(|(primitive, &is_wall)| is_wall && primitive.1.is_some_and(transmits));
        if !leaky {
            scene.room = enclosing_room(&shapes, &hull);
        }
        let mut surfaces = Vec::new();
        let lone = description.lights.len() == 1 && description.punctual.is_empty();
        for (id, (shape, material, light)) in primitives.into_iter().enumerate() {
            let primitive = id as u32;
            add(&mut scene.shapes, shape, primitive);
            // The only light casts no shadow on its own light, and there is no other.
            let only_light = light.is_some() && lone;
            let blocks = !hull[id] && !only_light;
            let part = if blocks {
                &mut scene.blockers
            } else {
                &mut scene.hull
            };
            add(part, shape, primitive);
            if let Some(light) = light {
                add(&mut scene.emitters, shape, primitive);
                light_ids[light] = primitive;
            }
            let kind = material.map(|id| description.materials[id].material.kind());
            scene.kinds.extend(kind);
            let bits = |id: Option<usize>| f32::from_bits(id.map_or(NONE, |id| id as u32));
            let (at, inverse_radius) = match shape {
                Shape::Sphere { center, radius } => (center, 1.0 / radius),
                Shape::Quad { u, v, .. } => (normal(u, v).as_vec3(), 0.0),
                Shape::Mesh { .. } => continue,
            };
            surfaces.push([
                at.x,
                at.y,
                at.z,
                inverse_radius,
                bits(material),
                bits(light),
                bits(kind.map(|kind| kind as usize)),
                0.0,
            ]);
        }
        scene.surfaces = Table::new(surfaces);
        scene.kinds.sort();
        scene.kinds.dedup();
        let rows = description
            .materials
            .iter()
            .map(|named| named.material.row());
        scene.materials = Table::new(rows.collect());
        scene.albedos = description
            .materials
            .iter()
            .map(|named| named.material.albedo())
            .collect();
        let radius = bounding_radius(&shapes, &corners);
        scene.lights = Lights::new(description, &light_ids, scene.sky.as_ref(), radius);
        scene
    }

    /// The closest hit of rays that start where [`Scene::encloses`] them, as [`Shapes::closest`].
    #[inline]
    pub fn closest(&self, origin: Vec3x8, direction: Vec3x8) -> (f32x8, u32x8) {
        match &self.room {
            Some((room, contents)) => {
                room.leave(origin, direction, contents.closest(origin, direction))
            }
            None => self.shapes.closest(origin, direction),
        }
    }

    /// Whether rays from this point, and all that follow them, may be traced by [`Scene::closest`]: no path leaves a room.
    pub fn encloses(&self, point: Vec3) -> bool {
        self.room
            .as_ref()
            .is_none_or(|(room, _)| room.contains(point))
    }

    /// What the albedo layer shows of a material: its reflectance; white for a source that does not scatter.
    pub fn albedo(&self, material: u32) -> Rgb {
        self.albedos
            .get(material as usize)
            .copied()
            .unwrap_or(Rgb::WHITE)
    }

    /// The surface of a primitive at a point of it.
    #[inline]
    pub fn surface(&self, primitive: u32x8, point: Vec3x8) -> SurfaceX8 {
        let [x, y, z, inverse_radius, material, light, kind, _] = self.surfaces.gather(primitive);
        let at = Vec3x8::new(x, y, z);
        let is_quad = inverse_radius.simd_eq(f32x8::ZERO);
        // Renormalised: a hit is off the sphere by rounding, a normal that is not unit makes the next direction longer and the
        // next hit further off. Inside a sphere that grew fourfold with every bounce.
        SurfaceX8 {
            normal: Vec3x8::select(is_quad, at, ((point - at) * inverse_radius).renormalize()),
            material: material.to_bits(),
            light: light.to_bits(),
            kind: kind.to_bits(),
        }
    }
}

/// A shape, its material and its light.
pub type Primitive = (Shape, Option<usize>, Option<usize>);

/// The spheres and quads, by id; what is made of triangles has ids from [`meshes::TRIANGLE`] up.
pub fn numbered_primitives(description: &Description) -> impl Iterator<Item = Primitive> {
    primitives(description).filter(|primitive| !meshes::is_mesh(description, primitive))
}

/// Everything that has a shape: objects, then lights.
fn primitives(description: &Description) -> impl Iterator<Item = Primitive> {
    let objects = description
        .objects
        .iter()
        .map(|object| (object.shape, Some(object.material), None));
    let lights = description.lights.iter().enumerate();
    let lights = lights.map(|(id, light)| (light.shape, light.material, Some(id)));
    objects.chain(lights)
}
