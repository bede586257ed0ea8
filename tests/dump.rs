//! Dumps: what a port is held to, and how it is held to it.

#[path = "common/mod.rs"]
mod common;
#[path = "common/render.rs"]
mod render;

mod dump {
    mod checks;
    mod records;
}

use ondine::dump::manifest::Manifest;
use ondine::dump::scene::SceneIds;
use ondine::dump::{Dump, folder, trace};
use ondine::film::Region;
use ondine::render::Settings;
use ondine::scene::description::Description;
use std::ops::Range;
use std::path::Path;

fn region(text: &str) -> Region {
    text.parse().expect("a region")
}

fn traced(description: &Description, settings: &Settings, tile: &str, samples: Range<u32>) -> Dump {
    let dump = trace(description, settings, region(tile), samples);
    dump.unwrap_or_else(|error| panic!("{error}"))
}

/// As `ondine dump` writes it.
fn write(dump: &Dump, description: &Description, settings: &Settings, path: &Path) {
    let (manifest, files) = Manifest::new(dump, description, settings, "test");
    let scene = SceneIds::of(description);
    folder::write(path, &manifest, &scene, &files).unwrap_or_else(|error| panic!("{error}"));
}
