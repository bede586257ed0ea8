//! `ondine sh lobe`: the coefficients of Phong lobes, exact and estimated.

use super::super::Outcome;
use super::super::args::{choice, threads, whole, within};
use super::super::outputs;
use super::super::plot::{Axis, Line, MOST_LINES, Plot, Scale, Style};
use super::bands;
use super::draws::{Convention, Draws, Sampling};
use super::printed::{ALL, WHY};
use crate::error::{Error, Result};
use crate::render::{all_processors, workers};
use crate::sh::lobe::{Sums, phong};
use clap::Args;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  ondine sh lobe --exponent 1,5,10,50 --bands 6
  ondine sh lobe --exponent 5 --bands 6 --estimate 10000000 --sampling all -o convergence.svg
  ondine sh lobe --exponent 1,5,10,50 --bands 6 --convention report

The lobe (n + 1)/2 max(cos, 0)^n around z has coefficients of order 0 alone; n = 1 is the clamped cosine. Estimates come with \
their standard error, and z, the error in standard errors; those of different exponents, samplings and sizes are \
independent. Threads do not change a bit of them.";

/// Give the coefficients of Phong lobes, exact and estimated
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct LobeArgs {
    /// Exponents n, numbers from 0 to 1e6
    #[arg(long, value_name = "LIST", value_delimiter = ',', required = true,
          allow_hyphen_values = true, value_parser = exponent)]
    pub exponent: Vec<f64>,
    /// Greatest degree L
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = bands)]
    pub bands: usize,
    /// Estimate them too, from about this many samples
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = samples)]
    pub estimate: Option<u32>,
    /// How directions are drawn: a list of uniform, stratified and cosine-power, or all
    #[arg(long, value_name = "LIST", default_value = "all", value_parser = samplings)]
    pub sampling: Samplings,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub seed: u64,
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// What is integrated: the lobe, or what a report of 2014 took for it, beside the values it prints
    #[arg(long, default_value = "orthonormal", value_parser = choice::<Convention>(&["orthonormal", "report"]))]
    pub convention: Convention,
    /// Plot the coefficients, or with --estimate how the estimates converge, as SVG
    #[arg(short, long, value_name = "PLOT.svg")]
    pub output: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
}

/// Some ways of sampling, each once.
#[derive(Clone, Debug)]
pub(in crate::cli) struct Samplings(Vec<Sampling>);

fn exponent(text: &str) -> std::result::Result<f64, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|n| (0.0..=1e6).contains(n))
        .ok_or_else(|| "an exponent is a number from 0 to 1e6".to_owned())
}

fn samples(text: &str) -> std::result::Result<u32, String> {
    within(text, 16, u32::MAX as usize).map(|samples| samples as u32)
}

fn samplings(text: &str) -> std::result::Result<Samplings, String> {
    let all = Sampling::NAMES.iter().map(|(_, sampling)| *sampling);
    if text == "all" {
        return Ok(Samplings(all.collect()));
    }
    let asked = text
        .split(',')
        .map(|name| {
            name.trim()
                .parse()
                .map_err(|error: crate::error::Error| error.to_string())
        })
        .collect::<std::result::Result<Vec<Sampling>, String>>()?;
    Ok(Samplings(
        all.filter(|sampling| asked.contains(sampling)).collect(),
    ))
}

/// What was found.
#[derive(Debug, Serialize)]
struct LobeReport {
    convention: String,
    integrand: &'static str,
    l_max: usize,
    seed: u64,
    lobes: Vec<Lobe>,
    #[serde(skip_serializing_if = "Option::is_none")]
    why_the_report_differs: Option<&'static str>,
}

/// One exponent.
#[derive(Debug, Serialize)]
struct Lobe {
    exponent: f64,
    /// By degree.
    exact: Vec<f64>,
    /// Of the lobe itself, where something else is integrated.
    #[serde(skip_serializing_if = "Option::is_none")]
    lobe: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    printed: Vec<Table>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    estimates: Vec<Estimated>,
}

/// What the report prints of it; null where it prints nothing.
#[derive(Debug, Serialize)]
struct Table {
    name: &'static str,
    values: Vec<Option<f64>>,
}

/// An estimate, by degree.
#[derive(Clone, Debug, Serialize)]
struct Estimated {
    sampling: String,
    samples: u64,
    values: Vec<f64>,
    standard_errors: Vec<f64>,
    /// Null where the estimate has no variance.
    z: Vec<Option<f64>>,
}

pub(super) fn run(args: &LobeArgs) -> Result<Outcome> {
    if let Some(path) = &args.output {
        outputs::plot(path)?;
        // Of estimates, lines are by sampling.
        if args.estimate.is_none() && args.exponent.len() > MOST_LINES {
            return Err(Error::Usage(format!(
                "-o {}: {} lines cannot be told apart; plot at most {MOST_LINES} exponents at a time",
                path.display(),
                args.exponent.len()
            )));
        }
    }
    let pool = workers(args.threads.unwrap_or_else(all_processors))?;
    let estimate = |exponent, exact: &[f64], sampling, samples| {
        let draws = Draws {
            seed: args.seed,
            sampling,
            convention: args.convention,
            exponent,
        };
        let sums = pool.install(|| draws.sums(samples, args.bands));
        Estimated::new(sampling, &sums, exact)
    };
    let lobes = args.exponent.iter().map(|&exponent| {
        let exact = exact(args.convention, exponent, args.bands);
        let each = |samples| {
            let samplings = args.sampling.0.iter();
            samplings.map(move |&sampling| (sampling, samples))
        };
        Lobe {
            exponent,
            estimates: args
                .estimate
                .into_iter()
                .flat_map(each)
                .map(|(sampling, samples)| estimate(exponent, &exact, sampling, samples))
                .collect(),
            lobe: (args.convention == Convention::Report).then(|| phong(exponent, args.bands)),
            printed: match args.convention {
                Convention::Orthonormal => Vec::new(),
                Convention::Report => printed(exponent, args.bands),
            },
            exact,
        }
    });
    let report = LobeReport {
        convention: args.convention.to_string(),
        integrand: match args.convention {
            Convention::Orthonormal => "(n + 1)/2 max(cos, 0)^n Y_l0",
            Convention::Report => "sqrt(2) (n + 1)/2 |cos|^n Y_l0",
        },
        l_max: args.bands,
        seed: args.seed,
        lobes: lobes.collect(),
        why_the_report_differs: (args.convention == Convention::Report).then_some(WHY),
    };
    if let Some(path) = &args.output {
        match args.estimate {
            None => report.spectrum().write(path)?,
            Some(samples) => report
                .convergence(&args.sampling, samples, estimate)
                .write(path)?,
        }
    }
    match args.json {
        true => super::super::print_json(&report)?,
        false => super::super::print(&report.text())?,
    }
    Ok(Outcome::Done)
}

/// The closed form of what is integrated.
fn exact(convention: Convention, exponent: f64, degree: usize) -> Vec<f64> {
    let mut values = phong(exponent, degree);
    if convention == Convention::Report {
        // |cos|ⁿ: both halves add up for even degrees, and cancel for odd ones.
        for (l, value) in values.iter_mut().enumerate() {
            *value *= if l % 2 == 0 {
                2.0 * std::f64::consts::SQRT_2
            } else {
                0.0
            };
        }
    }
    values
}

fn printed(exponent: f64, degree: usize) -> Vec<Table> {
    ALL.iter()
        .filter(|table| table.exponent == exponent)
        .map(|table| Table {
            name: table.name,
            values: (0..=degree)
                .map(|l| {
                    table
                        .values
                        .iter()
                        .find(|(at, _)| *at == l)
                        .map(|(_, value)| *value)
                })
                .collect(),
        })
        .collect()
}

impl Estimated {
    fn new(sampling: Sampling, sums: &Sums, exact: &[f64]) -> Self {
        let estimates = sums.estimates();
        Self {
            sampling: sampling.to_string(),
            samples: sums.samples(),
            values: estimates.iter().map(|estimate| estimate.value).collect(),
            standard_errors: estimates
                .iter()
                .map(|estimate| estimate.standard_error)
                .collect(),
            z: estimates
                .iter()
                .zip(exact)
                .map(|(estimate, exact)| estimate.z(*exact))
                .collect(),
        }
    }
}

impl LobeReport {
    /// Error and standard error of all coefficients together (root of the sum of squares, which is the error of the lobe as a
    /// function), root mean square over the lobes, against the number of samples: four times as many each time, up to the
    /// estimates that are there.
    fn convergence(
        &self,
        samplings: &Samplings,
        samples: u32,
        estimate: impl Fn(f64, &[f64], Sampling, u32) -> Estimated,
    ) -> Plot {
        let fewer = std::iter::successors(Some(samples / 4), |n| Some(n / 4));
        let mut fewer: Vec<u32> = fewer.take_while(|n| *n >= 64).collect();
        fewer.reverse();
        let mut lines = Vec::new();
        for (index, &sampling) in samplings.0.iter().enumerate() {
            let [mut errors, mut expected] = [Vec::new(), Vec::new()];
            let mut add = |estimates: &[Estimated]| {
                let [mut error, mut variance, mut taken] = [0.0; 3];
                for (estimate, lobe) in estimates.iter().zip(&self.lobes) {
                    let values = estimate.values.iter().zip(&lobe.exact);
                    error += values
                        .map(|(value, exact)| (value - exact).powi(2))
                        .sum::<f64>();
                    let errors = estimate.standard_errors.iter();
                    variance += errors.map(|error| error.powi(2)).sum::<f64>();
                    taken = estimate.samples as f64;
                }
                let lobes = self.lobes.len() as f64;
                errors.push((taken, (error / lobes).sqrt()));
                expected.push((taken, (variance / lobes).sqrt()));
            };
            for &samples in &fewer {
                let lobes = self.lobes.iter();
                let made =
                    lobes.map(|lobe| estimate(lobe.exponent, &lobe.exact, sampling, samples));
                add(&made.collect::<Vec<_>>());
            }
            let made = self
                .lobes
                .iter()
                .filter_map(|lobe| lobe.estimates.get(index));
            add(&made.cloned().collect::<Vec<_>>());
            let line = |name, style, points| Line {
                name: format!("{sampling}: {name}"),
                colour: index,
                style,
                points,
            };
            lines.push(line("error", Style::Dotted, errors));
            lines.push(line("standard error", Style::Dashed, expected));
        }
        let exponents: Vec<String> = self
            .lobes
            .iter()
            .map(|lobe| lobe.exponent.to_string())
            .collect();
        let lobes = match exponents.len() {
            0..=MOST_LINES => format!("Phong lobe, exponent {}", exponents.join(", ")),
            count => format!("{count} Phong lobes"),
        };
        Plot {
            title: format!("{lobes}: coefficients to degree {}", self.l_max),
            x: Axis::new("samples", Scale::Logarithmic),
            y: Axis::new("error of the coefficients", Scale::Logarithmic),
            lines,
        }
    }

    /// The exact coefficients against the degree.
    fn spectrum(&self) -> Plot {
        let line = |(colour, lobe): (usize, &Lobe)| Line {
            name: format!("n = {}", lobe.exponent),
            colour,
            style: Style::Dotted,
            points: lobe
                .exact
                .iter()
                .enumerate()
                .map(|(l, value)| (l as f64, *value))
                .collect(),
        };
        Plot {
            title: format!("Integrals of {}", self.integrand),
            x: Axis::new("degree l", Scale::Linear),
            y: Axis::new("coefficient", Scale::Linear),
            lines: self.lobes.iter().enumerate().map(line).collect(),
        }
    }

    /// For people.
    fn text(&self) -> String {
        let mut text = format!("Integrals of {} over the sphere\n", self.integrand);
        for lobe in &self.lobes {
            let exponent = lobe.exponent;
            let _ = write!(text, "\nn = {exponent}\n{:>26}", "l");
            (0..=self.l_max).for_each(|l| _ = write!(text, " {l:>10}"));
            row(
                &mut text,
                "exact",
                lobe.exact.iter().map(|value| Some(*value)),
            );
            for printed in &lobe.printed {
                row(
                    &mut text,
                    &format!("printed, {}", printed.name),
                    printed.values.iter().copied(),
                );
            }
            if let Some(values) = &lobe.lobe {
                row(
                    &mut text,
                    "of max(cos, 0)^n",
                    values.iter().map(|value| Some(*value)),
                );
            }
            for estimated in &lobe.estimates {
                let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
                row(&mut text, &estimated.sampling, some(&estimated.values));
                row(
                    &mut text,
                    "standard error",
                    some(&estimated.standard_errors),
                );
                row(&mut text, "z", estimated.z.iter().copied());
            }
            text.push('\n');
        }
        if let Some(why) = self.why_the_report_differs {
            let _ = writeln!(text, "\n{why}");
        }
        text
    }
}

/// A line of a table; a dot where there is nothing.
fn row(text: &mut String, name: &str, values: impl IntoIterator<Item = Option<f64>>) {
    let _ = write!(text, "\n  {name:<24}");
    for value in values {
        let _ = match value {
            None => write!(text, " {:>10}", "."),
            Some(0.0) => write!(text, " {:>10}", "0"),
            Some(value) if value.abs() < 1e-3 => write!(text, " {value:>10.2e}"),
            Some(value) => write!(text, " {value:>10.6}"),
        };
    }
}
