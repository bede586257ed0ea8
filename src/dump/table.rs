//! Records by path, and the arrays that they become.

use super::Numbering;
use crate::lanes::{Batch, Field, Fields, Number, Queue};
use crate::npy::{Array, Numbers};
use crate::wavefront::Stage;

/// The field by which records are found.
pub const PATH: &str = "path";

/// What is in a queue after a stage of a path edge, of all waves: one record a path at most, by ascending path.
#[derive(Clone, Debug)]
pub struct Table {
    /// Path edge, from 1.
    pub edge: u32,
    /// The stage that made it.
    pub stage: Stage,
    /// The queue.
    pub queue: String,
    /// What a record has.
    pub fields: Vec<Field>,
    /// Row by row, the numbers of the fields.
    words: Vec<u32>,
    /// Numbers of a row.
    width: usize,
    /// Which of them is the path.
    path: usize,
}

/// One record of a [`Table`].
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    table: &'a Table,
    words: &'a [u32],
}

impl Table {
    /// Without a record.
    pub(super) fn new<R: Fields>(edge: u32, stage: Stage, queue: String) -> Self {
        let mut fields = Vec::new();
        R::fields("", "", &mut fields);
        let before = |name: &str| -> usize {
            let before = fields.iter().take_while(|field| field.name != name);
            before.map(|field| field.width).sum()
        };
        Self {
            edge,
            stage,
            queue,
            width: before(""),
            path: before(PATH),
            fields,
            words: Vec::new(),
        }
    }

    /// Adds a record.
    pub(super) fn push(&mut self, record: &impl Fields, number: Numbering) {
        let path = self.words.len() + self.path;
        record.words(&mut self.words);
        self.words[path] = number.of(self.words[path]);
    }

    /// Adds a queue.
    pub(super) fn extend<B: Batch<Record: Fields>>(&mut self, queue: &Queue<B>, number: Numbering) {
        for index in 0..queue.len() {
            self.push(&queue.get(index), number);
        }
    }

    /// Sorts the records by path.
    pub(super) fn sort(&mut self) {
        let mut rows: Vec<&[u32]> = self.words.chunks_exact(self.width).collect();
        rows.sort_by_key(|row| row[self.path]);
        self.words = rows.concat();
    }

    /// Bytes that its records take.
    pub(super) fn bytes(&self) -> usize {
        self.words.len() * size_of::<u32>()
    }

    /// How many records there are.
    pub fn len(&self) -> usize {
        self.words.len() / self.width
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// The record of a path.
    pub fn of(&self, path: u32) -> Option<Record<'_>> {
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = usize::midpoint(low, high);
            let words = &self.words[middle * self.width..][..self.width];
            match words[self.path].cmp(&path) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return Some(Record { table: self, words }),
            }
        }
        None
    }

    /// Each field with its numbers, path by path: of shape (n,), or (n, 3) for vectors and colours.
    pub fn arrays(&self) -> impl Iterator<Item = (&Field, Array)> {
        let mut first = 0;
        self.fields.iter().map(move |field| {
            let columns = first..first + field.width;
            first += field.width;
            let rows = self.words.chunks_exact(self.width);
            let words = rows.flat_map(|row| row[columns.clone()].iter().copied());
            let numbers = match field.number {
                Number::Integer => Numbers::U32(words.collect()),
                Number::Float => Numbers::F32(words.map(f32::from_bits).collect()),
            };
            let shape = match field.width {
                1 => vec![self.len()],
                width => vec![self.len(), width],
            };
            (field, Array { shape, numbers })
        })
    }
}

impl Record<'_> {
    /// The bits of a field's numbers; none where it has no such field.
    fn words(&self, name: &str) -> &[u32] {
        let mut first = 0;
        for field in &self.table.fields {
            if field.name == name {
                return &self.words[first..first + field.width];
            }
            first += field.width;
        }
        &[]
    }

    /// The numbers of a field; none where it has no such field.
    pub fn floats(&self, name: &str) -> Vec<f32> {
        let words = self.words(name).iter();
        words.map(|&bits| f32::from_bits(bits)).collect()
    }

    /// The number of a field; 0 where it has no such field.
    pub fn float(&self, name: &str) -> f32 {
        f32::from_bits(self.integer(name))
    }

    /// The number of a field; 0 where it has no such field.
    pub fn integer(&self, name: &str) -> u32 {
        self.words(name).first().copied().unwrap_or_default()
    }
}
