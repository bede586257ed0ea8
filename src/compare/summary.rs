//! A report's sentences.

use super::Image;
use super::noise::Noise;
use super::report::{Bias, LayerReport, MeanTest, Report, Test, Verdict};
use std::fmt::Write;

/// The answer.
pub fn sentence(report: &Report) -> String {
    match (&report.bias, report.detectable) {
        (Some(bias), _) => biased(report, bias),
        (None, _) if report.verdict == Verdict::BitEqual => {
            "bit-equal: every number that was compared has the same bits".to_owned()
        }
        (None, Some(detectable)) => format!(
            "consistent: the images differ by noise alone; a uniform bias of {} would have been found",
            percent(detectable).trim_start_matches('+')
        ),
        (None, None) => {
            "consistent: the images differ by noise alone, but no bias of the mean could have been found".to_owned()
        }
    }
}

fn biased(report: &Report, bias: &Bias) -> String {
    let layer = report
        .lengths
        .iter()
        .find(|layer| layer.length == bias.length)
        .unwrap_or(&report.image);
    let mut text = "biased: ".to_owned();
    if let Some(length) = bias.length {
        let _ = write!(text, "the bias begins at path length {length}, where ");
    }
    let Some(channel) = layer.channels.iter().find(|c| c.channel == bias.channel) else {
        return text;
    };
    let name = channel.channel;
    let blocks = &channel.blocks;
    let [x0, y0, x1, y1] = blocks.worst.region;
    let _ = match (bias.test, &channel.pixels) {
        (Test::Mean, _) => write!(text, "the mean of {name} {}", compared(&channel.mean)),
        (Test::Pixel, Some(pixels)) => {
            let worst = &pixels.worst;
            let off = off(worst.difference, worst.reference);
            write!(text, "{name} of pixel {},{} is {off}", worst.x, worst.y)
        }
        _ if blocks.outstanding == 0 => write!(
            text,
            "the {} blocks of {name} together, though none alone, differ by more than noise (chi-square {:.0}), \
             and the mean {}",
            blocks.count,
            blocks.chi_square,
            compared(&channel.mean)
        ),
        _ => {
            let off = off(blocks.worst.difference, blocks.worst.reference);
            write!(
                text,
                "{name} is {off} in the block {x0},{y0} to {x1},{y1}; {} of {} blocks show it, and the mean {}",
                blocks.outstanding,
                blocks.count,
                compared(&channel.mean)
            )
        }
    };
    text
}

fn compared(mean: &MeanTest) -> String {
    match mean.relative {
        Some(relative) => {
            let [low, high] = relative.interval.map(percent);
            format!(
                "is off by {} (95 % interval {low} to {high})",
                percent(relative.value)
            )
        }
        None => format!("is off by {:.3e}", mean.difference),
    }
}

fn off(difference: f64, reference: f64) -> String {
    match reference > 0.0 {
        true => format!("off by {}", percent(difference / reference)),
        false => format!("off by {difference:.3e}"),
    }
}

/// A fraction in percent, with its sign and the digits that matter.
pub fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    let digits = match percent.abs() {
        x if x >= 10.0 => 1,
        x if x >= 1.0 => 2,
        x if x >= 0.1 => 3,
        _ => 4,
    };
    format!("{percent:+.digits$} %")
}

/// What was assumed or could not be tested.
pub fn notes(pair: [&Image; 2], image: &LayerReport, noise: Option<&Noise>) -> Vec<String> {
    let mut notes = Vec::new();
    let mut note = |text: String| notes.push(text);
    match noise {
        None => note(
            "not both images have variances: noise was estimated from blocks, and no single pixel was tested"
                .to_owned(),
        ),
        Some(Noise { samples: None, .. }) => note(
            "neither image has sample counts (a channel exact.samples): no single pixel was tested".to_owned(),
        ),
        Some(_) => {}
    }
    let correlation = image
        .channels
        .iter()
        .map(|channel| channel.mean.correlation)
        .fold(1.0, f64::max);
    if correlation > 1.0 {
        note(format!(
            "differences of neighbouring pixels go together, by a shared filter or a smooth bias: variances of means were \
             raised {correlation:.2} times"
        ));
    }
    for (one, other, has) in [(0, 1, "reference"), (1, 0, "test image")] {
        let lacks = |length: &u32| pair[other].lengths.iter().all(|(known, _)| known != length);
        let lengths = pair[one].lengths.iter().map(|(length, _)| *length);
        let alone: Vec<String> = lengths.filter(lacks).map(|n| n.to_string()).collect();
        if !alone.is_empty() && !pair[other].lengths.is_empty() {
            note(format!(
                "only the {has} has path length {}, which was not compared: a bias that no other length shows is there",
                alone.join(", ")
            ));
        }
    }
    if image
        .channels
        .iter()
        .any(|channel| channel.blocks.count < 16)
    {
        note("the images are small: few blocks, and weak tests".to_owned());
    }
    notes
}
