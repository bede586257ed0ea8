//! `ondine dump --vectors`: what the program's functions give for given inputs, as JSON, one file a topic.
//!
//! `docs/specification.md` says how they are computed; these are for a port to check itself against, function by function,
//! before it traces a path. `docs/vectors/` holds them, and a test writes them again and compares every byte.

mod bsdfs;
mod cameras;
mod films;
mod functions;
mod intersections;
mod lights;
mod page;
mod samplers;
mod triangles;
mod warps;

use crate::error::{Error, Result};
use crate::film::write_whole;
use crate::lanes::{Vec3x8, f32x8};
use glam::Vec3;
use page::Topic;
use std::io::Write;
use std::path::Path;

/// Writes every topic into a folder, which is made where it is missing.
///
/// # Errors
/// [`Error::Usage`] where `dir` is something else, [`Error::Write`] where the folder or a file cannot be written; those written before are whole.
pub fn write(dir: &Path) -> Result<()> {
    let what = match dir {
        _ if dir.is_dir() => None,
        _ if dir.exists() => Some("is no folder"),
        _ if dir.is_symlink() => Some("is a link to what does not exist"),
        _ => None,
    };
    if let Some(what) = what {
        let dir = dir.display();
        return Err(Error::Usage(format!(
            "{dir} {what}; name a folder, which is made where it is missing"
        )));
    }
    let topics = [
        samplers::topic(),
        functions::topic(),
        warps::topic(),
        cameras::topic(),
        intersections::topic()?,
        triangles::topic(),
        bsdfs::topic(),
        lights::topic()?,
        films::topic()?,
    ];
    std::fs::create_dir_all(dir).map_err(|source| Error::Write {
        path: dir.to_owned(),
        source,
    })?;
    topics
        .iter()
        .try_for_each(|topic| write_topic(dir, topic))?;
    super::super::print(&format!("{} files in {}\n", topics.len(), dir.display()))
}

fn write_topic(dir: &Path, topic: &Topic) -> Result<()> {
    let path = dir.join(format!("{}.json", topic.name));
    write_whole(&path, |file| file.write_all(topic.to_json().as_bytes()))
}

/// Greatest number that a sampler gives.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON;

/// Pairs of random numbers: corners and inside of the unit square, multiples of 2^-23 as samplers give them.
const PAIRS: [[f32; 2]; 10] = [
    [0.0, 0.0],
    [0.5, 0.5],
    [0.25, 0.75],
    [0.75, 0.25],
    [0.125, 0.625],
    [0.9375, 0.03125],
    [BELOW_ONE, 0.0],
    [0.0, BELOW_ONE],
    [BELOW_ONE, BELOW_ONE],
    [2_796_203.0 / 8_388_608.0, 5_592_405.0 / 8_388_608.0],
];

/// The same number in all lanes.
fn wide(x: f32) -> f32x8 {
    f32x8::splat(x)
}

/// The same pair in all lanes.
fn pair([first, second]: [f32; 2]) -> (f32x8, f32x8) {
    (wide(first), wide(second))
}

/// What all lanes hold.
fn one(x: f32x8) -> f32 {
    x.to_array()[0]
}

/// What all lanes hold.
fn vector(v: Vec3x8) -> [f32; 3] {
    v.lane(0).to_array()
}

/// Unit, from any components.
fn unit(x: f64, y: f64, z: f64) -> Vec3 {
    glam::DVec3::new(x, y, z).normalize().as_vec3()
}
