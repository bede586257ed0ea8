//! Names of outputs: a text with fields in braces, such as `out/{scene}-{camera}.exr`.

use super::file::{Cameras, Setting};
use crate::scene::toml::Change;
use crate::scene::toml::names::{did_you_mean, list, quoted};
use std::sync::Arc;

/// The fields of every job; besides them there are the keys of its `set`.
pub const FIELDS: [&str; 17] = [
    "scene",
    "camera",
    "index",
    "size",
    "width",
    "height",
    "spp",
    "seed",
    "path_length",
    "strategy",
    "sampler",
    "roulette",
    "crop",
    "aov",
    "tonemap",
    "exposure",
    "png",
];

/// The name of an output, to be filled in for each job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    pieces: Vec<Piece>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    Field(Field),
}

/// What a field stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Field {
    /// One that every job has.
    Known(&'static str),
    /// The value of a key of `set`, by its place there.
    Change(usize),
}

impl Template {
    /// Reads a template whose fields may be those of every job and `keys`, the keys of `set`, whole or by their last part.
    ///
    /// # Errors
    /// A message for a brace that is alone, an unknown field, a control character, and a name that is not called `.exr`.
    pub fn parse(text: &str, keys: &[&str]) -> Result<Self, String> {
        if text.contains(char::is_control) {
            return Err(format!(
                "the name {} has a line break or another control character; write it without",
                quoted(text)
            ));
        }
        let mut pieces = Vec::new();
        let mut plain = String::new();
        let mut rest = text;
        while let Some(at) = rest.find(['{', '}']) {
            plain += &rest[..at];
            let (brace, after) = rest[at..].split_at(1);
            // Doubled, it is itself.
            if let Some(after) = after.strip_prefix(brace) {
                plain += brace;
                rest = after;
                continue;
            }
            let end = after.find(['{', '}']).filter(|_| brace == "{");
            let Some(end) = end.filter(|&end| after[end..].starts_with('}')) else {
                return Err(format!(
                    "a {brace} stands alone in {}; write {{name}} for a field, {{{{ and }}}} for braces",
                    quoted(text)
                ));
            };
            pieces.push(Piece::Text(std::mem::take(&mut plain)));
            pieces.push(Piece::Field(field(&after[..end], keys)?));
            rest = &after[end + 1..];
        }
        plain += rest;
        let is_exr = plain.to_ascii_lowercase().ends_with(".exr");
        if !is_exr {
            return Err(format!(
                "the image is an OpenEXR file, and the PNG is written beside it; end the name {} with .exr",
                quoted(text)
            ));
        }
        pieces.push(Piece::Text(plain));
        Ok(Self { pieces })
    }

    /// That of a job file which gives none: the scene, and whatever has more than one value.
    pub fn default_of(
        changes: &[Vec<Arc<Change>>],
        cameras: &Cameras,
        settings: &[Vec<Setting>],
    ) -> Self {
        let mut pieces = vec![Piece::Field(Field::Known("scene"))];
        let mut add = |label: &str, field| {
            pieces.push(Piece::Text(format!("-{label}")));
            pieces.push(Piece::Field(field));
        };
        for (place, axis) in changes.iter().enumerate() {
            if let [first, _, ..] = &axis[..] {
                add(&safe(last_part(&first.key)), Field::Change(place));
            }
        }
        if *cameras != Cameras::First {
            add("", Field::Known("camera"));
        }
        for axis in settings {
            if let [first, _, ..] = &axis[..] {
                let field = first.field();
                // What is a word or a size needs no label.
                let label = match field {
                    "spp" | "seed" | "path_length" | "roulette" | "crop" => field,
                    _ => "",
                };
                add(label, Field::Known(field));
            }
        }
        pieces.push(Piece::Text(".exr".to_owned()));
        Self { pieces }
    }

    /// Whether it has a field.
    pub fn has(&self, field: Field) -> bool {
        self.pieces.contains(&Piece::Field(field))
    }

    /// The name, where `value` gives each field's value; what a file's name must not hold is replaced in values.
    pub fn fill(&self, value: impl Fn(Field) -> String) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Field(field) => safe(&value(*field)),
        };
        self.pieces.iter().map(piece).collect()
    }
}

/// The field of that name.
fn field(name: &str, keys: &[&str]) -> Result<Field, String> {
    if let Some(known) = FIELDS.iter().find(|known| **known == name) {
        return Ok(Field::Known(known));
    }
    if let Some(place) = keys.iter().position(|key| *key == name) {
        return Ok(Field::Change(place));
    }
    let by_last_part: Vec<usize> = (0..keys.len())
        .filter(|&place| last_part(keys[place]) == name)
        .collect();
    match by_last_part[..] {
        [place] => return Ok(Field::Change(place)),
        [first, second, ..] => {
            return Err(format!(
                "the field {{{name}}} may be {} or {}; write the whole key",
                keys[first], keys[second]
            ));
        }
        [] => {}
    }
    let known = || FIELDS.iter().chain(keys).copied();
    let hint = did_you_mean(name, known());
    Err(format!(
        "there is no field {{{}}}{hint}{} {}",
        quoted(name).trim_matches('"'),
        if hint.is_empty() {
            "; there are:"
        } else {
            " There are:"
        },
        list(known())
    ))
}

/// `roughness` of `materials.ball.roughness`.
fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// A value as part of a file's name: what is neither letter nor digit nor one of `._+-` becomes a hyphen, and dots alone
/// lead nowhere.
pub(super) fn safe(value: &str) -> String {
    let mut name = String::new();
    let mut gap = false;
    for c in value.chars() {
        if c.is_alphanumeric() || "._+-".contains(c) {
            if std::mem::take(&mut gap) && !name.is_empty() {
                name.push('-');
            }
            name.push(c);
        } else {
            gap = true;
        }
    }
    match name.trim_matches('.').is_empty() {
        true => "_".repeat(name.len().max(1)),
        false => name,
    }
}
