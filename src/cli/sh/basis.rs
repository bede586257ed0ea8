//! `ondine sh basis`: the basis in given directions, and how fast it is evaluated.

use super::super::Outcome;
use super::super::args::{repeats, threads};
use super::bands;
use crate::error::Result;
use clap::Args;
use std::path::PathBuf;

/// Evaluate the basis in given directions, and measure how fast
#[derive(Args, Debug)]
pub(in crate::cli) struct BasisArgs {
    /// The directions: a NumPy file of shape [n, 3]
    pub directions: PathBuf,
    /// Greatest degree L: (L + 1)² values a direction
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = bands)]
    pub bands: usize,
    /// Write the values: a NumPy file of shape [n, (L + 1)²], 32-bit floats
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

pub(super) fn run(_args: &BasisArgs) -> Result<Outcome> {
    Ok(Outcome::Done)
}
