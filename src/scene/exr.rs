//! OpenEXR images, for skies and for textures.

use exr::prelude::{MetaData, ReadChannels, ReadLayers};
use std::io::{Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Width, height and row-major pixels.
pub(super) type Raster<P> = (usize, usize, Vec<P>);

/// Reads the first layer with R, G and B channels, finite and not negative, of at most `largest` pixels by width and
/// height; alpha is 1 where there is none. The message of an error says what to do.
pub(super) fn read<P: Clone + 'static>(
    source: impl Read + Seek,
    largest: (usize, usize),
    pixel: fn([f32; 4]) -> P,
) -> Result<Raster<P>, String> {
    // The decoder promises errors, not panics, but its input is anyone's file: a panic becomes an error too.
    catch_unwind(AssertUnwindSafe(|| decode(source, largest, pixel))).unwrap_or_else(|_| {
        Err("the EXR decoder gave up; the file is damaged, write it again".to_owned())
    })
}

fn decode<P: Clone + 'static>(
    mut source: impl Read + Seek,
    largest: (usize, usize),
    pixel: fn([f32; 4]) -> P,
) -> Result<Raster<P>, String> {
    let explain = |error: exr::error::Error| match error {
        exr::error::Error::Io(error) => format!("cannot read: {error}"),
        error => format!("is not an EXR image with R, G and B channels ({error}); convert it"),
    };
    let headers = MetaData::read_from_buffered(&mut source, false)
        .map_err(explain)?
        .headers;
    for header in &headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        if width > largest.0 || height > largest.1 {
            return Err(too_large(width, height, largest));
        }
    }
    source
        .seek(SeekFrom::Start(0))
        .map_err(|error| format!("cannot read: {error}"))?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            move |size, _| Canvas {
                width: size.width(),
                height: size.height(),
                pixels: vec![pixel([0.0; 4]); size.area()],
                wrong: None,
            },
            move |canvas: &mut Canvas<P>, at, (r, g, b, a): (f32, f32, f32, f32)| {
                for (value, channel) in [(r, 'R'), (g, 'G'), (b, 'B'), (a, 'A')] {
                    if !(value.is_finite() && value >= 0.0) {
                        let wrong = || not_light(at.x(), at.y(), channel, value);
                        canvas.wrong.get_or_insert_with(wrong);
                    }
                }
                canvas.pixels[at.y() * canvas.width + at.x()] = pixel([r, g, b, a]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        // One thread, this one: a panic elsewhere could not be caught here.
        .non_parallel()
        .from_buffered(source)
        .map_err(explain)?;
    let frame = image.attributes.display_window.size;
    let Canvas {
        width,
        height,
        pixels,
        wrong,
    } = image.layer_data.channel_data.pixels;
    if (frame.width(), frame.height()) != (width, height) {
        return Err(format!(
            "holds {width}×{height} pixels of a picture of {}×{}; save it uncropped",
            frame.width(),
            frame.height()
        ));
    }
    match wrong {
        Some(wrong) => Err(wrong),
        None => Ok((width, height, pixels)),
    }
}

/// Pixels while they are read.
struct Canvas<P> {
    width: usize,
    height: usize,
    pixels: Vec<P>,
    /// What is wrong with the first that is not light.
    wrong: Option<String>,
}

pub(super) fn too_large(width: usize, height: usize, largest: (usize, usize)) -> String {
    let (most_wide, most_high) = largest;
    format!("is {width}×{height} pixels; scale it down to at most {most_wide}×{most_high}")
}

pub(super) fn not_light(x: usize, y: usize, channel: char, value: f32) -> String {
    format!(
        "pixel ({x}, {y}) has {channel} = {value}; radiance is finite and at least 0, repair the image"
    )
}
