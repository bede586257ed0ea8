//! Images to be compared: of an OpenEXR file, the channels that matter.

use super::pick::{self, Plane};
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// The names of the channels of a layer.
pub const RGB: [&str; 3] = ["R", "G", "B"];

/// Three planes of linear radiance, and their variances where the file has them. Pixels row after row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// R, G, B: the mean of each pixel, W·sr⁻¹·m⁻².
    pub radiance: [Vec<f32>; 3],
    /// Variance of that mean.
    pub variance: Option<[Vec<f32>; 3]>,
}

/// What a comparison reads of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// The file.
    pub path: PathBuf,
    /// Left column of the data window, in pixels of the full image.
    pub x0: i32,
    /// Top row.
    pub y0: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The image itself.
    pub image: Layer,
    /// Light by path length in edges, ascending (the `length.N` layers).
    pub lengths: Vec<(u32, Layer)>,
    /// Samples of each pixel, where the file says them.
    pub samples: Option<Vec<f32>>,
}

/// Reads an OpenEXR image of any program: scanlines or tiles, one part or several, half, float or uint. Of its channels
/// those of one layer are read, and what belongs to them: `variance.*`, `exact.samples`, `length.N.*`.
///
/// `layer` is what stands before `.R`, or the name of a part. Without it: `R`, `G` and `B`, or else the only layer that has
/// such channels.
///
/// # Errors
/// [`Error::Read`] where the system refuses; [`Error::Format`] where the file is no EXR or is damaged, has no such channels
/// or leaves open which are meant, or where a number is not finite.
pub fn read(path: &Path, layer: Option<&str>) -> Result<Image> {
    let mut chosen = Chosen::default();
    let picked = pick::read(path, |parts| {
        chosen = choose(parts, layer)?;
        Ok(pick::Selection {
            part: chosen.part,
            channels: chosen.channels.clone(),
        })
    })?;
    let mut image = Image {
        path: path.to_owned(),
        x0: picked.x0,
        y0: picked.y0,
        width: picked.width,
        height: picked.height,
        ..Image::default()
    };
    let check = |plane: &Plane| check(&image, plane).map_err(|why| Error::format(path, why));
    picked.planes.iter().try_for_each(check)?;
    let mut planes = picked.planes.into_iter().map(|plane| plane.values);
    let mut three = || std::array::from_fn(|_| planes.next().unwrap_or_default());
    for found in &chosen.layers {
        let layer = Layer {
            radiance: three(),
            variance: found.has_variance.then(&mut three),
        };
        match found.length {
            None => image.image = layer,
            Some(length) => image.lengths.push((length, layer)),
        }
    }
    image.samples = chosen.has_samples.then(|| planes.next()).flatten();
    Ok(image)
}

/// Channels to be read, in the order of their use.
#[derive(Default)]
struct Chosen {
    part: usize,
    channels: Vec<usize>,
    layers: Vec<Found>,
    has_samples: bool,
}

struct Found {
    length: Option<u32>,
    has_variance: bool,
}

/// Three channels `prefix.R`, `prefix.G`, `prefix.B` of a part.
struct Candidate<'a> {
    part: usize,
    prefix: &'a str,
    /// What `--layer` calls it.
    name: &'a str,
}

fn choose(parts: &[pick::Part], layer: Option<&str>) -> std::result::Result<Chosen, String> {
    let all = candidates(parts);
    let is_plain = |candidate: &&Candidate| candidate.prefix.is_empty();
    let names = || {
        let quoted = |candidate: &Candidate| match candidate.name {
            "" => "\"\" (plain R, G, B)".to_owned(),
            name => format!("{name:?}"),
        };
        let names: Vec<_> = all.iter().map(quoted).collect();
        names.join(", ")
    };
    let candidate = match layer {
        Some(wanted) => all
            .iter()
            .find(|candidate| candidate.name == wanted || candidate.prefix == wanted)
            .ok_or_else(|| {
                format!(
                    "it has no layer {wanted:?} with R, G and B; it has {}",
                    names()
                )
            })?,
        None => match (all.iter().find(is_plain), &all[..]) {
            (Some(plain), _) if all.iter().filter(is_plain).count() == 1 => plain,
            (None, [only]) => only,
            (None, []) => return Err(without_colour(parts)),
            _ => {
                return Err(format!(
                    "it has several layers with R, G and B; choose one with --layer: {}",
                    names()
                ));
            }
        },
    };
    let part = &parts[candidate.part];
    let mut chosen = Chosen {
        part: candidate.part,
        ..Chosen::default()
    };
    let mut layers = vec![(None, candidate.prefix.to_owned())];
    if candidate.prefix.is_empty() {
        layers.extend(lengths(part).map(|length| (Some(length), format!("length.{length}"))));
    }
    for (length, prefix) in layers {
        let Some(radiance) = three(part, &prefix) else {
            continue;
        };
        chosen.channels.extend(radiance);
        let variance = three(part, &joined("variance", &prefix));
        chosen.channels.extend(variance.into_iter().flatten());
        chosen.layers.push(Found {
            length,
            has_variance: variance.is_some(),
        });
    }
    if let Some(samples) = part
        .channels
        .iter()
        .position(|name| name == "exact.samples")
    {
        chosen.channels.push(samples);
        chosen.has_samples = true;
    }
    Ok(chosen)
}

fn candidates(parts: &[pick::Part]) -> Vec<Candidate<'_>> {
    let mut all = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        for channel in &part.channels {
            let prefix = match channel.strip_suffix('R') {
                Some("") => "",
                Some(layer) => match layer.strip_suffix('.') {
                    Some(prefix) => prefix,
                    None => continue,
                },
                None => continue,
            };
            // What goes with a layer is none.
            if prefix == "variance" || prefix.starts_with("variance.") {
                continue;
            }
            if three(part, prefix).is_some() {
                let name = match (prefix, &part.name) {
                    ("", Some(name)) => name,
                    _ => prefix,
                };
                all.push(Candidate {
                    part: index,
                    prefix,
                    name,
                });
            }
        }
    }
    all
}

fn joined(before: &str, after: &str) -> String {
    match before.is_empty() || after.is_empty() {
        true => format!("{before}{after}"),
        false => format!("{before}.{after}"),
    }
}

/// The channels of a layer.
fn three(part: &pick::Part, prefix: &str) -> Option<[usize; 3]> {
    let find = |colour| {
        let name = joined(prefix, colour);
        part.channels.iter().position(|channel| *channel == name)
    };
    let [r, g, b] = RGB.map(find);
    Some([r?, g?, b?])
}

/// Path lengths that have a layer, ascending.
fn lengths(part: &pick::Part) -> impl Iterator<Item = u32> {
    let mut all: Vec<u32> = part
        .channels
        .iter()
        .filter_map(|name| name.strip_prefix("length.")?.strip_suffix(".R"))
        .filter_map(|length| length.parse().ok())
        .collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter()
}

fn without_colour(parts: &[pick::Part]) -> String {
    let channels: Vec<&str> = parts
        .iter()
        .flat_map(|part| part.channels.iter().map(String::as_str))
        .take(12)
        .collect();
    if channels.contains(&"Y") {
        return "it holds luminance (Y) without colour; write R, G and B".to_owned();
    }
    format!(
        "it has no channels R, G and B, in no layer; it has {}",
        channels.join(", ")
    )
}

/// What is wrong with the numbers of a plane.
fn check(image: &Image, plane: &Plane) -> std::result::Result<(), String> {
    let is_variance = plane.name.starts_with("variance.");
    let is_wrong = |value: &f32| !value.is_finite() || (is_variance && *value < 0.0);
    let Some(first) = plane.values.iter().position(is_wrong) else {
        return Ok(());
    };
    let count = plane.values.iter().filter(|value| is_wrong(value)).count();
    let x = i64::from(image.x0) + (first % image.width) as i64;
    let y = i64::from(image.y0) + (first / image.width) as i64;
    let others = match count - 1 {
        0 => String::new(),
        1 => ", and so is one more of its pixels".to_owned(),
        more => format!(", and so are {more} more of its pixels"),
    };
    let what = match is_variance {
        true => "a variance is finite and not below 0",
        false => "no comparison can use it",
    };
    Err(format!(
        "{} is {} at pixel {x},{y}{others}; {what}: repair the image",
        plane.name, plane.values[first]
    ))
}
