//! From the file to the film: row after row, so that a part of a merge takes no film of its own.

use super::{Checksum, cannot_decode, damaged, foreign, guard, rle};
use crate::error::{Error, Result};
use crate::film::metadata::Metadata;
use crate::film::planes::{self, Content, Number, WORDS};
use crate::film::{AovSet, Band, Film, Region};
use ::exr::block::chunk::CompressedBlock;
use ::exr::compression::Compression;
use ::exr::error::Error as ExrError;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::Path;

/// Reads an image that [`write()`](super::write()) wrote: the film with its exact sums, and what is known of its render.
///
/// [`Error::Read`] where the system refuses, [`Error::Format`] where the file is no EXR, is damaged, or is not an
/// image of this program. Whatever the file holds: no panic, and no more memory than its size allows for.
pub fn read(path: &Path) -> Result<(Film, Metadata)> {
    guard(path, |file| {
        let opened = Opened::new(path, file)?;
        let image = &opened.header;
        let film = Film::new(image.width, image.height, image.region, image.aovs)
            .map_err(|_| foreign(path, "its windows do not fit"))?;
        let image_hash = image.image_hash.clone();
        let metadata = opened.add_to(path, &film)?;
        if film.image_hash() != image_hash {
            let what = "its pixels do not have the hash that it names";
            return Err(damaged(path, what));
        }
        Ok((film, metadata))
    })
}

/// Adds the exact pixels of an image to a film, and gives what is known of its render: [`read`] and [`Film::merge`] without
/// a film in between. Takes one thread; several files can be added at once.
///
/// # Errors
/// Those of [`read`]; [`Error::Format`] where the film does not hold the image's region, or has another size or other AOVs;
/// [`Error::Usage`] where a pixel would hold more than [`MAX_SAMPLES`](crate::film::MAX_SAMPLES). Part of the image may
/// have been added: the film is of no use then.
pub fn add_to(path: &Path, film: &Film) -> Result<Metadata> {
    guard(path, |file| {
        let opened = Opened::new(path, file)?;
        let image = &opened.header;
        let fits =
            (image.width, image.height, image.aovs) == (film.width(), film.height(), film.aovs());
        if !fits || !film.region().contains(image.region) {
            let message = "its size, crop or AOVs are not those of the image it is added to; give a part of that image";
            return Err(Error::format(path, message));
        }
        opened.add_to(path, film)
    })
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

/// Reads the header of an image that [`write()`](super::write()) wrote, and makes sure that the file is not cut short.
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
    checksum: String,
    exact: ExactChannels,
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
        let (aovs, exact) = exact_channels(header).map_err(|why| foreign(path, why))?;
        let attributes = &header.own_attributes.other;
        let (metadata, facts) = Metadata::from_attributes(attributes).map_err(|why| {
            match Metadata::version_of(attributes) {
                Some(version) => Error::format(
                    path,
                    format!(
                        "another build of Ondine ({version}) wrote this image, and its exact sums cannot be used ({why}); render it again"
                    ),
                ),
                None => foreign(path, why),
            }
        })?;
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
            checksum: facts.checksum,
            exact,
            reader,
            meta,
        })
    }

    /// Adds the pixels to a film that has place for them.
    fn add_to(self, path: &Path, film: &Film) -> Result<Metadata> {
        let cannot = |error| cannot_decode(path, error);
        let header = &self.meta.headers[0];
        let ImageHeader { region, aovs, .. } = self.header;
        let bytes_per_row = region.width() as usize * header.channels.bytes_per_pixel;
        let mut row = Band::new(region.width() as usize, aovs);
        let attributes = &header.own_attributes.other;
        let mut checksum = Checksum::of(&Metadata::checked_bytes(attributes));
        let mut samples = self.rejected;
        let mut y = region.y0;
        for chunk in self.reader.all_chunks(false).map_err(cannot)? {
            let CompressedBlock::ScanLine(block) = chunk.map_err(cannot)?.compressed_block else {
                return Err(damaged(path, "it has blocks that are no scanlines"));
            };
            // Rows are hashed in their order, which is that of the files that are written here.
            if i64::from(block.y_coordinate) != i64::from(y) || y == region.y1 {
                return Err(damaged(path, "rows are missing, or not in order"));
            }
            let bytes =
                unpack(header, y - region.y0, block.compressed_pixels_le).map_err(cannot)?;
            checksum.add(&Checksum::of(&bytes));
            for bytes in bytes.chunks_exact(bytes_per_row) {
                self.exact.decode(bytes, aovs, &mut row);
                if !planes::is_possible(&row, aovs) {
                    let what = "its exact sums are beyond what its samples can give";
                    return Err(damaged(path, what));
                }
                samples += row
                    .counts
                    .iter()
                    .map(|&count| u64::from(count))
                    .sum::<u64>();
                film.add_row(region.x0, y, &row)?;
                y += 1;
            }
        }
        if y != region.y1 {
            return Err(damaged(path, "rows are missing"));
        }
        // The format has none of its own.
        if checksum.text() != self.checksum {
            let what = "its pixels do not have the checksum that it names";
            return Err(damaged(path, what));
        }
        let metadata = self.header.metadata;
        let pixels = metadata.crop.pixels() as u64;
        if samples != metadata.blocks.paths(pixels, metadata.spp) {
            let what = "it has other samples than it says";
            return Err(damaged(path, what));
        }
        film.add_rejected(self.rejected);
        Ok(metadata)
    }
}

/// The bytes of a block of whole rows, the first of which is `row` of the data window, in the machine's own order.
fn unpack(header: &Header, row: u32, packed: Vec<u8>) -> std::result::Result<Vec<u8>, ExrError> {
    let Vec2(width, height) = header.layer_size;
    let rows = header
        .compression
        .scan_lines_per_block()
        .min(height - row as usize);
    let length = width * rows * header.channels.bytes_per_pixel;
    // What does not shrink is stored as it is.
    if header.compression == Compression::RLE
        && packed.len() < length
        && cfg!(target_endian = "little")
    {
        let damage = || ExrError::Invalid("run lengths".into());
        return rle::unpack(&packed, length).ok_or_else(damage);
    }
    let place = IntegerBounds::new(Vec2(0, row as i32), Vec2(width, rows));
    let compression = header.compression;
    compression.decompress_image_section_from_le(header, packed, place, false)
}

/// Where the exact numbers are in a row of a block.
struct ExactChannels {
    samples: Range<usize>,
    numbers: Vec<(Number, [Range<usize>; WORDS as usize])>,
}

impl ExactChannels {
    /// The exact pixels of a row.
    fn decode(&self, bytes: &[u8], aovs: AovSet, row: &mut Band) {
        let samples = bytes[self.samples.clone()].as_chunks().0;
        for (count, &bytes) in row.counts.iter_mut().zip(samples) {
            *count = u32::from_ne_bytes(bytes);
        }
        for (number, words) in &self.numbers {
            let words = words.each_ref().map(|place| &bytes[place.clone()]);
            planes::write_row(row, aovs, *number, words);
        }
    }
}

/// The AOVs of a file, and where its exact numbers are.
fn exact_channels(header: &Header) -> std::result::Result<(AovSet, ExactChannels), String> {
    let list = &header.channels.list;
    if list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err("a channel is subsampled".to_owned());
    }
    // The channels of a row lie one after the other.
    let mut end = 0;
    let places: HashMap<String, (SampleType, Range<usize>)> = list
        .iter()
        .map(|channel| {
            let start = end;
            end += header.layer_size.width() * channel.sample_type.bytes_per_sample();
            (channel.name.to_string(), (channel.sample_type, start..end))
        })
        .collect();
    let aovs = planes::aovs_among(|name| places.contains_key(name));
    let mut exact = ExactChannels {
        samples: 0..0,
        numbers: Vec::new(),
    };
    for plane in planes::planes(aovs) {
        if let Content::Shown(_) = plane.content {
            continue;
        }
        let place = match places.get(&plane.name) {
            None => return Err(format!("the channel {} is missing", plane.name)),
            Some((SampleType::U32, place)) => place.clone(),
            Some(_) => {
                return Err(format!(
                    "the channel {} does not hold whole numbers",
                    plane.name
                ));
            }
        };
        match plane.content {
            Content::Shown(_) => {}
            Content::Samples => exact.samples = place,
            Content::Word(number, w) => {
                // The words of a number are neighbours by name, the least first.
                if w == 0 {
                    exact.numbers.push((number, Default::default()));
                }
                if let Some((_, words)) = exact.numbers.last_mut() {
                    words[w as usize] = place;
                }
            }
        }
    }
    Ok((aovs, exact))
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
