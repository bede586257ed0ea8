//! Lights: shapes that emit, and those without a surface.

use super::files::Files;
use super::reader::{Table, Value};
use super::world::{Defined, Placed, shapes};
use crate::error::Result;
use crate::scene::description::{Light, Punctual};
use glam::Vec3;

/// The lights without a surface.
const PUNCTUAL: [&str; 3] = ["point", "spot", "distant"];

/// `[[lights]]`, in file order.
pub(super) fn lights(value: Value, defined: &Defined, files: &mut Files) -> Result<()> {
    for table in value.tables("[[lights]]")? {
        if let Some(value) = PUNCTUAL.into_iter().find_map(|key| table.get(key)) {
            let owner = format!("a {} light, which has no surface", value.key);
            table.keys(&owner, &[value.key])?;
            files.scene.punctual.push(punctual(value)?);
            continue;
        }
        let own = [
            "sphere",
            "quad",
            "mesh",
            "transform",
            "radiance",
            "two_sided",
            "material",
        ];
        table.keys("[[lights]]", &[&own[..], &PUNCTUAL].concat())?;
        let owner = "this light";
        let placed = shapes(&table, owner, files)?;
        let radiance = table
            .require(owner, "radiance", "radiance = [10.0, 10.0, 10.0]")?
            .radiance()?;
        let two_sided = table
            .get("two_sided")
            .map_or(Ok(false), |value| value.flag())?;
        let material = table
            .get("material")
            .map(|value| value.reference("material", defined))
            .transpose()?;
        let light = |shape| Light {
            shape,
            radiance,
            two_sided,
            material,
            texture: None,
        };
        match placed {
            Placed::Shape(shape) => files.scene.lights.push(light(shape)),
            Placed::Model(model, place) => {
                let parts = model.parts.iter().map(|part| light(part.placed(&place)));
                files.scene.lights.extend(parts);
            }
        }
    }
    Ok(())
}

fn punctual(value: Value) -> Result<Punctual> {
    match value.key {
        "point" => {
            let table =
                value.table("point = { position = [x, y, z], intensity = [1.0, 1.0, 1.0] }")?;
            table.keys("a point light", &["position", "intensity"])?;
            Ok(Punctual::Point {
                position: position(&table)?,
                intensity: intensity(&table)?,
            })
        }
        "spot" => spot(value),
        _ => {
            let table =
                value.table("distant = { direction = [x, y, z], irradiance = [1.0, 1.0, 1.0] }")?;
            table.keys("a distant light", &["direction", "irradiance"])?;
            Ok(Punctual::Distant {
                direction: direction(&table)?,
                irradiance: table
                    .require(OWNER, "irradiance", "irradiance = [1.0, 1.0, 1.0]")?
                    .radiance()?,
            })
        }
    }
}

fn spot(value: Value) -> Result<Punctual> {
    let table = value.table(
        "spot = { position = [x, y, z], direction = [x, y, z], intensity = [1.0, 1.0, 1.0], outer_degrees = 30.0 }",
    )?;
    let known = [
        "position",
        "direction",
        "intensity",
        "outer_degrees",
        "inner_degrees",
    ];
    table.keys("a spot light", &known)?;
    let outer_value = table.require(
        OWNER,
        "outer_degrees",
        "outer_degrees = 30.0, from its axis",
    )?;
    let outer = outer_value.number_where("above 0 and at most 90", |degrees| {
        degrees > 0.0 && degrees <= 90.0
    })?;
    let inner = table.get("inner_degrees").map_or(Ok(0.0), |value| {
        value.number_where("at least 0 and below outer_degrees", |degrees| {
            (0.0..outer).contains(&degrees)
        })
    })?;
    let cos = |degrees: f32| libm::cos(f64::from(degrees).to_radians()) as f32;
    let (cos_inner, cos_outer) = (cos(inner), cos(outer));
    if cos_inner <= cos_outer {
        return Err(outer_value.error("the cone is too narrow for 32-bit floats; write outer_degrees of 0.1 or more above inner_degrees"));
    }
    Ok(Punctual::Spot {
        position: position(&table)?,
        direction: direction(&table)?,
        intensity: intensity(&table)?,
        cos_inner,
        cos_outer,
    })
}

/// What errors call it.
const OWNER: &str = "this light";

fn position(table: &Table) -> Result<Vec3> {
    table
        .require(OWNER, "position", "position = [x, y, z]")?
        .point()
}

fn direction(table: &Table) -> Result<Vec3> {
    let value = table.require(
        OWNER,
        "direction",
        "direction = [0.0, -1.0, 0.0], the way its light travels",
    )?;
    let unit = value.point()?.as_dvec3().normalize_or_zero();
    match unit == glam::DVec3::ZERO {
        true => {
            Err(value.error("direction has no length; write [0.0, -1.0, 0.0] for light from above"))
        }
        false => Ok(unit.as_vec3()),
    }
}

fn intensity(table: &Table) -> Result<crate::lanes::Rgb> {
    table
        .require(OWNER, "intensity", "intensity = [1.0, 1.0, 1.0], in W/sr")?
        .radiance()
}
