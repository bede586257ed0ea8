//! OpenEXR files of any program: what is read of them, and what is said of those that cannot be.

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{IntegerBounds, LineOrder};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, WritableImage, f16};
use ondine::compare::read;
use std::path::{Path, PathBuf};

const SIZE: (usize, usize) = (37, 21);
const PIXELS: usize = SIZE.0 * SIZE.1;

fn value(channel: usize, pixel: usize) -> f32 {
    (channel * 1000 + pixel) as f32
}

fn floats(channel: usize) -> FlatSamples {
    FlatSamples::F32((0..PIXELS).map(|i| value(channel, i)).collect())
}

fn encoding(compression: Compression, blocks: Blocks) -> Encoding {
    Encoding {
        compression,
        blocks,
        line_order: LineOrder::Increasing,
    }
}

type Part<'a> = (&'a str, Encoding, Vec<(&'a str, FlatSamples)>);

fn write(path: &Path, parts: Vec<Part>) {
    let several = parts.len() > 1;
    let layers = parts.into_iter().map(|(name, encoding, channels)| {
        let mut attributes = match several {
            true => LayerAttributes::named(name),
            false => LayerAttributes::default(),
        };
        attributes.layer_position = Vec2(3, -2);
        let channels = channels
            .into_iter()
            .map(|(name, samples)| AnyChannel::new(name, samples))
            .collect();
        Layer::new(SIZE, attributes, encoding, AnyChannels::sort(channels))
    });
    let window = IntegerBounds::from_dimensions(SIZE);
    Image::from_layers(ImageAttributes::new(window), layers.collect::<Vec<_>>())
        .write()
        .to_file(path)
        .unwrap();
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    (folder, path)
}

fn lines() -> Encoding {
    encoding(Compression::ZIP16, Blocks::ScanLines)
}

fn rgb(first: usize, prefix: &str) -> Vec<(String, FlatSamples)> {
    let names = ["R", "G", "B"].into_iter().enumerate();
    names
        .map(|(c, name)| (format!("{prefix}{name}"), floats(first + c)))
        .collect()
}

fn borrowed(channels: &[(String, FlatSamples)]) -> Vec<(&str, FlatSamples)> {
    channels
        .iter()
        .map(|(name, samples)| (name.as_str(), samples.clone()))
        .collect()
}

#[track_caller]
fn refused(path: &Path, layer: Option<&str>, words: &[&str]) {
    let error = read(path, layer).unwrap_err().to_string();
    for word in words {
        assert!(error.contains(word), "{error}\nlacks {word:?}");
    }
    assert_eq!(error.lines().count(), 1, "{error}");
}

#[test]
fn every_storage_gives_the_same_pixels() {
    let (_folder, path) = folder();
    let tiles = Blocks::Tiles(Vec2(16, 8));
    for encoding in [
        encoding(Compression::Uncompressed, Blocks::ScanLines),
        encoding(Compression::ZIP1, Blocks::ScanLines),
        lines(),
        encoding(Compression::PIZ, Blocks::ScanLines),
        encoding(Compression::RLE, tiles),
        encoding(Compression::ZIP16, tiles),
    ] {
        let mut channels = rgb(0, "");
        channels.push(("A".to_owned(), floats(9)));
        channels.push(("Z.depth".to_owned(), floats(8)));
        write(&path, vec![("", encoding, borrowed(&channels))]);
        let image = read(&path, None).unwrap();
        assert_eq!(
            (image.width, image.height, image.x0, image.y0),
            (37, 21, 3, -2)
        );
        for c in 0..3 {
            for (i, &got) in image.image.radiance[c].iter().enumerate() {
                assert_eq!(got, value(c, i), "{encoding:?}");
            }
        }
        assert!(image.image.variance.is_none() && image.samples.is_none());
    }
}

#[test]
fn halves_and_whole_numbers_are_read_as_they_are() {
    let (_folder, path) = folder();
    let halves = FlatSamples::F16((0..PIXELS).map(|i| f16::from_f32(i as f32)).collect());
    let whole = FlatSamples::U32((0..PIXELS).map(|i| i as u32).collect());
    let channels = vec![("R", halves), ("G", whole), ("B", floats(0))];
    write(&path, vec![("", lines(), channels)]);
    let image = read(&path, None).unwrap();
    assert_eq!(image.image.radiance[0], image.image.radiance[2]);
    assert_eq!(image.image.radiance[1], image.image.radiance[2]);
}

#[test]
fn variances_counts_and_path_lengths_come_along() {
    let (_folder, path) = folder();
    let prefixes = [
        "",
        "variance.",
        "length.10.",
        "length.2.",
        "variance.length.2.",
    ];
    let mut channels: Vec<_> = prefixes
        .iter()
        .enumerate()
        .flat_map(|(k, prefix)| rgb(10 * k, prefix))
        .collect();
    channels.push((
        "exact.samples".to_owned(),
        FlatSamples::U32(vec![64; PIXELS]),
    ));
    write(&path, vec![("", lines(), borrowed(&channels))]);
    let image = read(&path, None).unwrap();
    assert_eq!(image.image.radiance[2][5], value(2, 5));
    assert_eq!(image.image.variance.unwrap()[1][5], value(11, 5));
    assert_eq!(image.samples.unwrap()[7], 64.0);
    let lengths: Vec<u32> = image.lengths.iter().map(|(length, _)| *length).collect();
    assert_eq!(lengths, [2, 10]);
    assert_eq!(image.lengths[0].1.radiance[0][1], value(30, 1));
    assert_eq!(
        image.lengths[0].1.variance.as_ref().unwrap()[2][1],
        value(42, 1)
    );
    assert!(image.lengths[1].1.variance.is_none());
}

#[test]
fn of_several_layers_one_is_chosen_and_a_plain_one_needs_no_choice() {
    let (_folder, path) = folder();
    // As Blender writes one view layer.
    let one = rgb(0, "ViewLayer.Combined.");
    write(&path, vec![("", lines(), borrowed(&one))]);
    assert_eq!(read(&path, None).unwrap().image.radiance[0][3], value(0, 3));

    let mut two = one;
    two.extend(rgb(20, "ViewLayer.DiffDir."));
    write(&path, vec![("", lines(), borrowed(&two))]);
    refused(
        &path,
        None,
        &["--layer", "\"ViewLayer.Combined\"", "\"ViewLayer.DiffDir\""],
    );
    refused(
        &path,
        Some("Combined"),
        &["\"Combined\"", "\"ViewLayer.Combined\""],
    );
    let chosen = read(&path, Some("ViewLayer.DiffDir")).unwrap();
    assert_eq!(chosen.image.radiance[1][3], value(21, 3));

    two.extend(rgb(40, ""));
    write(&path, vec![("", lines(), borrowed(&two))]);
    assert_eq!(
        read(&path, None).unwrap().image.radiance[0][3],
        value(40, 3)
    );
}

#[test]
fn parts_are_chosen_by_their_names() {
    let (_folder, path) = folder();
    let (first, second) = (rgb(0, ""), rgb(20, ""));
    let parts = || {
        vec![
            ("beauty", lines(), borrowed(&first)),
            ("albedo", lines(), borrowed(&second)),
        ]
    };
    write(&path, parts());
    refused(&path, None, &["--layer", "\"beauty\"", "\"albedo\""]);
    assert_eq!(
        read(&path, Some("albedo")).unwrap().image.radiance[0][3],
        value(20, 3)
    );
    assert_eq!(
        read(&path, Some("beauty")).unwrap().image.radiance[0][3],
        value(0, 3)
    );
}

#[test]
fn what_cannot_be_compared_is_said() {
    let (_folder, path) = folder();
    write(&path, vec![("", lines(), vec![("Y", floats(0))])]);
    refused(&path, None, &["luminance"]);
    write(
        &path,
        vec![("", lines(), vec![("R", floats(0)), ("G", floats(1))])],
    );
    refused(&path, None, &["no channels R, G and B", "it has G, R"]);

    let mut holes: Vec<f32> = vec![1.0; PIXELS];
    (holes[SIZE.0 + 2], holes[SIZE.0 * 3]) = (f32::NAN, f32::INFINITY);
    let channels = |holes: Vec<f32>| {
        vec![
            ("R", floats(0)),
            ("G", FlatSamples::F32(holes)),
            ("B", floats(2)),
        ]
    };
    write(&path, vec![("", lines(), channels(holes))]);
    refused(&path, None, &["G is NaN at pixel 5,-1", "one more"]);

    let mut with_variance = rgb(0, "");
    with_variance.extend(rgb(10, "variance."));
    with_variance[4].1 = FlatSamples::F32(vec![-1.0; PIXELS]);
    write(&path, vec![("", lines(), borrowed(&with_variance))]);
    refused(&path, None, &["variance.G is -1 at pixel 3,-2", "776 more"]);

    std::fs::write(&path, b"PNG?").unwrap();
    refused(&path, None, &["not an OpenEXR image"]);
    refused(
        Path::new("nowhere.exr"),
        None,
        &["nowhere.exr", "cannot read"],
    );
}

#[test]
fn damaged_files_are_refused_and_never_stop_the_program() {
    let (_folder, path) = folder();
    let channels = rgb(0, "");
    let tiles = encoding(Compression::ZIP16, Blocks::Tiles(Vec2(16, 8)));
    for encoding in [
        lines(),
        tiles,
        encoding(Compression::PIZ, Blocks::ScanLines),
    ] {
        write(&path, vec![("", encoding, borrowed(&channels))]);
        let whole = std::fs::read(&path).unwrap();
        let mut refusals = 0;
        for end in (0..whole.len()).step_by(whole.len() / 50) {
            std::fs::write(&path, &whole[..end]).unwrap();
            read(&path, None).unwrap_err();
        }
        for damaged in crate::common::mutations(7, &whole, 300) {
            std::fs::write(&path, &damaged).unwrap();
            refusals += usize::from(read(&path, None).is_err());
        }
        assert!(refusals > 100, "{refusals} refusals of 300");
    }
}
