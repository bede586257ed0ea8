//! Reads the folders that are compared. What a file says is believed of neither.

use super::super::budget;
use super::super::manifest::{FILE, FORMAT, Manifest, Queue, SCHEMA, sha256};
use super::super::table::PATH;
use crate::error::{Error, Result};
use crate::npy::{self, Array, Numbers};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// A queue's arrays.
#[derive(Debug, Default)]
pub(super) struct Records {
    /// The row of each path; of what has no path, of each row.
    pub rows: BTreeMap<usize, usize>,
    arrays: Vec<(String, Array)>,
}

impl Records {
    /// That of a field.
    pub fn array(&self, field: &str) -> Option<&Array> {
        let found = self.arrays.iter().find(|(name, _)| name == field);
        found.map(|(_, array)| array)
    }
}

/// Our dump.
#[derive(Debug)]
pub(super) struct Ours {
    root: PathBuf,
    pub manifest: Manifest,
}

impl Ours {
    pub fn open(root: &Path) -> Result<Self> {
        let path = root.join(FILE);
        let damaged = |what: String| Error::format(&path, format!("{what}; write the dump again"));
        let Value::Object(members) = read_json(&path)? else {
            return Err(damaged("is no manifest of a dump".to_owned()));
        };
        let (format, schema) = (members.get("format"), members.get("schema"));
        if format != Some(&FORMAT.into()) || schema != Some(&SCHEMA.into()) {
            return Err(damaged(format!(
                "is no manifest of a dump of schema {SCHEMA}"
            )));
        }
        let manifest: Manifest = serde_json::from_value(Value::Object(members))
            .map_err(|error| damaged(format!("is damaged: {error}")))?;
        if manifest.pixels_and_samples().is_none() {
            return Err(damaged(
                "has not the paths of its tile and samples".to_owned(),
            ));
        }
        for queue in &manifest.queues {
            // Every array has a row for each record: a count that no array bears out would be believed.
            let (records, paths) = (queue.records, manifest.paths);
            if records > paths || (records > 0) == queue.fields.is_empty() {
                return Err(damaged(format!(
                    "lists {records} records of {paths} paths and {} fields in {}",
                    queue.fields.len(),
                    queue.folder
                )));
            }
            let mut files = queue.fields.iter().map(|field| &field.file);
            let inside = |name: &str| {
                let parts = Path::new(name).components();
                parts
                    .into_iter()
                    .all(|part| matches!(part, Component::Normal(_)))
            };
            if !inside(&queue.folder) || !files.all(|file| inside(file)) {
                return Err(damaged(format!(
                    "names a file elsewhere, of {}",
                    queue.folder
                )));
            }
        }
        Ok(Self {
            root: root.to_owned(),
            manifest,
        })
    }

    /// The arrays of a queue, each as the manifest says it is.
    pub fn records(&self, queue: &Queue) -> Result<Records> {
        let mut arrays = Vec::new();
        for field in &queue.fields {
            let path = self.root.join(&field.file);
            let remedy = "the dump is damaged; write it again";
            let bytes = fs::read(&path).map_err(|source| Error::Read {
                path: path.clone(),
                source,
            })?;
            let array = npy::parse(&bytes[..], &path, remedy)?;
            let wrong = |what: &str| Err(Error::format(&path, format!("{what}; {remedy}")));
            if array.shape != field.shape || array.shape.first() != Some(&queue.records) {
                return wrong("has another shape than its manifest says");
            }
            if array.numbers.dtype() != field.dtype {
                return wrong("has another dtype than its manifest says");
            }
            if sha256(&bytes) != field.sha256 {
                return wrong("has another SHA-256 than its manifest says");
            }
            if budget::of(&field.field, 1).is_none() {
                return wrong("is of a field that this program does not know");
            }
            arrays.push((field.field.clone(), array));
        }
        let path = arrays.iter().find(|(name, _)| name == PATH);
        let rows = match path {
            Some((_, array)) => by_path(array, self.manifest.paths)
                .map_err(|what| Error::format(&self.root.join(&queue.folder), what))?,
            None => (0..queue.records).map(|row| (row, row)).collect(),
        };
        Ok(Records { rows, arrays })
    }
}

/// A port's dump.
#[derive(Debug)]
pub(super) struct Theirs {
    pub root: PathBuf,
    manifest: Option<Value>,
    paths: usize,
}

impl Theirs {
    /// `paths` is how many paths there are.
    pub fn open(root: &Path, paths: usize) -> Result<Self> {
        if !root.is_dir() {
            return Err(Error::format(
                root,
                "is no folder; give that of the port's dump",
            ));
        }
        let path = root.join(FILE);
        let manifest = path.exists().then(|| read_json(&path)).transpose()?;
        if manifest
            .as_ref()
            .is_some_and(|manifest| !manifest.is_object())
        {
            return Err(Error::format(
                &path,
                "is no JSON object; write a manifest as the dump has it, or none",
            ));
        }
        Ok(Self {
            root: root.to_owned(),
            manifest,
            paths,
        })
    }

    /// Makes sure that it is of the same paths, as far as it says; what it does not say comes back.
    pub fn unlike(&self, ours: &Ours) -> Result<Vec<String>> {
        let Some(theirs) = &self.manifest else {
            let root = self.root.display();
            let what = "nothing says that scene, settings and paths are the same";
            return Ok(vec![format!("{root} has no {FILE}: {what}")]);
        };
        let ours = serde_json::to_value(&ours.manifest).unwrap_or_default();
        let differs = |what: &str, a: &Value, b: &Value| {
            let message = format!(
                "cannot compare: {what} is {a} in the dump and {b} in {}; dump the same",
                self.root.join(FILE).display()
            );
            Err(Error::Usage(message))
        };
        let settings = ours["settings"].as_object().into_iter().flatten();
        let here = ["schema", "scene_hash", "tile", "samples"]
            .map(|key| (key, &ours[key], theirs.get(key)));
        let settings = settings.map(|(key, here)| {
            let there = theirs
                .get("settings")
                .and_then(|settings| settings.get(key));
            (key.as_str(), here, there)
        });
        let mut unsaid = Vec::new();
        for (key, here, there) in here.into_iter().chain(settings) {
            match there {
                Some(there) if !same(here, there) => return differs(key, here, there),
                Some(_) => {}
                None => unsaid.push(key),
            }
        }
        Ok(match unsaid.is_empty() {
            true => Vec::new(),
            false => vec![format!(
                "{} does not say: {}",
                self.root.join(FILE).display(),
                unsaid.join(", ")
            )],
        })
    }

    /// The arrays of a queue that are there; none where there is none.
    pub fn records(&self, queue: &Queue, ours: &Records) -> Result<Option<Records>> {
        let folder = self.root.join(&queue.folder);
        let remedy =
            "write it with numpy.save, little-endian, in the shape and dtype that the manifest has";
        let read = |file: &Path| -> Result<Option<Array>> {
            match file.exists() {
                true => npy::read(file, remedy).map(Some),
                false => Ok(None),
            }
        };
        let path_file = folder.join(format!("{PATH}.npy"));
        let path = read(&path_file)?;
        let mut arrays = Vec::new();
        for field in queue.fields.iter().filter(|field| field.field != PATH) {
            let file = self.root.join(&field.file);
            let Some(array) = read(&file)? else {
                continue;
            };
            let wrong = |what: String| Err(Error::format(&file, format!("{what}; {remedy}")));
            let rows = array.shape.first().copied().unwrap_or_default();
            let dtype = array.numbers.dtype();
            if dtype != field.dtype {
                return wrong(format!(
                    "holds numbers of dtype {dtype}, not {}",
                    field.dtype
                ));
            }
            if array.shape.len() != field.shape.len() || array.shape[1..] != field.shape[1..] {
                return wrong(format!(
                    "has the shape {}, not {}",
                    array.sides(),
                    ours.array(&field.field)
                        .map(Array::sides)
                        .unwrap_or_default()
                ));
            }
            let expected = match &path {
                Some(path) => path.shape.first().copied().unwrap_or_default(),
                None => queue.records,
            };
            if rows != expected {
                return wrong(match &path {
                    Some(_) => format!("has {rows} records, and {PATH}.npy beside it {expected}"),
                    None => format!(
                        "has {rows} records, not {expected}; where paths differ, a {PATH}.npy beside it must say which \
                         they are"
                    ),
                });
            }
            arrays.push((field.field.clone(), array));
        }
        let rows = match path {
            Some(path) => {
                let rows = by_path(&path, self.paths)
                    .map_err(|what| Error::format(&path_file, format!("{what}; {remedy}")))?;
                arrays.push((PATH.to_owned(), path));
                rows
            }
            // In our order.
            None => ours.rows.clone(),
        };
        match arrays.is_empty() {
            // Empty queues have no arrays, so what has none may be one.
            true => Ok(self.is_empty(queue).then(Records::default)),
            false => Ok(Some(Records { rows, arrays })),
        }
    }

    /// Whether the port says that a queue is empty: with 0 records, or by leaving it out of those that it lists of the edge.
    fn is_empty(&self, queue: &Queue) -> bool {
        let listed = self
            .manifest
            .as_ref()
            .and_then(|manifest| manifest.get("queues")?.as_array());
        let of_edge = || {
            let queues = listed.into_iter().flatten();
            queues.filter(|other| same(&other["edge"], &queue.edge.into()))
        };
        match of_edge().find(|other| other["folder"] == queue.folder.as_str()) {
            Some(other) => other["records"].as_f64() == Some(0.0),
            None => of_edge().next().is_some(),
        }
    }

    /// Folders with arrays, of queues that the dump has not or that are empty in it.
    pub fn beyond(&self, ours: &Manifest) -> Vec<String> {
        let filled = ours.queues.iter().filter(|queue| queue.records > 0);
        let filled: BTreeSet<&Path> = filled.map(|queue| Path::new(&queue.folder)).collect();
        let path_file = format!("{PATH}.npy");
        let mut found = Vec::new();
        // An edge's folder has one for each stage, and that one for each queue.
        let mut folders = vec![(PathBuf::new(), 0)];
        while let Some((folder, depth)) = folders.pop() {
            let entries = fs::read_dir(self.root.join(&folder));
            let entries: Vec<PathBuf> = entries
                .into_iter()
                .flatten()
                .flatten()
                .map(|entry| folder.join(entry.file_name()))
                .collect();
            // Of what is empty in ours, a record for a path is compared.
            let compared = filled.contains(&*folder)
                || (ours
                    .queues
                    .iter()
                    .any(|queue| Path::new(&queue.folder) == folder)
                    && self.root.join(&folder).join(&path_file).exists());
            let is_array = |entry: &PathBuf| entry.extension().is_some_and(|end| end == "npy");
            if !compared && entries.iter().any(is_array) {
                found.push(folder.display().to_string());
            }
            if depth < 3 {
                let below = entries
                    .into_iter()
                    .filter(|entry| self.root.join(entry).is_dir());
                folders.extend(below.map(|entry| (entry, depth + 1)));
            }
        }
        found.sort();
        found
    }
}

/// The row of each path.
fn by_path(array: &Array, paths: usize) -> std::result::Result<BTreeMap<usize, usize>, String> {
    let numbers = match &array.numbers {
        Numbers::U32(numbers) if array.shape.len() == 1 => numbers,
        other => {
            return Err(format!(
                "paths are of dtype {} and shape {}, not <u4 and (n,)",
                other.dtype(),
                array.sides()
            ));
        }
    };
    let mut rows = BTreeMap::new();
    for (row, &path) in numbers.iter().enumerate() {
        if path as usize >= paths {
            return Err(format!(
                "row {row} is of path {path}, and there are {paths}"
            ));
        }
        if let Some(before) = rows.insert(path as usize, row) {
            return Err(format!("path {path} is in row {before} and in row {row}"));
        }
    }
    Ok(rows)
}

/// Whether two values are the same, numbers by what they are worth: `6.0` is `6`.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) if x.is_f64() || y.is_f64() => {
            x.as_f64() == y.as_f64()
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        _ => a == b,
    }
}

fn read_json(path: &Path) -> Result<Value> {
    let text = fs::read_to_string(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    serde_json::from_str(&text)
        .map_err(|error| Error::format(path, format!("is no JSON: {error}; write the dump again")))
}
