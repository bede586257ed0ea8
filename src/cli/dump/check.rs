//! `ondine dump --check`: a port's dump against one of ours.

use super::super::Outcome;
use super::super::report::counted;
use crate::dump::check::{Compared, Difference, Verdict, check};
use crate::error::{Error, Result};
use std::fmt::Write;
use std::path::PathBuf;

pub(super) fn run(folders: &[PathBuf], json: bool) -> Result<Outcome> {
    let [ours, theirs] = folders else {
        return Err(Error::Usage("--check takes two folders".to_owned()));
    };
    let verdict = check(ours, theirs)?;
    match json {
        true => super::super::print_json(&verdict)?,
        false => super::super::print(&text(&verdict))?,
    }
    Ok(match verdict.within {
        true => Outcome::Done,
        false => Outcome::Differs,
    })
}

fn text(verdict: &Verdict) -> String {
    let mut text = String::new();
    let mut line = |what: std::fmt::Arguments| {
        // A String takes everything.
        let _ = writeln!(text, "{what}");
    };
    for missing in &verdict.not_compared {
        line(format_args!("not compared: {missing}"));
    }
    let parted = &verdict.parted;
    let not_all = match verdict.missing {
        0 => String::new(),
        1 => "; 1 array was not compared".to_owned(),
        arrays => format!("; {arrays} arrays were not compared"),
    };
    match (&verdict.first, verdict.bit_equal) {
        (Some(first), _) => line(format_args!("first difference: {}", difference(first))),
        (None, true) => line(format_args!(
            "all that was compared is the same to the last bit{not_all}"
        )),
        (None, false) if parted.paths > 0 => line(format_args!(
            "all that was compared is within its budget, but for {} of at most {} that may part{not_all}",
            parted.paths,
            counted(parted.allowed, "path")
        )),
        (None, false) => line(format_args!(
            "all that was compared is within its budget{not_all}"
        )),
    }
    if let Some(first) = &parted.first {
        let told = verdict.first.as_ref() == Some(first);
        line(format_args!(
            "{} parted from ours, {} by another choice ({} may part), and are left out from there on{}",
            counted(parted.paths, "path"),
            parted.by_choice,
            parted.allowed,
            match told {
                true => String::new(),
                false => format!("; the first: {}", difference(first)),
            }
        ));
    }
    let (differ, same): (Vec<_>, Vec<_>) = (verdict.arrays.iter()).partition(|a| a.different > 0);
    if !differ.is_empty() {
        line(format_args!(
            "\n{:4}  {:42} {:>8} {:>9} {:>7} {:>12} {:>8}",
            "edge", "array", "records", "different", "beyond", "worst ulp", "budget"
        ));
        for array in differ {
            line(format_args!("{}", row(array)));
        }
    }
    let arrays = counted(same.len(), "array");
    line(format_args!("\n{arrays} without any difference"));
    text
}

fn row(array: &Compared) -> String {
    let name: Vec<&str> = [&array.stage, &array.queue, &array.field]
        .into_iter()
        .map(String::as_str)
        .filter(|part| !part.is_empty())
        .collect();
    let edge = match array.edge {
        0 => String::new(),
        edge => edge.to_string(),
    };
    format!(
        "{edge:>4}  {:42} {:>8} {:>9} {:>7} {:>12} {:>8}",
        name.join("/"),
        array.records,
        array.different,
        array.beyond,
        ulp(array.worst_ulp),
        ulp(array.budget_ulp),
    )
}

/// `edge 2, shade, rays, direction of path 77 (pixel 4,4, sample 13): (..) and (..) are 812 ulp apart; 64 are allowed`.
fn difference(found: &Difference) -> String {
    let mut text = match found.edge {
        0 => String::new(),
        edge => format!("edge {edge}, "),
    };
    text += &found.stage;
    if !found.queue.is_empty() {
        text = text + ", " + &found.queue;
    }
    if let Some(field) = &found.field {
        text = text + ", " + field;
    }
    let [x, y] = found.pixel;
    text += &match found.sample {
        Some(sample) => format!(" of path {} (pixel {x},{y}, sample {sample})", found.path),
        None => format!(" of pixel {x},{y}"),
    };
    let (ours, theirs) = (&found.ours, &found.theirs);
    text + &match found.ulp {
        Some(apart) => format!(
            ": ours is {ours}, theirs {theirs}, {} ulp apart; {} are allowed",
            ulp(apart),
            ulp(found.budget_ulp)
        ),
        None => format!(": ours is {ours}, theirs {theirs}"),
    }
}

/// To a tenth.
fn ulp(ulp: f64) -> String {
    match ulp {
        _ if ulp.is_infinite() => "infinite".to_owned(),
        _ if ulp >= 1e9 => format!("{ulp:.1e}"),
        _ if ulp.fract() == 0.0 => format!("{ulp}"),
        _ if ulp < 0.05 => format!("{ulp:.0e}"),
        _ => format!("{ulp:.1}"),
    }
}
