//! The files of a scene: the JSON, the binary chunk of a `.glb`, and what URIs name.

use crate::error::{Error, Place, Result};
use crate::scene::toml::names::quoted;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::Document;
use gltf::json::validation::{self, Validate};
use gltf::json::{self, Root};
use percent_encoding::percent_decode_str;
use sha2::{Digest, Sha256};
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Greatest size of a file, bytes: what a `.glb` can say of itself.
const LARGEST: u64 = u32::MAX as u64;

/// What to do about a file that contradicts itself.
pub(super) const AGAIN: &str = "export the file again";

/// A scene's file and its buffers: every index in it names something.
pub(super) struct File<'a> {
    path: &'a Path,
    /// The JSON.
    pub(super) document: Document,
    buffers: Vec<Vec<u8>>,
}

impl<'a> File<'a> {
    /// Reads the file and its buffers; their bytes enter the hash.
    pub(super) fn open(path: &'a Path, hasher: &mut Sha256) -> Result<Self> {
        let bytes = read(path, LARGEST).map_err(|source| Error::Read {
            path: path.to_owned(),
            source,
        })?;
        hasher.update(&bytes);
        let binary = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("glb"));
        let (text, blob) = if binary || bytes.starts_with(MAGIC) {
            split(bytes).map_err(|message| Error::format(path, message))?
        } else {
            (bytes, None)
        };
        let root = parse(path, &text)?;
        check(&root).map_err(|(place, message)| at(path, place, message))?;
        let mut file = Self {
            path,
            document: Document::from_json_without_validation(root),
            buffers: Vec::new(),
        };
        file.buffers = file.read_buffers(blob, hasher)?;
        Ok(file)
    }

    /// Something in the file is wrong.
    pub(super) fn error(&self, place: impl Display, message: impl Display) -> Error {
        at(self.path, place, message)
    }

    /// What errors and `info` call a part of the file.
    pub(super) fn name(&self, place: &str) -> String {
        format!("{}: {place}", self.path.display())
    }

    fn read_buffers(&self, mut blob: Option<Vec<u8>>, hasher: &mut Sha256) -> Result<Vec<Vec<u8>>> {
        let mut buffers = Vec::new();
        for buffer in self.document.buffers() {
            let place = format!("buffers[{}]", buffer.index());
            let length = buffer.length();
            let bytes = match buffer.source() {
                gltf::buffer::Source::Uri(uri) => {
                    let bytes = self.resource(uri, length as u64, &place)?;
                    hasher.update(&bytes);
                    bytes
                }
                gltf::buffer::Source::Bin => blob.take().ok_or_else(|| {
                    let message =
                        "it has no uri, and only the first buffer of a .glb is part of the file";
                    self.error(&place, format!("{message}; {AGAIN}"))
                })?,
            };
            if bytes.len() < length {
                return Err(self.error(
                    place,
                    format!(
                        "it is {length} bytes by its byteLength, and {} are there; copy or {AGAIN}",
                        bytes.len()
                    ),
                ));
            }
            buffers.push(bytes);
        }
        Ok(buffers)
    }

    /// The file that a URI names; none where its name is not UTF-8.
    pub(super) fn beside(&self, uri: &str) -> Option<PathBuf> {
        let named = percent_decode_str(uri).decode_utf8().ok()?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        Some(folder.join(named.as_ref()))
    }

    /// The bytes that a URI names, `most` at most.
    pub(super) fn resource(&self, uri: &str, most: u64, place: &str) -> Result<Vec<u8>> {
        if let Some(data) = uri.strip_prefix("data:") {
            return embedded(data).map_err(|message| self.error(place, message));
        }
        if uri.contains("://") {
            let message = format!("{} is on a network; save it beside the scene", quoted(uri));
            return Err(self.error(place, message));
        }
        let file = self.beside(uri).ok_or_else(|| {
            self.error(
                place,
                format!("the name {} is not UTF-8; {AGAIN}", quoted(uri)),
            )
        })?;
        read(&file, most).map_err(|error| {
            let name = quoted(&file.display().to_string());
            self.error(
                place,
                format!("cannot read {name}: {error}; put it there, or {AGAIN}"),
            )
        })
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, view: &gltf::buffer::View) -> Result<&[u8]> {
        let buffer = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer.get(view.offset()..end))
            .ok_or_else(|| {
                self.error(
                    format!("bufferViews[{}]", view.index()),
                    format!(
                        "it has {} bytes from {}, and buffers[{}] has {}; {AGAIN}",
                        view.length(),
                        view.offset(),
                        view.buffer().index(),
                        buffer.len()
                    ),
                )
            })
    }
}

fn at(path: &Path, place: impl Display, message: impl Display) -> Error {
    Error::format(path, format!("{place}: {message}"))
}

fn read(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?
        .take(most)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The data of a `data:` URI (RFC 2397), after its scheme.
fn embedded(data: &str) -> std::result::Result<Vec<u8>, String> {
    // Writers differ in whether they pad.
    const BASE64: GeneralPurpose = GeneralPurpose::new(
        &STANDARD,
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
    );
    let (kind, body) = data
        .split_once(',')
        .ok_or_else(|| format!("its data URI has no comma before the data; {AGAIN}"))?;
    if !kind.ends_with(";base64") {
        return Ok(percent_decode_str(body).collect());
    }
    BASE64
        .decode(body)
        .map_err(|error| format!("its data URI is not base64 ({error}); {AGAIN}"))
}

const MAGIC: &[u8] = b"glTF";

/// The JSON and the binary chunk of a `.glb` (glTF 2.0, sec. 4).
fn split(bytes: Vec<u8>) -> std::result::Result<(Vec<u8>, Option<Vec<u8>>), String> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    if !bytes.starts_with(MAGIC) {
        return Err(format!(
            "it does not begin with \"glTF\", so it is no .glb; {AGAIN}"
        ));
    }
    match (word(4), word(8)) {
        (Some(2), Some(length)) if length as usize == bytes.len() => {}
        (Some(2), Some(length)) => {
            return Err(format!(
                "it is {length} bytes by its header, and {} are there; copy or {AGAIN}",
                bytes.len()
            ));
        }
        (Some(version), Some(_)) => {
            return Err(format!(
                "it is a .glb of version {version}; convert it to glTF 2.0"
            ));
        }
        _ => return Err(format!("it ends within its header; copy or {AGAIN}")),
    }
    let chunk = |rest: &mut &'_ [u8], kind: &[u8; 4]| -> Option<Vec<u8>> {
        let (length, after) = rest.split_first_chunk()?;
        let (found, after) = after.split_first_chunk()?;
        let data = after.get(..u32::from_le_bytes(*length) as usize)?;
        *rest = &after[data.len()..];
        (found == kind).then(|| data.to_vec())
    };
    let mut rest = &bytes[12..];
    let text = chunk(&mut rest, b"JSON")
        .ok_or_else(|| format!("its first chunk is no whole JSON chunk; copy or {AGAIN}"))?;
    if rest.is_empty() {
        return Ok((text, None));
    }
    let blob = chunk(&mut rest, b"BIN\0")
        .ok_or_else(|| format!("its second chunk is no whole BIN chunk; copy or {AGAIN}"))?;
    Ok((text, Some(blob)))
}

fn parse(path: &Path, text: &[u8]) -> Result<Root> {
    let root = Root::from_slice(text).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        let cause = error.to_string();
        let cause = cause
            .strip_suffix(&format!(" at line {line} column {column}"))
            .unwrap_or(&cause);
        let cause: String = cause.escape_debug().take(200).collect();
        Error::Scene {
            place: Place {
                file: path.display().to_string(),
                line,
                column,
            },
            message: format!("this is not the JSON of glTF: {cause}; {AGAIN}"),
        }
    })?;
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        let message = format!(
            "version {} is not read; convert it to glTF 2.0",
            quoted(version)
        );
        return Err(at(path, "asset", message));
    }
    Ok(root)
}

/// Checks that every index names something and every choice is known. `Document` counts on it.
fn check(root: &Root) -> std::result::Result<(), (String, String)> {
    let nothing_there = |place| {
        let message = format!("it names something that is not there; {AGAIN}");
        Err((place, message))
    };
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            // The validation below looks into the accessor of the positions before it has checked that there is one.
            if primitive
                .attributes
                .values()
                .any(|&index| root.get(index).is_none())
            {
                return nothing_there(format!("meshes[{m}].primitives[{p}].attributes"));
            }
        }
    }
    for (index, camera) in root.cameras.iter().enumerate() {
        use json::camera::Type;
        use validation::Checked::Valid;
        let missing = match camera.type_ {
            Valid(Type::Perspective) if camera.perspective.is_none() => "perspective",
            Valid(Type::Orthographic) if camera.orthographic.is_none() => "orthographic",
            _ => continue,
        };
        return Err((
            format!("cameras[{index}].{missing}"),
            format!("it is missing; {AGAIN}"),
        ));
    }
    let mut first = Ok(());
    root.validate(root, json::Path::new, &mut |place, error| {
        if first.is_err() {
            return;
        }
        let place = place().to_string();
        let what = match error {
            // Required extensions have their own check.
            validation::Error::Unsupported => return,
            // Bounds of positions are not used, and attributes of unknown names neither.
            _ if place.ends_with(".min") || place.ends_with(".max") => return,
            validation::Error::Invalid if place.contains(".attributes[") => return,
            validation::Error::IndexOutOfBounds => {
                first = nothing_there(place);
                return;
            }
            validation::Error::Invalid => "it is nothing that glTF 2.0 knows",
            validation::Error::Missing => "it is missing",
            validation::Error::Oversize => "it is larger than the memory of this machine",
        };
        first = Err((place, format!("{what}; {AGAIN}")));
    });
    first
}
