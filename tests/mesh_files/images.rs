//! Images: six formats, two meanings of their numbers.

use super::common::mutations;
use image::{DynamicImage, ImageFormat};
use ondine::scene::description::{Image, Pixels};
use ondine::scene::image::{ColorSpace, decode, read};
use std::io::Cursor;
use std::path::Path;

/// Two by three pixels.
const TEXELS: [[u8; 4]; 6] = [
    [0, 10, 255, 255],
    [255, 128, 0, 255],
    [1, 2, 3, 255],
    [9, 9, 9, 255],
    [200, 100, 50, 255],
    [255, 255, 255, 255],
];

fn raster() -> image::RgbaImage {
    image::RgbaImage::from_raw(2, 3, TEXELS.concat()).expect("6 pixels")
}

fn encode(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("an image");
    bytes.into_inner()
}

fn exr() -> Vec<u8> {
    use exr::prelude::{SpecificChannels, WritableImage};
    let texel = |at: exr::prelude::Vec2<usize>| (at.x() as f32, at.y() as f32, 0.25, 0.5);
    let image = exr::prelude::Image::from_channels((2, 3), SpecificChannels::rgba(texel));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).expect("an image");
    bytes.into_inner()
}

fn refusal(bytes: &[u8], name: &str) -> String {
    match decode(bytes, name, ColorSpace::Srgb) {
        Ok(_) => panic!("{name} is decoded without complaint"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn eight_bits_stay_as_they_are() {
    let image = DynamicImage::ImageRgba8(raster());
    for (format, name) in [
        (ImageFormat::Png, "a.png"),
        (ImageFormat::Bmp, "a.bmp"),
        (ImageFormat::Tga, "a.tga"),
    ] {
        let bytes = encode(&image, format);
        let decoded = decode(&bytes, name, ColorSpace::Srgb).expect(name);
        assert_eq!((decoded.width, decoded.height), (2, 3), "{name}");
        assert_eq!(decoded.file, name);
        assert!(matches!(&decoded.pixels, Pixels::Srgb8(texels) if texels == &TEXELS));
        let decoded = decode(&bytes, name, ColorSpace::Linear).expect(name);
        assert!(matches!(&decoded.pixels, Pixels::Linear8(texels) if texels == &TEXELS));
    }
}

#[test]
fn a_jpeg_and_a_grey_image_are_colours() {
    let grey = image::GrayImage::from_pixel(8, 8, image::Luma([77]));
    for format in [ImageFormat::Jpeg, ImageFormat::Png] {
        let bytes = encode(&grey.clone().into(), format);
        let decoded = decode(&bytes, "embedded", ColorSpace::Srgb).expect("an image");
        assert!(
            matches!(&decoded.pixels, Pixels::Srgb8(texels) if texels == &[[77, 77, 77, 255]; 64])
        );
    }
}

#[test]
fn sixteen_bits_become_linear_floats() {
    let values = [0u16, 2570, 32768, 65535];
    let image = image::ImageBuffer::from_raw(1, 1, values.to_vec()).expect("a pixel");
    let bytes = encode(&DynamicImage::ImageRgba16(image), ImageFormat::Png);
    let texel = |space| match decode(&bytes, "a.png", space).expect("an image").pixels {
        Pixels::Float(texels) => texels[0],
        other => panic!("{other:?}"),
    };
    assert_eq!(
        texel(ColorSpace::Linear),
        values.map(|v| f32::from(v) / 65535.0)
    );
    let [r, g, b, a] = texel(ColorSpace::Srgb);
    assert_eq!((r, a), (0.0, 1.0));
    let curve = |s: f64| {
        if s <= 0.04045 {
            s / 12.92
        } else {
            ((s + 0.055) / 1.055).powf(2.4)
        }
    };
    for (got, value) in [(g, 2570.0), (b, 32768.0)] {
        assert!(
            (f64::from(got) - curve(value / 65535.0)).abs() < 1e-7,
            "{got}"
        );
    }
}

#[test]
fn floats_are_linear_whatever_is_asked() {
    let hdr = image::Rgb32FImage::from_pixel(2, 3, image::Rgb([2.0, 0.5, 0.0]));
    let hdr = encode(&DynamicImage::ImageRgb32F(hdr), ImageFormat::Hdr);
    for space in [ColorSpace::Srgb, ColorSpace::Linear] {
        let Image { pixels, .. } = decode(&hdr, "a.hdr", space).expect("an HDR");
        assert!(matches!(&pixels, Pixels::Float(texels) if texels == &[[2.0, 0.5, 0.0, 1.0]; 6]));
        let Image { pixels, .. } = decode(&exr(), "a.exr", space).expect("an EXR");
        assert!(matches!(&pixels, Pixels::Float(texels) if texels[3] == [1.0, 1.0, 0.25, 0.5]));
    }
}

#[test]
fn what_is_no_image_is_refused_by_name() {
    assert!(refusal(b"once upon a time", "a.png").starts_with("a.png: cannot decode it: "));
    let message = refusal(b"once upon a time", "buffer 3");
    assert!(
        message.starts_with("buffer 3: is not an image that is read"),
        "{message}"
    );
    let missing = read(Path::new("none/such.png"), ColorSpace::Srgb).expect_err("no file");
    assert!(
        missing
            .to_string()
            .starts_with("none/such.png: cannot read: ")
    );
}

#[test]
fn a_size_beyond_reason_is_refused_before_it_is_allocated() {
    let mut png = encode(&raster().into(), ImageFormat::Png);
    // Width and height of the header chunk, and its checksum.
    png[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let crc = png[12..29].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
        })
    });
    png[29..33].copy_from_slice(&(!crc).to_be_bytes());
    let message = refusal(&png, "a.png");
    assert!(
        message.contains("scale it down to at most 16384×16384"),
        "{message}"
    );
}

#[test]
fn a_damaged_image_is_refused_or_decoded_and_never_a_panic() {
    let images = [
        ("a.png", encode(&raster().into(), ImageFormat::Png)),
        (
            "a.jpg",
            encode(
                &DynamicImage::from(raster()).to_rgb8().into(),
                ImageFormat::Jpeg,
            ),
        ),
        ("a.tga", encode(&raster().into(), ImageFormat::Tga)),
        ("a.bmp", encode(&raster().into(), ImageFormat::Bmp)),
        (
            "a.hdr",
            encode(
                &DynamicImage::from(raster()).to_rgb32f().into(),
                ImageFormat::Hdr,
            ),
        ),
        ("a.exr", exr()),
    ];
    for (seed, (name, whole)) in images.iter().enumerate() {
        let mut refused = 0;
        for bytes in mutations(seed as u64, whole, 500) {
            if let Err(error) = decode(&bytes, name, ColorSpace::Srgb) {
                let message = error.to_string();
                assert!(
                    !message.contains("gave up"),
                    "{message}: a panic was caught"
                );
                assert!(message.starts_with(&format!("{name}: ")), "{message}");
                refused += 1;
            }
        }
        assert!(refused > 50, "{name}: {refused} refused");
    }
}
