//! `ondine dump`.

use super::refusals::refuses;
use crate::{folder, names, ondine};
use std::fs;
use std::path::Path;

const SMALL: &str = "dump cornell --size 40x30 --tile 8,8 --tile-size 6x4 --samples 0..20";

/// All files below a folder, with their bytes.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => all.push((
                    path.strip_prefix(folder).unwrap().display().to_string(),
                    fs::read(&path).unwrap(),
                )),
            }
        }
    }
    all.sort();
    all
}

#[test]
fn a_dump_is_written_whole_listed_in_its_manifest_and_the_same_again() {
    let folder = folder();
    let run = ondine(&folder, &format!("{SMALL} --out a"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout
            .starts_with("Wrote a: 480 paths of cornell, pixels 8,8 to 13,11"),
        "{}",
        run.stdout
    );
    let manifest = ondine(&folder, &format!("{SMALL} --out b --json")).json();
    assert_eq!(names(folder.path()), ["a", "b"]);
    let (a, b) = (
        files(&folder.path().join("a")),
        files(&folder.path().join("b")),
    );
    assert!(a == b, "two dumps of the same differ");
    assert_eq!(manifest["settings"]["width"], 40);
    assert_eq!(manifest["samples"], serde_json::json!([0, 20]));
    let listed: Vec<&str> = (manifest["queues"].as_array().unwrap().iter())
        .flat_map(|queue| queue["fields"].as_array().unwrap())
        .map(|field| field["file"].as_str().unwrap())
        .collect();
    let arrays = a.iter().filter(|(name, _)| name.ends_with(".npy"));
    assert_eq!(arrays.clone().count(), listed.len());
    for (name, bytes) in arrays {
        assert!(listed.contains(&name.as_str()), "{name}");
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"), "{name}");
    }
    let run = ondine(&folder, "dump --check a b");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.contains("the same to the last bit"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_dump_of_other_rounding_passes_and_one_with_a_fault_does_not() {
    let folder = folder();
    for out in ["a", "b"] {
        assert_eq!(ondine(&folder, &format!("{SMALL} --out {out}")).code, 0);
    }
    let pdf = folder.path().join("b/edge03/shade/rays/pdf.npy");
    let mut bytes = fs::read(&pdf).unwrap();
    let last = bytes.len() - 4;
    // The lowest bit of the last density, then a high one of all.
    bytes[last] ^= 1;
    fs::write(&pdf, &bytes).unwrap();
    let run = ondine(&folder, "dump --check a b");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("within its budget"), "{}", run.stdout);
    let header = 128;
    bytes
        .iter_mut()
        .skip(header + 2)
        .step_by(4)
        .for_each(|byte| *byte ^= 0x20);
    fs::write(&pdf, &bytes).unwrap();
    let run = ondine(&folder, "dump --check a b");
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout
            .contains("first difference: edge 3, shade, rays, pdf of path "),
        "{}",
        run.stdout
    );
    let run = ondine(&folder, "dump --check a b --json");
    assert_eq!(run.code, 1);
    let verdict: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(verdict["within"], false);
    assert_eq!(verdict["first"]["field"], "pdf");
}

/// Turns the first direction of the first edge round.
fn turn_a_direction(dump: &Path) {
    let file = dump.join("edge01/shade/rays/direction.npy");
    let mut bytes = fs::read(&file).unwrap();
    let signs = bytes[128..140].iter_mut().skip(3).step_by(4);
    signs.for_each(|byte| *byte ^= 0x80);
    fs::write(file, bytes).unwrap();
}

#[test]
fn of_many_paths_a_few_may_part_and_of_one_none() {
    let folder = folder();
    let one = "dump cornell --size 40x30 --tile 8,8 --tile-size 1x1 --samples 3..4";
    for (line, code, words) in [
        (
            SMALL,
            0,
            "within its budget, but for 1 of at most 4 paths that may part",
        ),
        (
            one,
            1,
            "first difference: edge 1, shade, rays, direction of path 0",
        ),
    ] {
        for out in ["a", "b"] {
            assert_eq!(ondine(&folder, &format!("{line} --out {out}")).code, 0);
        }
        turn_a_direction(&folder.path().join("b"));
        let run = ondine(&folder, "dump --check a b");
        assert_eq!(run.code, code, "{}{}", run.stdout, run.stderr);
        assert!(run.stdout.contains(words), "{}", run.stdout);
    }
}

#[test]
fn the_paths_of_a_pixel_add_up_to_what_is_printed() {
    let folder = folder();
    let run = ondine(&folder, "dump cornell --pixel 128,100 --samples 3..5");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(names(folder.path()), Vec::<String>::new());
    for words in [
        "pixel 128,100, sample 3\n  edge 1: from (0, 0, 2.95) along (",
        "meets \"white\" (lambert) at (",
        "    shadow ray from (",
        "pixel 128,100: mean of 2 samples (",
    ] {
        assert!(
            run.stdout.contains(words),
            "{}\nlacks {words:?}",
            run.stdout
        );
    }
    let triple = |line: &str| -> Vec<f64> {
        let numbers = line.rsplit_once('(').unwrap().1.trim_end_matches(')');
        numbers
            .split(", ")
            .map(|number| number.parse().unwrap())
            .collect()
    };
    let mut sums = [[0.0; 3]; 2];
    let mut sample = 0;
    for line in run.stdout.lines() {
        if line.starts_with("  radiance (") {
            for (c, x) in triple(line).into_iter().enumerate() {
                assert!((sums[sample][c] - x).abs() < 1e-5 * x, "{line}");
            }
            sample += 1;
        } else if line.contains("adds (") && !line.contains("would") {
            triple(line)
                .into_iter()
                .zip(&mut sums[sample])
                .for_each(|(x, sum)| *sum += x);
        }
    }
    assert_eq!(sample, 2);
}

#[test]
fn an_older_dump_is_replaced_and_nothing_else() {
    let folder = folder();
    let path = folder.path();
    for _ in 0..2 {
        let run = ondine(
            &folder,
            "dump mirror --size 9x9 --tile 2,2 --samples 1..2 --out d",
        );
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    assert!(path.join("d/edge05").exists());
    let run = ondine(
        &folder,
        "dump mirror --size 9x9 --tile 2,2 --samples 1..2 --path-length 2 --out d",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(!path.join("d/edge05").exists());
    assert_eq!(names(path), ["d"]);
    let before = files(&path.join("d"));

    fs::write(path.join("d/notes.txt"), "mine").unwrap();
    let line = "dump mirror --tile 2,2 --out d";
    refuses(&folder, line, &["d holds \"notes.txt\"", "name a folder"]);
    fs::remove_file(path.join("d/notes.txt")).unwrap();
    for (place, file) in [
        ("d/film", "d/film/notes.txt"),
        ("d/edge01/shade/rays", "d/edge01/shade/rays/mine.npy"),
        ("d/edge01/mine", "d/edge01/mine/path.npy"),
    ] {
        fs::create_dir_all(path.join(place)).unwrap();
        fs::write(path.join(file), "mine").unwrap();
        refuses(
            &folder,
            line,
            &["d holds", "does not list", "name a folder"],
        );
        assert!(path.join(file).exists());
        fs::remove_file(path.join(file)).unwrap();
    }
    fs::remove_dir(path.join("d/edge01/mine")).unwrap();
    assert!(files(&path.join("d")) == before);

    fs::create_dir_all(path.join("e/edge01")).unwrap();
    fs::write(path.join("f"), "a file").unwrap();
    fs::create_dir(path.join("g")).unwrap();
    for (out, words) in [
        ("e", "is no dump"),
        ("f", "is no folder"),
        ("h/i", "mkdir -p h"),
        (".", "is no dump"),
        ("/", "is no dump"),
    ] {
        refuses(
            &folder,
            &format!("dump mirror --tile 2,2 --out {out}"),
            &[words],
        );
    }
    let run = ondine(
        &folder,
        "dump mirror --size 9x9 --tile 2,2 --samples 1..2 --out g",
    );
    assert_eq!(run.code, 0, "an empty folder: {}", run.stderr);
}

#[test]
fn what_cannot_be_dumped_or_compared_is_refused() {
    let folder = folder();
    let cases: &[(&str, &[&str])] = &[
        ("cornell", &["nothing is asked for", "--tile"]),
        ("", &["SCENE"]),
        ("cornell --tile 1,1", &["--out"]),
        ("cornell --out d", &["--tile"]),
        (
            "cornell --tile 256,0 --out d",
            &["--tile 256,0", "0 to 255"],
        ),
        ("cornell --tile 0,4294967295 --out d", &["lies outside"]),
        ("cornell --tile -1,0 --out d", &["--tile", "120,96"]),
        ("cornell --tile 1;1 --out d", &["--tile", "120,96"]),
        (
            "cornell --tile 1,1 --tile-size 0x4 --out d",
            &["0x4", "1x1"],
        ),
        ("cornell --pixel 3,256", &["--pixel 3,256", "lies outside"]),
        (
            "cornell --pixel 3,3 --samples 4..4",
            &["--samples", "0..16"],
        ),
        (
            "cornell --pixel 3,3 --samples 5..4",
            &["--samples", "0..16"],
        ),
        ("cornell --pixel 3,3 --samples 4", &["--samples", "0..16"]),
        (
            "cornell --pixel 3,3 --samples 0..4294967295",
            &["134217728"],
        ),
        (
            "cornell --pixel 3,3 --samples 0..9999999",
            &["9999999 paths", "--samples"],
        ),
        (
            "cornell --tile 0,0 --tile-size 256x256 --samples 0..17 --out d",
            &["1114112 paths", "--tile-size"],
        ),
        ("cornell --pixel 3,3 --path-length 0", &["path length is 0"]),
        (
            "cornell --pixel 3,3 --camera nobody",
            &["no camera", "nobody"],
        ),
        ("cornell --pixel 3,3 --json", &["--json", "--pixel"]),
        ("cornel --pixel 3,3", &["cornel", "did you mean"]),
        ("--check d", &["--check"]),
        ("cornell --check d e", &["--check"]),
        ("--check d e", &["d/manifest.json", "cannot read"]),
    ];
    for (arguments, words) in cases {
        refuses(&folder, &format!("dump {arguments}"), words);
    }
    for instead in ["--check a b", "--vectors d"] {
        for ignored in [
            "--tile-size 3x3",
            "--size 8x8",
            "--camera c",
            "--seed 4",
            "--path-length 2",
            "--strategy mis",
            "--sampler pcg",
            "--roulette 2",
        ] {
            let option = ignored.split(' ').next().unwrap();
            let line = format!("dump {instead} {ignored}");
            refuses(&folder, &line, &[option, "cannot be used with"]);
        }
    }
    // A million paths are not too many, but their records are.
    let all = "dump cornell --tile 0,0 --tile-size 256x256 --out d";
    refuses(&folder, all, &["256 MiB", "--tile-size", "--path-length"]);
}

#[cfg(unix)]
#[test]
fn what_is_no_folder_is_named_and_the_current_one_is_not_replaced() {
    let folder = folder();
    let path = folder.path();
    std::os::unix::fs::symlink("nowhere", path.join("link")).unwrap();
    for (line, words) in [
        (
            "cornell --tile 8,8 --out link",
            "link is a link to what does not exist; name a folder",
        ),
        (
            "--vectors link",
            "link is a link to what does not exist; name a folder",
        ),
        (
            "--vectors /dev/null",
            "/dev/null is no folder; name a folder",
        ),
    ] {
        refuses(&folder, &format!("dump {line}"), &[words]);
    }

    let line = "dump mirror --size 9x9 --tile 2,2 --samples 1..2 --out";
    assert_eq!(ondine(&folder, &format!("{line} d")).code, 0);
    for (place, out) in [("d", "."), ("d/edge01", "../../d")] {
        let mut run = crate::command(&path.join(place), &format!("{line} {out}"));
        let run: crate::Run = run.output().unwrap().into();
        assert_eq!(run.code, 2, "{}", run.stdout);
        let words = format!("{out} holds the current directory");
        assert!(run.stderr.contains(&words), "{}", run.stderr);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_and_keeps_what_was_there() {
    let Some(disk) = crate::small_disk::SmallDisk::new() else {
        eprintln!("skipped: no file system can be mounted here");
        return;
    };
    // An older dump, as far as there is room for one.
    fs::create_dir(disk.0.path().join("d")).unwrap();
    let manifest = disk.0.path().join("d/manifest.json");
    fs::write(manifest, r#"{"format": "ondine dump"}"#).unwrap();
    let before = files(&disk.0.path().join("d"));
    let run = crate::ondine(&disk.0, "dump cornell --tile 8,8 --out d");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("d: cannot write: "), "{}", run.stderr);
    assert!(files(&disk.0.path().join("d")) == before);
    assert_eq!(names(disk.0.path()), ["d"]);
}
