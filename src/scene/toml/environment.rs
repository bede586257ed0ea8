//! The environment, and lat-long images of it.

use super::files::Files;
use super::reader::{Table, Value};
use crate::error::Result;
use crate::scene::description::{Environment, LatLong};
use crate::scene::{hash, lat_long};
use std::sync::Arc;

/// `[environment]`. The bytes of an image enter the scene's hash.
pub(super) fn environment(value: Value, files: &mut Files) -> Result<Environment> {
    const OWNER: &str = "[environment]";
    let table = value.table(OWNER)?;
    let known = ["constant", "gradient", "image", "rotate_degrees"];
    let later = [(
        "sh",
        "use constant, gradient or an image (a lat-long EXR) instead",
    )];
    table.keys(OWNER, &known, &later)?;
    let mut kinds = table.values();
    kinds.retain(|value| value.key != "rotate_degrees");
    let kind = match kinds.as_slice() {
        [] => {
            return Err(table.error(
                "[environment] is empty; add constant = [1.0, 1.0, 1.0], gradient = { zenith = [..], horizon = [..], ground = [..] } or image = \"sky.exr\"",
            ));
        }
        [kind] => *kind,
        [first, second, ..] => {
            return Err(second.key_error(format!(
                "[environment] has both {} and {}; keep one",
                first.key, second.key
            )));
        }
    };
    let rotation = table.get("rotate_degrees");
    if let (Some(rotation), true) = (rotation, kind.key != "image") {
        return Err(rotation.key_error(format!(
            "rotate_degrees turns an image, and this environment is {}; remove it",
            kind.key
        )));
    }
    match kind.key {
        "constant" => Ok(Environment::Constant(kind.radiance()?)),
        "gradient" => {
            gradient(kind.table("gradient = { zenith = [..], horizon = [..], ground = [..] }")?)
        }
        _ => Ok(Environment::Image {
            rotate_degrees: rotation.map_or(Ok(0.0), |value| {
                value.number_where("from -360 to 360", |degrees| degrees.abs() <= 360.0)
            })?,
            image: Arc::new(image(kind, files)?),
        }),
    }
}

fn gradient(table: Table) -> Result<Environment> {
    table.keys("a gradient", &["zenith", "horizon", "ground"], &[])?;
    let radiance = |key| {
        let example = format!("{key} = [1.0, 1.0, 1.0]");
        table.require("this gradient", key, &example)?.radiance()
    };
    Ok(Environment::Gradient {
        zenith: radiance("zenith")?,
        horizon: radiance("horizon")?,
        ground: radiance("ground")?,
    })
}

fn image(value: Value, files: &mut Files) -> Result<LatLong> {
    let path = files.path(value, "a lat-long EXR file")?;
    let image = lat_long::explained(&path)
        .map_err(|message| value.error(format!("image {}: {message}", path.display())))?;
    hash::add_file(&path, &mut files.hasher)
        .map_err(|error| value.error(format!("image {}: cannot read: {error}", path.display())))?;
    Ok(image)
}
