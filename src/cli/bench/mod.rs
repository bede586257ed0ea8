//! `ondine bench`: arguments to a plan, the run, and what is made of it.

mod html;
mod plots;
mod roofline;
mod text;

use super::args::{choice, repeats, threads};
use super::target::target_features;
use super::{Outcome, interrupt, memory, outputs};
use crate::bench::against::{self, Change, NOISE};
use crate::bench::{self, CASES, Case, Look, Plan, Report, Suite};
use crate::error::{Error, Result};
use crate::film::write_whole;
use crate::render::all_processors;
use crate::scene::toml::names;
use crate::wavefront;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  ondine bench                                             a minute, and a score
  ondine bench --suite full --json new.json --html new.html
  ondine bench --json today.json --compare yesterday.json  what is faster, what is slower
  ondine bench --threads 1,2,4,8,16
  ondine bench --export scenes                             the scenes, for other renderers

A score is printed only if every image is right: consistent with a stored reference by the
statistics of `ondine compare`, and of the same bits in all repeats.
Exit codes: 0 done, 1 an image is wrong or something became slower, 2 bad input, 130 interrupted.";

/// Measure this machine and this build: rates of fixed scenes, with proof that their images are right
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct BenchArgs {
    /// How much is measured: quick, or full (ten million triangles, more samples, all sizes of waves: 4 GB, ten minutes)
    #[arg(long, default_value = "quick", value_parser = choice::<Suite>(&["quick", "full"]))]
    suite: Suite,
    /// Only these scenes of the suite, by name; there is no score then
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = scene)]
    scenes: Vec<&'static Case>,
    /// Numbers of threads to measure scaling with; all else is measured on the greatest [default: 1, 2, 4 ... all]
    #[arg(long, value_name = "N,...", value_delimiter = ',', allow_negative_numbers = true, value_parser = threads)]
    threads: Vec<usize>,
    /// Times that everything is measured, after once to warm up; --compare needs 8 at least
    #[arg(long, value_name = "N", default_value_t = 9, allow_negative_numbers = true, value_parser = repeats)]
    repeat: usize,
    /// Leave out other numbers of threads and other sizes of waves
    #[arg(long)]
    no_scaling: bool,
    /// Write everything that was measured; - prints it instead of the tables
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Say what is faster and what is slower than in this report of an earlier run
    #[arg(long, value_name = "OLD.json")]
    compare: Option<PathBuf>,
    /// Percent that two runs may differ though nothing changed, beside what the machine itself was faster or slower
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0 * NOISE, allow_negative_numbers = true, value_parser = noise)]
    noise: f64,
    /// Write a page with plots: stages, bounces, scaling, roofline
    #[arg(long, value_name = "PAGE.html")]
    html: Option<PathBuf>,
    /// Measure nothing: write the scenes of the suite into this folder, as files that other renderers can be given
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["json", "compare", "html", "threads"])]
    export: Option<PathBuf>,
    /// Show no progress bar
    #[arg(short, long)]
    quiet: bool,
}

pub(super) fn run(args: &BenchArgs) -> Result<Outcome> {
    if let Some(folder) = &args.export {
        return export(&args.cases()?, folder);
    }
    let json = args.json.as_deref().filter(|path| *path != Path::new("-"));
    let old = args.compare.as_deref().map(against::read).transpose()?;
    let written: Vec<&Path> = json.into_iter().chain(args.html.as_deref()).collect();
    outputs::distinct(&written)?;
    for path in &written {
        let old = args.compare.iter().map(PathBuf::as_path);
        outputs::writable(path, &old.collect::<Vec<_>>())?;
    }
    let plan = Plan {
        suite: args.suite,
        cases: args.cases()?,
        scaling: !args.no_scaling,
        threads: numbers_of_threads(&args.threads),
        repeats: args.repeat,
        target_features: target_features(),
    };
    fits(&plan.cases)?;
    if let Some(old) = &old {
        against::check(old, &plan)?;
    }
    let Some(report) = measure(&plan, args.quiet)? else {
        super::say("interrupted: nothing was written");
        return Ok(Outcome::Interrupted);
    };
    if let Some(path) = json {
        let text = serde_json::to_string_pretty(&report)
            .map_err(|error| Error::Usage(format!("no JSON can be made: {error}")))?;
        write_whole(path, |file| writeln!(file, "{text}"))?;
    }
    let noise = args.noise / 100.0;
    let figures = old
        .as_ref()
        .map(|old| against::compare(old, &report, noise));
    if let Some(path) = &args.html {
        html::write(path, &report, figures.as_deref())?;
    }
    let compared = old.as_ref().zip(figures.as_ref());
    let compared = compared.map(|(old, figures)| text::against(old, &report, figures, args.noise));
    match json.is_none() && args.json.is_some() {
        true => {
            super::print_json(&report)?;
            compared.iter().for_each(super::say);
        }
        false => super::print(&(text::text(&report) + &compared.unwrap_or_default()))?,
    }
    let slower = |figure: &against::Figure| figure.change == Change::Slower;
    let is_slower = figures.is_some_and(|figures| figures.iter().any(slower));
    Ok(match report.is_wrong() || is_slower {
        true => Outcome::Differs,
        false => Outcome::Done,
    })
}

fn measure(plan: &Plan, quiet: bool) -> Result<Option<Report>> {
    /// Parts that the bar is told of.
    const PARTS: u64 = 1000;
    let bar = match quiet || !std::io::stderr().is_terminal() {
        true => ProgressBar::hidden(),
        false => ProgressBar::new(PARTS),
    };
    let style =
        ProgressStyle::with_template("{bar:30.cyan/blue} {percent:>3} %  {msg}  {eta} left");
    bar.set_style(
        style
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("━╸─"),
    );
    let progress = |what: &str, part: f64| {
        // Drawn here and at no other time: while something is measured nothing else runs.
        bar.set_message(what.to_owned());
        bar.set_position((part * PARTS as f64) as u64);
    };
    let look = Look {
        stop: interrupt::listen(),
        progress: &progress,
    };
    let report = bench::run(plan, &wavefront::trace, &look);
    bar.finish_and_clear();
    report
}

/// Ascending, each once; without any, powers of two up to all processors.
fn numbers_of_threads(asked: &[usize]) -> Vec<usize> {
    let all = all_processors();
    let mut numbers = match asked {
        [] => std::iter::successors(Some(1), |n| Some(2 * n))
            .take_while(|&n| n < all)
            .chain([all])
            .collect(),
        asked => asked.to_vec(),
    };
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Whether the scenes fit in memory, all at once.
///
/// # Errors
/// [`Error::Usage`] where they do not.
fn fits(cases: &[&Case]) -> Result<()> {
    /// Bytes of a triangle: mesh, tree, and what building the tree takes.
    const TRIANGLE: u64 = 250;
    let triangles: usize = cases.iter().map(|case| case.triangles()).sum();
    let needed = triangles as u64 * TRIANGLE;
    memory::check_bytes(
        needed,
        "the scenes of this suite",
        "choose --suite quick, or a larger machine",
    )
}

fn export(cases: &[&Case], folder: &Path) -> Result<Outcome> {
    std::fs::create_dir_all(folder).map_err(|source| Error::Write {
        path: folder.to_owned(),
        source,
    })?;
    for case in cases {
        case.export(folder)?;
        let (name, title) = (case.name, case.title);
        super::print(&format!(
            "{}: {title}\n",
            folder.join(format!("{name}.toml")).display()
        ))?;
    }
    Ok(Outcome::Done)
}

impl BenchArgs {
    /// The scenes that are asked for, in the order of reports.
    ///
    /// # Errors
    /// [`Error::Usage`] for one that the suite does not have.
    fn cases(&self) -> Result<Vec<&'static Case>> {
        if let Some(other) = self.scenes.iter().find(|case| !self.suite.has(case)) {
            return Err(Error::Usage(format!(
                "the scene {} is not in the suite {}; add --suite full",
                other.name, self.suite
            )));
        }
        let asked = |case: &&Case| {
            self.scenes.is_empty() || self.scenes.iter().any(|named| named.name == case.name)
        };
        Ok(self.suite.cases().filter(asked).collect())
    }
}

fn scene(text: &str) -> std::result::Result<&'static Case, String> {
    CASES.iter().find(|case| case.name == text).ok_or_else(|| {
        let names = CASES.iter().map(|case| case.name);
        let hint = names::did_you_mean(text, names.clone());
        format!(
            "there is no such scene{hint} Scenes: {}",
            names::list(names)
        )
    })
}

fn noise(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|percent: &f64| (0.0..=100.0).contains(percent))
        .ok_or_else(|| "write a percentage from 0 to 100".to_owned())
}
