//! `ondine sh basis`: the basis in given directions, and how fast it is evaluated.

use super::super::Outcome;
use super::super::args::{repeats, threads};
use super::super::memory;
use super::super::outputs;
use super::super::progress::metric;
use super::super::report::counted;
use super::bands;
use crate::error::{Error, Result};
use crate::film::write_whole;
use crate::npy::{self, Array, Numbers};
use crate::render::{all_processors, workers};
use crate::sh::{Basis, coefficients};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  ondine sh basis directions.npy --bands 8 -o values.npy
  ondine sh basis directions.npy --bands 16 --threads 1 --json | jq .points_per_s

Value l*l + l + m of a row is that of degree l and order m: real, orthonormal, without the Condon-Shortley sign, so that \
values 1, 2 and 3 go with y, z and x. Time is that of evaluation alone. Threads do not change a bit of the values.";

/// How far from unit length a direction may be: what rounding of its components to 16 bits leaves.
const UNIT: f64 = 1e-3;

/// Evaluate the basis in given directions, and measure how fast
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct BasisArgs {
    /// The directions: a NumPy file of shape [n, 3], 32- or 64-bit floats, of unit length
    pub directions: PathBuf,
    /// Greatest degree L: (L + 1)^2 values a direction
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = bands)]
    pub bands: usize,
    /// Write the values: a NumPy file of shape [n, (L + 1)^2], 32-bit floats
    #[arg(short, long, value_name = "VALUES.npy")]
    pub output: Option<PathBuf>,
    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Measured runs, after one to warm up
    #[arg(long, value_name = "N", default_value_t = 7, allow_negative_numbers = true, value_parser = repeats)]
    pub repeat: usize,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// What it took.
#[derive(Debug, Serialize)]
struct BasisReport {
    directions: String,
    points: usize,
    l_max: usize,
    coefficients: usize,
    threads: usize,
    repeat: usize,
    points_per_s: f64,
    points_per_s_best: f64,
    points_per_s_worst: f64,
    output: Option<String>,
}

pub(super) fn run(args: &BasisArgs) -> Result<Outcome> {
    if let Some(path) = &args.output {
        outputs::writable(path, &[&args.directions])?;
    }
    let directions = read(&args.directions)?;
    let row = coefficients(args.bands);
    let values = directions.len().saturating_mul(row);
    memory::check_bytes(
        (values as u64).saturating_mul(size_of::<f32>() as u64),
        &format!("{values} values"),
        "give fewer directions or a smaller --bands",
    )?;
    let mut values = vec![0.0_f32; values];

    let threads = args.threads.unwrap_or_else(all_processors);
    let pool = workers(threads)?;
    let basis = Basis::new(args.bands);
    let time = |_| {
        let begin = Instant::now();
        basis.tabulate(&directions, &mut values);
        begin.elapsed().as_secs_f64()
    };
    let mut times: Vec<f64> = pool.install(|| (0..=args.repeat).map(time).collect());
    // The first was to warm up.
    times.remove(0);
    times.sort_by(f64::total_cmp);

    if let Some(path) = &args.output {
        let table = Array {
            shape: vec![directions.len(), row],
            numbers: Numbers::F32(values),
        };
        write_whole(path, |file| table.write(file))?;
    }
    let rate = |seconds: f64| directions.len() as f64 / seconds;
    let report = BasisReport {
        directions: args.directions.display().to_string(),
        points: directions.len(),
        l_max: args.bands,
        coefficients: row,
        threads,
        repeat: args.repeat,
        points_per_s: rate(times[times.len() / 2]),
        points_per_s_best: rate(times[0]),
        points_per_s_worst: rate(times[times.len() - 1]),
        output: args.output.as_ref().map(|path| path.display().to_string()),
    };
    match args.json {
        true => super::super::print_json(&report)?,
        false => super::super::print(&report.text())?,
    }
    Ok(Outcome::Done)
}

impl BasisReport {
    /// For people.
    fn text(&self) -> String {
        let mut text = format!(
            "{}, {} each (l_max {}): {}points/s with {} (median of {}; {} to {})\n",
            counted(self.points, "direction"),
            counted(self.coefficients, "value"),
            self.l_max,
            metric(self.points_per_s),
            counted(self.threads, "thread"),
            self.repeat,
            metric(self.points_per_s_worst).trim_end(),
            metric(self.points_per_s_best).trim_end(),
        );
        if let Some(output) = &self.output {
            text += &format!("written to {output}\n");
        }
        text
    }
}

/// The directions of a file; those that are nearly of unit length are made so.
fn read(path: &Path) -> Result<Vec<[f32; 3]>> {
    let mut directions = rows_of_three(path)?;
    if directions.is_empty() {
        return Err(Error::format(path, "holds no directions"));
    }
    for (row, direction) in directions.iter_mut().enumerate() {
        let length = libm::sqrt(direction.iter().map(|&c| f64::from(c) * f64::from(c)).sum());
        if !(1.0 - UNIT..=1.0 + UNIT).contains(&length) {
            return Err(Error::format(
                path,
                format!(
                    "row {row} (counted from 0) is {direction:?}, of length {length:.6}; give directions of length 1"
                ),
            ));
        }
        *direction = direction.map(|c| (f64::from(c) / length) as f32);
    }
    Ok(directions)
}

/// Rows of three numbers, in 32 or 64 bits; 64 are rounded to 32.
fn rows_of_three(path: &Path) -> Result<Vec<[f32; 3]>> {
    let remedy = "write it with numpy.save, as an array of shape [n, 3] and dtype float32";
    let array = npy::read(path, remedy)?;
    let three = array.shape.len() == 2 && array.shape[1] == 3;
    let numbers = match array.numbers {
        Numbers::F32(numbers) if three => numbers,
        Numbers::F64(numbers) if three => numbers.into_iter().map(|x| x as f32).collect(),
        _ => {
            let (dtype, sides) = (array.numbers.dtype(), array.sides());
            let what = format!("holds numbers of dtype {dtype} in shape {sides}");
            return Err(Error::format(path, format!("{what}; {remedy}")));
        }
    };
    Ok(numbers.as_chunks().0.to_vec())
}
