//! A port's dump against one of ours: the first difference that is beyond its budget, and a count of all.
//!
//! Queues are compared in the order in which they are filled, by path. A path *parts* from ours where it met or chose
//! something else (it is missing from a queue or is in another one, an id differs), or a value is beyond its
//! [`budget`]. What follows on it is no difference of its own, and is left out. A few paths of a right port part;
//! where more do than may, the queue and the field by which they became too many are named.

mod load;
mod ulp;

use super::budget::{self, Measure};
use super::manifest::{Field, Manifest, Queue};
use crate::error::{Error, Result};
use crate::npy::Array;
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
    /// The first that may not be.
    pub first: Option<Difference>,
    /// Paths that parted from ours.
    pub parted: Parted,
    /// Every array of which something was compared.
    pub arrays: Vec<Compared>,
    /// How many of our arrays were not compared.
    pub missing: usize,
    /// What was not compared, and why.
    pub not_compared: Vec<String>,
}

/// A difference of one record.
#[derive(Clone, Debug, PartialEq, Serialize)]
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

/// Paths that parted from ours.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Parted {
    /// How many.
    pub paths: usize,
    /// How many of them met or chose something else.
    pub by_choice: usize,
    /// How many there may be: none of fewer than [`Manifest::paths_per_parting`].
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
    /// Those that are beyond the budget, or are something else.
    pub beyond: usize,
    /// The largest difference within the budget.
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
                comparison.missing += queue.fields.len();
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
    let beyond = theirs.beyond(&ours.manifest).into_iter();
    not_compared.extend(beyond.map(|folder| format!("{folder}: the dump has no records there")));
    let mut verdict = comparison.verdict(not_compared);
    for difference in verdict.first.iter_mut().chain(&mut verdict.parted.first) {
        elsewhere(difference, &ours, &theirs)?;
    }
    Ok(verdict)
}

/// Where a record is missing: which queue of the stage has the path instead.
fn elsewhere(difference: &mut Difference, ours: &Ours, theirs: &Theirs) -> Result<()> {
    if difference.field.is_some() {
        return Ok(());
    }
    let of_stage = |queue: &&Queue| {
        (queue.edge, &queue.stage) == (difference.edge, &difference.stage)
            && queue.queue != difference.queue
    };
    for queue in ours.manifest.queues.iter().filter(of_stage) {
        let mine = ours.records(queue)?;
        let other = theirs.records(queue, &mine)?;
        let has = |records: &Records| records.rows.contains_key(&difference.path);
        let instead = format!("one in {}", queue.queue);
        if difference.ours == NO_RECORD && has(&mine) {
            difference.ours = instead;
        } else if difference.theirs == NO_RECORD && other.is_some_and(|other| has(&other)) {
            difference.theirs = instead;
        }
    }
    Ok(())
}

/// In place of a value, where there is none.
const NO_RECORD: &str = "no record";

/// What was found so far.
struct Comparison<'a> {
    manifest: &'a Manifest,
    pixels: usize,
    samples: usize,
    /// How many paths may part.
    allowed: usize,
    parted: BTreeSet<usize>,
    by_choice: usize,
    first_parted: Option<Difference>,
    first: Option<Difference>,
    arrays: Vec<Compared>,
    /// Arrays of ours that were not compared.
    missing: usize,
}

impl<'a> Comparison<'a> {
    fn new(manifest: &'a Manifest) -> Self {
        // Checked when it was read.
        let (pixels, samples) = manifest.pixels_and_samples().unwrap_or((1, 1));
        Self {
            manifest,
            pixels,
            samples,
            allowed: manifest.paths / manifest.paths_per_parting.max(1),
            parted: BTreeSet::new(),
            by_choice: 0,
            first_parted: None,
            first: None,
            arrays: Vec::new(),
            missing: 0,
        }
    }

    fn compare(
        &mut self,
        queue: &Queue,
        ours: &Records,
        theirs: &Records,
        not_compared: &mut Vec<String>,
    ) {
        // By the record that parts, what it is seen by: its first field.
        let mut parted: BTreeMap<usize, Difference> = BTreeMap::new();
        let mut first = None;
        for (rows, others, missing) in [(ours, theirs, true), (theirs, ours, false)] {
            let alone = rows
                .rows
                .keys()
                .filter(|path| !others.rows.contains_key(path));
            for &path in alone.filter(|&&path| self.follows(queue, path)) {
                let found = |there| if there { "a record" } else { NO_RECORD }.to_owned();
                let words = (found(missing), found(!missing));
                let difference = self.difference(queue, None, path, words, None);
                match queue.edge {
                    // How many there are follows from settings.
                    0 => first = first.or(Some(difference)),
                    _ => drop(parted.insert(path, difference)),
                }
            }
        }
        self.first = self.first.take().or(first);
        for field in &queue.fields {
            let arrays = (ours.array(&field.field), theirs.array(&field.field));
            let (Some(mine), Some(other)) = arrays else {
                if theirs.rows.is_empty() {
                    continue;
                }
                self.missing += 1;
                not_compared.push(format!("{}: the port has none", field.file));
                continue;
            };
            let rows = ours.rows.iter().filter_map(|(&record, &row)| {
                let other_row = *theirs.rows.get(&record)?;
                self.follows(queue, record)
                    .then_some((record, row, other_row))
            });
            let rows: Vec<_> = rows.collect();
            let compared = self.compare_field(queue, field, (mine, other), &rows, &mut parted);
            self.arrays.push(compared);
        }
        self.part(parted);
    }

    /// Compares the rows (of each record, ours and theirs) of a field.
    fn compare_field(
        &mut self,
        queue: &Queue,
        field: &Field,
        (ours, theirs): (&Array, &Array),
        rows: &[(usize, usize, usize)],
        parted: &mut BTreeMap<usize, Difference>,
    ) -> Compared {
        let budget = budget::of(&field.field, 1);
        let measure = budget.map_or(Measure::Same, |budget| budget.measure);
        let mut compared = Compared {
            edge: queue.edge,
            stage: queue.stage.clone(),
            queue: queue.queue.clone(),
            field: field.field.clone(),
            records: rows.len(),
            different: 0,
            beyond: 0,
            worst_ulp: 0.0,
            budget_ulp: field.budget_ulp,
        };
        for &(record, row, other_row) in rows {
            let apart = ulp::apart((ours, row), (theirs, other_row), measure);
            if apart.same_bits {
                continue;
            }
            compared.different += 1;
            if apart.ulp <= field.budget_ulp {
                compared.worst_ulp = compared.worst_ulp.max(apart.ulp);
                continue;
            }
            compared.beyond += 1;
            let describe = || {
                let words = (ulp::shown(ours, row), ulp::shown(theirs, other_row));
                let whole = matches!(measure, Measure::Same | Measure::Choice);
                let ulps = (!whole).then_some((apart.ulp, field.budget_ulp));
                self.difference(queue, Some(&field.field), record, words, ulps)
            };
            // What follows from settings alone, and sums of what has not parted, leave no choice.
            if measure == Measure::Same || self.owner(queue, record).1.is_none() {
                if self.first.is_none() {
                    self.first = Some(describe());
                }
            } else {
                parted.entry(record).or_insert_with(describe);
            }
        }
        compared
    }

    /// Takes leave of the paths that part in a queue. Where they become too many, the field by which most part is named.
    fn part(&mut self, parted: BTreeMap<usize, Difference>) {
        let mut fields: BTreeMap<Option<&str>, usize> = BTreeMap::new();
        for difference in parted.values() {
            *fields.entry(difference.field.as_deref()).or_default() += 1;
        }
        let most = fields.iter().max_by_key(|(_, paths)| **paths);
        let by_most = |difference: &&Difference| {
            most.is_some_and(|(field, _)| *field == difference.field.as_deref())
        };
        if self.first.is_none() && self.parted.len() + parted.len() > self.allowed {
            self.first = parted.values().find(by_most).cloned();
        }
        if self.first_parted.is_none() {
            self.first_parted = parted.values().next().cloned();
        }
        self.by_choice += parted.values().filter(|found| found.ulp.is_none()).count();
        self.parted.extend(parted.into_keys());
    }

    /// Whose a record is: a pixel's place in the tile, and one of its samples or all.
    fn owner(&self, queue: &Queue, record: usize) -> (usize, Option<usize>) {
        match (queue.stage.as_str(), queue.queue.as_str()) {
            ("film", "pixels") => (record, None),
            ("film", "blocks") => (record * self.pixels / queue.records.max(1), None),
            _ => (record / self.samples, Some(record % self.samples)),
        }
    }

    /// Whether none of the paths that a record is of has parted.
    fn follows(&self, queue: &Queue, record: usize) -> bool {
        let paths = match self.owner(queue, record) {
            (_, Some(_)) => record..record + 1,
            (pixel, None) => pixel * self.samples..(pixel + 1) * self.samples,
        };
        self.parted.range(paths).next().is_none()
    }

    fn difference(
        &self,
        queue: &Queue,
        field: Option<&str>,
        record: usize,
        (ours, theirs): (String, String),
        ulps: Option<(f64, f64)>,
    ) -> Difference {
        let [x0, y0, x1, _] = self.manifest.tile;
        let width = (x1 - x0) as usize;
        let (pixel, sample) = self.owner(queue, record);
        Difference {
            edge: queue.edge,
            stage: queue.stage.clone(),
            queue: queue.queue.clone(),
            field: field.map(str::to_owned),
            path: record,
            // A manifest may list more records than there are pixels.
            pixel: [
                x0 + (pixel % width) as u32,
                y0.saturating_add((pixel / width) as u32),
            ],
            sample: sample.map(|sample| self.manifest.samples[0] + sample as u32),
            ours,
            theirs,
            ulp: ulps.map(|(apart, _)| apart),
            budget_ulp: ulps.map_or(0.0, |(_, budget)| budget),
        }
    }

    fn verdict(self, not_compared: Vec<String>) -> Verdict {
        Verdict {
            within: self.first.is_none(),
            bit_equal: self.first.is_none()
                && self.parted.is_empty()
                && self.arrays.iter().all(|array| array.different == 0),
            first: self.first,
            parted: Parted {
                paths: self.parted.len(),
                by_choice: self.by_choice,
                allowed: self.allowed,
                first: self.first_parted,
            },
            arrays: self.arrays,
            missing: self.missing,
            not_compared,
        }
    }
}
