//! The page of a comparison: one file that needs no network.

use super::pictures::{Pictures, pictures};
use crate::compare::flip::Flip;
use crate::compare::{Blocks, CHANNELS, ChannelReport, Image, LayerReport, Report, Verdict};
use crate::error::{Error, Result};
use crate::film::{describe, write_whole};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
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

/// The template, with what stands at `{{name}}` put in. Nothing that is put in is read again.
fn fill(
    to: &mut impl Write,
    report: &Report,
    images: [&Image; 2],
    pictures: &Pictures,
) -> io::Result<()> {
    let mut rest = PAGE;
    while let Some((before, after)) = rest.split_once("{{") {
        to.write_all(before.as_bytes())?;
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        let value = part(name, report, images, pictures);
        to.write_all(value.as_bytes())?;
        rest = after;
    }
    to.write_all(rest.as_bytes())
}

/// One part of the page.
fn part(name: &str, report: &Report, images: [&Image; 2], pictures: &Pictures) -> String {
    match name {
        "style" => STYLE.to_owned(),
        "script" => SCRIPT.to_owned(),
        // The browser runs and applies these alone, whatever a header or a file name says.
        "style_hash" => policy(STYLE),
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

/// A source of the content security policy: this text and no other.
fn policy(text: &str) -> String {
    format!(
        "'sha256-{}'",
        BASE64_STANDARD.encode(Sha256::digest(text.as_bytes()))
    )
}

/// As people read it, and as the style sheet does.
fn verdict(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::BitEqual => ("Bit-equal", "bit-equal"),
        Verdict::Consistent => ("Consistent", "consistent"),
        Verdict::Biased => ("Biased", "biased"),
    }
}

/// Text between tags and in attributes.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            c => escaped.push(c),
        }
    }
    escaped
}

/// Without the verdict, which stands above it, and with a capital.
fn sentence(summary: &str) -> String {
    let said = summary.split_once(": ").map_or(summary, |(_, said)| said);
    let mut characters = said.chars();
    let first = characters.next().map(|c| c.to_uppercase().to_string());
    escape(&(first.unwrap_or_default() + characters.as_str()))
}

/// Four digits that matter.
fn number(x: f64) -> String {
    let text = match x.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e5).contains(&size) => {
            let before = libm::log10(size).floor() as i32;
            let digits = usize::try_from(3 - before).unwrap_or(0);
            format!("{x:.digits$}")
        }
        _ => format!("{x:.2e}"),
    };
    text.replace('-', "−")
}

/// A probability.
fn probability(p: f64) -> String {
    match p {
        p if p >= 1e-3 => format!("{p:.3}"),
        p if p > 1e-99 => format!("{p:.0e}").replace('-', "−"),
        _ => "< 1e−99".to_owned(),
    }
}

fn signed_percent(fraction: f64) -> String {
    percent(fraction, if fraction > 0.0 { "+" } else { "" })
}

fn percent(fraction: f64, sign: &str) -> String {
    format!("{sign}{} %", number(100.0 * fraction))
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
        (
            "Bias it would find",
            report.detectable.map(|bias| percent(bias, "")),
        ),
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

fn metrics(report: &Report) -> String {
    let metrics = &report.metrics;
    let mut rows = String::new();
    let mut row = |name: &str, value: String, text: String| {
        rows += &format!(
            "<tr><th scope=\"row\">{name}</th><td>{value}</td><td class=\"text\">{text}</td></tr>"
        );
    };
    let expected = metrics.expected_mse.map_or(String::new(), |expected| {
        format!("; noise alone makes {}", number(expected))
    });
    row(
        "MSE",
        number(metrics.mse),
        format!("mean of d², d = test − reference{expected}"),
    );
    row(
        "relMSE",
        number(metrics.rel_mse),
        "mean of d² / (reference² + 0.01)".to_owned(),
    );
    row("MAE", number(metrics.mae), "mean of |d|".to_owned());
    if let (Some(flip), Some(at)) = (metrics.flip, metrics.flip_exposures) {
        let text = format!(
            "mean HDR-ꟻLIP, 0 to 1, at {} exposures from {:+.2} to {:+.2} EV",
            at.count, at.start, at.stop
        );
        row(
            "ꟻLIP",
            number(flip),
            text.replace('-', "−").replace("HDR−", "HDR-"),
        );
    }
    if let Some(bias) = report.detectable {
        row(
            "Detectable bias",
            percent(bias, ""),
            "smallest uniform bias that this pair would have shown in 95 of 100 cases".to_owned(),
        );
    }
    row(
        "α",
        number(report.alpha),
        "probability of a false alarm, all tests together".to_owned(),
    );
    row(
        "Tolerance",
        percent(report.tolerance, ""),
        "relative bias that is not called one".to_owned(),
    );
    format!("<tbody>{rows}</tbody>")
}

/// The heads of a table of tests.
fn heads(first: &str) -> String {
    let names = [
        first,
        "Reference",
        "Test",
        "Difference",
        "95 % interval",
        "z",
        "p",
        "p of blocks",
        "Worst block",
        "its z",
    ];
    let cells = names.map(|name| format!("<th scope=\"col\">{name}</th>"));
    format!("<thead><tr>{}</tr></thead>", cells.concat())
}

/// A row of one: a channel's tests.
fn channel_row(name: &str, biased: bool, channel: &ChannelReport) -> String {
    let ChannelReport { mean, blocks, .. } = channel;
    let [difference, interval] = match mean.relative {
        Some(relative) => {
            let [low, high] = relative.interval.map(signed_percent);
            [signed_percent(relative.value), format!("{low} to {high}")]
        }
        None => [number(mean.difference), String::new()],
    };
    let [x0, y0, x1, y1] = blocks.worst.region;
    let cells = [
        number(mean.reference),
        number(mean.test),
        difference,
        interval,
        number(mean.z),
        probability(mean.p),
        probability(blocks.p),
        format!("{x0},{y0} to {x1},{y1}"),
        number(blocks.worst.z),
    ];
    let cells = cells.map(|cell| format!("<td>{cell}</td>"));
    let class = if biased { " class=\"biased\"" } else { "" };
    format!(
        "<tr{class}><th scope=\"row\">{name}</th>{}</tr>",
        cells.concat()
    )
}

fn channels(layer: &LayerReport) -> String {
    let rows = layer
        .channels
        .iter()
        .map(|channel| channel_row(channel.channel, false, channel));
    format!(
        "{}<tbody>{}</tbody>",
        heads("Channel"),
        rows.collect::<String>()
    )
}

/// The luminance of each path length.
fn lengths(report: &Report) -> String {
    if report.lengths.is_empty() {
        return "<p class=\"hint\">Not both images have layers by path length. Rendered with <code>--aov bounces</code>, they show \
                at which path length a bias begins.</p>"
            .to_owned();
    }
    let row = |layer: &LayerReport| {
        let luminance = layer.channels.last()?;
        let name = match (layer.length?, layer.biased) {
            (length, true) => format!("{length} <span class=\"yes\">biased</span>"),
            (length, false) => length.to_string(),
        };
        Some(channel_row(&name, layer.biased, luminance))
    };
    let rows: String = report.lengths.iter().filter_map(row).collect();
    format!(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"lengths\"><table>{}<tbody>{rows}</tbody></table></div>\
         <p class=\"hint\">Luminance of the light that arrives on paths of that many edges.</p>",
        heads("Edges")
    )
}

/// What the files say of how they were made: attributes `ondine.*`.
fn settings(images: [&Image; 2]) -> String {
    let [reference, test] = images.map(|image| attributes(&image.path));
    let names: BTreeSet<&String> = reference.keys().chain(test.keys()).collect();
    if names.is_empty() {
        return String::new();
    }
    let row = |name: &String| {
        let [a, b] = [&reference, &test].map(|all| all.get(name).map_or("", String::as_str));
        let class = if a == b { "" } else { " class=\"differs\"" };
        format!(
            "<tr{class}><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>",
            escape(&name.replace('_', " ")),
            escape(a),
            escape(b)
        )
    };
    let rows: String = names.into_iter().map(row).collect();
    format!(
        "<section aria-labelledby=\"settings\"><h2 id=\"settings\">Settings</h2><div class=\"scroll\" tabindex=\"0\" role=\"region\" \
         aria-labelledby=\"settings\"><table class=\"settings\"><thead><tr><th></th><th scope=\"col\">Reference</th>\
         <th scope=\"col\">Test</th></tr></thead><tbody>{rows}</tbody></table></div></section>"
    )
}

/// None where the header cannot be read again: the page can do without.
fn attributes(path: &Path) -> BTreeMap<String, String> {
    let parts = describe(path).map_or(Vec::new(), |file| file.parts);
    let all = parts.into_iter().flat_map(|part| part.attributes);
    all.filter_map(|(name, value)| {
        let text = match value {
            Value::String(text) => text,
            other => other.to_string(),
        };
        Some((name.strip_prefix("ondine.")?.to_owned(), text))
    })
    .collect()
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
    fn names_and_headers_are_text_and_nothing_else() {
        assert_eq!(escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
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
        assert!(!STYLE.contains("</") && !SCRIPT.contains("</") && !SCRIPT.contains("<!--"));
    }

    #[test]
    fn numbers_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.000"),
            (-12.345_67, "−12.35"),
            (99_999.0, "99999"),
            (1e-5, "1.00e−5"),
            (0.001, "0.001000"),
        ] {
            assert_eq!(number(x), text);
        }
    }
}
