//! From what the file says to the description: materials made, objects put in their places.

use super::lexer::At;
use super::materials::Studio;
use super::names::{did_you_mean, quoted};
use super::options::MIRROR;
use super::reader::{Reader, Surface};
use super::shapes::{Geometries, Geometry};
use super::sky;
use super::textures::{Gallery, Use};
use crate::error::{Error, Result};
use crate::lanes::Rgb;
use crate::material::Material;
use crate::scene::description::{
    Alpha, Description, FilmDescription, Light, Maps, NamedCamera, NamedMaterial, Object, Shape,
};
use crate::scene::framing;
use crate::scene::mesh::Mesh;
use glam::{Affine3A, DAffine3, DVec3, Mat3A, Vec2, Vec3, Vec3A};
use std::collections::HashMap;
use std::sync::Arc;

/// Most shapes of a scene, instances counted one by one.
pub(super) const MOST: usize = 1 << 25;
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

/// A mesh as a shape needs it.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    geometry: usize,
    /// In the plane x = 0: what a transformation mirrors is mirrored here, so that the rest of it is not.
    mirrored: bool,
    reversed: bool,
    /// With pbrt's UV for triangles that have none.
    with_uvs: bool,
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
        "the scene has more than {MOST} shapes; have fewer instances"
    ))
}

impl World {
    pub fn new(reader: Reader) -> Result<Self> {
        if let Some(error) = reader.undefined_material() {
            return Err(error);
        }
        Ok(Self {
            gallery: Gallery::default(),
            materials: Vec::new(),
            finishes: vec![None; reader.surfaces.len()],
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
        let mut all: Vec<(&Placed, DAffine3)> = Vec::with_capacity(placed.len());
        all.extend(placed.iter().map(|shape| (shape, shape.to_world)));
        for (name, to_world, at) in &instances {
            let Some(object) = objects.get(name) else {
                let mut known: Vec<&str> = objects.keys().map(String::as_str).collect();
                known.sort_unstable();
                return Err(at.error(format!(
                    "object {} is not defined{}",
                    quoted(name),
                    match did_you_mean(name, known) {
                        hint if hint.is_empty() => "; add ObjectBegin".to_owned(),
                        hint => hint,
                    }
                )));
            };
            if all.len() + object.len() > MOST {
                return Err(too_many(at));
            }
            all.extend(
                object
                    .iter()
                    .map(|shape| (shape, *to_world * shape.to_world)),
            );
        }
        self.count_exact(&all);
        for (shape, to_world) in all {
            self.place(shape, to_world)?;
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

    fn count_exact(&mut self, all: &[(&Placed, DAffine3)]) {
        let (mut spheres, mut quads) = (0, 0);
        let mut sphere_at = None;
        for (shape, _) in all {
            match self.reader.geometries.list.get(shape.geometry) {
                Some(Geometry::Sphere) => {
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
            (None, None) => {}
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
            Geometry::Sphere if self.exact_spheres && !is_textured && !placed.reverse => {
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
        let has_uvs = |mesh: &Mesh| !mesh.uvs.is_empty();
        let variant = Variant {
            geometry: placed.geometry,
            mirrored: is_mirrored,
            reversed: placed.reverse,
            with_uvs: is_textured && !matches!(&geometry, Geometry::Mesh(mesh, _) if has_uvs(mesh)),
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
        let [low, high] = *self
            .boxes
            .entry(placed.geometry)
            .or_insert_with(|| match geometry {
                Geometry::Sphere => [DVec3::NEG_ONE, DVec3::ONE],
                Geometry::Mesh(mesh, _) => {
                    let points = || mesh.positions.iter().map(|p| p.as_dvec3());
                    [
                        points().fold(DVec3::INFINITY, DVec3::min),
                        points().fold(DVec3::NEG_INFINITY, DVec3::max),
                    ]
                }
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
        let Some(surface) = self.reader.surfaces.get(index).cloned() else {
            return Ok(Finish::Absent);
        };
        let finish = self.made(&surface)?;
        if let Some(slot) = self.finishes.get_mut(index) {
            *slot = Some(finish);
        }
        Ok(finish)
    }

    fn made(&mut self, surface: &Surface) -> Result<Finish> {
        let material = self.reader.unmixed(surface.material)?;
        let mut studio = Studio {
            textures: &self.reader.textures,
            gallery: &mut self.gallery,
            files: &mut self.reader.files,
            warnings: &mut self.reader.warnings,
        };
        let slot = self.reader.materials.get(material);
        let mut material = match slot.and_then(|slot| slot.definition.as_ref()) {
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

/// Single precision, as kernels have it.
fn narrow(to_world: DAffine3) -> Affine3A {
    let column = |v: DVec3| Vec3A::from(v.as_vec3());
    let matrix = to_world.matrix3;
    Affine3A {
        matrix3: Mat3A::from_cols(
            column(matrix.x_axis),
            column(matrix.y_axis),
            column(matrix.z_axis),
        ),
        translation: column(to_world.translation),
    }
}

/// The factor by which lengths grow, where it is the same in all directions, and a radius.
fn uniform_scale(to_world: DAffine3) -> Option<f64> {
    let matrix = to_world.matrix3;
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let square = x.length_squared();
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * square;
    let is_uniform = near(y.length_squared(), square)
        && near(z.length_squared(), square)
        && near(x.dot(y), 0.0)
        && near(y.dot(z), 0.0)
        && near(z.dot(x), 0.0);
    let scale = square.sqrt();
    (is_uniform && (1e-9..=FARTHEST).contains(&scale)).then_some(scale)
}

/// Whether two edges make a quad, as the scene format asks of one.
fn is_sound(u: Vec3, v: Vec3) -> bool {
    let (u, v) = (u.as_dvec3(), v.as_dvec3());
    let area = u.cross(v).length();
    area >= 1e-4 * u.length() * v.length() && area >= 1e-18 && u.length().min(v.length()) >= 1e-9
}

/// The mesh of a geometry as a shape needs it.
fn varied(geometry: &Geometry, variant: Variant) -> Arc<Mesh> {
    let mesh = match geometry {
        Geometry::Mesh(mesh, _) => mesh,
        Geometry::Sphere => &Arc::new(Geometries::sphere_mesh()),
    };
    let Variant {
        mirrored,
        reversed,
        with_uvs,
        ..
    } = variant;
    let with_uvs = with_uvs && mesh.uvs.is_empty();
    if !(mirrored || reversed || with_uvs) {
        return Arc::clone(mesh);
    }
    let mut mesh = if with_uvs {
        with_triangle_uvs(mesh)
    } else {
        Mesh::clone(mesh)
    };
    if mirrored {
        for vector in mesh.positions.iter_mut().chain(&mut mesh.normals) {
            vector.x = -vector.x;
        }
    }
    if reversed {
        for normal in &mut mesh.normals {
            *normal = -*normal;
        }
    }
    if mirrored ^ reversed {
        for corners in &mut mesh.triangles {
            corners.swap(1, 2);
        }
    }
    Arc::new(mesh)
}

/// pbrt's UV for meshes that have none: (0, 0), (1, 0), (1, 1) on each triangle.
fn with_triangle_uvs(mesh: &Mesh) -> Mesh {
    const CORNERS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::ONE];
    let mut own = Mesh {
        name: mesh.name.clone(),
        ..Mesh::default()
    };
    for corners in &mesh.triangles {
        let first = own.positions.len() as u32;
        for (&corner, uv) in corners.iter().zip(CORNERS) {
            own.positions.extend(mesh.positions.get(corner as usize));
            own.normals.extend(mesh.normals.get(corner as usize));
            own.uvs.push(uv);
        }
        own.triangles.push([first, first + 1, first + 2]);
    }
    own
}
