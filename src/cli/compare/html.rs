//! The page of a comparison: one file that needs no network.

use super::pictures::{Pictures, pictures};
use super::tables::{channels, lengths, metrics, number, percent, settings, signed_percent};
use crate::cli::page::{self, escape, policy};
use crate::compare::flip::Flip;
use crate::compare::{Blocks, CHANNELS, Image, Report, Verdict};
use crate::error::{Error, Result};
use crate::film::write_whole;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::Path;

const PAGE: &str = include_str!("page/report.html");
const STYLE: &str = include_str!("page/report.css");
const SCRIPT: &str = include_str!("page/report.js");

/// Writes the page: whole, or nothing.
///
/// # Errors
/// [`Error::Write`].
pub(super) fn write(
    path: &Path,
    report: &Report,
    images: [&Image; 2],
    flip: Option<&Flip>,
) -> Result<()> {
    let pictures = pictures(images, flip).map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })?;
    write_whole(path, |file| fill(file, report, images, &pictures))
}

fn fill(
    to: &mut impl Write,
    report: &Report,
    images: [&Image; 2],
    pictures: &Pictures,
) -> io::Result<()> {
    page::fill(to, PAGE, |name| part(name, report, images, pictures))
}

fn style() -> String {
    page::STYLE.to_owned() + STYLE
}

/// One part of the page.
fn part(name: &str, report: &Report, images: [&Image; 2], pictures: &Pictures) -> String {
    match name {
        "style" => style(),
        "script" => SCRIPT.to_owned(),
        // The browser runs and applies these alone, whatever a header or a file name says.
        "style_hash" => policy(&style()),
        "script_hash" => policy(SCRIPT),
        "verdict" => verdict(report.verdict).0.to_owned(),
        "verdict_class" => verdict(report.verdict).1.to_owned(),
        "reference" => escape(&images[0].path.to_string_lossy()),
        "test" => escape(&images[1].path.to_string_lossy()),
        "size" => format!("{} × {}", report.width, report.height),
        "summary" => sentence(&report.summary),
        "figures" => figures(report),
        "plates" => plates(pictures),
        "scale_note" => scale_note(pictures),
        "metrics" => metrics(report),
        "channels" => channels(&report.image),
        "lengths" => lengths(report),
        "settings" => settings(images),
        "notes" => notes(report),
        "version" => env!("CARGO_PKG_VERSION").to_owned(),
        "data" => data(report, images, pictures),
        _ => String::new(),
    }
}

/// As people read it, and as the style sheet does.
fn verdict(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::BitEqual => ("Bit-equal", "bit-equal"),
        Verdict::Consistent => ("Consistent", "consistent"),
        Verdict::Biased => ("Biased", "biased"),
    }
}

/// Without the verdict, which stands above it, and with a capital.
fn sentence(summary: &str) -> String {
    let said = summary.split_once(": ").map_or(summary, |(_, said)| said);
    let mut characters = said.chars();
    let first = characters.next().map(|c| c.to_uppercase().to_string());
    escape(&(first.unwrap_or_default() + characters.as_str())).replace(" -", " −")
}

/// What is looked for first.
fn figures(report: &Report) -> String {
    let metrics = &report.metrics;
    let luminance = report.image.channels.last();
    let relative = luminance.and_then(|channel| channel.mean.relative);
    let all = [
        (
            "Mean luminance",
            relative.map(|relative| signed_percent(relative.value)),
        ),
        ("Bias it would find", report.detectable.map(percent)),
        ("relMSE", Some(number(metrics.rel_mse))),
        ("ꟻLIP", metrics.flip.map(number)),
    ];
    let figure = |(name, value): (&str, Option<String>)| {
        Some(format!("<div><dt>{name}</dt><dd>{}</dd></div>", value?))
    };
    all.into_iter().filter_map(figure).collect()
}

/// The pictures, for the script; without it, they are the page's.
fn plates(pictures: &Pictures) -> String {
    let plate = |picture: &super::pictures::Picture| {
        let super::pictures::Picture {
            name,
            title,
            alone,
            uri,
        } = picture;
        let class = if *alone { "" } else { " class=\"carrier\"" };
        format!(
            "<figure{class}><img id=\"image-{name}\" alt=\"{title}\" width=\"{}\" height=\"{}\" src=\"{uri}\">\
             <figcaption>{title}</figcaption></figure>\n",
            pictures.columns, pictures.rows
        )
    };
    pictures.all.iter().map(plate).collect()
}

fn scale_note(pictures: &Pictures) -> String {
    let mut note = String::new();
    if pictures.exposure != 0.0 {
        let exposure = pictures.exposure.to_string().replace('-', "−");
        note += &format!(" At 0 EV, radiance is shown times 2<sup>{exposure}</sup>.");
    }
    if pictures.scale > 1 {
        note += &format!(
            " Each pixel shown is the mean of {0} × {0} of the images.",
            pictures.scale
        );
    }
    note
}

fn notes(report: &Report) -> String {
    if report.notes.is_empty() {
        return String::new();
    }
    let items: String = report
        .notes
        .iter()
        .map(|note| format!("<li>{}</li>", escape(note)))
        .collect();
    format!(
        "<section aria-labelledby=\"notes\"><h2 id=\"notes\">Notes</h2><ul>{items}</ul></section>"
    )
}

/// What the script shows, as JSON that no text in it can end.
fn data(report: &Report, [reference, _]: [&Image; 2], pictures: &Pictures) -> String {
    let layers: Vec<Value> = std::iter::once(&report.image)
        .chain(&report.lengths)
        .map(|layer| {
            let Blocks { columns, rows, z } = &layer.blocks;
            let z: Vec<Vec<f64>> = z
                .iter()
                .map(|z| z.iter().map(|&z| shown(z)).collect())
                .collect();
            let name = layer.length.map_or("the image".to_owned(), |length| {
                format!("path length {length}")
            });
            json!({ "name": name, "columns": columns, "rows": rows, "z": z })
        })
        .collect();
    let bias = report.bias.as_ref();
    let channel = bias.and_then(|bias| CHANNELS.iter().position(|name| *name == bias.channel));
    let layer = bias.and_then(|bias| {
        report
            .lengths
            .iter()
            .position(|layer| layer.length == bias.length)
    });
    let data = json!({
        "columns": pictures.columns,
        "rows": pictures.rows,
        "scale": pictures.scale,
        "x0": reference.x0,
        "y0": reference.y0,
        "gain": libm::exp2f(pictures.exposure),
        "headroom": pictures.headroom,
        "relative_range": pictures.relative_range,
        "flip": report.metrics.flip.is_some(),
        "layers": layers,
        "channels": CHANNELS,
        "layer": layer.map_or(0, |layer| layer + 1),
        "channel": channel.unwrap_or(CHANNELS.len() - 1),
    });
    data.to_string().replace('<', "\\u003c")
}

/// Two places, and a number.
fn shown(z: f64) -> f64 {
    let z = (z * 100.0).round() / 100.0;
    if z.is_finite() { z } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_is_text_and_nothing_else() {
        assert_eq!(sentence("biased: <i>"), "&lt;i&gt;");
    }

    #[test]
    fn every_place_of_the_template_is_known() {
        let names = PAGE
            .split("{{")
            .skip(1)
            .map(|rest| rest.split_once("}}").expect("an end").0);
        let known = [
            "style_hash",
            "script_hash",
            "verdict",
            "reference",
            "test",
            "style",
            "verdict_class",
            "size",
            "summary",
            "figures",
            "scale_note",
            "plates",
            "metrics",
            "channels",
            "lengths",
            "settings",
            "notes",
            "version",
            "data",
            "script",
        ];
        for name in names {
            assert!(known.contains(&name), "{name}");
        }
        // What would end the elements that hold them.
        assert!(!style().contains("</") && !SCRIPT.contains("</") && !SCRIPT.contains("<!--"));
    }
}
