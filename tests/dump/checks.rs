//! A port's faults, put into a copy of a dump: the check names the first, and says so of no copy without one.

mod manifests;

use crate::common::mutations;
use crate::render::*;
use crate::{traced, write};
use ondine::dump::check::{Verdict, check};
use ondine::error::{Error, Result};
use ondine::npy::{self, Array, Numbers};
use ondine::render::Settings;
use ondine::scene::description::SamplerKind;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A dump, and a port's.
struct Pair(TempDir);

impl Pair {
    fn new() -> Self {
        let description = builtin("materials");
        let settings = Settings {
            sampler: SamplerKind::Sobol,
            ..settings(&description, (45, 29), 20)
        };
        let dump = traced(&description, &settings, "10,8,22,20", 0..20);
        let pair = Self(tempfile::tempdir().expect("a folder"));
        for folder in [pair.ours(), pair.theirs()] {
            write(&dump, &description, &settings, &folder);
        }
        pair
    }

    fn ours(&self) -> PathBuf {
        self.0.path().join("ours")
    }

    fn theirs(&self) -> PathBuf {
        self.0.path().join("theirs")
    }

    fn check(&self) -> Result<Verdict> {
        check(&self.ours(), &self.theirs())
    }

    #[track_caller]
    fn verdict(&self) -> Verdict {
        self.check().unwrap_or_else(|error| panic!("{error}"))
    }

    /// Changes an array of the port's.
    fn change(&self, file: &str, change: impl FnOnce(&mut Array)) {
        let path = self.theirs().join(file);
        let mut array = npy::read(&path, "").unwrap_or_else(|error| panic!("{error}"));
        change(&mut array);
        save(&path, &array);
    }

    #[track_caller]
    fn refuses(&self, words: &[&str]) {
        let error = self.check().expect_err("not to be compared").to_string();
        for word in words {
            assert!(error.contains(word), "{error}\nlacks {word:?}");
        }
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

fn save(path: &Path, array: &Array) {
    let mut bytes = Vec::new();
    array.write(&mut bytes).expect("a Vec takes all");
    fs::write(path, bytes).expect("written");
}

fn floats(array: &mut Array) -> &mut Vec<f32> {
    match &mut array.numbers {
        Numbers::F32(all) => all,
        other => panic!("{}", other.dtype()),
    }
}

fn integers(array: &mut Array) -> &mut Vec<u32> {
    match &mut array.numbers {
        Numbers::U32(all) => all,
        other => panic!("{}", other.dtype()),
    }
}

/// The stage, edge, queue and field of the first difference.
fn first(verdict: &Verdict) -> String {
    let first = verdict.first.as_ref().expect("a difference");
    let field = first.field.as_deref().unwrap_or("-");
    format!("{} {} {} {field}", first.edge, first.stage, first.queue)
}

#[test]
fn a_copy_is_the_same_to_the_last_bit() {
    let pair = Pair::new();
    let verdict = pair.verdict();
    assert!(verdict.within && verdict.bit_equal && verdict.first.is_none());
    assert!(
        verdict.not_compared.is_empty(),
        "{:?}",
        verdict.not_compared
    );
    assert!(verdict.arrays.len() > 200, "{}", verdict.arrays.len());
    assert!(verdict.arrays.iter().all(|array| array.different == 0));
}

#[test]
fn an_ulp_is_within_the_budget_and_counted() {
    let pair = Pair::new();
    pair.change("edge02/shade/rays/pdf.npy", |array| {
        let pdf = floats(array).iter_mut().find(|pdf| pdf.is_finite());
        let pdf = pdf.expect("a density");
        *pdf = f32::from_bits(pdf.to_bits() + 1);
    });
    let verdict = pair.verdict();
    assert!(verdict.within && !verdict.bit_equal);
    let changed: Vec<_> = verdict
        .arrays
        .iter()
        .filter(|array| array.different > 0)
        .collect();
    let [pdf] = changed[..] else {
        panic!("{} arrays differ", changed.len());
    };
    let place = (pdf.edge, pdf.stage.as_str(), pdf.field.as_str());
    assert_eq!(place, (2, "shade", "pdf"));
    assert_eq!((pdf.different, pdf.beyond, pdf.worst_ulp), (1, 0, 1.0));
}

#[test]
fn the_first_stage_edge_and_path_of_a_fault_are_named() {
    let pair = Pair::new();
    // A later array too: it is not the first.
    pair.change("edge03/nee/shadow_rays/contribution.npy", |array| {
        floats(array).iter_mut().for_each(|x| *x *= 0.99);
    });
    pair.change("edge02/shade/rays/pdf.npy", |array| {
        floats(array).iter_mut().for_each(|pdf| *pdf *= 1.01);
    });
    let verdict = pair.verdict();
    assert!(!verdict.within);
    assert_eq!(first(&verdict), "2 shade rays pdf");
    let found = verdict.first.expect("a difference");
    let mut path = npy::read(&pair.ours().join("edge02/shade/rays/path.npy"), "").expect("read");
    let mut pdf = npy::read(&pair.ours().join("edge02/shade/rays/pdf.npy"), "").expect("read");
    let row = floats(&mut pdf)
        .iter()
        .position(|pdf| pdf.is_finite())
        .expect("one");
    let number = integers(&mut path)[row];
    assert_eq!(found.path, number as usize);
    let pixel = number / 20;
    assert_eq!(found.pixel, [10 + pixel % 12, 8 + pixel / 12]);
    assert_eq!(found.sample, Some(number % 20));
    let ulp = found.ulp.expect("a float's");
    // 1 % of a number is 0.01 · 2^23 to 0.01 · 2^24 of its last place.
    assert!((83_000.0..168_000.0).contains(&ulp), "{ulp}");
}

#[test]
fn a_few_paths_may_part_and_no_more() {
    let pair = Pair::new();
    let allowed = 28;
    for (wrong, within) in [(allowed, true), (allowed + 1, false)] {
        pair.change("edge01/shade/rays/pdf.npy", |array| {
            let finite = floats(array).iter_mut().filter(|pdf| pdf.is_finite());
            finite.take(wrong).for_each(|pdf| *pdf = 3.0);
        });
        let verdict = pair.verdict();
        assert_eq!(verdict.parted.allowed, allowed);
        assert_eq!((verdict.parted.paths, verdict.parted.by_choice), (wrong, 0));
        assert_eq!(verdict.within, within);
    }
}

#[test]
fn another_material_is_another_choice_and_where_a_path_is_instead_is_said() {
    let pair = Pair::new();
    pair.change("edge01/intersect/vertices.lambert/material.npy", |array| {
        integers(array)[3] += 1;
    });
    let verdict = pair.verdict();
    assert_eq!((verdict.parted.paths, verdict.parted.by_choice), (1, 1));
    let found = verdict.parted.first.expect("a path");
    assert_eq!(
        (found.field.as_deref(), found.ulp),
        (Some("material"), None)
    );

    let folder = pair.theirs().join("edge01/intersect");
    let queues: Vec<PathBuf> = (fs::read_dir(&folder).expect("a folder"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.to_string_lossy().contains("vertices.") && !path.ends_with("vertices.lambert")
        })
        .collect();
    let aside = folder.join("aside");
    let lambert = folder.join("vertices.lambert");
    for (from, to) in [
        (&lambert, &aside),
        (&queues[0], &lambert),
        (&aside, &queues[0]),
    ] {
        fs::rename(from, to).expect("renamed");
    }
    let verdict = pair.verdict();
    assert_eq!(first(&verdict), "1 intersect vertices.lambert -");
    let found = verdict.first.expect("a difference");
    let there = queues[0]
        .file_name()
        .expect("a name")
        .to_string_lossy()
        .into_owned();
    let words = [found.ours, found.theirs];
    assert!(words.contains(&format!("one in {there}")), "{words:?}");
}

#[test]
fn a_film_that_adds_up_otherwise_and_another_key_are_wrong_for_any_pixel() {
    for (file, place) in [
        ("film/blocks/sum.npy", "0 film blocks sum"),
        ("film/pixels/exact_square.npy", "0 film pixels exact_square"),
        ("edge01/generate/rays/key.npy", "1 generate rays key"),
        ("paths/sample.npy", "0 paths  sample"),
    ] {
        let pair = Pair::new();
        pair.change(file, |array| match &mut array.numbers {
            Numbers::F64(all) => all[7] += 1.0,
            // A high word of a sum.
            Numbers::U32(all) => all[6] += 1 << 4,
            Numbers::F32(_) => panic!("no single"),
        });
        let verdict = pair.verdict();
        assert!(!verdict.within);
        assert_eq!(first(&verdict), place);
    }
}

#[test]
fn a_wrong_direction_parts_its_path_and_what_follows_is_left_out() {
    let pair = Pair::new();
    let turn = |array: &mut Array| {
        for direction in floats(array).chunks_exact_mut(3).take(2) {
            direction.rotate_left(1);
        }
    };
    pair.change("edge01/shade/rays/direction.npy", turn);
    let follow = |array: &mut Array| floats(array)[..3].fill(7.0);
    pair.change("edge02/intersect/vertices.lambert/position.npy", follow);
    let verdict = pair.verdict();
    let parted = verdict.parted.first.as_ref().expect("a path");
    assert_eq!((parted.edge, parted.stage.as_str()), (1, "shade"));
    assert_eq!(parted.field.as_deref(), Some("direction"));
    assert!(verdict.parted.paths >= 2 && verdict.parted.paths <= 3);
    // So few may part.
    assert!(verdict.within && !verdict.bit_equal);

    pair.change("edge01/shade/rays/direction.npy", |array| {
        let all = floats(array);
        all.chunks_exact_mut(3)
            .for_each(|direction| direction.reverse());
    });
    let verdict = pair.verdict();
    assert!(!verdict.within);
    assert_eq!(first(&verdict), "1 shade rays direction");
    let after = verdict
        .arrays
        .iter()
        .find(|array| array.edge == 2)
        .expect("one");
    assert!(after.records < 300, "{} are still compared", after.records);
}

#[test]
fn records_that_are_missing_or_too_many_are_named() {
    let pair = Pair::new();
    let fields = [
        "origin",
        "direction",
        "distance",
        "target",
        "contribution",
        "path",
    ];
    for field in fields {
        pair.change(&format!("edge01/nee/shadow_rays/{field}.npy"), |array| {
            let left = array.shape[0] / 2;
            let width: usize = array.shape[1..].iter().product();
            array.shape[0] = left;
            match &mut array.numbers {
                Numbers::F32(all) => all.truncate(left * width),
                Numbers::U32(all) => all.truncate(left * width),
                Numbers::F64(all) => all.truncate(left * width),
            }
        });
    }
    let verdict = pair.verdict();
    assert!(!verdict.within);
    assert_eq!(first(&verdict), "1 nee shadow_rays -");
    let found = verdict.first.expect("a difference");
    assert_eq!(
        (found.ours.as_str(), found.theirs.as_str()),
        ("a record", "no record")
    );

    // The other way round.
    let swapped = check(&pair.theirs(), &pair.ours());
    let error = swapped.expect_err("ours is damaged now").to_string();
    assert!(error.contains("than its manifest says"), "{error}");
}

#[test]
fn paths_may_be_in_any_order_and_arrays_may_be_missing() {
    let pair = Pair::new();
    let folder = "edge02/shade/rays";
    for entry in fs::read_dir(pair.theirs().join(folder)).expect("a folder") {
        let name = entry.expect("an entry").file_name();
        let name = name.to_string_lossy().into_owned();
        pair.change(&format!("{folder}/{name}"), |array| {
            let width: usize = array.shape[1..].iter().product();
            match &mut array.numbers {
                Numbers::F32(all) => *all = all.chunks(width).rev().flatten().copied().collect(),
                Numbers::U32(all) => all.reverse(),
                Numbers::F64(_) => panic!("no double"),
            }
        });
    }
    assert!(pair.verdict().bit_equal);

    for lost in ["manifest.json", "edge02/shade/rays/throughput.npy"] {
        fs::remove_file(pair.theirs().join(lost)).expect("removed");
    }
    for lost in ["film", "edge01/accumulate", "edge03"] {
        fs::remove_dir_all(pair.theirs().join(lost)).expect("removed");
    }
    let verdict = pair.verdict();
    assert!(verdict.bit_equal);
    let said = verdict.not_compared.join("\n");
    for word in [
        "manifest.json",
        "rays/throughput.npy",
        "film/blocks",
        "edge01/accumulate",
        "edge03/nee",
    ] {
        assert!(said.contains(word), "{said}\nlacks {word}");
    }
    fs::remove_file(pair.theirs().join("edge02/shade/rays/path.npy")).expect("removed");
    // Without it, they are taken in our order, which they are not in.
    assert!(!pair.verdict().within);
    pair.change("edge02/shade/rays/pdf.npy", |array| {
        floats(array).pop();
        array.shape[0] -= 1;
    });
    pair.refuses(&["edge02/shade/rays/pdf.npy", "path.npy"]);
}

#[test]
fn a_damaged_array_is_named() {
    let pair = Pair::new();
    let file = "edge01/shade/rays/direction.npy";
    let good = fs::read(pair.ours().join(file)).expect("read");
    for folder in [pair.ours(), pair.theirs()] {
        let path = folder.join(file);
        for cut in [0, 7, 60, good.len() - 1] {
            fs::write(&path, &good[..cut]).expect("written");
            pair.refuses(&["rays/direction.npy"]);
        }
        fs::write(&path, [&good[..], b"x"].concat()).expect("written");
        pair.refuses(&["rays/direction.npy", "goes on after"]);
        fs::write(&path, &good).expect("written");
    }
    let mut other = good.clone();
    other[good.len() / 2] ^= 1;
    fs::write(pair.ours().join(file), other).expect("written");
    pair.refuses(&["ours/edge01", "SHA-256"]);
    fs::remove_file(pair.ours().join(file)).expect("removed");
    pair.refuses(&["ours/edge01", "cannot read"]);
    fs::write(pair.ours().join(file), good).expect("written");

    pair.change("edge01/shade/rays/path.npy", |array| integers(array)[1] = 0);
    pair.refuses(&[
        "theirs/edge01/shade/rays/path.npy",
        "path 0 is in row 0 and in row 1",
    ]);
    pair.change("edge01/shade/rays/path.npy", |array| {
        integers(array)[1] = 1 << 31
    });
    pair.refuses(&["theirs/edge01/shade/rays/path.npy", "path 2147483648"]);
    pair.change("edge01/shade/rays/pdf.npy", |array| {
        let doubles = floats(array).iter().map(|&x| x.into()).collect();
        array.numbers = Numbers::F64(doubles);
    });
    pair.refuses(&["theirs/edge01/shade/rays/p"]);

    let pair = Pair::new();
    pair.change("film/radiance/radiance.npy", |array| array.shape.reverse());
    pair.refuses(&["has the shape (3, 2880), not (2880, 3)"]);
}

#[test]
fn no_damage_of_a_manifest_or_an_array_makes_it_panic() {
    let pair = Pair::new();
    let (mut compared, mut refused) = (0, 0);
    for (seed, file) in (700..).zip([
        "ours/manifest.json",
        "theirs/manifest.json",
        "theirs/edge01/shade/rays/path.npy",
        "theirs/film/pixels/exact_sum.npy",
    ]) {
        let path = pair.0.path().join(file);
        let good = fs::read(&path).expect("read");
        for bad in mutations(seed, &good, 20) {
            fs::write(&path, bad).expect("written");
            match pair.check() {
                Ok(_) => compared += 1,
                Err(Error::Read { .. } | Error::Format { .. } | Error::Usage(_)) => refused += 1,
                Err(other) => panic!("{other}"),
            }
        }
        fs::write(&path, good).expect("written");
    }
    assert!(
        compared + refused == 80 && refused > 20,
        "{compared} {refused}"
    );
}
