//! What became faster or slower since another run.

use super::Plan;
use super::report::{Report, VERSION};
use super::series::Series;
use crate::error::{Error, Result};
use std::path::Path;

/// Probability that one figure is marked though nothing changed within a run; between runs see [`NOISE`].
const ALPHA: f64 = 1e-3;

/// Two runs on a quiet machine agree this far, relative: what is closer is not marked.
pub const NOISE: f64 = 0.03;

/// What a figure did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// No more than noise.
    Same,
    /// Takes less time.
    Faster,
    /// Takes more time.
    Slower,
}

/// One figure of both runs.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What was measured.
    pub name: String,
    /// Median seconds of the old run and of the new one.
    pub seconds: [f64; 2],
    /// New over old.
    pub ratio: f64,
    /// Probability of such ranks where nothing changed.
    pub p: f64,
    /// What to make of it.
    pub change: Change,
}

/// Reads the report of another run.
///
/// # Errors
/// [`Error::Read`], and [`Error::Format`] where it is none, or of other work.
pub fn read(path: &Path) -> Result<Report> {
    let text = std::fs::read_to_string(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    let wrong = |what: String| Error::format(path, what);
    let remedy = "give a file that `ondine bench --json` wrote";
    // First of all: a later version may have other fields.
    let value: serde_json::Value = serde_json::from_str(&text)
        .map_err(|error| wrong(format!("is no JSON ({error}); {remedy}")))?;
    match value.get("version").and_then(serde_json::Value::as_u64) {
        Some(version) if version == u64::from(VERSION) => {}
        Some(version) => {
            return Err(wrong(format!(
                "is of version {version} of the suite, and this program has version {VERSION}: their work differs; run \
                 the suite again with that program and this one's"
            )));
        }
        None => return Err(wrong(format!("is no report of a suite; {remedy}"))),
    }
    serde_json::from_value(value).map_err(|error| wrong(format!("is damaged ({error}); {remedy}")))
}

/// Fewer measurements than these have no ranks that would be seldom by chance.
const FEWEST: usize = 8;

/// How much faster the machine itself was in the new run than in the old, by what it read from its first caches: 1 where
/// nothing changed, and of another machine, whose speed is what is asked for.
pub fn pace(old: &Report, new: &Report) -> f64 {
    match [old, new].map(|report| report.pace_gbytes.median()) {
        [then, now] if then > 0.0 && now > 0.0 && !old.machine.differs(&new.machine) => now / then,
        _ => 1.0,
    }
}

/// Whether a run of this plan can be held against an earlier report.
///
/// # Errors
/// [`Error::Usage`] where they do not do the same work (other suites, other numbers of threads, no scene in common), or too seldom.
pub fn check(old: &Report, plan: &Plan) -> Result<()> {
    let differ = |what: &str, [old, new]: [String; 2]| {
        Err(Error::Usage(format!(
            "the old report has {what} {}, and this run {new}: only equal work can be compared",
            old.escape_debug()
        )))
    };
    let suite = plan.suite.to_string();
    if old.suite != suite {
        return differ("the suite", [old.suite.clone(), suite]);
    }
    let threads = plan.threads.last().copied().unwrap_or(1);
    if old.threads != threads {
        return differ(
            "a number of threads of",
            [old.threads, threads].map(|n| n.to_string()),
        );
    }
    let has = |name: &str| plan.cases.iter().any(|case| case.name == name);
    if !old.cases.iter().any(|case| has(&case.name)) {
        return differ(
            "other scenes",
            ["alone", "has none of them"].map(str::to_owned),
        );
    }
    let repeats = old.repeats.min(plan.repeats);
    if repeats < FEWEST {
        return Err(Error::Usage(format!(
            "with {repeats} measurements of a thing nothing can be told from chance; --compare needs --repeat {FEWEST} or more \
             in both runs"
        )));
    }
    Ok(())
}

/// Compares what both runs measured. By as much as the machine itself was faster or slower, the program may have been, too.
pub fn compare(old: &Report, new: &Report, noise: f64) -> Vec<Figure> {
    let pace = pace(old, new);
    let allowed = Allowed {
        slower: (1.0 + noise) * (1.0 / pace).max(1.0),
        faster: 1.0 / ((1.0 + noise) * pace.max(1.0)),
    };
    let before = old.figures();
    let figures = new.figures().into_iter().filter_map(|(name, now)| {
        let (_, then) = before.iter().find(|(other, _)| *other == name)?;
        Some(figure(name, then, now, &allowed))
    });
    figures.collect()
}

/// Ratios of times, new over old, that are no change.
struct Allowed {
    /// The greatest.
    slower: f64,
    /// The least.
    faster: f64,
}

fn figure(name: String, then: &Series, now: &Series, allowed: &Allowed) -> Figure {
    let seconds = [then.median(), now.median()];
    let ratio = seconds[1] / seconds[0];
    let p = then.same(now);
    let change = match p < ALPHA {
        true if ratio > allowed.slower => Change::Slower,
        true if ratio < allowed.faster => Change::Faster,
        _ => Change::Same,
    };
    Figure {
        name,
        seconds,
        ratio,
        p,
        change,
    }
}
