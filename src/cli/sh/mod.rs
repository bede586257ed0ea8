//! `ondine sh`: spherical harmonics.

mod basis;
mod compare;
mod comparison;
mod draws;
mod light;
mod lobe;
mod object;
mod printed;
mod probe;
mod project;
mod shade;

use super::Outcome;
use super::args::within;
use crate::error::Result;
use crate::sh::MAX_DEGREE;
use clap::Subcommand;

/// What can be done with spherical harmonics.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Evaluate the basis in given directions, and measure how fast
    Basis(basis::BasisArgs),
    /// Give the coefficients of Phong lobes, exact and estimated
    Lobe(lobe::LobeArgs),
    /// Project a lat-long image onto spherical harmonics
    Project(project::ProjectArgs),
    /// Shade an object by the double sum over light and lobe
    Shade(shade::ShadeArgs),
    /// Bake light probes: the light that arrives at points of a scene
    Probe(Box<probe::ProbeArgs>),
    /// Compare the double sum with rays: by degree, as a table, a plot and pictures
    Compare(compare::CompareArgs),
}

pub(super) fn run(command: &Command) -> Result<Outcome> {
    match command {
        Command::Basis(args) => basis::run(args),
        Command::Lobe(args) => lobe::run(args),
        Command::Project(args) => project::run(args),
        Command::Shade(args) => shade::run(args),
        Command::Probe(args) => probe::run(args),
        Command::Compare(args) => compare::run(args),
    }
}

/// The greatest degree, as `--bands` has it.
fn bands(text: &str) -> std::result::Result<usize, String> {
    within(text, 0, MAX_DEGREE)
}
