//! The image file: one OpenEXR that opens in any viewer *and* merges exactly (see `planes` for its channels).
//!
//! Scanlines, run lengths (RLE): exact sums are mostly words that are 0 and words that look like noise, so deflate
//! makes a file that is an eighth smaller (with AOVs two fifths), takes fifteen times as long to pack and five to unpack.
//! The data window is the film's region, the display window the full image. Rows are compressed on the rayon pool that
//! the caller runs in, a few at a time: no second copy of the image is made.

mod read;
mod rle;

pub use read::{ImageHeader, add_to, read, read_header};

use super::metadata::{Attributes, FilmFacts, Metadata};
use super::planes::{self, Content, Plane};
use super::{Film, write_whole};
use crate::error::{Error, Result};
use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::error::Error as ExrError;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData};
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Rows that are compressed at once.
const BATCH: usize = 64;
/// Bytes of pixels that one thread compresses sooner than it would find another to help.
const ALONE: usize = 1 << 19;

/// Writes `film` and what is known of its render to `path`: whole, or [`Error::Write`] and nothing. Gives the film's
/// [`image_hash`](Film::image_hash), which takes a while to compute.
pub fn write(path: &Path, film: &Film, metadata: &Metadata) -> Result<String> {
    let image_hash = film.image_hash();
    write_whole(path, |file| {
        let checksum = encode(file, film, metadata, &image_hash).map_err(|error| match error {
            ExrError::Io(source) => source,
            other => io::Error::other(other.to_string()),
        })?;
        file.flush()?;
        put_checksum(file.get_mut(), &checksum)
    })?;
    Ok(image_hash)
}

/// Writes all but the checksum, which it gives back.
fn encode(
    file: &mut BufWriter<&mut File>,
    film: &Film,
    metadata: &Metadata,
    image_hash: &str,
) -> ::exr::error::Result<String> {
    let planes = planes::planes(film.aovs());
    let facts = FilmFacts {
        rejected: film.rejected(),
        image_hash: image_hash.to_owned(),
        checksum: NO_CHECKSUM.to_owned(),
    };
    let attributes = metadata.to_attributes(&facts);
    let mut checksum = Checksum::of(&Metadata::checked_bytes(&attributes));
    let header = header(film, attributes, &planes);
    let headers = [header].into_iter().collect();
    ::exr::block::write(file, headers, true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        let bytes = film.region().width() as usize * meta.headers[0].channels.bytes_per_pixel;
        for batch in blocks.chunks(BATCH) {
            let chunks: Vec<_> = batch
                .par_iter()
                .with_min_len(ALONE / bytes.max(1) + 1)
                .map(|&(index, block)| {
                    let block = uncompressed(film, &planes, &meta, block);
                    let sum = Checksum::of(&block.data);
                    Ok((index, sum, block.compress_to_chunk(&meta.headers)?))
                })
                .collect::<::exr::error::Result<_>>()?;
            for (index, sum, chunk) in chunks {
                checksum.add(&sum);
                writer.write_chunk(index, chunk)?;
            }
        }
        Ok(())
    })?;
    Ok(checksum.text())
}

/// Puts the checksum where the header has room for it: it is known only when all blocks are written.
fn put_checksum(file: &mut File, checksum: &str) -> io::Result<()> {
    // Name and type of the attribute, and how long its text is.
    let mut wanted = b"ondine.checksum\0string\0".to_vec();
    wanted.extend_from_slice(&(NO_CHECKSUM.len() as u32).to_le_bytes());
    wanted.extend_from_slice(NO_CHECKSUM.as_bytes());
    file.rewind()?;
    let mut header = Vec::new();
    Read::take(&mut *file, LONGEST_HEADER).read_to_end(&mut header)?;
    let place = header
        .windows(wanted.len())
        .position(|bytes| bytes == wanted)
        .ok_or_else(|| io::Error::other("its header has no room for a checksum"))?;
    let text = place + wanted.len() - NO_CHECKSUM.len();
    file.seek(SeekFrom::Start(text as u64))?;
    file.write_all(checksum.as_bytes())
}

/// As long as a checksum.
const NO_CHECKSUM: &str = "--------";
/// A header lists its channels, which are at most some thousands.
const LONGEST_HEADER: u64 = 1 << 20;

/// CRC-32 of what the header says of the render, and of the pixels of all channels, as blocks hold them before they are
/// compressed: run lengths notice no damage.
#[derive(Clone, Default)]
pub(crate) struct Checksum(crc32fast::Hasher);

impl Checksum {
    /// Of a block.
    pub fn of(bytes: &[u8]) -> Self {
        let mut sum = Self::default();
        sum.0.update(bytes);
        sum
    }

    /// Adds that of the next block.
    pub fn add(&mut self, next: &Self) {
        self.0.combine(&next.0);
    }

    /// As files say it.
    pub fn text(self) -> String {
        format!("{:08x}", self.0.finalize())
    }
}

fn header(film: &Film, own: Attributes, planes: &[Plane]) -> Header {
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
    let mut attributes = LayerAttributes {
        software_name: Some(Text::from_slice_unchecked(b"Ondine")),
        other: own,
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

fn uncompressed(
    film: &Film,
    planes: &[Plane],
    meta: &MetaData,
    block: BlockIndex,
) -> UncompressedBlock {
    UncompressedBlock::from_lines(&meta.headers[0].channels, block, |line| {
        let y = film.region().y0 + line.location.position.y() as u32;
        planes::read_row(film, planes[line.location.channel].content, y, line.value);
    })
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
