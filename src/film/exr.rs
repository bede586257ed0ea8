//! The image file: one OpenEXR that opens in any viewer *and* merges exactly (see `planes` for its channels).
//!
//! Scanlines, ZIP compression; the data window is the film's region, the display window the full image. Blocks are
//! compressed on the rayon pool that the caller runs in, a few at a time: no second copy of the image is made.

use super::metadata::{FilmFacts, Metadata};
use super::planes::{self, Content, Exact, Plane};
use super::{AovSet, Film, Region, write_whole};
use crate::error::{Error, Result};
use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, UncompressedBlock, chunk::Chunk};
use ::exr::compression::Compression;
use ::exr::error::Error as ExrError;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData};
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Blocks (of 16 rows) that are compressed at once.
const BATCH: usize = 32;

/// Writes `film` and what is known of its render to `path`: whole, or [`Error::Write`] and nothing.
pub fn write(path: &Path, film: &Film, metadata: &Metadata) -> Result<()> {
    write_whole(path, |file| {
        encode(file, film, metadata).map_err(|error| match error {
            ExrError::Io(source) => source,
            other => io::Error::other(other.to_string()),
        })
    })
}

fn encode(file: impl Write + Seek, film: &Film, metadata: &Metadata) -> ::exr::error::UnitResult {
    let planes = planes::planes(film.aovs());
    let header = header(film, metadata, &planes);
    ::exr::block::write(
        file,
        [header].into_iter().collect(),
        true,
        |meta, writer| {
            let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
            for batch in blocks.chunks(BATCH) {
                let chunks: Vec<_> = batch
                    .par_iter()
                    .map(|&(index, block)| Ok((index, compress(film, &planes, &meta, block)?)))
                    .collect::<::exr::error::Result<_>>()?;
                for (index, chunk) in chunks {
                    writer.write_chunk(index, chunk)?;
                }
            }
            Ok(())
        },
    )
}

fn header(film: &Film, metadata: &Metadata, planes: &[Plane]) -> Header {
    let region = film.region();
    let channels = planes
        .iter()
        .map(|plane| ChannelDescription {
            name: Text::from_slice_unchecked(plane.name.as_bytes()),
            sample_type: match plane.content {
                Content::Shown(_) => SampleType::F32,
                Content::Exact(_) => SampleType::U32,
            },
            quantize_linearly: false,
            sampling: Vec2(1, 1),
        })
        .collect();
    let facts = FilmFacts {
        rejected: film.rejected(),
        image_hash: film.image_hash(),
    };
    let mut attributes = LayerAttributes {
        software_name: Some(Text::from_slice_unchecked(b"Ondine")),
        other: metadata.to_attributes(&facts),
        ..LayerAttributes::default()
    };
    // A region lies within 2^30 pixels a side.
    attributes.layer_position = Vec2(region.x0 as i32, region.y0 as i32);
    let size = |width: u32, height: u32| Vec2(width as usize, height as usize);
    Header::new(
        Text::default(),
        size(region.width(), region.height()),
        channels,
    )
    .with_attributes(attributes)
    .with_display_window(IntegerBounds::from_dimensions(size(
        film.width(),
        film.height(),
    )))
    .with_encoding(
        Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    )
}

fn compress(
    film: &Film,
    planes: &[Plane],
    meta: &MetaData,
    block: BlockIndex,
) -> ::exr::error::Result<Chunk> {
    let mut row = vec![0; block.pixel_size.width()];
    UncompressedBlock::from_lines(&meta.headers[0].channels, block, |line| {
        let place = line.location;
        let y = film.region().y0 + place.position.y() as u32;
        planes::read_row(
            film,
            planes[place.channel].content,
            y,
            place.position.x(),
            &mut row,
        );
        // A block's bytes are in the machine's own order; the crate converts.
        for (bytes, word) in line.value.chunks_exact_mut(4).zip(&row) {
            bytes.copy_from_slice(&word.to_ne_bytes());
        }
    })
    .compress_to_chunk(&meta.headers)
}

/// Reads an image that [`write()`] wrote: the film with its exact sums, and what is known of its render.
///
/// [`Error::Read`] where the system refuses, [`Error::Format`] where the file is no EXR, is damaged, or is not an
/// image of this program. Whatever the file holds: no panic, and no more memory than its size allows for.
pub fn read(path: &Path) -> Result<(Film, Metadata)> {
    guard(path, |file| decode(path, file))
}

/// Opens an EXR and reads from it; a panic of the decoder on hostile bytes becomes [`Error::Format`].
pub(crate) fn guard<T>(path: &Path, read: impl FnOnce(File) -> Result<T>) -> Result<T> {
    let cannot = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(cannot)?;
    if file.metadata().is_ok_and(|found| !found.is_file()) {
        let what = "it is no plain file; give the name of one";
        return Err(cannot(io::Error::other(what)));
    }
    let mut magic = [0; 4];
    let length = file.read(&mut magic).map_err(cannot)?;
    if length < 4 || magic != [0x76, 0x2f, 0x31, 0x01] {
        return Err(Error::format(path, "it is not an OpenEXR image"));
    }
    file.rewind().map_err(cannot)?;
    catch_unwind(AssertUnwindSafe(|| read(file)))
        .unwrap_or_else(|_| Err(damaged(path, "it is not what the decoder expects")))
}

pub(crate) fn damaged(path: &Path, what: impl std::fmt::Display) -> Error {
    Error::format(
        path,
        format!("this OpenEXR image is damaged or cut short ({what}); render or copy it again"),
    )
}

pub(crate) fn cannot_decode(path: &Path, error: ExrError) -> Error {
    match error {
        ExrError::Io(source) => Error::Read {
            path: path.to_owned(),
            source,
        },
        ExrError::Invalid(what) => damaged(path, what),
        other => Error::format(path, format!("this OpenEXR image cannot be read: {other}")),
    }
}

fn foreign(path: &Path, why: impl std::fmt::Display) -> Error {
    Error::format(
        path,
        format!(
            "it is no image that Ondine wrote: {why}; give a file that `ondine render` or `ondine merge` made"
        ),
    )
}

/// What the header of an image says, without its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageHeader {
    /// Columns of the full image.
    pub width: u32,
    /// Rows of the full image.
    pub height: u32,
    /// The pixels that are stored.
    pub region: Region,
    /// The AOVs that are stored.
    pub aovs: AovSet,
    /// What is known of its render.
    pub metadata: Metadata,
    /// [`Film::image_hash`]; only [`read`] makes sure that the pixels have it.
    pub image_hash: String,
}

impl ImageHeader {
    /// The first thing, beside the number of samples, in which another image is not a part of this one: what it is, this
    /// image's value and the other's.
    pub fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let size = |header: &Self| format!("{}x{}", header.width, header.height);
        let layers = |header: &Self| match (header.aovs.to_string(), header.aovs.lengths) {
            (list, _) if list.is_empty() => "none".to_owned(),
            (list, 0) => list,
            (list, lengths) => format!("{list} ({lengths} path lengths)"),
        };
        let scene = self.metadata.difference(&other.metadata);
        if let Some(("scene", ..)) = scene {
            return scene;
        }
        if size(self) != size(other) {
            return Some(("size", size(self), size(other)));
        }
        let aovs = (self.aovs != other.aovs).then(|| ("list of AOVs", layers(self), layers(other)));
        scene.or(aovs)
    }
}

/// Reads the header of an image that [`write()`] wrote, and makes sure that the file is not cut short.
///
/// # Errors
/// As [`read`].
pub fn read_header(path: &Path) -> Result<ImageHeader> {
    guard(path, |file| {
        let opened = Opened::new(path, file)?;
        // Blocks lie in their order: where the last one is, all are.
        let last = opened.meta.enumerate_ordered_header_block_indices().last();
        let last = last.map(|(_, block)| block.pixel_position);
        let chunks = opened
            .reader
            .filter_chunks(false, |_, _, block| Some(block.pixel_position) == last)
            .map_err(|error| cannot_decode(path, error))?;
        for chunk in chunks {
            chunk.map_err(|error| cannot_decode(path, error))?;
        }
        Ok(opened.header)
    })
}

/// An image of which the header is read.
struct Opened {
    reader: ::exr::block::reader::Reader<BufReader<File>>,
    meta: MetaData,
    header: ImageHeader,
    rejected: u64,
    /// For each channel, the exact numbers it holds, if any.
    sources: Vec<Option<Exact>>,
}

impl Opened {
    fn new(path: &Path, file: File) -> Result<Self> {
        let cannot = |error| cannot_decode(path, error);
        let bytes = file.metadata().map_or(0, |m| m.len());
        let reader =
            ::exr::block::read(BufReader::with_capacity(1 << 18, file), false).map_err(cannot)?;
        let meta = reader.meta_data().clone();
        let [header] = &meta.headers[..] else {
            return Err(foreign(path, "it has several parts"));
        };
        if header.deep || header.blocks != BlockDescription::ScanLines {
            return Err(foreign(path, "it is deep or tiled"));
        }
        // Deflate shrinks at most 1032-fold (zlib's technical notes): more pixels than that are a lie, and much memory.
        let area = header.layer_size.0 as u128 * header.layer_size.1 as u128;
        let claimed = area * header.channels.bytes_per_pixel.max(1) as u128;
        if claimed > u128::from(bytes) * 1100 {
            return Err(damaged(path, "it has fewer bytes than its size needs"));
        }
        let (aovs, sources) = exact_channels(header).map_err(|why| foreign(path, why))?;
        let (metadata, facts) = Metadata::from_attributes(&header.own_attributes.other)
            .map_err(|why| foreign(path, why))?;
        let (width, height, region) = windows(header)
            .filter(|(width, height, region)| {
                Region::full(*width, *height).contains(metadata.crop)
                    && metadata.crop.contains(*region)
                    && !region.is_empty()
            })
            .ok_or_else(|| foreign(path, "its windows do not fit"))?;
        Ok(Self {
            header: ImageHeader {
                width,
                height,
                region,
                aovs,
                metadata,
                image_hash: facts.image_hash,
            },
            rejected: facts.rejected,
            sources,
            reader,
            meta,
        })
    }
}

fn decode(path: &Path, file: File) -> Result<(Film, Metadata)> {
    let cannot = |error| cannot_decode(path, error);
    let Opened {
        reader,
        meta,
        header: image,
        rejected,
        sources,
    } = Opened::new(path, file)?;
    let header = &meta.headers[0];
    let mut film = Film::new(image.width, image.height, image.region, image.aovs)
        .map_err(|_| foreign(path, "its windows do not fit"))?;

    let mut chunks = reader.all_chunks(false).map_err(cannot)?;
    let mut rows = vec![false; film.region().height() as usize];
    loop {
        let batch: Vec<_> = chunks
            .by_ref()
            .take(BATCH)
            .collect::<::exr::error::Result<_>>()
            .map_err(cannot)?;
        if batch.is_empty() {
            break;
        }
        let blocks: Vec<_> = batch
            .into_par_iter()
            .map(|chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false))
            .collect::<::exr::error::Result<_>>()
            .map_err(cannot)?;
        for block in &blocks {
            place_block(&film, header, &sources, block, &mut rows)
                .map_err(|what| damaged(path, what))?;
        }
    }
    if rows.contains(&false) {
        return Err(damaged(path, "rows are missing"));
    }
    if !planes::is_possible(&film) {
        return Err(damaged(
            path,
            "its exact sums are beyond what its samples can give",
        ));
    }
    // The format has no checksum of its own that all decoders look at.
    if film.image_hash() != image.image_hash {
        return Err(damaged(
            path,
            "its pixels do not have the hash that it names",
        ));
    }
    film.set_rejected(rejected);
    Ok((film, image.metadata))
}

/// The AOVs of a file, and for each of its channels the exact numbers it holds, if any.
fn exact_channels(header: &Header) -> std::result::Result<(AovSet, Vec<Option<Exact>>), String> {
    let list = &header.channels.list;
    let names: Vec<_> = list
        .iter()
        .map(|channel| channel.name.to_string())
        .collect();
    let aovs = planes::aovs_among(&names);
    let mut sources = vec![None; names.len()];
    for plane in planes::planes(aovs) {
        let found = names.iter().position(|name| *name == plane.name);
        let Content::Exact(exact) = plane.content else {
            continue;
        };
        let Some(i) = found else {
            return Err(format!("the channel {} is missing", plane.name));
        };
        if list[i].sample_type != SampleType::U32 {
            return Err(format!(
                "the channel {} does not hold whole numbers",
                plane.name
            ));
        }
        sources[i] = Some(exact);
    }
    if list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err("a channel is subsampled".to_owned());
    }
    Ok((aovs, sources))
}

/// The size and the stored pixels that a file claims.
fn windows(header: &Header) -> Option<(u32, u32, Region)> {
    let display = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    if display.position != Vec2(0, 0) {
        return None;
    }
    let (x0, y0) = (
        u32::try_from(position.0).ok()?,
        u32::try_from(position.1).ok()?,
    );
    let region = Region {
        x0,
        y0,
        x1: x0.checked_add(u32::try_from(header.layer_size.0).ok()?)?,
        y1: y0.checked_add(u32::try_from(header.layer_size.1).ok()?)?,
    };
    let side = |length| u32::try_from(length).ok();
    Some((side(display.size.0)?, side(display.size.1)?, region))
}

/// Puts a block's exact channels into the film; what is wrong with it.
fn place_block(
    film: &Film,
    header: &Header,
    sources: &[Option<Exact>],
    block: &UncompressedBlock,
    rows: &mut [bool],
) -> std::result::Result<(), &'static str> {
    let (position, size) = (block.index.pixel_position, block.index.pixel_size);
    if position.x() != 0 || size.width() != header.layer_size.width() {
        return Err("a block is not as wide as the image");
    }
    for seen in rows
        .get_mut(position.y()..position.y() + size.height())
        .ok_or("a block lies outside")?
    {
        if std::mem::replace(seen, true) {
            return Err("a row comes twice");
        }
    }
    if block.data.len() != size.area() * header.channels.bytes_per_pixel {
        return Err("a block has the wrong size");
    }
    let mut words = Vec::with_capacity(size.width());
    for line in block.lines(&header.channels) {
        if let Some(content) = sources[line.location.channel] {
            let bytes = line.value.chunks_exact(4);
            words.clear();
            words.extend(bytes.map(|b| u32::from_ne_bytes([b[0], b[1], b[2], b[3]])));
            let y = film.region().y0 + line.location.position.y() as u32;
            planes::write_row(film, content, y, 0, &words);
        }
    }
    Ok(())
}
