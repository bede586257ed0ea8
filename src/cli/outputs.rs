//! Where a render's files go, made sure of before it begins: an hour's work is not lost to a folder that is not there.

use crate::error::{Error, Result};
use crate::film::{Shard, write_whole};
use crate::scene::description::Description;
use std::io;
use std::path::{Path, PathBuf};

/// The files of a render.
#[derive(Clone, Debug)]
pub(super) struct Outputs {
    /// The OpenEXR image.
    pub exr: PathBuf,
    /// The PNG beside it, unless not wanted.
    pub png: Option<PathBuf>,
}

impl Outputs {
    /// What was asked for, or the scene's name in the current folder, with the number of the part if it is one.
    ///
    /// # Errors
    /// [`Error::Usage`] where the image is not called `.exr`, or a file would replace one that the scene reads;
    /// [`Error::Write`] where one cannot be written.
    pub fn new(
        asked: Option<&Path>,
        png: bool,
        scene: &Description,
        shard: Option<Shard>,
    ) -> Result<Self> {
        let exr = match asked {
            Some(path) if is_exr(path) => path.to_owned(),
            Some(path) => return Err(not_exr("-o", path)),
            None => {
                let stem = Path::new(&scene.name).file_stem().unwrap_or_default();
                let mut name = stem.to_owned();
                if let Some(shard) = shard {
                    name.push(format!(".{}-of-{}", shard.number(), shard.of()));
                }
                name.push(".exr");
                name.into()
            }
        };
        let outputs = Self {
            png: png.then(|| exr.with_extension("png")),
            exr,
        };
        for path in outputs.paths() {
            spare_inputs(path, scene)?;
            probe(path)?;
        }
        Ok(outputs)
    }

    /// Each file.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.exr)
            .chain(&self.png)
            .map(PathBuf::as_path)
    }
}

/// An image and the PNG beside it; `option` is what names the image.
///
/// # Errors
/// [`Error::Usage`] where the image is not called `.exr`.
pub(super) fn exr_and_png(option: &str, exr: &Path) -> Result<[PathBuf; 2]> {
    match is_exr(exr) {
        true => Ok([exr.to_owned(), exr.with_extension("png")]),
        false => Err(not_exr(option, exr)),
    }
}

/// Makes sure that a plot is called `.svg`, and can be written.
///
/// # Errors
/// [`Error::Usage`] where it is called otherwise, [`Error::Write`] where it cannot be written.
pub(super) fn plot(path: &Path) -> Result<()> {
    match is_called(path, "svg") {
        true => writable(path, &[]),
        false => Err(misnamed("-o", path, "plot.svg", "the plot is an SVG file")),
    }
}

/// Makes sure that a file can be written, and is none of the inputs.
///
/// # Errors
/// [`Error::Usage`] where it is an input, [`Error::Write`] where it cannot be written.
pub(super) fn writable(path: &Path, inputs: &[&Path]) -> Result<()> {
    match inputs.iter().any(|input| is_same(path, input)) {
        true => Err(Error::Usage(format!(
            "{}: this file is read; name another output",
            path.display()
        ))),
        false => probe(path),
    }
}

/// Makes sure that no two outputs are one file.
///
/// # Errors
/// [`Error::Usage`] where two are.
pub(super) fn distinct(paths: &[&Path]) -> Result<()> {
    let places: Vec<PathBuf> = paths.iter().map(|path| place(path)).collect();
    let again = (1..paths.len()).find(|&i| places[..i].contains(&places[i]));
    match again {
        None => Ok(()),
        Some(i) => Err(Error::Usage(format!(
            "{}: two outputs go to this file (a PNG lies beside each image); name another with -o",
            paths[i].display()
        ))),
    }
}

/// Where a file is, or will be.
fn place(path: &Path) -> PathBuf {
    let in_folder = || {
        let folder = path.parent().filter(|parent| *parent != Path::new(""));
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        Some(folder.join(path.file_name()?))
    };
    let whole = path.canonicalize().ok();
    whole.or_else(in_folder).unwrap_or_else(|| path.to_owned())
}

/// Whether both are there, and one file.
pub(super) fn is_same(output: &Path, input: &Path) -> bool {
    matches!((output.canonicalize(), input.canonicalize()), (Ok(output), Ok(input)) if output == input)
}

/// Whether a file is an image, by its name.
pub(super) fn is_exr(path: &Path) -> bool {
    is_called(path, "exr")
}

fn is_called(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

fn not_exr(option: &str, path: &Path) -> Error {
    let what = "the image is an OpenEXR file, and the PNG is written beside it";
    misnamed(option, path, "image.exr", what)
}

/// `example` has the right extension.
fn misnamed(option: &str, path: &Path, example: &str, what: &str) -> Error {
    // A folder has no name to extend.
    let named = path.file_name().is_some() && !path.is_dir();
    let better = match Path::new(example).extension() {
        Some(extension) if named => path.with_extension(extension),
        _ => path.join(example),
    };
    Error::Usage(format!(
        "{option} {}: {what}; use {option} {}",
        path.display(),
        better.display()
    ))
}

/// Makes sure that a file is none that the scene's sky or textures are read from: `sky.toml` with `image = "sky.exr"` would
/// by default be rendered over its own sky.
///
/// # Errors
/// [`Error::Usage`] where it is.
pub(super) fn spare_inputs(output: &Path, scene: &Description) -> Result<()> {
    let mut pictures = scene.pictures();
    match pictures.find(|(_, picture)| is_same(output, Path::new(picture))) {
        None => Ok(()),
        Some((what, _)) => Err(Error::Usage(format!(
            "{}: the scene's {what} is read from this file; name another output with -o",
            output.display()
        ))),
    }
}

/// Marks the end of a trial.
#[derive(Debug, thiserror::Error)]
#[error("a trial")]
struct Trial;

/// Writes a file as it will be written, up to its first byte, and then gives up, so that nothing is left and what is at
/// `path` stays.
fn probe(path: &Path) -> Result<()> {
    match write_whole(path, |_| Err(io::Error::other(Trial))) {
        Err(Error::Write { source, .. })
            if source.get_ref().is_some_and(|inner| inner.is::<Trial>()) =>
        {
            Ok(())
        }
        other => other,
    }
}
