//! The environment, and lat-long images of it.

use super::reader::{Table, Value};
use crate::error::Result;
use crate::lanes::Rgb;
use crate::scene::description::{Environment, LatLong};
use exr::prelude::{MetaData, ReadChannels, ReadLayers};
use sha2::{Digest, Sha256};
use std::io::Read;
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
    // The decoder promises errors, not panics, but its input is anyone's file: a panic becomes an error too.
    let read = std::panic::catch_unwind(|| read_exr(&path)).unwrap_or_else(|_| {
        Err("the EXR decoder gave up; the file is damaged, write it again".to_owned())
    });
    let (width, height, pixels) =
        read.map_err(|message| value.error(format!("image {}: {message}", path.display())))?;
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

/// Pixels while they are read: width, height, row-major colours.
type Pixels = (usize, usize, Vec<Rgb>);

/// The first layer with R, G and B channels; the message of an error says what to do.
fn read_exr(path: &Path) -> std::result::Result<Pixels, String> {
    let explain = |error: exr::error::Error| match error {
        exr::error::Error::Io(error) => format!("cannot read: {error}"),
        error => format!("is not an EXR image with R, G and B channels ({error}); convert it"),
    };
    let headers = MetaData::read_from_file(path, false)
        .map_err(explain)?
        .headers;
    for header in &headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        if width > LARGEST.0 || height > LARGEST.1 {
            return Err(format!(
                "is {width}×{height} pixels; scale it down to at most {}×{}",
                LARGEST.0, LARGEST.1
            ));
        }
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), size.height(), vec![Rgb::BLACK; size.area()]),
            |(width, _, pixels): &mut Pixels, at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = Rgb::new(r, g, b);
            },
        )
        .first_valid_layer()
        .all_attributes()
        // One thread, this one: a panic elsewhere could not be caught here.
        .non_parallel()
        .from_file(path)
        .map_err(explain)?;
    let frame = image.attributes.display_window.size;
    let (width, height, pixels) = image.layer_data.channel_data.pixels;
    if (frame.width(), frame.height()) != (width, height) {
        return Err(format!(
            "holds {width}×{height} pixels of a picture of {}×{}; save it uncropped",
            frame.width(),
            frame.height()
        ));
    }
    if width != 2 * height {
        return Err(format!(
            "is {width}×{height} pixels, and a lat-long image is twice as wide as high; resize it to {}×{height}",
            2 * height
        ));
    }
    for (index, pixel) in pixels.iter().enumerate() {
        for (value, channel) in pixel.to_array().into_iter().zip(["R", "G", "B"]) {
            if !(value.is_finite() && value >= 0.0) {
                return Err(format!(
                    "pixel ({}, {}) has {channel} = {value}; radiance is finite and at least 0, repair the image",
                    index % width,
                    index / width
                ));
            }
        }
    }
    Ok((width, height, pixels))
}
