//! The test vectors of `docs/vectors`: what the program gives today, byte for byte, and worth checking a port against.

use ondine::dump::budget;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

/// The files of a folder by name.
fn files(folder: &Path) -> BTreeMap<String, String> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            let name = entry.file_name().into_string().unwrap();
            (name, std::fs::read_to_string(entry.path()).unwrap())
        })
        .collect()
}

fn dump_vectors(folder: &Path, to: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ondine"))
        .args(["dump", "--vectors", to])
        .current_dir(folder)
        .output()
        .unwrap()
}

fn committed() -> BTreeMap<String, String> {
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/vectors"))
}

#[test]
fn the_committed_vectors_are_what_the_program_writes() {
    let folder = tempfile::tempdir().unwrap();
    let output = dump_vectors(folder.path(), "vectors");
    assert!(output.status.success(), "{output:?}");
    let (written, committed) = (files(&folder.path().join("vectors")), committed());
    assert!(
        written.keys().eq(committed.keys()),
        "{:?} and {:?}",
        written.keys(),
        committed.keys()
    );
    for (name, text) in &committed {
        let lines = text.lines().zip(written[name].lines());
        for (number, (ours, now)) in lines.enumerate() {
            assert_eq!(
                now,
                ours,
                "{name}:{}: run `ondine dump --vectors docs/vectors`",
                number + 1
            );
        }
        assert_eq!(written[name], *text, "{name}");
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("taken"), "").unwrap();
    let output = dump_vectors(folder.path(), "taken/vectors");
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.starts_with("error: taken/vectors: cannot write"),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
}

/// Calls `visit` with each case of each section of each topic, and the place as text.
fn each_case(mut visit: impl FnMut(&str, &serde_json::Map<String, Value>)) {
    for (name, text) in committed() {
        let topic: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(topic["schema"], "ondine-vectors/1", "{name}");
        for (section, content) in topic["sections"].as_object().unwrap() {
            let cases = content["cases"].as_array().unwrap();
            assert!(!content["about"].as_str().unwrap().is_empty());
            for (number, case) in cases.iter().enumerate() {
                visit(
                    &format!("{name}: {section}[{number}]"),
                    case.as_object().unwrap(),
                );
            }
        }
    }
}

/// A float or floats in decimals, and the same as bits.
fn same(decimal: &Value, bits: &Value) -> bool {
    match (decimal, bits) {
        (Value::Array(decimals), Value::Array(bits)) => {
            decimals.len() == bits.len() && decimals.iter().zip(bits).all(|(d, b)| same(d, b))
        }
        (decimal, Value::String(bits)) => {
            let word = u32::from_str_radix(bits.strip_prefix("0x").unwrap(), 16).unwrap();
            let float = f32::from_bits(word);
            match decimal.as_f64() {
                Some(decimal) => (decimal as f32).to_bits() == word,
                None => decimal.is_null() && !float.is_finite(),
            }
        }
        _ => false,
    }
}

#[test]
fn decimals_and_bits_of_every_float_are_the_same_number() {
    let mut floats = 0;
    each_case(|place, case| {
        for (name, value) in case {
            if let Some(bits) = case.get(&format!("{name}_bits")) {
                assert!(same(value, bits), "{place}: {name}");
                floats += 1;
            }
        }
    });
    assert!(floats > 2000, "{floats} floats");
}

#[test]
fn the_vectors_tell_one_behaviour_from_another() {
    let mut seen: BTreeMap<String, (usize, BTreeMap<String, usize>)> = BTreeMap::new();
    each_case(|place, case| {
        let section = place.split('[').next().unwrap().to_owned();
        let (count, texts) = seen.entry(section).or_default();
        *count += 1;
        *texts
            .entry(serde_json::to_string(case).unwrap())
            .or_default() += 1;
    });
    assert!(seen.len() >= 45, "{} sections", seen.len());
    for (section, (count, texts)) in &seen {
        assert_eq!(texts.len(), *count, "{section}: a case is there twice");
        assert!(
            *count >= 3 || section.ends_with("ties"),
            "{section}: {count} cases"
        );
    }
    // Both answers of every question that has two.
    for (section, key, yes) in [
        ("intersections.json: shadow", "occluded", "true"),
        ("triangles.json: any", "occluded", "true"),
        ("lights.json: all", "punctual", "true"),
        ("intersections.json: sphere", "primitive", "null"),
        ("intersections.json: quad", "primitive", "null"),
        ("triangles.json: closest", "triangle", "null"),
        ("film.json: pixel", "rejected", "0"),
    ] {
        let text = format!("\"{key}\":{yes}");
        let with = seen[section].1.keys().filter(|case| case.contains(&text));
        let with = with.count();
        assert!(
            0 < with && with < seen[section].0,
            "{section}: {with} with {text}"
        );
    }
}

/// The rows of the table of the specification that begins with this.
fn rows(head: &str) -> Vec<Vec<String>> {
    let text = specification();
    let table = text.split(head).nth(1).expect(head);
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect();
    // The rest of the head, and the rule below it.
    let rows = table.lines().skip(2).map_while(|line| {
        let is_row = line.starts_with('|');
        is_row.then(|| cells(line))
    });
    rows.collect()
}

fn specification() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/specification.md");
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn the_specification_names_every_budget() {
    let written: BTreeMap<String, f64> = rows("| fields | ulp on the first edge |")
        .iter()
        .flat_map(|row| {
            let ulp: f64 = row[2].parse().unwrap();
            row[1]
                .split(' ')
                .map(move |field| (field.trim_matches('`').to_owned(), ulp))
        })
        .collect();
    let held: BTreeMap<String, f64> = budget::BUDGETS
        .iter()
        .map(|(field, budget)| ((*field).to_owned(), budget.ulp))
        .collect();
    assert_eq!(written, held);
    let text = specification();
    for number in [
        format!("times {} for each edge", budget::GROWTH),
        format!("{} at most", budget::PARTED),
        format!("One path in {} may part", budget::PATHS_PER_PARTING),
    ] {
        assert!(text.contains(&number), "{number}");
    }
}

#[test]
fn the_specification_lists_the_vectors_and_counts_their_cases() {
    let mut counted: BTreeMap<String, usize> = BTreeMap::new();
    each_case(|place, _| {
        let name = place.split(':').next().unwrap();
        *counted.entry(format!("`{name}`")).or_default() += 1;
    });
    let written: BTreeMap<String, usize> = rows("| file | cases |")
        .iter()
        .map(|row| (row[1].clone(), row[2].parse().unwrap()))
        .collect();
    assert_eq!(written, counted);
}
