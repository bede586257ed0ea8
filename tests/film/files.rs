//! Files: whole or not there, and exact.

use crate::{ALL, assert_same, filled};
use ondine::error::Error;
use ondine::film::tonemap::{Operator, Tonemap};
use ondine::film::{
    AovSet, Coverage, Film, Layers, Metadata, Region, describe, exr, png, write_whole,
};
use std::io::Write;
use std::path::{Path, PathBuf};

pub(crate) fn metadata() -> Metadata {
    Metadata {
        scene: "scènes/châlet 🎬.toml".to_owned(),
        scene_hash: "0123456789abcdef".to_owned(),
        camera: String::new(),
        seed: u64::MAX,
        spp: 33,
        crop: CROP,
        shard: "3/16".parse().ok(),
        // Two passes over its 37 x 47 pixels, and the last sample of pixel 9,9.
        blocks: Coverage::of([0..2 * 1739, 2 * 1739 + 154..2 * 1739 + 155]),
        path_length: u32::MAX,
        strategy: "mis".to_owned(),
        sampler: "sobol".to_owned(),
        roulette: Some(3),
        version: "0.1.0".to_owned(),
        target_features: "avx2,fma".to_owned(),
        seconds: 12.345_678_901,
        rays: 98_765_432_101,
        interrupted: true,
    }
}

pub(crate) const CROP: Region = Region {
    x0: 3,
    y0: 5,
    x1: 40,
    y1: 52,
};

/// 47 rows, so that the last block is not full; one sample is rejected.
pub(crate) fn sample_film() -> Film {
    let film = filled(50, 60, CROP, 32);
    let pixel = Region {
        x0: 9,
        y0: 9,
        x1: 10,
        y1: 10,
    };
    let layers = Layers {
        first_hits: &[Default::default()],
        by_length: &[vec![[0.0; 4]], vec![[0.0; 4]]],
    };
    film.add(pixel, 1, &[[f32::NAN; 4]], layers);
    film
}

/// A file that was written, and the folder that holds it.
pub(crate) fn written() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    exr::write(&path, &sample_film(), &metadata()).unwrap();
    (folder, path)
}

fn is_empty(folder: &Path) -> bool {
    std::fs::read_dir(folder).unwrap().next().is_none()
}

#[test]
fn an_exr_gives_back_every_bit() {
    let (folder, path) = written();
    let (film, read) = exr::read(&path).unwrap();
    assert_eq!(read, metadata());
    assert_eq!((film.width(), film.height(), film.aovs()), (50, 60, ALL));
    assert_eq!(film.rejected(), 1);
    assert_same(&film, &sample_film());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn parts_merge_from_files_as_in_memory_with_their_aovs() {
    let (_folder, path) = written();
    let (mut film, _) = exr::read(&path).unwrap();
    let (again, _) = exr::read(&path).unwrap();
    film.merge(&again).unwrap();
    let mut expected = sample_film();
    expected.merge(&sample_film()).unwrap();
    assert_same(&film, &expected);
    assert_eq!(film.rejected(), 2);
}

#[test]
fn parts_added_from_files_are_what_their_films_merge_to() {
    let (_folder, path) = written();
    let sum = Film::new(50, 60, Region::full(50, 60), ALL).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| assert_eq!(exr::add_to(&path, &sum).unwrap(), metadata()));
        }
    });
    let mut expected = Film::new(50, 60, Region::full(50, 60), ALL).unwrap();
    for _ in 0..3 {
        expected.merge(&sample_film()).unwrap();
    }
    assert_same(&sum, &expected);
    assert_eq!(sum.rejected(), 3);
}

#[test]
fn a_part_is_not_added_to_a_film_of_another_shape() {
    let (_folder, path) = written();
    let full = Region::full(50, 60);
    let narrow = Region {
        x1: CROP.x1 - 1,
        ..CROP
    };
    let lengths = AovSet { lengths: 1, ..ALL };
    for (width, region, aovs) in [
        (50, narrow, ALL),
        (51, full, ALL),
        (50, full, AovSet::default()),
        (50, full, lengths),
    ] {
        let film = Film::new(width, 60, region, aovs).unwrap();
        let error = exr::add_to(&path, &film).unwrap_err();
        assert!(matches!(error, Error::Format { .. }), "{error}");
        assert_eq!(film.total_samples(), 0);
    }
}

#[test]
fn an_image_that_another_program_deflated_comes_back_bit_for_bit() {
    use ::exr::compression::Compression;
    use ::exr::image::{Blocks, Encoding};
    use ::exr::meta::attribute::LineOrder;
    use ::exr::prelude::{WritableImage, read_all_flat_layers_from_file};
    let (_folder, path) = written();
    let mut image = read_all_flat_layers_from_file(&path).unwrap();
    for compression in [
        Compression::ZIP16,
        Compression::ZIP1,
        Compression::Uncompressed,
    ] {
        image.layer_data[0].encoding = Encoding {
            compression,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        image.write().to_file(&path).unwrap();
        let (film, read) = exr::read(&path).unwrap();
        assert_eq!(read, metadata());
        assert_same(&film, &sample_film());
    }
}

#[test]
fn an_exr_without_aovs_comes_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.exr");
    let film = Film::new(5, 4, Region::full(5, 4), AovSet::default()).unwrap();
    film.add(
        Region::full(5, 4),
        1,
        &[[-0.5, 2.0, 1e-6, 0.0]; 20],
        Layers::default(),
    );
    let metadata = Metadata {
        crop: Region::full(5, 4),
        spp: 1,
        blocks: Coverage::of(std::iter::once(0..20)),
        shard: None,
        roulette: None,
        ..metadata()
    };
    exr::write(&path, &film, &metadata).unwrap();
    let (read, told) = exr::read(&path).unwrap();
    assert_eq!(told, metadata);
    assert_same(&read, &film);
}

#[test]
fn a_description_lists_what_the_file_holds() {
    let (_folder, path) = written();
    let description = describe(&path).unwrap();
    let [part] = &description.parts[..] else {
        panic!("one part");
    };
    assert_eq!(part.data_window, [3, 5, 40, 52]);
    assert_eq!(part.display_window, [0, 0, 50, 60]);
    assert_eq!((part.compression, part.storage), ("rle", "scanline"));
    let kind = |name: &str| {
        part.channels
            .iter()
            .find(|c| c.name == name)
            .map(|c| c.kind)
    };
    assert_eq!(kind("R"), Some("float"));
    assert_eq!(kind("variance.B"), Some("float"));
    assert_eq!(kind("normal.Z"), Some("float"));
    assert_eq!(kind("exact.square.G.3"), Some("uint"));
    assert_eq!(kind("exact.depth.Z.0"), Some("uint"));
    assert_eq!(part.attributes["ondine.scene"], metadata().scene);
    assert_eq!(part.attributes["ondine.spp"], 33);
    assert!(
        serde_json::to_string(&description)
            .unwrap()
            .contains("ondine.seed")
    );
}

#[test]
fn an_unwritable_place_is_a_write_error_that_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "kept").unwrap();
    let failing = [
        (
            folder.path().join("no/such/folder/a.exr"),
            "create it first (mkdir -p",
        ),
        (file.join("a.exr"), "cannot write"),
        (folder.path().to_owned(), "it is a folder"),
        (PathBuf::from("/dev/null"), "no plain file"),
        (
            PathBuf::from("/proc/a.exr"),
            "cannot create a file in /proc",
        ),
        (PathBuf::from("/"), "it is a folder"),
        (PathBuf::from(""), "cannot write"),
    ];
    for (path, part) in failing {
        for error in [
            exr::write(&path, &sample_film(), &metadata()).unwrap_err(),
            png::write(&path, &sample_film(), Tonemap::default()).unwrap_err(),
        ] {
            assert!(matches!(error, Error::Write { .. }));
            assert!(error.to_string().contains(part), "{error}");
        }
    }
    assert_eq!(std::fs::read(&file).unwrap(), b"kept");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn an_error_half_way_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let half = |file: &mut dyn Write| {
        file.write_all(&[7; 1 << 20])?;
        Err(std::io::Error::other("half way"))
    };
    assert!(write_whole(&path, |file| half(file)).is_err());
    assert!(is_empty(folder.path()));
    std::fs::write(&path, "old").unwrap();
    assert!(write_whole(&path, |file| half(file)).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_write_error_and_leaves_nothing() {
    let Some(disk) = crate::small_disk::SmallDisk::new() else {
        eprintln!(
            "SKIPPED: a_full_disk_is_a_write_error_and_leaves_nothing: may not mount a tmpfs here"
        );
        return;
    };
    let path = disk.0.path().join("image.exr");
    let film = sample_film();
    let error = exr::write(&path, &film, &metadata()).unwrap_err();
    assert!(matches!(error, Error::Write { .. }), "{error}");
    assert!(
        error.to_string().to_lowercase().contains("no space"),
        "{error}"
    );
    assert!(is_empty(disk.0.path()));

    let noise = filled(256, 256, Region::full(256, 256), 1);
    let error = png::write(&disk.0.path().join("image.png"), &noise, Tonemap::default());
    assert!(matches!(error, Err(Error::Write { .. })), "{error:?}");
    assert!(is_empty(disk.0.path()));
}

#[cfg(unix)]
#[test]
fn a_new_file_has_the_permissions_of_any_other_and_a_replaced_one_keeps_its_own() {
    use std::os::unix::fs::PermissionsExt;
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let (folder, path) = written();
    let plain = folder.path().join("plain");
    std::fs::write(&plain, "").unwrap();
    assert_eq!(mode(&path), mode(&plain));
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
    let link = folder.path().join("link.exr");
    std::os::unix::fs::symlink(&path, &link).unwrap();
    exr::write(&link, &sample_film(), &metadata()).unwrap();
    assert_eq!(mode(&path), 0o600);
    assert!(link.is_symlink());
    assert_eq!(exr::read(&path).unwrap().1, metadata());
}

#[test]
fn tone_curves_are_monotone_and_bounded() {
    for operator in [Operator::Linear, Operator::Reinhard, Operator::Aces] {
        assert_eq!(operator.to_string().parse::<Operator>().unwrap(), operator);
        let map = Tonemap {
            operator,
            exposure: 0.0,
        };
        let mut last = (0.0, 0);
        for bits in (0..0x7f80_0000_u32).step_by(997).chain([0x7f80_0000]) {
            let x = f32::from_bits(bits);
            let now = (operator.apply(x), map.encode(x));
            assert!((0.0..=1.0).contains(&now.0), "{operator} {x:e}");
            assert!(now.0 >= last.0 && now.1 >= last.1, "{operator} {x:e}");
            last = now;
        }
        assert_eq!(last.1, 255);
        for x in [f32::NAN, f32::NEG_INFINITY, -1.0, -0.0, 0.0] {
            assert_eq!(map.encode(x), 0);
        }
        assert_eq!(map.encode(f32::INFINITY), 255);
        for exposure in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            Tonemap { operator, exposure }.encode(0.5);
        }
        let brighter = Tonemap {
            operator,
            exposure: 2.0,
        };
        assert_eq!(brighter.encode(0.1), map.encode(0.4));
    }
    assert!("filmic".parse::<Operator>().is_err());
}

#[test]
fn linear_codes_are_srgb_rounded_to_nearest() {
    let map = Tonemap::default();
    for i in 0..=100_000 {
        let x = i as f32 / 100_000.0;
        let linear = f64::from(x);
        let code = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        } * 255.0;
        // The standard's constants leave a step of 1e-7 where its two pieces meet.
        assert!(
            (f64::from(map.encode(x)) - code).abs() <= 0.5 + 1e-4,
            "{x} {code}"
        );
    }
}

#[test]
fn a_png_decodes_to_the_tone_mapped_pixels_and_says_srgb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    let film = sample_film();
    let map = Tonemap {
        operator: Operator::Aces,
        exposure: -1.5,
    };
    png::write(&path, &film, map).unwrap();
    let decoder = ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    assert!(reader.info().srgb.is_some());
    assert_eq!((reader.info().width, reader.info().height), (37, 47));
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    assert_eq!(bytes, png::pixels(&film, map));
    assert_eq!(bytes[..3], film.mean(3, 5).map(|x| map.encode(x)));
}
