//! Whether an image is right: held to a stored reference, cell by cell, by the statistics of `compare`.

use super::scenes::Case;
use crate::compare::{Image, Layer, Options, Report, compare};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::npy::{self, Array, Numbers};
use std::path::{Path, PathBuf};

/// Cells on a side of a reference: an image of any size that they divide is held to it.
pub const CELLS: usize = 64;

/// Probability that a right image is called wrong: a suite has some eight, and is run many times.
const ALPHA: f64 = 1e-5;

/// Compares an image with the reference of its scene.
///
/// # Errors
/// [`Error::Format`] where the reference is none.
pub fn prove(case: &Case, film: &Film) -> Result<Report> {
    let name = PathBuf::from(format!("the reference of {}", case.name));
    let reference = reference(case.reference, &name)?;
    let options = Options {
        alpha: ALPHA,
        ..Options::default()
    };
    compare(&reference, &cells(film)?, &options)
}

/// Six planes of float: R, G, B, and the variances of these means.
fn reference(bytes: &[u8], name: &Path) -> Result<Image> {
    let remedy = "a reference is made by tools/bench_references.py";
    let array = npy::parse(bytes, name, remedy)?;
    let (
        Array {
            shape,
            numbers: Numbers::F32(numbers),
        },
        true,
    ) = (&array, array.shape == [6, CELLS, CELLS])
    else {
        let what = format!(
            "is {} of shape {}; {remedy}",
            array.numbers.dtype(),
            array.sides()
        );
        return Err(Error::format(name, what));
    };
    let cells = shape[1] * shape[2];
    let plane = |p: usize| numbers[p * cells..(p + 1) * cells].to_vec();
    Ok(Image {
        path: name.to_owned(),
        width: CELLS,
        height: CELLS,
        image: Layer {
            radiance: [0, 1, 2].map(plane),
            variance: Some([3, 4, 5].map(plane)),
        },
        ..Image::default()
    })
}

/// The means of an image's cells, and the variances of these.
///
/// # Errors
/// [`Error::Usage`] where its sides are no multiples of [`CELLS`].
fn cells(film: &Film) -> Result<Image> {
    let [width, height] = [film.width(), film.height()].map(|side| side as usize);
    if width % CELLS != 0 || height % CELLS != 0 || film.region().pixels() != width * height {
        let what = format!("{width}x{height} pixels are not divided into {CELLS} cells a side");
        return Err(Error::Usage(what));
    }
    let pixels = (width / CELLS * (height / CELLS)) as f64;
    let sum = |numbers: &[[f32; 3]], channel: usize, over: f64| -> Vec<f32> {
        let mut cells = vec![0.0; CELLS * CELLS];
        for (i, pixel) in numbers.iter().enumerate() {
            let (x, y) = (i % width * CELLS / width, i / width * CELLS / height);
            cells[y * CELLS + x] += f64::from(pixel[channel]);
        }
        cells.into_iter().map(|sum| (sum / over) as f32).collect()
    };
    let (means, variances) = (film.means(), film.variances());
    Ok(Image {
        path: PathBuf::from("the image"),
        width: CELLS,
        height: CELLS,
        image: Layer {
            radiance: [0, 1, 2].map(|channel| sum(&means, channel, pixels)),
            variance: Some([0, 1, 2].map(|channel| sum(&variances, channel, pixels * pixels))),
        },
        ..Image::default()
    })
}
