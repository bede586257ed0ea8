//! `ondine info`: what a file holds.

use super::args::InfoArgs;
use super::{Outcome, info_image, info_scene};
use crate::error::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

pub(super) fn run(args: &InfoArgs) -> Result<Outcome> {
    let path = Path::new(&args.file);
    if is_image(path) {
        let image = info_image::read(path, args.crop)?;
        match args.json {
            true => super::print_json(&image)?,
            false => super::print(&image.text())?,
        }
        return Ok(Outcome::Done);
    }
    if args.crop.is_some() {
        return Err(Error::Usage(format!(
            "--crop asks for pixels, and {} is a scene; leave it out, or name an OpenEXR image",
            args.file
        )));
    }
    let scene = info_scene::read(&args.file)?;
    match args.json {
        true => super::print_json(&scene)?,
        false => super::print(&scene.text())?,
    }
    Ok(Outcome::Done)
}

/// By its name or, whatever it is called, by its first bytes.
fn is_image(path: &Path) -> bool {
    let named = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
    let starts_as_one = || {
        // Opening a pipe would wait for its writer.
        let mut file = path
            .is_file()
            .then(|| File::open(path))
            .and_then(std::io::Result::ok)?;
        let mut magic = [0; 4];
        file.read_exact(&mut magic).ok()?;
        Some(magic == [0x76, 0x2f, 0x31, 0x01])
    };
    named || starts_as_one().unwrap_or(false)
}
