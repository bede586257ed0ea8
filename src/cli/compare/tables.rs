//! The tables of the page.

use crate::cli::page::escape;
use crate::compare::{self, ChannelReport, Image, LayerReport, Report};
use crate::film::describe;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

pub(super) fn metrics(report: &Report) -> String {
    let metrics = &report.metrics;
    let mut rows = String::new();
    let mut row = |name: &str, value: String, text: String| {
        rows += &format!(
            "<tr><th scope=\"row\">{name}</th><td>{value}</td><td class=\"text\">{text}</td></tr>"
        );
    };
    let expected = metrics.expected_mse.map_or(String::new(), |expected| {
        format!("; the variances announce {}", number(expected))
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
            percent(bias),
            "smallest uniform bias that this pair would have shown in 95 of 100 cases".to_owned(),
        );
    }
    row(
        "α",
        report.alpha.to_string(),
        "probability of a false alarm, all tests together".to_owned(),
    );
    row(
        "Tolerance",
        percent(report.tolerance),
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
        score(mean.z),
        probability(mean.p),
        probability(blocks.p),
        format!("{x0},{y0} to {x1},{y1}"),
        score(blocks.worst.z),
    ];
    let cells = cells.map(|cell| format!("<td>{cell}</td>"));
    let class = if biased { " class=\"biased\"" } else { "" };
    format!(
        "<tr{class}><th scope=\"row\">{name}</th>{}</tr>",
        cells.concat()
    )
}

pub(super) fn channels(layer: &LayerReport) -> String {
    let rows = layer
        .channels
        .iter()
        .map(|channel| channel_row(channel.channel, channel.biased, channel));
    format!(
        "{}<tbody>{}</tbody>",
        heads("Channel"),
        rows.collect::<String>()
    )
}

/// The luminance of each path length.
pub(super) fn lengths(report: &Report) -> String {
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
pub(super) fn settings(images: [&Image; 2]) -> String {
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

/// Four digits that matter.
pub(super) fn number(x: f64) -> String {
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

/// A relative difference, with its sign.
pub(super) fn signed_percent(fraction: f64) -> String {
    compare::percent(fraction).replace('-', "−")
}

/// A part, without one.
pub(super) fn percent(fraction: f64) -> String {
    signed_percent(fraction).replace('+', "")
}

/// A normal score.
fn score(z: f64) -> String {
    format!("{z:.2}").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

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
