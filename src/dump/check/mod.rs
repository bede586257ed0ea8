//! A port's dump against one of ours: the first difference that is beyond its budget, and a count of all.
//!
//! Queues are compared in the order in which they are filled, fields in theirs, records by path. A path whose record says
//! that it met or chose something else (it is missing from a queue, is in another one, an id differs, a place is another
//! place) has *parted*: what follows on it is no error of its own, and is left out. A port may have some such paths; what
//! the others hold must be within the [budgets](super::budget).

mod load;
mod ulp;

use super::budget::{self, Budget, Measure, PARTED};
use super::manifest::{Manifest, Queue};
use crate::error::{Error, Result};
use load::{Ours, Records, Theirs};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What a comparison comes to.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Whether all that was compared is within the budgets.
    pub within: bool,
    /// Whether it is the same to the last bit.
    pub bit_equal: bool,
    /// The first that is beyond its budget.
    pub first: Option<Difference>,
    /// Paths that met or chose something else.
    pub parted: Parted,
    /// Every array of which something was compared.
    pub arrays: Vec<Compared>,
    /// What was not compared, and why.
    pub not_compared: Vec<String>,
}

/// A difference of one record.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// Path edge, from 1; 0 for what belongs to none.
    pub edge: u32,
    /// The stage that made it.
    pub stage: String,
    /// The queue.
    pub queue: String,
    /// The field; none where the record itself is missing, or there is one too many.
    pub field: Option<String>,
    /// The path's number, or of the film the record's.
    pub path: usize,
    /// Column and row of its pixel.
    pub pixel: [u32; 2],
    /// Its sample; none for what belongs to all.
    pub sample: Option<u32>,
    /// Our value.
    pub ours: String,
    /// The port's.
    pub theirs: String,
    /// How far apart they are; none for whole numbers.
    pub ulp: Option<f64>,
    /// How far apart they may be.
    pub budget_ulp: f64,
}

/// Paths that met or chose something else.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Parted {
    /// How many.
    pub paths: usize,
    /// How many there may be.
    pub allowed: usize,
    /// The first of them.
    pub first: Option<Difference>,
}

/// An array against the port's.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Path edge, from 1; 0 for what belongs to none.
    pub edge: u32,
    /// The stage that made it.
    pub stage: String,
    /// The queue.
    pub queue: String,
    /// The field.
    pub field: String,
    /// Records that were compared.
    pub records: usize,
    /// Those that differ in any bit.
    pub different: usize,
    /// Those that are beyond the budget.
    pub beyond: usize,
    /// The largest difference of a path that had not parted.
    pub worst_ulp: f64,
    /// How large it may be.
    pub budget_ulp: f64,
}

/// Compares the dump at `ours` with a port's at `theirs`, which may lack arrays, and the manifest.
///
/// # Errors
/// [`Error::Read`] and [`Error::Format`] for a folder that is no dump, or is damaged; [`Error::Usage`] where scene, settings
/// or paths are not the same.
pub fn check(ours: &Path, theirs: &Path) -> Result<Verdict> {
    let ours = Ours::open(ours)?;
    let theirs = Theirs::open(theirs, ours.manifest.paths)?;
    let mut not_compared = theirs.unlike(&ours)?;
    let mut comparison = Comparison::new(&ours.manifest);
    for queue in &ours.manifest.queues {
        let mine = ours.records(queue)?;
        match theirs.records(queue, &mine)? {
            Some(other) => comparison.compare(queue, &mine, &other, &mut not_compared),
            None if queue.records > 0 => {
                not_compared.push(format!(
                    "{}: {} has none",
                    queue.folder,
                    theirs.root.display()
                ));
            }
            None => {}
        }
    }
    if comparison.arrays.is_empty() {
        return Err(Error::format(
            &theirs.root,
            "holds no array that the dump has; give the folder that holds the port's edge01",
        ));
    }
    Ok(comparison.verdict(not_compared))
}

/// What was found so far.
struct Comparison<'a> {
    manifest: &'a Manifest,
    first: Option<Difference>,
    parted: BTreeSet<usize>,
    first_parted: Option<Difference>,
    arrays: Vec<Compared>,
}

impl<'a> Comparison<'a> {
    fn new(manifest: &'a Manifest) -> Self {
        Self {
            manifest,
            first: None,
            parted: BTreeSet::new(),
            first_parted: None,
            arrays: Vec::new(),
        }
    }

    fn compare(
        &mut self,
        queue: &Queue,
        ours: &Records,
        theirs: &Records,
        not_compared: &mut Vec<String>,
    ) {
        // Only afterwards: all fields of a record are looked at.
        let mut parted: BTreeMap<usize, Difference> = BTreeMap::new();
        {
            for (rows, others, missing) in [(ours, theirs, true), (theirs, ours, false)] {
                for &path in rows
                    .rows
                    .keys()
                    .filter(|path| !others.rows.contains_key(path))
                {
                    if self.follows(queue, path) {
                        let found = |there| if there { "a record" } else { "none" }.to_owned();
                        let words = (found(missing), found(!missing));
                        let difference = self.difference(queue, None, path, words, (None, 0.0));
                        parted.entry(path).or_insert(difference);
                    }
                }
            }
        }
        for field in &queue.fields {
            let (Some(mine), Some(other)) = (ours.array(&field.field), theirs.array(&field.field))
            else {
                not_compared.push(format!("{}: the port has none", field.file));
                continue;
            };
            let budget = budget::of(&field.field, 1).unwrap_or(Budget {
                measure: Measure::Same,
                ulp: 0.0,
            });
            let allowed = field.budget_ulp;
            let mut compared = Compared {
                edge: queue.edge,
                stage: queue.stage.clone(),
                queue: queue.queue.clone(),
                field: field.field.clone(),
                records: 0,
                different: 0,
                beyond: 0,
                worst_ulp: 0.0,
                budget_ulp: allowed,
            };
            for (&path, &row) in &ours.rows {
                let Some(&other_row) = theirs.rows.get(&path) else {
                    continue;
                };
                if !self.follows(queue, path) {
                    continue;
                }
                compared.records += 1;
                let apart = ulp::apart(mine, row, other, other_row);
                if apart.same_bits {
                    continue;
                }
                compared.different += 1;
                let parts = match budget.measure {
                    Measure::Choice => true,
                    Measure::Place => apart.ulp > PARTED,
                    Measure::Same | Measure::Value => false,
                };
                let describe = || {
                    let words = (ulp::shown(mine, row), ulp::shown(other, other_row));
                    let ulps = (budget.measure == Measure::Value
                        || budget.measure == Measure::Place)
                        .then_some(apart.ulp);
                    self.difference(queue, Some(&field.field), path, words, (ulps, allowed))
                };
                if parts {
                    parted.entry(path).or_insert_with(describe);
                } else if !parted.contains_key(&path) {
                    compared.worst_ulp = compared.worst_ulp.max(apart.ulp);
                    if apart.ulp > allowed {
                        compared.beyond += 1;
                        if self.first.is_none() {
                            self.first = Some(describe());
                        }
                    }
                }
            }
            self.arrays.push(compared);
        }
        if let Some((_, difference)) = parted.first_key_value() {
            self.first_parted.get_or_insert(difference.clone());
        }
        self.parted.extend(parted.into_keys());
    }

    /// Whether a record belongs to paths that have not parted.
    fn follows(&self, queue: &Queue, record: usize) -> bool {
        let samples = self.samples();
        let of_pixel = |pixel: usize| pixel * samples..(pixel + 1) * samples;
        let paths = match (queue.stage.as_str(), queue.queue.as_str()) {
            ("film", "pixels") => of_pixel(record),
            ("film", "blocks") => of_pixel(record * self.pixels() / queue.records.max(1)),
            _ => record..record + 1,
        };
        self.parted.range(paths).next().is_none()
    }

    fn samples(&self) -> usize {
        let [first, end] = self.manifest.samples;
        end.saturating_sub(first) as usize
    }

    fn pixels(&self) -> usize {
        let [x0, y0, x1, y1] = self.manifest.tile;
        x1.saturating_sub(x0) as usize * y1.saturating_sub(y0) as usize
    }

    fn difference(
        &self,
        queue: &Queue,
        field: Option<&str>,
        record: usize,
        (ours, theirs): (String, String),
        (ulp, budget_ulp): (Option<f64>, f64),
    ) -> Difference {
        let [x0, y0, x1, _] = self.manifest.tile;
        let width = x1.saturating_sub(x0).max(1) as usize;
        let (pixel, sample) = match (queue.stage.as_str(), queue.queue.as_str()) {
            ("film", "pixels") => (record, None),
            ("film", "blocks") => (record * self.pixels() / queue.records.max(1), None),
            _ => {
                let samples = self.samples().max(1);
                let sample = self.manifest.samples[0].saturating_add((record % samples) as u32);
                (record / samples, Some(sample))
            }
        };
        Difference {
            edge: queue.edge,
            stage: queue.stage.clone(),
            queue: queue.queue.clone(),
            field: field.map(str::to_owned),
            path: record,
            pixel: [
                x0.saturating_add((pixel % width) as u32),
                y0.saturating_add((pixel / width) as u32),
            ],
            sample,
            ours,
            theirs,
            ulp,
            budget_ulp,
        }
    }

    fn verdict(self, not_compared: Vec<String>) -> Verdict {
        let allowed = self
            .manifest
            .paths
            .div_ceil(self.manifest.paths_per_parting.max(1));
        let too_many = self.parted.len() > allowed;
        let first = match too_many {
            // Whichever comes first: the order of edges is that of time, but both were kept in the order of queues.
            true => earlier(self.first, self.first_parted.clone(), self.manifest),
            false => self.first,
        };
        Verdict {
            within: first.is_none(),
            bit_equal: self.parted.is_empty()
                && self.arrays.iter().all(|array| array.different == 0),
            first,
            parted: Parted {
                paths: self.parted.len(),
                allowed,
                first: self.first_parted,
            },
            arrays: self.arrays,
            not_compared,
        }
    }
}

/// The one of the earlier queue.
fn earlier(
    a: Option<Difference>,
    b: Option<Difference>,
    manifest: &Manifest,
) -> Option<Difference> {
    let place = |difference: &Difference| {
        manifest.queues.iter().position(|queue| {
            (queue.edge, &queue.stage, &queue.queue)
                == (difference.edge, &difference.stage, &difference.queue)
        })
    };
    match (a, b) {
        (Some(a), Some(b)) => Some(if place(&b) < place(&a) { b } else { a }),
        (a, b) => a.or(b),
    }
}
