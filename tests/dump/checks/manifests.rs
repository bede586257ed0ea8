//! What manifests say: of something else, too little, of empty queues, and what is not so.

use super::{Pair, first};
use crate::render::*;
use serde_json::{Value, json};
use std::fs;

#[test]
fn what_is_of_something_else_cannot_be_compared() {
    let pair = Pair::new();
    let path = pair.theirs().join("manifest.json");
    let text = fs::read_to_string(&path).expect("a manifest");
    let hash = &builtin("materials").hash[..20];
    for (from, to, word) in [
        (hash, "00000000000000000000", "scene_hash"),
        ("\"seed\": 1", "\"seed\": 2", "seed"),
        ("\"path_length\": ", "\"path_length\": 1", "path_length"),
        (
            "\"strategy\": \"mis\"",
            "\"strategy\": \"light\"",
            "strategy",
        ),
        ("\"samples\": [\n    0", "\"samples\": [\n    1", "samples"),
        ("\"tile\": [\n    10", "\"tile\": [\n    11", "tile"),
        ("\"schema\": 1", "\"schema\": 2", "schema"),
    ] {
        assert!(text.contains(from), "{from}");
        fs::write(&path, text.replace(from, to)).expect("written");
        pair.refuses(&["cannot compare", word]);
    }
    fs::write(&path, "{").expect("written");
    pair.refuses(&["theirs/manifest.json", "no JSON"]);
    fs::write(&path, "[]").expect("written");
    pair.refuses(&["theirs/manifest.json", "no JSON object"]);
    fs::remove_dir_all(pair.theirs()).expect("removed");
    pair.refuses(&["theirs", "no folder"]);
    fs::create_dir(pair.theirs()).expect("made");
    pair.refuses(&["theirs", "no array"]);
}

#[test]
fn what_a_ports_manifest_does_not_say_is_named_and_numbers_may_be_written_otherwise() {
    let pair = Pair::new();
    let path = pair.theirs().join("manifest.json");
    let text = fs::read_to_string(&path).expect("a manifest");
    let mut manifest: Value = serde_json::from_str(&text).expect("JSON");
    manifest["settings"]["path_length"] = json!(manifest["settings"]["path_length"].as_f64());
    manifest["tile"][0] = json!(10.0);
    fs::write(&path, manifest.to_string()).expect("written");
    assert!(pair.verdict().not_compared.is_empty());
    fs::write(&path, "{}").expect("written");
    let [said] = &pair.verdict().not_compared[..] else {
        panic!("one line");
    };
    for key in [
        "schema",
        "scene_hash",
        "tile",
        "samples",
        "seed",
        "strategy",
        "roulette",
    ] {
        assert!(said.contains(key), "{said}\nlacks {key}");
    }
}

#[test]
fn a_queue_that_a_port_says_is_empty_lacks_its_records_and_one_of_which_it_is_silent_is_not_compared()
 {
    let pair = Pair::new();
    let nee = "edge02/nee";
    fs::remove_dir_all(pair.theirs().join(nee)).expect("removed");
    let path = pair.theirs().join("manifest.json");
    let text = fs::read_to_string(&path).expect("a manifest");
    let good: Value = serde_json::from_str(&text).expect("JSON");
    let is_nee = |queue: &Value| {
        queue["folder"]
            .as_str()
            .is_some_and(|folder| folder.starts_with(nee))
    };
    let mut empty = good.clone();
    let mut left_out = good.clone();
    for queue in empty["queues"].as_array_mut().expect("queues") {
        if is_nee(queue) {
            queue["records"] = json!(0);
        }
    }
    let queues = left_out["queues"].as_array_mut().expect("queues");
    queues.retain(|queue| !is_nee(queue));
    for manifest in [empty, left_out] {
        fs::write(&path, manifest.to_string()).expect("written");
        let verdict = pair.verdict();
        assert!(!verdict.within && !verdict.bit_equal);
        assert_eq!(first(&verdict), "2 nee shadow_rays -");
        assert_eq!(verdict.missing, 0, "{:?}", verdict.not_compared);
    }

    fs::write(&path, text).expect("written");
    let verdict = pair.verdict();
    assert!(
        verdict.bit_equal && verdict.missing == 6,
        "{}",
        verdict.missing
    );
    assert!(verdict.not_compared.join("").contains(nee));
}

#[test]
fn what_a_port_has_beyond_the_dump_is_said() {
    let pair = Pair::new();
    let rays = pair.theirs().join("edge01/shade/rays/pdf.npy");
    let beyond = pair.theirs().join("edge77/shade/rays");
    fs::create_dir_all(&beyond).expect("made");
    fs::copy(rays, beyond.join("pdf.npy")).expect("copied");
    let said = pair.verdict().not_compared;
    assert_eq!(said, ["edge77/shade/rays: the dump has no records there"]);
}

#[test]
fn records_that_no_array_bears_out_are_not_believed() {
    let pair = Pair::new();
    let path = pair.ours().join("manifest.json");
    let good: Value = serde_json::from_slice(&fs::read(&path).expect("read")).expect("JSON");
    let some = json!(good["queues"][0]["fields"]);
    for (records, fields) in [
        (1_000_000_000_u64, json!([])),
        (1, json!([])),
        (0, some.clone()),
        (2881, some),
    ] {
        let mut bad = good.clone();
        bad["queues"][0]["records"] = records.into();
        bad["queues"][0]["fields"] = fields;
        fs::write(&path, bad.to_string()).expect("written");
        pair.refuses(&[
            "ours/manifest.json",
            &format!("lists {records} records"),
            "write the dump again",
        ]);
    }
}
