//! A report's sentences.

use super::Image;
use super::noise::Noise;
use super::report::{Bias, LayerReport, MeanTest, Report, Test, Verdict};
use std::fmt::Write;

/// A comparison that would miss a uniform bias of this size says little.
const WEAK: f64 = 0.1;

/// The answer.
pub fn sentence(report: &Report) -> String {
    match (&report.bias, report.detectable) {
        (Some(bias), _) => biased(report, bias),
        (None, _) if report.verdict == Verdict::BitEqual => {
            "bit-equal: every number that was compared has the same bits".to_owned()
        }
        (None, Some(detectable)) => {
            let bias = percent(detectable);
            let bias = bias.trim_start_matches('+');
            match detectable < WEAK {
                true => format!(
                    "consistent: the images differ by noise alone; a uniform bias of {bias} would have been found"
                ),
                false => format!(
                    "consistent, but with so much noise that no uniform bias below {bias} could have been found; give \
                     both images more samples"
                ),
            }
        }
        (None, None) => {
            "consistent, but these images have too few pixels, or too little light, to show any bias".to_owned()
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
        let _ = write!(
            text,
            "the bias is first seen at path length {length}, where "
        );
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
            "not both images have sample counts (a channel exact.samples), or their samples vary by different amounts, as of \
             two strategies: no single pixel was tested"
                .to_owned(),
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
                "only the {has} has the path lengths {}: a bias of theirs would show in the image alone",
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
