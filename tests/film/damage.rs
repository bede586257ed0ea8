//! Files that are damaged, cut short or not ours: a format error, and never another image.

use super::files::{CROP, metadata, sample_film, written};
use crate::{ALL, Random, assert_same};
use ondine::error::Error;
use ondine::film::{Coverage, Film, Metadata, describe, exr};
use std::path::Path;

#[test]
fn a_part_that_was_changed_is_not_added_unseen() {
    let (_folder, path) = written();
    let bytes = std::fs::read(&path).unwrap();
    let mut random = Random(5);
    let mut refused = 0;
    for _ in 0..100 {
        let mut mutant = bytes.clone();
        // Behind the header and the table of offsets.
        let at = 12_000 + random.below(bytes.len() - 12_000);
        mutant[at] ^= 1 << random.below(8);
        std::fs::write(&path, &mutant).unwrap();
        let sum = Film::new(50, 60, CROP, ALL).unwrap();
        match exr::add_to(&path, &sum) {
            // What viewers see alone was changed.
            Ok(_) => assert_same(&sum, &sample_film()),
            Err(Error::Format { .. }) => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused >= 50, "{refused}");
}

#[test]
fn what_the_header_says_of_the_render_is_checked_too() {
    let (_folder, path) = written();
    let bytes = std::fs::read(&path).unwrap();
    let mut found = 0;
    for (name, value) in [
        ("ondine.blocks", &b"0..3478"[..]),
        ("ondine.seed", b"18446744073709551615"),
        ("ondine.scene_hash", b"0123456789abcdef"),
        ("ondine.checksum", b""),
    ] {
        let at = bytes.windows(name.len()).position(|w| w == name.as_bytes());
        let value_at = at.unwrap() + name.len() + b"\0string\0____".len();
        assert!(bytes[value_at..].starts_with(value), "{name}");
        // The last digit of the first number, and one bit of it.
        for bit in 0..4 {
            let mut mutant = bytes.clone();
            mutant[value_at + value.len().max(1) - 1] ^= 1 << bit;
            std::fs::write(&path, mutant).unwrap();
            let sum = Film::new(50, 60, CROP, ALL).unwrap();
            for result in [
                exr::read(&path).map(drop),
                exr::add_to(&path, &sum).map(drop),
            ] {
                assert!(
                    matches!(result, Err(Error::Format { .. })),
                    "{name}, bit {bit}"
                );
                found += 1;
            }
        }
    }
    assert_eq!(found, 32);

    // Sums and header that do not fit each other, though both are as they were written.
    let less = Metadata {
        blocks: Coverage::of([0..2 * 1739 - 1, 2 * 1739 + 154..2 * 1739 + 155]),
        ..metadata()
    };
    exr::write(&path, &sample_film(), &less).unwrap();
    let message = exr::read(&path).unwrap_err().to_string();
    assert!(message.contains("other samples than it says"), "{message}");
}

#[test]
fn what_is_no_image_of_ours_is_a_format_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.exr");
    let message = |path: &Path| match exr::read(path) {
        Err(Error::Format { message, .. }) => message,
        other => panic!("{other:?}"),
    };
    std::fs::write(&path, "not an image").unwrap();
    assert!(message(&path).contains("not an OpenEXR image"));
    std::fs::write(&path, "").unwrap();
    assert!(message(&path).contains("not an OpenEXR image"));
    ::exr::prelude::write_rgb_file(&path, 4, 4, |x, y| (x as f32, y as f32, 0.0_f32)).unwrap();
    assert!(message(&path).contains("no image that Ondine wrote"));
    assert_eq!(describe(&path).unwrap().parts[0].channels.len(), 3);
    assert!(matches!(
        exr::read(&folder.path().join("none.exr")),
        Err(Error::Read { .. })
    ));
    assert!(matches!(exr::read(folder.path()), Err(Error::Read { .. })));
}

#[test]
fn a_file_cut_anywhere_is_a_format_error() {
    let (_folder, path) = written();
    let bytes = std::fs::read(&path).unwrap();
    let mut random = Random(3);
    let cuts = (0..8).chain((0..150).map(|_| random.below(bytes.len())));
    for cut in cuts.chain([bytes.len() - 1]) {
        std::fs::write(&path, &bytes[..cut]).unwrap();
        assert!(
            matches!(exr::read(&path), Err(Error::Format { .. })),
            "cut at {cut}"
        );
        let _ = describe(&path);
    }
}

#[test]
fn no_mutation_of_a_file_makes_the_reader_panic_or_changes_a_pixel_unseen() {
    let (_folder, path) = written();
    let bytes = std::fs::read(&path).unwrap();
    let hash = sample_film().image_hash();
    let mut random = Random(4);
    for round in 0..600 {
        let mut mutant = bytes.clone();
        // Mostly the header and the first blocks, where the structure is.
        let reach = if round % 3 == 0 { mutant.len() } else { 4000 };
        for _ in 0..1 + random.below(4) {
            let at = random.below(reach);
            mutant[at] = match random.below(4) {
                0 => 0,
                1 => 0xff,
                2 => mutant[at] ^ (1 << random.below(8)),
                _ => random.bits() as u8,
            };
        }
        std::fs::write(&path, &mutant).unwrap();
        match exr::read(&path) {
            Ok((film, _)) => assert_eq!(film.image_hash(), hash),
            Err(Error::Format { .. } | Error::Read { .. }) => {}
            Err(error) => panic!("{error}"),
        }
        let _ = describe(&path);
    }
}
