//! Materials, objects and lights.

use super::names::{did_you_mean, quoted};
use super::reader::{Table, Value};
use crate::error::Result;
use crate::material::Material;
use crate::scene::description::{Light, Maps, NamedMaterial, Object, Shape};
use std::collections::HashMap;

/// Smallest radius or edge, scene units: below it squares leave the range of 32-bit floats.
const SMALLEST: f32 = 1e-9;
/// Greatest radius, as of coordinates.
const LARGEST: f32 = 1e9;
/// Sine of the smallest angle between the edges of a quad: below it the normal is rounding error.
const PARALLEL: f64 = 1e-6;

/// Materials by name, each its index in the list.
type Defined<'a> = HashMap<&'a str, usize>;

/// `[materials.NAME]`, in file order.
pub(super) fn materials(value: Value) -> Result<Vec<NamedMaterial>> {
    let materials = value.table("[materials.NAME]")?.values();
    materials
        .into_iter()
        .map(|value| {
            Ok(NamedMaterial {
                name: value.key.to_owned(),
                material: material(value)?,
                maps: Maps::default(),
            })
        })
        .collect()
}

fn material(value: Value) -> Result<Material> {
    const TYPES: [&str; 5] = ["lambert", "mirror", "glass", "phong", "conductor"];
    let owner = format!("[materials.{}]", value.name());
    let table = value.table(&owner)?;
    let kind_value = table.require(
        &owner,
        "type",
        r#"type = "lambert", "mirror", "glass", "phong" or "conductor""#,
    )?;
    let kind = kind_value.text()?;
    let owner = format!("a {kind} material");
    let known = |keys: &[&str]| table.keys(&owner, keys, &[]);
    let need = |key, example| table.require(&owner, key, example);
    match kind {
        "lambert" => {
            known(&["type", "albedo"])?;
            let albedo = need("albedo", "albedo = [0.8, 0.8, 0.8]")?.reflectance()?;
            Ok(Material::Lambert { albedo })
        }
        "mirror" => {
            known(&["type", "reflectance"])?;
            let reflectance = need("reflectance", "reflectance = [0.95, 0.95, 0.95]")?.reflectance()?;
            Ok(Material::Mirror { reflectance })
        }
        "glass" => {
            known(&["type", "ior"])?;
            let ior = need("ior", "ior = 1.5")?.number_where(
                "above 0 (the index inside over the index outside: 1.5 for window glass)",
                |ior| ior > 0.0,
            )?;
            Ok(Material::Glass { ior })
        }
        "phong" => {
            known(&["type", "diffuse", "specular", "exponent"])?;
            let diffuse = need("diffuse", "diffuse = [0.5, 0.5, 0.5]")?.reflectance()?;
            let specular_value = need("specular", "specular = [0.3, 0.3, 0.3]")?;
            let specular = specular_value.reflectance()?;
            let exponent = need("exponent", "exponent = 50")?.number_where("at least 0", |n| n >= 0.0)?;
            let channels = diffuse.to_array().into_iter().zip(specular.to_array());
            for ((d, s), channel) in channels.zip(["red", "green", "blue"]) {
                // 0.7 + 0.3 may round to above 1.
                if d + s > 1.0 + 1e-6 {
                    return Err(specular_value.error(format!(
                        "diffuse + specular is {} in {channel}, and a surface reflects no more light than it gets; lower either until each channel's sum is at most 1",
                        d + s
                    )));
                }
            }
            Ok(Material::Phong {
                diffuse,
                specular,
                exponent,
            })
        }
        "conductor" => {
            known(&["type", "roughness", "reflectance"])?;
            let roughness = need("roughness", "roughness = 0.2")?.number_where(
                "above 0 and at most 1 (use type = \"mirror\" for a perfectly smooth one)",
                |alpha| alpha > 0.0 && alpha <= 1.0,
            )?;
            let reflectance = need("reflectance", "reflectance = [0.9, 0.9, 0.9]")?.reflectance()?;
            Ok(Material::Conductor {
                roughness,
                reflectance,
            })
        }
        "principled" => Err(kind_value.error(
            "type \"principled\" is not supported by this version; use \"lambert\" or \"phong\" for a base_color, \"conductor\" for a metal",
        )),
        other => Err(kind_value.error(format!(
            "unknown material type {}{} Use lambert, mirror, glass, phong or conductor",
            quoted(other),
            match did_you_mean(other, TYPES) {
                hint if hint.is_empty() => ".".to_owned(),
                hint => hint,
            }
        ))),
    }
}

/// `[[objects]]`, in file order.
pub(super) fn objects(value: Value, defined: &Defined) -> Result<Vec<Object>> {
    let read = |table: Table| {
        table.keys("[[objects]]", &["sphere", "quad", "material"], &LATER_KEYS)?;
        let shape = shape(&table, "this object")?;
        let material = table
            .require("this object", "material", &naming_one(defined))?
            .reference("material", defined)?;
        Ok(Object { shape, material })
    };
    value.tables("[[objects]]")?.into_iter().map(read).collect()
}

/// `[[lights]]`, in file order.
pub(super) fn lights(value: Value, defined: &Defined) -> Result<Vec<Light>> {
    let read = |table: Table| {
        let known = ["sphere", "quad", "radiance", "two_sided", "material"];
        table.keys("[[lights]]", &known, &LATER_KEYS)?;
        Ok(Light {
            shape: shape(&table, "this light")?,
            radiance: table
                .require("this light", "radiance", "radiance = [10.0, 10.0, 10.0]")?
                .radiance()?,
            two_sided: table
                .get("two_sided")
                .map_or(Ok(false), |value| value.flag())?,
            material: table
                .get("material")
                .map(|value| value.reference("material", defined))
                .transpose()?,
            texture: None,
        })
    };
    value.tables("[[lights]]")?.into_iter().map(read).collect()
}

/// Keys that a later version of the program reads.
const LATER_KEYS: [(&str, &str); 2] = [
    ("mesh", "build the shape from spheres and quads"),
    ("transform", "write the shape's coordinates in world space"),
];

fn naming_one(defined: &Defined) -> String {
    match defined.iter().min_by_key(|(_, index)| **index) {
        Some((name, _)) => format!("material = {}", quoted(name)),
        None => "material = \"white\" and a table [materials.white]".to_owned(),
    }
}

fn shape(table: &Table, owner: &str) -> Result<Shape> {
    match (table.get("sphere"), table.get("quad")) {
        (Some(value), None) => sphere(value),
        (None, Some(value)) => quad(value),
        (Some(a), Some(b)) => {
            let second = if a.key_at > b.key_at { a } else { b };
            Err(second.key_error(format!(
                "{owner} has two shapes; give each its own table"
            )))
        }
        (None, None) => Err(table.error(format!(
            "{owner} has no shape; add sphere = {{ center = [x, y, z], radius = r }} or quad = {{ corner = [..], u = [..], v = [..] }}"
        ))),
    }
}

fn sphere(value: Value) -> Result<Shape> {
    let table = value.table("sphere = { center = [x, y, z], radius = r }")?;
    table.keys("a sphere", &["center", "radius"], &[])?;
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
    table.keys("a quad", &["corner", "u", "v"], &[])?;
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
