//! Line plots, as SVG.

use crate::error::Result;
use crate::film::write_whole;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

/// Pixels, as a browser shows them.
const SIZE: (u32, u32) = (760, 480);

/// Told apart by the colour-blind, and in grey (Okabe & Ito 2008, "Color Universal Design").
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Lines of one style that can be told apart.
pub(super) const MOST_LINES: usize = COLOURS.len();

/// What is plotted against what.
#[derive(Clone, Debug)]
pub(super) struct Plot {
    /// Above everything.
    pub title: String,
    /// Across.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// The lines, in the order of the legend.
    pub lines: Vec<Line>,
}

/// An axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// What it shows, and its unit.
    pub label: String,
    /// How it shows it.
    pub scale: Scale,
    /// Whether 0 is on it, wherever the numbers are.
    pub from_zero: bool,
}

impl Axis {
    /// With a label.
    pub fn new(label: &str, scale: Scale) -> Self {
        Self {
            label: label.to_owned(),
            scale,
            from_zero: false,
        }
    }

    /// Linear, from 0: lengths on it can be compared.
    pub fn from_zero(label: &str) -> Self {
        Self {
            from_zero: true,
            ..Self::new(label, Scale::Linear)
        }
    }

    /// What it covers, of places on its scale.
    fn ticks(&self, places: impl Iterator<Item = f64>) -> Ticks {
        let zero = self.from_zero.then_some(0.0);
        Ticks::new(self.scale, places.chain(zero))
    }
}

/// How numbers lie on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    Linear,
    /// The same for whole numbers: nothing is marked between two.
    Whole,
    /// Only what is above 0 can be shown.
    Logarithmic,
}

/// A line through points.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Its name in the legend.
    pub name: String,
    /// Which of the colours: lines that belong together share one.
    pub colour: usize,
    /// How it is drawn.
    pub style: Style,
    /// Where it goes. Points that the axes cannot show are left out.
    pub points: Vec<(f64, f64)>,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// With a dot at each point.
    Dotted,
    /// Broken, without dots: what is expected, beside what was found.
    Dashed,
}

impl Plot {
    /// Writes it as an SVG file.
    ///
    /// # Errors
    /// [`Error::Write`](crate::error::Error::Write).
    pub fn write(&self, path: &Path) -> Result<()> {
        write_whole(path, |file| {
            let svg = self
                .svg()
                .map_err(|error| io::Error::other(error.to_string()))?;
            file.write_all(svg.as_bytes())
        })
    }

    /// The same as text.
    ///
    /// # Errors
    /// None that is known: a string takes everything.
    pub fn svg(&self) -> std::result::Result<String, Box<dyn std::error::Error>> {
        let shown: Vec<Vec<(f64, f64)>> = self.lines.iter().map(|line| self.shown(line)).collect();
        let x = self.x.ticks(shown.iter().flatten().map(|point| point.0));
        let y = self.y.ticks(shown.iter().flatten().map(|point| point.1));
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .caption(&self.title, ("sans-serif", 17))
                .margin(14)
                .x_label_area_size(42)
                .y_label_area_size(64)
                .build_cartesian_2d(x, y)?;
            chart
                .configure_mesh()
                .bold_line_style(BLACK.mix(0.16))
                .light_line_style(BLACK.mix(0.05))
                .axis_style(BLACK.mix(0.5))
                .label_style(("sans-serif", 13))
                .axis_desc_style(("sans-serif", 14))
                .x_desc(&self.x.label)
                .y_desc(&self.y.label)
                .draw()?;
            for (line, points) in self.lines.iter().zip(shown) {
                let colour = COLOURS[line.colour % COLOURS.len()];
                let stroke = colour.stroke_width(2);
                let drawn = match line.style {
                    Style::Dotted => {
                        let dots = points.iter().map(|&at| Circle::new(at, 3, colour.filled()));
                        chart.draw_series(dots)?;
                        chart.draw_series(LineSeries::new(points, stroke))?
                    }
                    Style::Dashed => {
                        chart.draw_series(DashedLineSeries::new(points, 6, 4, stroke))?
                    }
                };
                let style = line.style;
                drawn.label(&line.name).legend(move |(x, y)| {
                    let ends = [(x, y), (x + 24, y)];
                    match style {
                        Style::Dotted => PathElement::new(ends, stroke).into_dyn(),
                        Style::Dashed => DashedPathElement::new(ends, 6, 3, stroke).into_dyn(),
                    }
                });
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .label_font(("sans-serif", 13))
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.2))
                .draw()?;
            area.present()?;
        }
        Ok(svg)
    }

    /// The points of a line that the axes can show, on their scales.
    fn shown(&self, line: &Line) -> Vec<(f64, f64)> {
        line.points
            .iter()
            .map(|&(x, y)| (self.x.scale.place(x), self.y.scale.place(y)))
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .collect()
    }
}

impl Scale {
    /// Where a number lies on the axis; not finite where it cannot be shown.
    fn place(self, number: f64) -> f64 {
        match self {
            Self::Linear | Self::Whole => number,
            Self::Logarithmic => libm::log10(number),
        }
    }

    /// What stands at a labelled place.
    fn name(self, place: f64) -> String {
        match self {
            Self::Whole => place.to_string(),
            Self::Linear if (1e-4..1e6).contains(&place.abs()) => {
                // Multiples of a step: `0.30000000000000004` is 0.3.
                (libm::round(place * 1e9) / 1e9).to_string()
            }
            Self::Linear if place == 0.0 => "0".to_owned(),
            Self::Linear => format!("{place:.3e}"),
            Self::Logarithmic => power_of_ten(place),
        }
    }
}

/// `10⁻³` and its like.
fn power_of_ten(exponent: f64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    let exponent = format!("{exponent:.0}");
    "10".chars().chain(exponent.chars().map(raised)).collect()
}

/// What an axis covers, and where its lines are, in places on its scale.
#[derive(Debug)]
pub(super) struct Ticks {
    scale: Scale,
    low: f64,
    high: f64,
    labelled: Vec<f64>,
    between: Vec<f64>,
}

impl Ticks {
    /// Labels on an axis, about.
    const LABELS: f64 = 7.0;

    /// Round numbers around these places.
    pub fn new(scale: Scale, places: impl Iterator<Item = f64>) -> Self {
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), place| {
            (low.min(place), high.max(place))
        });
        // Nothing to show, or one number alone.
        let (low, high) = match high - low {
            span if span > 0.0 => (low, high),
            _ if low.is_finite() && scale == Scale::Whole => (low, low + 1.0),
            _ if low.is_finite() => (low - 0.5, low + 0.5),
            _ => (0.0, 1.0),
        };
        let step = match scale {
            Scale::Linear => round_step((high - low) / Self::LABELS),
            Scale::Whole => round_step(((high - low) / Self::LABELS).max(1.0)),
            Scale::Logarithmic => ((high - low) / Self::LABELS).ceil(),
        };
        let (first, last) = ((low / step).floor(), (high / step).ceil());
        let labels = (last - first) as usize;
        let fine: &[f64] = match scale {
            Scale::Linear => &[0.2, 0.4, 0.6, 0.8],
            Scale::Whole => &[],
            // Each power of ten, or what lies between two.
            Scale::Logarithmic if step > 1.0 => &[],
            Scale::Logarithmic => &[0.301, 0.477, 0.602, 0.699, 0.778, 0.845, 0.903, 0.954],
        };
        let places = |part: f64| (0..=labels).map(move |i| (first + i as f64 + part) * step);
        Self {
            scale,
            low: first * step,
            high: last * step,
            labelled: places(0.0).collect(),
            between: fine
                .iter()
                .flat_map(|&part| places(part).take(labels))
                .collect(),
        }
    }
}

impl Ranged for Ticks {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (place - self.low) / (self.high - self.low);
        from + (share * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => self.between.clone(),
            false => self.labelled.clone(),
        }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Ticks {
    fn format(place: &f64) -> String {
        place.to_string()
    }

    fn format_ext(&self, place: &f64) -> String {
        self.scale.name(*place)
    }
}

/// 1, 2 or 5 times a power of ten, not below `least`.
fn round_step(least: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(least)));
    let digit = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|digit| digit * power >= least);
    digit.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> String {
        let plot = Plot {
            title: "Title <1>".to_owned(),
            x: Axis::new("across", Scale::Logarithmic),
            y: Axis::new("upwards", Scale::Linear),
            lines: [Style::Dotted, Style::Dashed]
                .map(|style| Line {
                    name: format!("{style:?}"),
                    colour: 0,
                    style,
                    points: points.clone(),
                })
                .into(),
        };
        plot.svg().unwrap()
    }

    #[test]
    fn a_plot_has_its_title_labels_and_lines() {
        let svg = plot(vec![(1.0, 0.1), (10.0, 0.7), (1000.0, 0.3)]);
        for word in [
            "Title &lt;1&gt;",
            "across",
            "upwards",
            "Dotted",
            "10³",
            "0.7",
        ] {
            assert!(svg.contains(word), "{svg}\nlacks {word}");
        }
        assert_eq!(svg.matches("<circle").count(), 3);
    }

    #[test]
    fn what_an_axis_cannot_show_is_left_out() {
        for points in [
            vec![],
            vec![(0.0, 1.0), (-1.0, f64::NAN)],
            vec![(5.0, 2.0)],
            vec![(1e-300, 1e300), (1e300, -1e300)],
            vec![(1.0, 1.0), (1.0 + f64::EPSILON, 1.0 + f64::EPSILON)],
        ] {
            let svg = plot(points.clone());
            assert!(svg.ends_with("</svg>\n"), "{points:?}");
            assert!(!svg.contains("NaN"), "{points:?}");
            assert!(svg.len() < 50_000, "{points:?}: {} bytes", svg.len());
        }
    }

    #[test]
    fn whole_numbers_are_labelled_by_whole_numbers() {
        for degree in [0, 1, 2, 7, 31, 128] {
            let places = [0.0, f64::from(degree)];
            let ticks = Ticks::new(Scale::Whole, places.into_iter());
            let labels: Vec<String> = ticks
                .labelled
                .iter()
                .map(|&x| ticks.format_ext(&x))
                .collect();
            assert!(
                labels.iter().all(|label| label.parse::<u32>().is_ok()),
                "{labels:?}"
            );
            assert!(ticks.between.is_empty() && labels.len() <= 10, "{labels:?}");
            assert!(ticks.low == 0.0 && ticks.high >= places[1], "{labels:?}");
        }
    }
}
