//! What commands read light from, and how it is turned.

use super::super::outputs::is_exr;
use crate::error::{Error, Result};
use crate::scene::description::LatLong;
use crate::scene::{lat_long, toml};
use crate::sh::{self, Lobe, PUBLISHED, Probe};
use glam::{DMat3, DVec3};
use std::path::Path;

/// Greatest degree of an image's coefficients where none is asked for.
const DEGREE: usize = 8;

/// Light, as a command line names it.
pub(super) struct Light {
    pub probe: Probe,
    /// What the coefficients are of, where that is a lat-long image.
    pub image: Option<LatLong>,
}

/// The light that a published name, a file of coefficients or a lat-long image stands for, to a degree: by default all that
/// there is, and of an image [`DEGREE`].
///
/// # Errors
/// [`Error::Usage`] where there is none, or fewer degrees than asked for, and those of the readers.
pub(super) fn open(light: &str, degree: Option<usize>) -> Result<Light> {
    let path = Path::new(light);
    let mut image = None;
    let probe = match sh::published(light) {
        Some(probe) => probe,
        None if !path.exists() => {
            return Err(Error::Usage(format!(
                "there is no file and no published probe {light:?}; the probes are {}",
                PUBLISHED.join(", ")
            )));
        }
        None if is_exr(path) => {
            let image = image.insert(lat_long::read(path)?);
            project(image, degree.unwrap_or(DEGREE))?
        }
        None => Probe::read(path)?,
    };
    match degree {
        Some(degree) if degree > probe.degree => Err(Error::Usage(format!(
            "{light} has coefficients to degree {}; ask for at most --bands {0}",
            probe.degree
        ))),
        degree => {
            let degree = degree.unwrap_or(probe.degree);
            let probe = moderate(probe.truncated(degree), light)?;
            Ok(Light { probe, image })
        }
    }
}

/// Light of a file that nothing overflows under.
fn moderate(probe: Probe, file: &str) -> Result<Probe> {
    match probe.check_magnitude() {
        Ok(()) => Ok(probe),
        Err(message) => Err(Error::format(Path::new(file), message)),
    }
}

/// The coefficients of an image.
///
/// # Errors
/// [`Error::Usage`] and [`Error::Format`] where they cannot be, or nothing could read or shade with them.
pub(super) fn project(image: &LatLong, degree: usize) -> Result<Probe> {
    let mut probe = sh::project(image.width, image.height, &image.pixels, degree)?;
    probe.source = Some(image.file.clone());
    moderate(probe, &image.file)
}

/// `--rotate`: degrees about x, then y, then z.
pub(super) fn rotation(text: &str) -> std::result::Result<DMat3, String> {
    let angles: Vec<f64> = text
        .split(',')
        .filter_map(|angle| angle.trim().parse().ok())
        .filter(|angle: &f64| angle.abs() <= 360.0)
        .collect();
    match *angles.as_slice() {
        [x, y, z] if text.split(',').count() == 3 => Ok(toml::rotation(DVec3::new(x, y, z))),
        _ => Err(
            "write three angles from -360 to 360 degrees, about x, then y, then z, as in 0,90,0"
                .to_owned(),
        ),
    }
}

/// A lobe by its name.
pub(super) fn lobe(text: &str) -> std::result::Result<Lobe, String> {
    text.parse().map_err(|error: Error| error.to_string())
}
