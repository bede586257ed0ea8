//! A comparison as text: the answer, then the figures.

use crate::compare::{ChannelReport, LayerReport, Report, Verdict, percent};
use std::fmt::{Result, Write};

/// The report, for a reader.
pub(super) fn text(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a text cannot fail.
    let _ = write(&mut text, report);
    text
}

fn write(out: &mut String, report: &Report) -> Result {
    writeln!(out, "{}", report.summary)?;
    if let Some(bias) = &report.bias {
        // Below, the probability is no number.
        let p = bias.p.max(1e-300);
        writeln!(
            out,
            "  noise alone would look so with a probability of {p:.0e} or less, all tests together"
        )?;
    }
    for note in &report.notes {
        writeln!(out, "  note: {note}")?;
    }
    if report.verdict == Verdict::BitEqual {
        return Ok(());
    }
    let metrics = &report.metrics;
    writeln!(out)?;
    write!(out, "MSE {:.4e}", metrics.mse)?;
    if let Some(expected) = metrics.expected_mse {
        write!(out, " (the variances announce {expected:.4e})")?;
    }
    write!(
        out,
        "  relMSE {:.4e}  MAE {:.4e}",
        metrics.rel_mse, metrics.mae
    )?;
    if let Some(flip) = metrics.flip {
        write!(out, "  FLIP {flip:.4}")?;
    }
    writeln!(out)?;
    writeln!(out)?;
    writeln!(
        out,
        "{:<10} {:<10} {:>10} {:>11} {:>23} {:>8} {:>17} {:>8} {:>8}",
        "",
        "channel",
        "reference",
        "difference",
        "95 % interval",
        "z",
        "chi2/blocks",
        "worst z",
        "pixel z"
    )?;
    table(out, "image", &report.image, |_| true)?;
    for layer in &report.lengths {
        let name = layer
            .length
            .map_or_else(String::new, |length| format!("length {length}"));
        // Luminance speaks for the others, unless one of them is off.
        table(out, &name, layer, |channel| {
            channel.biased || channel.channel == "luminance"
        })?;
    }
    Ok(())
}

fn table(
    out: &mut String,
    name: &str,
    layer: &LayerReport,
    is_shown: impl Fn(&ChannelReport) -> bool,
) -> Result {
    for channel in layer.channels.iter().filter(|channel| is_shown(channel)) {
        let (mean, blocks) = (&channel.mean, &channel.blocks);
        let (difference, interval) = match mean.relative {
            Some(relative) => {
                let [low, high] = relative.interval.map(percent);
                (percent(relative.value), format!("{low} to {high}"))
            }
            None => (format!("{:.2e}", mean.difference), String::new()),
        };
        let pixel = channel.pixels.as_ref();
        writeln!(
            out,
            "{name:<10} {:<10} {:>10.4e} {difference:>11} {interval:>23} {:>8.2} {:>17} {:>8.2} {:>8}{}",
            channel.channel,
            mean.reference,
            mean.z,
            format!("{:.1}/{}", blocks.chi_square, blocks.count),
            blocks.worst.z,
            pixel.map_or_else(|| "-".to_owned(), |pixel| format!("{:.2}", pixel.worst.z)),
            if channel.biased { "  biased" } else { "" }
        )?;
    }
    Ok(())
}
