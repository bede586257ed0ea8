//! The environment, and lat-long images of it.

use super::reader::{Table, Value};
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::{Environment, LatLong};
use crate::scene::exr::{self, Raster};
use sha2::{Digest, Sha256};
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// Greatest width and height of an image, pixels: a header may claim any size.
const LARGEST: (usize, usize) = (16384, 8192);

/// `[environment]`. The bytes of an image enter the scene's hash.
pub(super) fn environment(
    value: Value,
    base_dir: Option<&Path>,
    hasher: &mut Sha256,
) -> Result<Environment> {
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
            image: Arc::new(image(kind, base_dir, hasher)?),
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

fn image(value: Value, base_dir: Option<&Path>, hasher: &mut Sha256) -> Result<LatLong> {
    let named = value.text()?;
    if named.is_empty() {
        return Err(value.error("image is empty; name a lat-long EXR file"));
    }
    let path = match base_dir {
        Some(folder) => folder.join(named),
        None if Path::new(named).is_absolute() => named.into(),
        None => {
            return Err(value.error(
                "image is relative to the scene file, and this scene is not a file; give an absolute path, or save the scene to a file",
            ));
        }
    };
    let (width, height, pixels) = std::fs::File::open(&path)
        .map_err(|error| format!("cannot read: {error}"))
        .and_then(|file| {
            exr::read(BufReader::new(file), LARGEST, |[r, g, b, _]| {
                Rgb::new(r, g, b)
            })
        })
        .and_then(twice_as_wide)
        .map_err(|message| value.error(format!("image {}: {message}", path.display())))?;
    hash_file(&path, hasher)
        .map_err(|error| value.error(format!("image {}: cannot read: {error}", path.display())))?;
    Ok(LatLong {
        file: path.display().to_string(),
        width,
        height,
        pixels,
    })
}

fn hash_file(path: &Path, hasher: &mut Sha256) -> std::io::Result<()> {
    let mut file = std::fs::File::open(path)?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(()),
            length => hasher.update(&buffer[..length]),
        }
    }
}

fn twice_as_wide<P>((width, height, pixels): Raster<P>) -> std::result::Result<Raster<P>, String> {
    if width == 2 * height {
        return Ok((width, height, pixels));
    }
    Err(format!(
        "is {width}×{height} pixels, and a lat-long image is twice as wide as high; resize it to {}×{height}",
        2 * height
    ))
}
