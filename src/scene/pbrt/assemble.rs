//! From what the file says to the description: materials made, objects put in their places.

use super::gallery::{Gallery, Use};
use super::lexer::At;
use super::library::Surface;
use super::materials::Studio;
use super::names::undefined;
use super::options::MIRROR;
use super::reader::Reader;
use super::shapes::Geometry;
use super::sky;
use super::variants::{Variant, is_sound, narrow, uniform_scale, varied};
use crate::error::{Error, Result};
use crate::lanes::Rgb;
use crate::material::Material;
use crate::scene::description::{
    Alpha, Description, FilmDescription, Light, MOST_OBJECTS, Maps, NamedCamera, NamedMaterial,
    Object, Shape,
};
use crate::scene::framing;
use crate::scene::mesh::Mesh;
use glam::{DAffine3, DVec3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Up to this many spheres and quads are what they are; more are meshes, which have a tree.
const MOST_EXACT: usize = 64;
/// Greatest coordinate of a point.
const FARTHEST: f64 = 1e9;

/// A shape of the file.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// Index into the geometries.
    pub geometry: usize,
    pub to_world: DAffine3,
    /// Whether its normals are turned round.
    pub reverse: bool,
    /// Index into the surfaces.
    pub surface: usize,
    /// Index into the area lights.
    pub light: Option<usize>,
    pub at: At,
}

/// A surface, made.
#[derive(Clone, Copy)]
enum Finish {
    /// Nothing is there.
    Absent,
    /// Index into the materials, and whether they look at UV.
    Material(usize, bool),
}

/// The world while it is put together.
pub(super) struct World {
    reader: Reader,
    gallery: Gallery,
    materials: Vec<NamedMaterial>,
    finishes: Vec<Option<Finish>>,
    meshes: Vec<Arc<Mesh>>,
    variants: HashMap<Variant, usize>,
    boxes: HashMap<usize, [DVec3; 2]>,
    exact_spheres: bool,
    exact_quads: bool,
    objects: Vec<Object>,
    lights: Vec<Light>,
    low: DVec3,
    high: DVec3,
}

pub(super) fn too_many(at: &At) -> Error {
    at.error(format!(
        "the scene has more than {MOST_OBJECTS} shapes; have fewer instances"
    ))
}

impl World {
    pub fn new(reader: Reader) -> Result<Self> {
        reader.library.finish()?;
        Ok(Self {
            gallery: Gallery::default(),
            materials: Vec::new(),
            finishes: vec![None; reader.library.surfaces.len()],
            meshes: Vec::new(),
            variants: HashMap::new(),
            boxes: HashMap::new(),
            exact_spheres: true,
            exact_quads: true,
            objects: Vec::new(),
            lights: Vec::new(),
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            reader,
        })
    }

    /// The description.
    pub fn describe(mut self, name: String) -> Result<Description> {
        let placed = std::mem::take(&mut self.reader.placed);
        let instances = std::mem::take(&mut self.reader.instances);
        let objects = std::mem::take(&mut self.reader.objects);
        let mut groups = vec![(placed.as_slice(), DAffine3::IDENTITY)];
        let mut count = placed.len();
        for (name, to_world, at) in &instances {
            let Some(object) = objects.get(name) else {
                let known = objects.keys().map(String::as_str);
                return Err(at.error(undefined("object", name, known, "add ObjectBegin")));
            };
            count += object.len();
            if count > MOST_OBJECTS {
                return Err(too_many(at));
            }
            groups.push((object, *to_world));
        }
        self.count_exact(groups.iter().flat_map(|(shapes, _)| *shapes));
        for (shapes, to_world) in groups {
            for shape in shapes {
                self.place(shape, to_world * shape.to_world)?;
            }
        }
        self.finish(name)
    }

    fn finish(mut self, name: String) -> Result<Description> {
        let Reader {
            files,
            warnings,
            view,
            film,
            infinite,
            punctual,
            ..
        } = &mut self.reader;
        let mut environment = sky::environment(infinite, files, warnings)?;
        if environment.is_none() && self.lights.is_empty() && punctual.is_empty() {
            environment = Some(framing::soft_sky());
        }
        let camera = match view {
            Some(view) => view.camera(*film, warnings)?,
            None if self.low.is_finite() => framing::frame(self.low.as_vec3(), self.high.as_vec3()),
            None => framing::frame(Vec3::NEG_ONE, Vec3::ONE),
        };
        Ok(Description {
            hash: files.digest(),
            written: None,
            name,
            cameras: vec![NamedCamera {
                name: "camera".to_owned(),
                camera,
            }],
            film: FilmDescription {
                width: film.width,
                height: film.height,
                filter: self.reader.filter,
            },
            render: self.reader.render,
            materials: self.materials,
            objects: self.objects,
            lights: self.lights,
            punctual: self.reader.punctual,
            environment,
            meshes: self.meshes,
            textures: self.gallery.textures,
            warnings: self.reader.warnings.lines,
        })
    }

    /// Few spheres and quads are what they are.
    fn count_exact<'a>(&mut self, shapes: impl Iterator<Item = &'a Placed>) {
        let (mut spheres, mut quads) = (0, 0);
        let mut sphere_at = None;
        for shape in shapes {
            match self.reader.geometries.list.get(shape.geometry) {
                Some(Geometry::Sphere(_)) => {
                    spheres += 1;
                    sphere_at = sphere_at.or(Some(&shape.at));
                }
                Some(Geometry::Mesh(_, Some(_))) => quads += 1,
                _ => {}
            }
        }
        self.exact_spheres = spheres <= MOST_EXACT;
        self.exact_quads = quads <= MOST_EXACT;
        if let (false, Some(at)) = (self.exact_spheres, sphere_at) {
            let message =
                format!("the scene has {spheres} spheres; more than {MOST_EXACT} become meshes");
            self.reader.warnings.tell(at, message);
        }
    }

    fn place(&mut self, placed: &Placed, to_world: DAffine3) -> Result<()> {
        let finish = self.surface(placed.surface)?;
        let light = placed
            .light
            .and_then(|light| self.reader.area_lights.get(light))
            .cloned();
        let light = light.filter(|light| light.radiance.max_channel() > 0.0);
        let emission = match light.as_ref().and_then(|light| light.map.as_ref()) {
            Some(map) => Some(self.gallery.add(map, Use::Color, &mut self.reader.files)?),
            None => None,
        };
        let (material, is_textured) = match finish {
            Finish::Absent => (None, false),
            Finish::Material(index, is_textured) => (Some(index), is_textured),
        };
        let Some(shape) = self.shape(placed, to_world, is_textured || emission.is_some())? else {
            return Ok(());
        };
        match (light, material) {
            (Some(light), material) => self.lights.push(Light {
                shape,
                radiance: light.radiance,
                two_sided: light.two_sided,
                material,
                texture: emission,
            }),
            (None, Some(material)) => self.objects.push(Object { shape, material }),
            (None, None) => self.reader.warnings.tell(
                &placed.at,
                "surfaces of thin glass or of nothing are left out; light passes straight through",
            ),
        }
        Ok(())
    }

    /// The shape in the world: a sphere or a quad where it is exactly one and has no image on it, else a mesh.
    fn shape(
        &mut self,
        placed: &Placed,
        to_world: DAffine3,
        is_textured: bool,
    ) -> Result<Option<Shape>> {
        let Some(geometry) = self.reader.geometries.list.get(placed.geometry).cloned() else {
            return Ok(None);
        };
        let is_mirrored = to_world.matrix3.determinant() < 0.0;
        self.check(placed, &geometry, to_world)?;
        match &geometry {
            Geometry::Sphere(_) if self.exact_spheres && !is_textured && !placed.reverse => {
                if let Some(radius) = uniform_scale(to_world) {
                    return Ok(Some(Shape::Sphere {
                        center: to_world.translation.as_vec3(),
                        radius: radius as f32,
                    }));
                }
            }
            Geometry::Mesh(_, Some([corner, u, v])) if self.exact_quads && !is_textured => {
                let edge = |edge: &Vec3| to_world.transform_vector3(edge.as_dvec3()).as_vec3();
                let (u, v) = if is_mirrored ^ placed.reverse {
                    (edge(v), edge(u))
                } else {
                    (edge(u), edge(v))
                };
                if is_sound(u, v) {
                    let corner = to_world.transform_point3(corner.as_dvec3()).as_vec3();
                    return Ok(Some(Shape::Quad { corner, u, v }));
                }
            }
            _ => {}
        }
        let variant = Variant {
            geometry: placed.geometry,
            mirrored: is_mirrored,
            reversed: placed.reverse,
            with_uvs: is_textured && geometry.mesh().uvs.is_empty(),
        };
        let mesh = match self.variants.get(&variant) {
            Some(&index) => index,
            None => {
                self.meshes.push(varied(&geometry, variant));
                self.variants.insert(variant, self.meshes.len() - 1);
                self.meshes.len() - 1
            }
        };
        let to_world = if is_mirrored {
            to_world * MIRROR
        } else {
            to_world
        };
        Ok(Some(Shape::Mesh {
            mesh,
            transform: narrow(to_world),
        }))
    }

    /// Whether a place can be rendered; the box around everything grows.
    fn check(&mut self, placed: &Placed, geometry: &Geometry, to_world: DAffine3) -> Result<()> {
        let [low, high] = *self.boxes.entry(placed.geometry).or_insert_with(|| {
            let (low, high) = geometry.mesh().bounds();
            [low.as_dvec3(), high.as_dvec3()]
        });
        let matrix = narrow(to_world);
        let determinant = matrix.matrix3.determinant();
        if !(matrix.is_finite() && determinant.abs() > 1e-30 && matrix.inverse().is_finite()) {
            return Err(placed.at.error(
                "the transformation of this shape has no inverse in 32-bit floats; remove the scale of 0, or of almost 0, before it",
            ));
        }
        for corner in 0..8 {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            let point = to_world.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
            if point.abs().max_element() > FARTHEST {
                return Err(placed.at.error(
                    "this shape reaches farther than 1e9 from the origin; scale the scene down",
                ));
            }
            self.low = self.low.min(point);
            self.high = self.high.max(point);
        }
        Ok(())
    }

    fn surface(&mut self, index: usize) -> Result<Finish> {
        if let Some(finish) = self.finishes.get(index).copied().flatten() {
            return Ok(finish);
        }
        let Some(surface) = self.reader.library.surfaces.get(index).cloned() else {
            return Ok(Finish::Absent);
        };
        let finish = self.made(&surface)?;
        if let Some(slot) = self.finishes.get_mut(index) {
            *slot = Some(finish);
        }
        Ok(finish)
    }

    fn made(&mut self, surface: &Surface) -> Result<Finish> {
        let Reader {
            library,
            textures,
            files,
            warnings,
            ..
        } = &mut self.reader;
        let definition = library.find(surface.material, warnings)?;
        let mut studio = Studio {
            textures,
            gallery: &mut self.gallery,
            files,
            warnings,
        };
        let mut material = match definition {
            Some(definition) => {
                let Some(material) = studio.material(definition)? else {
                    return Ok(Finish::Absent);
                };
                material
            }
            None => NamedMaterial {
                name: "default".to_owned(),
                material: Material::Lambert {
                    albedo: Rgb::splat(0.5),
                },
                maps: Maps::default(),
            },
        };
        if let Some((alpha, at)) = &surface.alpha {
            let value = studio.value(alpha, at)?;
            let texture = match &value.map {
                Some(map) => Some(studio.gallery.add(map, Use::Alpha, studio.files)?),
                None => None,
            };
            material.name += ", cut out";
            material.maps.alpha = Some(Alpha {
                texture,
                factor: value.factor.luminance(),
                cutoff: 0.5,
            });
        }
        let Maps {
            color,
            metallic_roughness,
            normal,
            alpha,
        } = material.maps;
        let is_textured = color.or(metallic_roughness).is_some()
            || normal.is_some()
            // A cut-out is a mesh's.
            || alpha.is_some();
        self.materials.push(material);
        Ok(Finish::Material(self.materials.len() - 1, is_textured))
    }
}
