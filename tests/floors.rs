//! The house's rule: a room uses rooms of lower floors, and stages of the wave meet in their queues alone.

use std::path::{Path, PathBuf};

/// Rooms and their floors. `record!` is exported at the root, from the lanes.
const FLOORS: [(&str, u32); 25] = [
    ("lanes", 0),
    ("record", 0),
    ("error", 0),
    ("sampling", 1),
    ("sh", 1),
    ("texture", 1),
    ("npy", 1),
    ("shape", 2),
    ("bvh", 2),
    ("material", 2),
    ("film", 2),
    ("scene", 3),
    ("compare", 3),
    ("wavefront", 4),
    ("render", 5),
    ("stats", 5),
    ("dump", 5),
    ("merge", 5),
    ("resume", 5),
    ("batch", 6),
    ("bench", 6),
    ("view", 6),
    ("cli", 7),
    ("main", 7),
    ("lib", 8),
];

/// Arrows between rooms of one floor that are meant.
const LEVEL: [(&str, &str); 6] = [
    ("render", "stats"),
    ("dump", "render"),
    ("resume", "render"),
    ("main", "cli"),
    // A macro of the lanes that names its own room from outside.
    ("record", "lanes"),
    ("lanes", "record"),
];

/// Where the stages of the wave meet.
const MEETING_PLACE: &str = "queues";

/// Not stages: what the loop keeps count with, and who looks on.
const NO_STAGES: [&str; 3] = [MEETING_PLACE, "tally", "observe"];

fn floor(room: &str) -> Option<u32> {
    FLOORS
        .iter()
        .find(|(name, _)| *name == room)
        .map(|(_, floor)| *floor)
}

/// A file's place in the house: `scene/toml/mod.rs` is `[scene, toml]`.
fn place(file: &Path) -> Vec<String> {
    let mut parts: Vec<String> = file
        .with_extension("")
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if parts.last().is_some_and(|last| last == "mod") {
        parts.pop();
    }
    parts
}

/// The code alone: no comments, no contents of texts, no tests (they stand last in a file).
fn code(source: &str) -> String {
    let source = source.split("#[cfg(test)]").next().unwrap_or(source);
    let mut kept = String::new();
    for line in source.lines() {
        let mut in_text = false;
        let mut before = ' ';
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            if !in_text && c == '/' && characters.peek() == Some(&'/') {
                break;
            }
            if c == '"' && before != '\\' && before != '\'' {
                in_text = !in_text;
            }
            if !in_text {
                kept.push(c);
            }
            before = if before == '\\' && c == '\\' { ' ' } else { c };
        }
        kept.push('\n');
    }
    kept
}

/// The paths of a tree such as `a::{b, c::{self, d}}`, and what was not read.
fn leaves(tree: &str) -> (Vec<Vec<String>>, &str) {
    let mut path = Vec::new();
    let mut rest = tree.trim_start();
    loop {
        if let Some(mut inside) = rest.strip_prefix('{') {
            let mut all = Vec::new();
            loop {
                inside = inside.trim_start().trim_start_matches(',').trim_start();
                if let Some(after) = inside.strip_prefix('}') {
                    return (all, after);
                }
                let (below, after) = leaves(inside);
                assert!(
                    after.len() < inside.len(),
                    "cannot read the use of {tree:.80}"
                );
                all.extend(below.into_iter().map(|leaf| [path.clone(), leaf].concat()));
                inside = after.trim_start();
                if let Some(after) = inside.strip_prefix("as ") {
                    inside = after
                        .trim_start_matches(|c: char| c.is_alphanumeric() || c == '_' || c == ' ');
                }
            }
        }
        let end = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '*'))
            .unwrap_or(rest.len());
        path.push(rest[..end].to_owned());
        rest = &rest[end..];
        match rest.strip_prefix("::") {
            Some(after) => rest = after.trim_start(),
            None => return (vec![path], rest),
        }
    }
}

/// Absolute paths that a file names: by `crate`, the crate's own name from the program, or `super`.
fn uses(place: &[String], source: &str) -> Vec<Vec<String>> {
    let text = code(source);
    let mut found = Vec::new();
    let mut taken = 0;
    for (start, _) in text.match_indices(|c: char| c.is_alphabetic()) {
        let word = &text[start..];
        let joined = text[..start].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
        if start < taken || joined {
            continue;
        }
        let mut base = Vec::new();
        let mut rest = word;
        if let Some(after) = word
            .strip_prefix("crate::")
            .or_else(|| word.strip_prefix("ondine::"))
        {
            rest = after;
        } else if word.starts_with("super::") {
            base = place.to_vec();
            while let Some(after) = rest.strip_prefix("super::") {
                base.pop();
                rest = after;
            }
        } else {
            continue;
        }
        let (below, after) = leaves(rest);
        taken = text.len() - after.len();
        found.extend(below.into_iter().map(|leaf| [base.clone(), leaf].concat()));
    }
    found
}

/// What is wrong with a file's arrows.
fn wrong_arrows(file: &Path, source: &str) -> Vec<String> {
    let place = place(file);
    let room = place[0].as_str();
    let Some(here) = floor(room) else {
        return vec![format!(
            "src/{}: give {room} a floor in tests/floors.rs",
            file.display()
        )];
    };
    let mut wrong = Vec::new();
    for path in uses(&place, source) {
        let target = path.first().map_or("", String::as_str);
        let shown = format!("src/{}: crate::{}", file.display(), path.join("::"));
        if target == room {
            let stage = |path: &[String]| -> Option<String> {
                let part = path.get(1)?;
                let is_file = Path::new(env!("CARGO_MANIFEST_DIR"))
                    .join(format!("src/wavefront/{part}.rs"))
                    .exists();
                (is_file && !NO_STAGES.contains(&part.as_str())).then(|| part.clone())
            };
            // The loop itself may call every stage; a stage and the meeting place may not.
            if room == "wavefront"
                && place.len() > 1
                && let Some(other) = stage(&path).filter(|other| *other != place[1])
            {
                wrong.push(format!(
                    "{shown}: {} and {other} are to meet in {MEETING_PLACE}",
                    place[1]
                ));
            }
            continue;
        }
        match floor(target) {
            None => wrong.push(format!("{shown}: give {target} a floor in tests/floors.rs")),
            Some(there) if there > here => {
                wrong.push(format!("{shown}: from floor {here} up to {there}"))
            }
            Some(there) if there == here && !LEVEL.contains(&(room, target)) => {
                wrong.push(format!("{shown}: sideways on floor {here}"));
            }
            Some(_) => {}
        }
    }
    wrong
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn arrows_point_down() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 40, "{} files", files.len());
    let mut arrows = 0;
    let mut wrong = Vec::new();
    for file in files {
        let source = std::fs::read_to_string(&file).expect("a text");
        let relative = file.strip_prefix(&root).expect("below src");
        arrows += uses(&place(relative), &source).len();
        wrong.extend(wrong_arrows(relative, &source));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(
        arrows > 150,
        "{arrows} arrows: does this test still read them?"
    );
}

#[test]
fn a_wrong_arrow_is_caught_however_it_is_written() {
    for (file, source) in [
        ("lanes/rgb.rs", "use crate::sampling::Sampler;"),
        (
            "shape/quad.rs",
            "fn f() { let x = crate::render::render(); }",
        ),
        (
            "film/mod.rs",
            "use crate::{error::Error, scene::{toml::Scene}};",
        ),
        (
            "film/exr.rs",
            "pub(crate) use super::super::wavefront::Wave;",
        ),
        ("film/mod.rs", "use super::stats::Stats;"),
        ("material/lambert.rs", "use crate::shape::Quad;"),
        ("stats.rs", "use crate::render::Settings;"),
        ("render.rs", "use crate::cli;"),
        ("batch/run.rs", "use crate::cli::report::Report;"),
        ("wavefront/nee.rs", "use super::shade::continues;"),
        (
            "wavefront/nee.rs",
            "use crate::wavefront::{queues::VertexX8, accumulate};",
        ),
        ("wavefront/queues.rs", "use super::intersect;"),
        ("scene/toml/world.rs", "use super::super::super::wavefront;"),
        ("new_room/mod.rs", ""),
        ("sampling/mod.rs", "use crate::new_room::Thing;"),
    ] {
        let wrong = wrong_arrows(Path::new(file), source);
        assert_eq!(wrong.len(), 1, "{file}: {source}: {wrong:?}");
    }
}

#[test]
fn a_right_arrow_is_left_alone() {
    for (file, source) in [
        (
            "scene/mod.rs",
            "use crate::lanes::{Rgb, f32x8 as wide}; use super::sampling::warp;",
        ),
        (
            "wavefront/nee.rs",
            "use super::queues::{ShadowRayX8, VertexX8}; use super::Context; use super::tally::Stage;",
        ),
        (
            "wavefront/mod.rs",
            "pub mod nee; use crate::film::Region; fn f() { nee::sample(); }",
        ),
        (
            "film/mod.rs",
            "// use crate::render::Settings;\n/// As [`crate::cli`].\nconst A: &str = \"use crate::render;\";",
        ),
        ("render.rs", "use crate::stats::Stats;"),
        ("main.rs", "use ondine::cli; use ondine::render::render;"),
        (
            "scene/toml/world.rs",
            "use super::super::description::Light; use super::reader;",
        ),
        ("lib.rs", "pub mod cli;"),
    ] {
        assert_eq!(
            wrong_arrows(Path::new(file), source),
            Vec::<String>::new(),
            "{file}: {source}"
        );
    }
}
