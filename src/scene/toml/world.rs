//! Shapes and objects.

use super::files::{Files, Model, Part};
use super::names::quoted;
use super::reader::{Table, Value};
use super::transform::{Transform, moved};
use crate::error::Result;
use crate::scene::description::{Light, Object, Shape};
use glam::Affine3A;
use std::collections::HashMap;
use std::rc::Rc;

/// Smallest radius or edge, scene units: below it squares leave the range of 32-bit floats.
const SMALLEST: f32 = 1e-9;
/// Greatest radius, as of coordinates.
const LARGEST: f32 = 1e9;
/// Sine of the smallest angle between the edges of a quad: below it the normal is rounding error.
const PARALLEL: f64 = 1e-6;

/// Materials by name, each its index in the list.
pub(super) type Defined<'a> = HashMap<&'a str, usize>;

/// `[[objects]]`, in file order.
pub(super) fn objects(value: Value, defined: &Defined, files: &mut Files) -> Result<()> {
    for table in value.tables("[[objects]]")? {
        table.keys(
            "[[objects]]",
            &["sphere", "quad", "mesh", "transform", "material"],
        )?;
        let owner = "this object";
        let shapes = shapes(&table, owner, files)?;
        let required = || {
            table
                .require(owner, "material", &naming_one(defined))?
                .reference("material", defined)
        };
        match shapes {
            Placed::Shape(shape) => {
                let material = required()?;
                files.scene.objects.push(Object { shape, material });
            }
            Placed::Model(model, place) => {
                let own = table
                    .get("material")
                    .map(|value| value.reference("material", defined))
                    .transpose()?;
                for part in &model.parts {
                    let shape = part.placed(&place);
                    match (own, part.material, part.emission) {
                        (None, material, Some(emission)) => files.scene.lights.push(Light {
                            shape,
                            radiance: emission.radiance,
                            two_sided: emission.two_sided,
                            material,
                            texture: emission.texture,
                        }),
                        (own, in_file, _) => {
                            let material = own.or(in_file).map_or_else(required, Ok)?;
                            files.scene.objects.push(Object { shape, material });
                        }
                    }
                }
                if own.is_none() {
                    let lights = model.punctual.iter().map(|&light| moved(light, &place));
                    files.scene.punctual.extend(lights);
                }
            }
        }
    }
    Ok(())
}

fn naming_one(defined: &Defined) -> String {
    match defined.iter().min_by_key(|(_, index)| **index) {
        Some((name, _)) => format!("material = {}", quoted(name)),
        None => "material = \"white\" and a table [materials.white]".to_owned(),
    }
}

/// A shape where it is put.
pub(super) enum Placed {
    /// A sphere or quad.
    Shape(Shape),
    /// A mesh file, and from its space to the world.
    Model(Rc<Model>, Affine3A),
}

impl Part {
    /// The shape of a mesh whose file is put somewhere.
    pub fn placed(&self, place: &Affine3A) -> Shape {
        Shape::Mesh {
            mesh: self.mesh,
            transform: *place * self.transform,
        }
    }
}

/// The one shape of an object or light.
pub(super) fn shapes(table: &Table, owner: &str, files: &mut Files) -> Result<Placed> {
    let mut found: Vec<Value> = ["sphere", "quad", "mesh"]
        .into_iter()
        .filter_map(|key| table.get(key))
        .collect();
    found.sort_by_key(|value| value.key_at);
    let value = match found[..] {
        [value] => value,
        [_, second, ..] => {
            return Err(
                second.key_error(format!("{owner} has two shapes; give each its own table"))
            );
        }
        [] => {
            return Err(table.error(format!(
                "{owner} has no shape; add sphere = {{ center = [x, y, z], radius = r }}, quad = {{ corner = [..], u = [..], v = [..] }} or mesh = {{ file = \"x.ply\" }}"
            )));
        }
    };
    let transform = Transform::of(table)?;
    let shape = match value.key {
        "sphere" => sphere(value)?,
        "quad" => quad(value)?,
        _ => {
            let model = mesh(value, files)?;
            let place = transform
                .as_ref()
                .map_or(Affine3A::IDENTITY, |transform| transform.affine);
            if let Some(transform) = transform {
                for part in &model.parts {
                    transform.check(&files.scene.meshes[part.mesh], &(place * part.transform))?;
                }
            }
            return Ok(Placed::Model(model, place));
        }
    };
    Ok(Placed::Shape(match transform {
        Some(transform) => transform.apply(shape)?,
        None => shape,
    }))
}

fn mesh(value: Value, files: &mut Files) -> Result<Rc<Model>> {
    const EXAMPLE: &str = "mesh = { file = \"x.ply\" }";
    let table = value.table(EXAMPLE)?;
    table.keys("a mesh", &["file"])?;
    files.model(table.require("this mesh", "file", "file = \"x.ply\"")?)
}

fn sphere(value: Value) -> Result<Shape> {
    let table = value.table("sphere = { center = [x, y, z], radius = r }")?;
    table.keys("a sphere", &["center", "radius"])?;
    let need = |key, example| table.require("this sphere", key, example);
    let center = need("center", "center = [x, y, z]")?.point()?;
    let radius = need("radius", "radius = 1.0")?
        .number_where("above 0 (from 1e-9 to 1e9)", |radius| {
            (SMALLEST..=LARGEST).contains(&radius)
        })?;
    Ok(Shape::Sphere { center, radius })
}

fn quad(value: Value) -> Result<Shape> {
    let table = value.table("quad = { corner = [x, y, z], u = [x, y, z], v = [x, y, z] }")?;
    table.keys("a quad", &["corner", "u", "v"])?;
    let need = |key, example| table.require("this quad", key, example);
    let corner = need("corner", "corner = [x, y, z]")?.point()?;
    let edge = |key, example| {
        let value = need(key, example)?;
        let edge = value.point()?;
        if edge.as_dvec3().length() < f64::from(SMALLEST) {
            return Err(value.error(format!(
                "{key} has no length, so the quad has no area; give an edge of at least 1e-9"
            )));
        }
        Ok((edge, value))
    };
    let (u, _) = edge("u", "u = [x, y, z], its first edge")?;
    let (v, v_value) = edge("v", "v = [x, y, z], its second edge")?;
    let (a, b) = (u.as_dvec3(), v.as_dvec3());
    let area = a.cross(b).length();
    if area < PARALLEL * a.length() * b.length() {
        return Err(v_value.error(
            "v is parallel to u, so the quad has no area; give two edges that span a parallelogram",
        ));
    }
    // Its square must be a normal 32-bit float, or the normal cannot be computed.
    if area < 1e-18 {
        return Err(v_value.error(format!(
            "the quad's area is {area:e}, too small for 32-bit floats; give it at least 1e-18"
        )));
    }
    Ok(Shape::Quad { corner, u, v })
}
