//! What any OpenEXR file holds, without its pixels.

use super::exr::{cannot_decode, guard};
use crate::error::Result;
use ::exr::compression::Compression;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

/// An OpenEXR file.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ExrDescription {
    /// Its parts; one in most files.
    pub parts: Vec<Part>,
}

/// A part of an OpenEXR file. Windows are x0, y0, x1, y1 in pixels, the last two past the end.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Part {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// The pixels that are stored.
    pub data_window: [i64; 4],
    /// The pixels of the full image.
    pub display_window: [i64; 4],
    /// `none rle zips zip piz pxr24 b44 b44a dwaa dwab htj2k32 htj2k256`.
    pub compression: &'static str,
    /// `scanline`, `tiled` or `deep`.
    pub storage: &'static str,
    /// Its channels, in file order.
    pub channels: Vec<Channel>,
    /// All other attributes: numbers, texts, lists of numbers; what is none of these as a debugging text.
    pub attributes: BTreeMap<String, Value>,
}

/// A channel.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Channel {
    /// Its name, with the layer before the last dot.
    pub name: String,
    /// `half`, `float` or `uint`.
    pub kind: &'static str,
    /// Every how many pixels, in x and y, it has a value.
    pub sampling: [usize; 2],
}

/// What any OpenEXR file at `path` holds, from its header alone.
///
/// [`Error::Read`](crate::error::Error::Read) where the system refuses, [`Error::Format`](crate::error::Error::Format)
/// where it is no EXR or its header is damaged.
pub fn describe(path: &Path) -> Result<ExrDescription> {
    guard(path, |file| {
        let meta = MetaData::read_from_buffered(BufReader::new(file), false)
            .map_err(|error| cannot_decode(path, error))?;
        Ok(ExrDescription {
            parts: meta.headers.iter().map(part).collect(),
        })
    })
}

fn part(header: &Header) -> Part {
    let own = &header.own_attributes;
    let channels = header.channels.list.iter().map(|channel| Channel {
        name: channel.name.to_string(),
        kind: match channel.sample_type {
            SampleType::U32 => "uint",
            SampleType::F16 => "half",
            SampleType::F32 => "float",
        },
        sampling: [channel.sampling.0, channel.sampling.1],
    });
    // Said elsewhere in `Part`.
    const SAID: [&str; 5] = [
        "name",
        "channels",
        "compression",
        "dataWindow",
        "displayWindow",
    ];
    Part {
        name: own.layer_name.as_ref().map(ToString::to_string),
        data_window: window(IntegerBounds::new(own.layer_position, header.layer_size)),
        display_window: window(header.shared_attributes.display_window),
        compression: compression(header.compression),
        storage: match header.blocks {
            _ if header.deep => "deep",
            BlockDescription::ScanLines => "scanline",
            BlockDescription::Tiles(_) => "tiled",
        },
        channels: channels.collect(),
        attributes: header
            .all_named_attributes()
            .map(|(name, attribute)| (utf8(name), value(attribute)))
            .filter(|(name, _)| !SAID.contains(&name.as_str()))
            .collect(),
    }
}

fn utf8(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn window(bounds: IntegerBounds) -> [i64; 4] {
    let (x, y) = (i64::from(bounds.position.0), i64::from(bounds.position.1));
    [x, y, x + bounds.size.0 as i64, y + bounds.size.1 as i64]
}

fn compression(compression: Compression) -> &'static str {
    match compression {
        Compression::Uncompressed => "none",
        Compression::RLE => "rle",
        Compression::ZIP1 => "zips",
        Compression::ZIP16 => "zip",
        Compression::PIZ => "piz",
        Compression::PXR24 => "pxr24",
        Compression::B44 => "b44",
        Compression::B44A => "b44a",
        Compression::DWAA(_) => "dwaa",
        Compression::DWAB(_) => "dwab",
        Compression::HTJ2K32 => "htj2k32",
        Compression::HTJ2K256 => "htj2k256",
    }
}

fn value(attribute: AttributeValue) -> Value {
    match attribute {
        AttributeValue::Text(text) => utf8(text.as_slice()).into(),
        AttributeValue::TextVector(texts) => texts
            .iter()
            .map(|t| utf8(t.as_slice()))
            .collect::<Vec<_>>()
            .into(),
        AttributeValue::F64(x) => x.into(),
        AttributeValue::F32(x) => x.into(),
        AttributeValue::I32(x) => x.into(),
        AttributeValue::IntVec2(v) => json!([v.0, v.1]),
        AttributeValue::FloatVec2(v) => json!([v.0, v.1]),
        AttributeValue::IntVec3(v) => json!([v.0, v.1, v.2]),
        AttributeValue::FloatVec3(v) => json!([v.0, v.1, v.2]),
        AttributeValue::Matrix3x3(m) => json!(m),
        AttributeValue::Matrix4x4(m) => json!(m),
        AttributeValue::IntegerBounds(bounds) => json!(window(bounds)),
        AttributeValue::Bytes { bytes, .. } | AttributeValue::Custom { bytes, .. } => {
            format!("{} bytes", bytes.len()).into()
        }
        AttributeValue::Preview(preview) => {
            format!("a preview of {}x{} pixels", preview.size.0, preview.size.1).into()
        }
        other => format!("{other:?}").into(),
    }
}
