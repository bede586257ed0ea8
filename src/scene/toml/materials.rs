//! Materials, and what varies over their surfaces.

use super::files::Files;
use super::names::{did_you_mean, quoted};
use super::reader::{Table, Value};
use crate::error::Result;
use crate::lanes::Rgb;
use crate::material::Material;
use crate::scene::description::{Alpha, Maps, NamedMaterial};
use crate::scene::image::ColorSpace;

/// Keys that every type of material has.
const COMMON: [&str; 3] = ["type", "normal_map", "alpha_cutoff"];

/// `[materials.NAME]`, in file order.
pub(super) fn materials(value: Value, files: &mut Files) -> Result<Vec<NamedMaterial>> {
    let materials = value.table("[materials.NAME]")?.values();
    materials
        .into_iter()
        .map(|value| named(value, files, Maps::default()))
        .collect()
}

/// One of them, which has these maps unless it names others.
pub(super) fn named(value: Value, files: &mut Files, mut maps: Maps) -> Result<NamedMaterial> {
    let material = material(value, files, &mut maps)?;
    surface(&value.table("")?, files, &mut maps)?;
    Ok(NamedMaterial {
        name: value.key.to_owned(),
        material,
        maps,
    })
}

/// What any material may have.
fn surface(table: &Table, files: &mut Files, maps: &mut Maps) -> Result<()> {
    if let Some(value) = table.get("normal_map") {
        let strength = value
            .entry("strength")
            .map_or(Ok(1.0), |value| value.number())?;
        let texture = files.texture(value, ColorSpace::Linear, &["strength"])?;
        maps.normal = Some((texture, strength));
    }
    if let Some(value) = table.get("alpha_cutoff") {
        let cutoff = value.number_where("from 0 to 1", |cutoff| (0.0..=1.0).contains(&cutoff))?;
        let there = maps.alpha.or(maps.color.map(|color| Alpha {
            texture: Some(color),
            factor: 1.0,
            cutoff,
        }));
        let Some(alpha) = there else {
            return Err(value.key_error(
                "alpha_cutoff cuts by the alpha of the colour's texture, and this colour has none; write its colour as { texture = \"leaf.png\" }",
            ));
        };
        maps.alpha = Some(Alpha { cutoff, ..alpha });
    }
    Ok(())
}

/// A colour, or a texture and what it is multiplied with.
fn color(value: Value, files: &mut Files, maps: &mut Maps) -> Result<Rgb> {
    if !value.is_table() {
        return value.reflectance();
    }
    maps.color = Some(files.texture(value, ColorSpace::Srgb, &["scale"])?);
    value
        .entry("scale")
        .map_or(Ok(Rgb::WHITE), |value| value.reflectance())
}

fn material(value: Value, files: &mut Files, maps: &mut Maps) -> Result<Material> {
    const TYPES: [&str; 6] = [
        "lambert",
        "mirror",
        "glass",
        "phong",
        "conductor",
        "principled",
    ];
    let owner = format!("[materials.{}]", value.name());
    let table = value.table(&owner)?;
    let kind_value = table.require(
        &owner,
        "type",
        r#"type = "lambert", "mirror", "glass", "phong", "conductor" or "principled""#,
    )?;
    let kind = kind_value.text()?;
    let owner = format!("a {kind} material");
    let known = |keys: &[&str]| table.keys(&owner, &[&COMMON, keys].concat());
    let need = |key, example| table.require(&owner, key, example);
    match kind {
        "lambert" => {
            known(&["albedo"])?;
            let albedo = color(need("albedo", "albedo = [0.8, 0.8, 0.8]")?, files, maps)?;
            Ok(Material::Lambert { albedo })
        }
        "mirror" => {
            known(&["reflectance"])?;
            let reflectance = color(
                need("reflectance", "reflectance = [0.95, 0.95, 0.95]")?,
                files,
                maps,
            )?;
            Ok(Material::Mirror { reflectance })
        }
        "glass" => {
            known(&["ior"])?;
            let ior = need("ior", "ior = 1.5")?.number_where(
                "above 0 (the index inside over the index outside: 1.5 for window glass)",
                |ior| ior > 0.0,
            )?;
            Ok(Material::Glass { ior })
        }
        "phong" => {
            known(&["diffuse", "specular", "exponent"])?;
            let diffuse = color(need("diffuse", "diffuse = [0.5, 0.5, 0.5]")?, files, maps)?;
            let specular_value = need("specular", "specular = [0.3, 0.3, 0.3]")?;
            let specular = specular_value.reflectance()?;
            let exponent =
                need("exponent", "exponent = 50")?.number_where("at least 0", |n| n >= 0.0)?;
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
            known(&["roughness", "reflectance"])?;
            let roughness = need("roughness", "roughness = 0.2")?.number_where(
                "above 0 and at most 1 (use type = \"mirror\" for a perfectly smooth one)",
                |alpha| alpha > 0.0 && alpha <= 1.0,
            )?;
            let reflectance = color(
                need("reflectance", "reflectance = [0.9, 0.9, 0.9]")?,
                files,
                maps,
            )?;
            Ok(Material::Conductor {
                roughness,
                reflectance,
            })
        }
        "principled" => principled(&table, &owner, files, maps),
        other => Err(kind_value.error(format!(
            "unknown material type {}{} Use lambert, mirror, glass, phong, conductor or principled",
            quoted(other),
            match did_you_mean(other, TYPES) {
                hint if hint.is_empty() => ".".to_owned(),
                hint => hint,
            }
        ))),
    }
}

fn principled(table: &Table, owner: &str, files: &mut Files, maps: &mut Maps) -> Result<Material> {
    let own = [
        "base_color",
        "metallic",
        "roughness",
        "ior",
        "metallic_roughness",
    ];
    table.keys(owner, &[&COMMON[..], &own].concat())?;
    if let Some(value) = table.get("metallic_roughness") {
        maps.metallic_roughness = Some(files.texture(value, ColorSpace::Linear, &[])?);
    }
    // A texture needs no factors.
    let factor = |key, example: &str| match (table.get(key), maps.metallic_roughness) {
        (None, Some(_)) => Ok(1.0),
        _ => table
            .require(owner, key, example)?
            .number_where("from 0 to 1", |factor| (0.0..=1.0).contains(&factor)),
    };
    let metallic = factor("metallic", "metallic = 0.0 (1.0 for a metal)")?;
    let roughness = factor("roughness", "roughness = 0.5")?;
    let base_color = table.require(owner, "base_color", "base_color = [0.8, 0.8, 0.8]")?;
    Ok(Material::Principled {
        base_color: color(base_color, files, maps)?,
        metallic,
        roughness,
        ior: table.get("ior").map_or(Ok(1.5), |value| {
            value.number_where("at least 1 (1.5 for most things)", |ior| ior >= 1.0)
        })?,
    })
}
