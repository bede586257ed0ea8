//! The environment, and lat-long images of it.

use super::files::Files;
use super::names;
use super::reader::{Table, Value};
use crate::error::Result;
use crate::scene::description::{Environment, Harmonics, LatLong};
use crate::scene::hash;
use crate::sh::{self, PUBLISHED, Probe};
use std::sync::Arc;

/// `[environment]`. The bytes of an image enter the scene's hash.
pub(super) fn environment(value: Value, files: &mut Files) -> Result<Environment> {
    const OWNER: &str = "[environment]";
    let table = value.table(OWNER)?;
    let known = [
        "constant",
        "gradient",
        "image",
        "sh",
        "rotate_degrees",
        "clamp",
    ];
    table.keys(OWNER, &known)?;
    let mut kinds = table.values();
    kinds.retain(|value| !["rotate_degrees", "clamp"].contains(&value.key));
    let kind = match kinds.as_slice() {
        [] => {
            return Err(table.error(
                "[environment] is empty; add constant = [1.0, 1.0, 1.0], gradient = { zenith = [..], horizon = [..], ground = [..] }, image = \"sky.exr\" or sh = \"probe.json\"",
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
    if let (Some(rotation), false) = (rotation, ["image", "sh"].contains(&kind.key)) {
        return Err(rotation.key_error(format!(
            "rotate_degrees turns an image or sh, and this environment is {}; remove it",
            kind.key
        )));
    }
    let rotate_degrees = || {
        rotation.map_or(Ok(0.0), |value| {
            value.number_where("from -360 to 360", |degrees| degrees.abs() <= 360.0)
        })
    };
    let clamp = table.get("clamp");
    if let (Some(clamp), true) = (clamp, kind.key != "sh") {
        return Err(clamp.key_error(format!(
            "clamp cuts off what is below 0 in sh, and this environment is {}; remove it",
            kind.key
        )));
    }
    match kind.key {
        "constant" => Ok(Environment::Constant(kind.radiance()?)),
        "gradient" => {
            gradient(kind.table("gradient = { zenith = [..], horizon = [..], ground = [..] }")?)
        }
        "sh" => {
            let (source, probe) = probe(kind, files)?;
            let harmonics = Harmonics {
                source,
                probe,
                rotate_degrees: rotate_degrees()?,
                clamp: clamp.map_or(Ok(false), |value| value.flag())?,
            };
            // Who writes `clamp`, whatever it is, knows.
            if clamp.is_none() {
                files.scene.warnings.extend(negative(kind, &harmonics));
            }
            Ok(Environment::Harmonics(harmonics))
        }
        _ => Ok(Environment::Image {
            rotate_degrees: rotate_degrees()?,
            image: image(kind, files)?,
        }),
    }
}

fn gradient(table: Table) -> Result<Environment> {
    table.keys("a gradient", &["zenith", "horizon", "ground"])?;
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

/// A light that is part of the program, by its name, or a file; and which.
fn probe(value: Value, files: &mut Files) -> Result<(String, Probe)> {
    let named = value.text()?;
    if let Some(probe) = sh::published(named) {
        return Ok((named.to_owned(), probe));
    }
    let known = names::list(PUBLISHED);
    let wanted = format!("a file of coefficients, or one of {known}");
    let path = files.path(value, &wanted)?;
    let wrong = |message: String| value.error(message + &names::did_you_mean(named, PUBLISHED));
    let probe = Probe::read(&path).map_err(|error| wrong(format!("sh {error}")))?;
    let file = path.display();
    if let Some(lobe) = probe.lobe {
        return Err(wrong(format!(
            "sh {file}: holds light convolved with {lobe}, and an environment is radiance; name coefficients of radiance"
        )));
    }
    probe
        .check_magnitude()
        .map_err(|message| wrong(format!("sh {file}: {message}")))?;
    hash::add_file(&path, &mut files.hasher)
        .map_err(|error| wrong(format!("sh {file}: cannot read: {error}")))?;
    Ok((file.to_string(), probe))
}

/// What a user should know of light below zero.
fn negative(value: Value, harmonics: &Harmonics) -> Option<String> {
    let (part, least) = harmonics.negative();
    (part > 0.0).then(|| {
        let message = format!(
            "the radiance of sh is negative over {:.1} % of the sphere, down to {least:.3}: band-limited light rings; it is \
             kept, so that images equal the double sum; clamp = true cuts it off at 0, clamp = false keeps it unsaid",
            100.0 * part
        );
        value.error(message).to_string()
    })
}

fn image(value: Value, files: &mut Files) -> Result<Arc<LatLong>> {
    let path = files.path(value, "a lat-long EXR file")?;
    files
        .lat_long(&path)
        .map_err(|message| value.error(format!("image {}: {message}", path.display())))
}
