//! The image file: one OpenEXR that opens in any viewer *and* merges exactly (see `planes` for its channels).
//!
//! Scanlines, run lengths (RLE): exact sums are mostly words that are 0 and words that look like noise, so deflate
//! makes a file that is an eighth smaller (with AOVs two fifths), fifteen times as long to pack and eight to unpack.
//! The data window is the film's region, the display window the full image. Rows are compressed on the rayon pool that
//! the caller runs in, a few at a time: no second copy of the image is made.

mod read;
mod rle;

pub use read::{ImageHeader, add_to, read, read_header};

use super::metadata::{FilmFacts, Metadata};
use super::planes::{self, Content, Plane};
use super::{Film, write_whole};
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
use std::io::{self, Read, Seek, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Rows that are compressed at once.
const BATCH: usize = 64;

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
                Content::Samples | Content::Word(..) => SampleType::U32,
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
        Compression::RLE,
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
    UncompressedBlock::from_lines(&meta.headers[0].channels, block, |line| {
        let y = film.region().y0 + line.location.position.y() as u32;
        planes::read_row(film, planes[line.location.channel].content, y, line.value);
    })
    .compress_to_chunk(&meta.headers)
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
