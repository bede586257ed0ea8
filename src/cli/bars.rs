//! Bars of parts, one below the other, as SVG.

use super::plot::{COLOURS, Scale, Ticks};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Pixels across, as a browser shows them.
const WIDTH: u32 = 760;
/// Pixels of one bar and the gap below it.
const ROW: u32 = 34;
/// Pixels to the left of the bars, for their names.
const NAMES: u32 = 92;

/// Bars that are made of the same parts.
#[derive(Clone, Debug)]
pub(super) struct Bars {
    /// Above everything.
    pub title: String,
    /// What a bar's length is, and its unit.
    pub label: String,
    /// What the parts are called.
    pub parts: Vec<String>,
    /// Each bar's name and the lengths of its parts.
    pub rows: Vec<(String, Vec<f64>)>,
}

impl Bars {
    /// The drawing.
    ///
    /// # Errors
    /// None that is known: a string takes everything.
    pub fn svg(&self) -> std::result::Result<String, Box<dyn std::error::Error>> {
        let rows = self.rows.len().max(1);
        let height = 120 + ROW * rows as u32;
        let lengths = self.rows.iter().map(|(_, parts)| parts.iter().sum::<f64>());
        // Room for the legend to the right of the longest.
        let longest = 1.25 * lengths.fold(0.0, f64::max);
        let x = Ticks::new(Scale::Linear, [0.0, longest].into_iter());
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .caption(&self.title, ("sans-serif", 17))
                .margin(14)
                .x_label_area_size(42)
                .y_label_area_size(NAMES)
                .build_cartesian_2d(x, -(rows as f64)..0.0)?;
            chart
                .configure_mesh()
                .disable_y_mesh()
                .y_labels(0)
                .bold_line_style(BLACK.mix(0.16))
                .light_line_style(BLACK.mix(0.05))
                .axis_style(BLACK.mix(0.5))
                .label_style(("sans-serif", 13))
                .axis_desc_style(("sans-serif", 14))
                .x_desc(&self.label)
                .draw()?;
            for (k, part) in self.parts.iter().enumerate() {
                let colour = COLOURS[k % COLOURS.len()].filled();
                let bars = self.rows.iter().enumerate().map(|(row, (_, parts))| {
                    let begin: f64 = parts[..k].iter().sum();
                    let top = -(row as f64);
                    let ends = [(begin, top - 0.14), (begin + parts[k], top - 0.86)];
                    Rectangle::new(ends, colour)
                });
                chart
                    .draw_series(bars)?
                    .label(part)
                    .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 14, y + 5)], colour));
            }
            let style = ("sans-serif", 13)
                .into_text_style(&area)
                .pos(Pos::new(HPos::Right, VPos::Center));
            for (row, (name, _)) in self.rows.iter().enumerate() {
                let (x, y) = chart.backend_coord(&(0.0, -(row as f64) - 0.5));
                area.draw(&Text::new(name.as_str(), (x - 8, y), style.clone()))?;
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::LowerRight)
                .label_font(("sans-serif", 13))
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.2))
                .draw()?;
            area.present()?;
        }
        Ok(svg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_each_bar_is_drawn() {
        let bars = Bars {
            title: "Time <1>".to_owned(),
            label: "ns".to_owned(),
            parts: vec!["one".to_owned(), "two".to_owned()],
            rows: vec![
                ("box".to_owned(), vec![1.0, 2.0]),
                ("sky".to_owned(), vec![3.0, 0.5]),
            ],
        };
        let svg = bars.svg().unwrap();
        for word in ["Time &lt;1&gt;", "ns", "one", "two", "box", "sky"] {
            assert!(svg.contains(word), "{svg}\nlacks {word}");
        }
        let drawn = |colour: &RGBColor| {
            let RGBColor(r, g, b) = *colour;
            svg.matches(&format!("#{r:02X}{g:02X}{b:02X}")).count()
        };
        // A bar each, and the legend.
        assert_eq!([drawn(&COLOURS[0]), drawn(&COLOURS[1])], [3, 3]);
    }
}
