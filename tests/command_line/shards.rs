//! Parts of an image, put together: the bits of one render, or a refusal that says why.

use crate::{Run, folder, names, ondine};
use std::fs;
use tempfile::TempDir;

/// Glass and mirrors bounce long; a crop and an odd number of samples make ragged waves.
const IMAGE: &str = "materials --size 40x30 --crop 3,2,38,29 --aov albedo,bounces --no-png --quiet";

fn hash(folder: &TempDir, file: &str) -> String {
    let info = ondine(folder, &format!("info {file} --json")).json();
    info["image_hash"].as_str().unwrap().to_owned()
}

fn render(folder: &TempDir, options: &str) {
    let run = ondine(folder, &format!("render {IMAGE} {options}"));
    assert_eq!(run.code, 0, "{options}: {}", run.stderr);
}

/// A merge that must fail, and leave nothing.
#[track_caller]
fn refused(folder: &TempDir, parts: &str, words: &[&str]) -> Run {
    let run = ondine(folder, &format!("merge {parts} -o refused.exr"));
    assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "{word} in {}", run.stderr);
    }
    let left = names(folder.path());
    assert!(
        left.iter()
            .all(|name| !name.starts_with("refused") && !name.ends_with(".tmp")),
        "{left:?}"
    );
    run
}

/// SplitMix64 (Steele et al. 2014), for the order of parts.
fn shuffled(mut parts: Vec<String>, seed: u64) -> Vec<String> {
    let mut state = seed;
    for i in (1..parts.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        parts.swap(i, ((z ^ z >> 31) % (i as u64 + 1)) as usize);
    }
    parts
}

#[test]
fn shards_in_any_order_on_any_threads_are_the_single_run() {
    let folder = folder();
    render(&folder, "--spp 37 -o whole.exr");
    let whole = hash(&folder, "whole.exr");
    for (number, of) in [1, 2, 3, 16, 64].into_iter().enumerate() {
        let parts: Vec<String> = (1..=of)
            .map(|k| {
                let name = format!("{k}-of-{of}.exr");
                let (threads, wave) = (1 + k % 2, 100 + 17 * k);
                render(
                    &folder,
                    &format!(
                        "--spp 37 --shard {k}/{of} --threads {threads} --wave {wave} -o {name}"
                    ),
                );
                name
            })
            .collect();
        let parts = shuffled(parts, number as u64).join(" ");
        let merged = ondine(
            &folder,
            &format!("merge {parts} -o merged.exr --no-png --json"),
        )
        .json();
        assert_eq!(merged["image_hash"], *whole, "{of} shards");
        assert_eq!(
            (&merged["complete"], &merged["parts"]),
            (&true.into(), &of.into())
        );
        assert_eq!(hash(&folder, "merged.exr"), whole);

        // Every layer has the bits of the single run, and so have all channels that follow from the sums.
        let compared = ondine(&folder, "compare whole.exr merged.exr --json").json();
        assert_eq!(compared["verdict"], "bit-equal");
        let [one, other] = ["whole.exr", "merged.exr"].map(|file| {
            let mut info = ondine(&folder, &format!("info {file} --json")).json();
            for word in ["file", "seconds", "rays", "parts"] {
                info[word] = 0.into();
            }
            info
        });
        assert_eq!(one, other, "what the files say of themselves");
    }
}

#[test]
fn more_samples_tomorrow_are_as_many_at_once() {
    let folder = folder();
    render(&folder, "--spp 96 -o once.exr");
    render(&folder, "--spp 32 -o today.exr");
    render(&folder, "--samples 32..96 --shard 1/2 -o tomorrow-1.exr");
    render(&folder, "--samples 32..96 --shard 2/2 -o tomorrow-2.exr");
    let merge = "merge tomorrow-2.exr today.exr tomorrow-1.exr -o all.exr --no-png --json";
    let merged = ondine(&folder, merge).json();
    assert_eq!(merged["image_hash"], *hash(&folder, "once.exr"));
    assert_eq!(
        (&merged["spp"], &merged["samples"]["min"]),
        (&96.into(), &96.into())
    );
    let info = ondine(&folder, "info all.exr --json").json();
    assert_eq!(info["sample_ranges"][0]["end"], 96);
    assert_eq!(info["missing_blocks"], "");

    // What was merged goes on, too.
    let run = ondine(
        &folder,
        &format!("render {IMAGE} --spp 128 -o all.exr --resume"),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr
            .contains("going on from all.exr with 96 samples per pixel"),
        "{}",
        run.stderr
    );
    render(&folder, "--spp 128 -o more-at-once.exr");
    assert_eq!(hash(&folder, "all.exr"), hash(&folder, "more-at-once.exr"));

    // The samples of a block are rounded together, so a part of one cannot be continued.
    render(&folder, "--spp 20 -o odd.exr");
    refused(
        &folder,
        "odd.exr tomorrow-1.exr",
        &[
            "odd.exr: was rendered with 20 samples per pixel, and tomorrow-1.exr has 96",
            "16",
        ],
    );
    let run = ondine(
        &folder,
        &format!("render {IMAGE} --samples 8..96 -o no.exr"),
    );
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("8..96") && run.stderr.contains("multiple of 16"),
        "{}",
        run.stderr
    );
}

#[test]
fn missing_parts_are_named_and_a_partial_image_says_what_it_lacks() {
    let folder = folder();
    for k in [1, 2, 4, 6] {
        render(&folder, &format!("--spp 32 --shard {k}/6 -o {k}.exr"));
    }
    let words = ["shards 3/6 and 5/6 (33.3 % of the samples)", "--partial"];
    refused(&folder, "4.exr 1.exr 6.exr 2.exr", &words);

    let partial = "merge 4.exr 1.exr 6.exr 2.exr -o some.exr --partial --no-png --json";
    let run = ondine(&folder, partial);
    let report = run.json();
    assert!(
        run.stderr.contains("the image lacks shards 3/6 and 5/6"),
        "{}",
        run.stderr
    );
    assert_eq!(report["missing_shards"], serde_json::json!(["3/6", "5/6"]));
    assert_eq!(report["complete"], false);
    let info = ondine(&folder, "info some.exr");
    assert!(
        info.stdout.contains("1260 of 1890 sample blocks (66.7 %)"),
        "{}",
        info.stdout
    );
    let one = ondine(&folder, "info 1.exr").stdout;
    assert!(
        one.contains("shard 1/6: 315 of 1890 sample blocks (16.7 %)"),
        "{one}"
    );

    // A partial image is a part like any other.
    for k in [3, 5] {
        render(&folder, &format!("--spp 32 --shard {k}/6 -o {k}.exr"));
    }
    let merge = "merge 5.exr some.exr 3.exr -o all.exr --no-png --json";
    render(&folder, "--spp 32 -o whole.exr");
    let merged = ondine(&folder, merge).json();
    assert_eq!(merged["image_hash"], *hash(&folder, "whole.exr"));
    // One image that is whole may be merged with itself alone.
    assert_eq!(
        ondine(&folder, "merge whole.exr -o copy.exr --no-png").code,
        0
    );
    let words = ["shard 1/6 (16.7 % of the samples)"];
    refused(&folder, "2.exr 3.exr 4.exr 5.exr 6.exr", &words);
}

#[test]
fn parts_of_another_image_and_samples_that_are_there_twice_are_refused() {
    let folder = folder();
    render(&folder, "--spp 16 --shard 1/2 -o one.exr");
    render(&folder, "--spp 16 --shard 2/2 -o two.exr");
    let others = [
        ("--seed 7", "its seed is 7, and there it is 0"),
        (
            "--strategy light",
            "its strategy is light, and there it is mis",
        ),
        ("--sampler pcg", "its sampler is pcg, and there it is sobol"),
        ("--path-length 3", "its path length is 3, and there it is 9"),
        (
            "--roulette 4",
            "its roulette is from edge 4, and there it is none",
        ),
    ];
    for (option, words) in others {
        render(
            &folder,
            &format!("--spp 16 --shard 2/2 {option} -o other.exr"),
        );
        refused(
            &folder,
            "one.exr other.exr",
            &["other.exr: is no part of the image of one.exr", words],
        );
    }
    let elsewhere = [
        (
            "materials --size 44x30 --crop 3,2,38,29 --aov albedo,bounces",
            "its size is 44x30",
        ),
        (
            "materials --size 40x30 --crop 3,2,38,28 --aov albedo,bounces",
            "its crop is 3,2,38,28",
        ),
        (
            "materials --size 40x30 --crop 3,2,38,29 --aov bounces",
            "its list of AOVs is bounces",
        ),
        (
            "glossy --size 40x30 --crop 3,2,38,29 --aov albedo,bounces",
            "its scene is glossy (",
        ),
    ];
    for (image, words) in elsewhere {
        let line = format!("render {image} --spp 16 --shard 2/2 --quiet -o other.exr");
        assert_eq!(ondine(&folder, &line).code, 0);
        refused(&folder, "one.exr other.exr", &["other.exr", words]);
    }

    refused(
        &folder,
        "one.exr two.exr one.exr",
        &["holds samples that one.exr holds too", "leave one"],
    );
    render(&folder, "--spp 16 --shard 1/3 -o third.exr");
    let words = ["third.exr", "holds too (from sample 0 of pixel 3,2 on)"];
    refused(&folder, "third.exr one.exr two.exr", &words);

    // What is no part at all, or no longer.
    let bytes = fs::read(folder.path().join("one.exr")).unwrap();
    for length in [0, 3, 200, bytes.len() / 2, bytes.len() - 1] {
        fs::write(folder.path().join("cut.exr"), &bytes[..length]).unwrap();
        refused(&folder, "cut.exr two.exr", &["cut.exr: "]);
    }
    let mut flipped = bytes.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 16;
    fs::write(folder.path().join("flipped.exr"), flipped).unwrap();
    refused(
        &folder,
        "flipped.exr two.exr",
        &["flipped.exr: ", "damaged"],
    );
    refused(&folder, "one.exr none.exr", &["none.exr: cannot read"]);

    // An output is no part.
    let before = fs::read(folder.path().join("two.exr")).unwrap();
    let run = ondine(&folder, "merge one.exr two.exr -o two.exr");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("two.exr: this file is read"),
        "{}",
        run.stderr
    );
    assert_eq!(fs::read(folder.path().join("two.exr")).unwrap(), before);
}

#[test]
fn a_shard_has_a_name_of_its_own_and_no_picture() {
    let folder = folder();
    let line = "render furnace --size 8x8 --spp 16 --shard 2/3 --quiet";
    assert_eq!(ondine(&folder, line).code, 0);
    assert_eq!(names(folder.path()), ["furnace.2-of-3.exr"]);

    let run = ondine(
        &folder,
        "render furnace --size 2x2 --spp 16 --shard 5/5 --quiet",
    );
    assert_eq!(run.code, 0, "a part of 4 blocks: {}", run.stderr);
    let run = ondine(
        &folder,
        "render furnace --size 2x2 --spp 16 --shard 1/5 --quiet",
    );
    assert_eq!(run.code, 2);
    assert!(
        run.stderr
            .contains("shard 1/5 is empty: the image has 4 blocks"),
        "{}",
        run.stderr
    );
    for wrong in ["0/2", "3/2", "x"] {
        let run = ondine(&folder, &format!("render furnace --shard {wrong}"));
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains("write K/N"), "{}", run.stderr);
    }

    // What a part is a part of has a number of samples.
    let run = ondine(&folder, "render furnace --size 8x8 --shard 1/2 --time 1");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("add --spp"), "{}", run.stderr);
    let shard = "render furnace --size 8x8 --shard 2/3 --quiet --resume";
    assert_eq!(ondine(&folder, &format!("{shard} --spp 16")).code, 0);
    let run = ondine(&folder, &format!("{shard} --spp 32"));
    assert_eq!(run.code, 2);
    assert!(
        run.stderr
            .contains("a shard of 16 samples per pixel, and one of 32"),
        "{}",
        run.stderr
    );
}
