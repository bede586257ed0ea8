//! Reads some channels of any OpenEXR file. Blocks are unpacked on the rayon pool that the caller runs in.

use crate::error::{Error, Result};
use crate::film::exr::{cannot_decode, damaged, guard};
use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;
use rayon::prelude::*;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Blocks that are unpacked at once.
const BATCH: usize = 32;

/// 16384 × 16384.
const MOST_PIXELS: u128 = 1 << 28;

/// A part of a file.
#[derive(Debug)]
pub struct Part {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// The names of its channels.
    pub channels: Vec<String>,
}

/// Which channels are read.
#[derive(Debug)]
pub struct Selection {
    /// Of which part.
    pub part: usize,
    /// By their places in it.
    pub channels: Vec<usize>,
}

/// What was read of a file.
#[derive(Debug)]
pub struct Picked {
    /// Left column of the data window.
    pub x0: i32,
    /// Top row.
    pub y0: i32,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// In the order of the selection.
    pub planes: Vec<Plane>,
}

/// A channel.
#[derive(Debug)]
pub struct Plane {
    /// Its name in the file.
    pub name: String,
    /// Its pixels, row after row.
    pub values: Vec<f32>,
}

/// Reads the channels that `select` chooses.
///
/// # Errors
/// [`Error::Read`] where the system refuses; [`Error::Format`] where the file is no EXR or is damaged, with what `select`
/// says, and for deep or subsampled pixels. Whatever the file holds: no panic, and no more memory than its size allows for.
pub fn read(
    path: &Path,
    select: impl FnOnce(&[Part]) -> std::result::Result<Selection, String>,
) -> Result<Picked> {
    guard(path, |file| decode(path, file, select))
}

fn decode(
    path: &Path,
    file: File,
    select: impl FnOnce(&[Part]) -> std::result::Result<Selection, String>,
) -> Result<Picked> {
    let cannot = |error| cannot_decode(path, error);
    let bytes = file.metadata().map_or(0, |m| m.len());
    let reader =
        exr::block::read(BufReader::with_capacity(1 << 18, file), false).map_err(cannot)?;
    let meta = reader.meta_data().clone();
    let parts: Vec<Part> = meta.headers.iter().map(part).collect();
    let selection = select(&parts).map_err(|why| Error::format(path, why))?;
    let header = &meta.headers[selection.part];
    if header.deep {
        return Err(Error::format(path, "its pixels are deep; flatten it"));
    }
    if header
        .channels
        .list
        .iter()
        .any(|channel| channel.sampling != Vec2(1, 1))
    {
        return Err(Error::format(
            path,
            "a channel is subsampled; write every pixel of it",
        ));
    }
    let area = header.layer_size.0 as u128 * header.layer_size.1 as u128;
    if area > MOST_PIXELS {
        return Err(Error::format(path, "it has more than 2^28 pixels; crop it"));
    }
    // More pixels than so many bytes can hold are a lie, and much memory.
    let wanted = area * 4 * selection.channels.len() as u128;
    if wanted > u128::from(bytes) * most_packed(header.compression) {
        return Err(damaged(path, "it has fewer bytes than its size needs"));
    }

    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| {
            block.layer == selection.part && tile.level_index == Vec2(0, 0)
        })
        .map_err(cannot)?;
    let mut image = Canvas::new(header, &selection.channels);
    loop {
        let batch: Vec<Chunk> = chunks
            .by_ref()
            .take(BATCH)
            .collect::<exr::error::Result<_>>()
            .map_err(cannot)?;
        if batch.is_empty() {
            break;
        }
        let blocks: Vec<_> = batch
            .into_par_iter()
            .map(|chunk| {
                let block = UncompressedBlock::decompress_chunk(chunk, &meta, false)?;
                Ok(Block::pick(header, &selection.channels, &block))
            })
            .collect::<exr::error::Result<_>>()
            .map_err(cannot)?;
        for block in &blocks {
            image.place(block).map_err(|what| damaged(path, what))?;
        }
    }
    if image.missing > 0 {
        return Err(damaged(path, "pixels are missing"));
    }
    let names = selection
        .channels
        .iter()
        .map(|&i| &parts[selection.part].channels[i]);
    let position = header.own_attributes.layer_position;
    Ok(Picked {
        x0: position.0,
        y0: position.1,
        width: image.width,
        height: image.height,
        planes: names
            .zip(image.planes)
            .map(|(name, values)| Plane {
                name: name.clone(),
                values,
            })
            .collect(),
    })
}

fn part(header: &Header) -> Part {
    let channels = &header.channels.list;
    Part {
        name: header
            .own_attributes
            .layer_name
            .as_ref()
            .map(ToString::to_string),
        channels: channels
            .iter()
            .map(|channel| channel.name.to_string())
            .collect(),
    }
}

/// By how much a compression can shrink: deflate 1032-fold (zlib's technical notes), run lengths and B44 less; PIZ's codes
/// for runs more, and DWA deflates what has one number for 64.
fn most_packed(compression: Compression) -> u128 {
    match compression {
        Compression::DWAA(_) | Compression::DWAB(_) => 1 << 16,
        Compression::PIZ => 1 << 13,
        _ => 1100,
    }
}

/// The chosen channels of a block, one after the other, rows in each.
struct Block {
    index: BlockIndex,
    values: Vec<f32>,
}

impl Block {
    fn pick(header: &Header, channels: &[usize], block: &UncompressedBlock) -> Self {
        let (width, height) = (block.index.pixel_size.0, block.index.pixel_size.1);
        let list = &header.channels.list;
        let mut values = Vec::with_capacity(width * height * channels.len());
        for &wanted in channels {
            let before: usize = list[..wanted]
                .iter()
                .map(|c| c.sample_type.bytes_per_sample())
                .sum();
            let kind = list[wanted].sample_type;
            for y in 0..height {
                let start = width * (y * header.channels.bytes_per_pixel + before);
                let bytes = &block.data[start..start + width * kind.bytes_per_sample()];
                unpack(kind, bytes, &mut values);
            }
        }
        Self {
            index: block.index,
            values,
        }
    }
}

/// A block's bytes are in the machine's own order.
fn unpack(kind: SampleType, bytes: &[u8], values: &mut Vec<f32>) {
    let four = |b: &[u8]| [b[0], b[1], b[2], b[3]];
    match kind {
        SampleType::F16 => values.extend(
            bytes
                .chunks_exact(2)
                .map(|b| f16::from_ne_bytes([b[0], b[1]]).to_f32()),
        ),
        SampleType::F32 => {
            values.extend(bytes.chunks_exact(4).map(|b| f32::from_ne_bytes(four(b))))
        }
        SampleType::U32 => {
            values.extend(
                bytes
                    .chunks_exact(4)
                    .map(|b| u32::from_ne_bytes(four(b)) as f32),
            );
        }
    }
}

/// Planes while they are read.
struct Canvas {
    width: usize,
    height: usize,
    planes: Vec<Vec<f32>>,
    /// Pixels that no block has given.
    missing: usize,
    seen: Vec<bool>,
}

impl Canvas {
    fn new(header: &Header, channels: &[usize]) -> Self {
        let (width, height) = (header.layer_size.0, header.layer_size.1);
        Self {
            width,
            height,
            planes: vec![vec![0.0; width * height]; channels.len()],
            missing: width * height,
            seen: vec![false; width * height],
        }
    }

    fn place(&mut self, block: &Block) -> std::result::Result<(), &'static str> {
        let (at, size) = (block.index.pixel_position, block.index.pixel_size);
        if at.0 + size.0 > self.width || at.1 + size.1 > self.height {
            return Err("a block lies outside");
        }
        for y in 0..size.1 {
            let first = (at.1 + y) * self.width + at.0;
            for seen in &mut self.seen[first..first + size.0] {
                if std::mem::replace(seen, true) {
                    return Err("a pixel comes twice");
                }
            }
            for (plane, values) in self.planes.iter_mut().zip(block.values.chunks(size.area())) {
                plane[first..first + size.0].copy_from_slice(&values[y * size.0..][..size.0]);
            }
        }
        self.missing -= size.area();
        Ok(())
    }
}
