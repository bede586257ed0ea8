//! Floor 1: NumPy's files of numbers, as far as they are needed: little-endian, row by row.
//!
//! Format 1.0 to 3.0 (NumPy Enhancement Proposal 1; `numpy.lib.format`). The crates that read them are made for files one
//! trusts: they allocate what a header says and descend as deep as its brackets go.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

/// What a file begins with.
const MAGIC: [u8; 6] = *b"\x93NUMPY";

/// The longest header that is read. NumPy's own have 128 bytes.
const LONGEST_HEADER: usize = 4096;

/// An array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its sides, the last the innermost.
    pub shape: Vec<usize>,
    /// Its numbers, as many as the sides multiply to.
    pub numbers: Numbers,
}

/// Numbers of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// `<f4`
    F32(Vec<f32>),
    /// `<f8`
    F64(Vec<f64>),
    /// `<u4`
    U32(Vec<u32>),
}

impl Numbers {
    /// NumPy's name of the type.
    pub fn dtype(&self) -> &'static str {
        match self {
            Numbers::F32(_) => "<f4",
            Numbers::F64(_) => "<f8",
            Numbers::U32(_) => "<u4",
        }
    }
}

/// Reads an array. `remedy` ends the message about a file that holds something else.
///
/// # Errors
/// [`Error::Read`] where there is no such file, [`Error::Format`] where it is something else, or ends too soon or too late.
pub fn read(path: &Path, remedy: &str) -> Result<Array> {
    let file = File::open(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(BufReader::new(file), path, remedy)
}

/// The same of what is in a file called `path`.
///
/// # Errors
/// As [`read`].
pub fn parse(mut file: impl Read, path: &Path, remedy: &str) -> Result<Array> {
    let cannot_read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let wrong = |what: &str| Error::format(path, format!("{what}; {remedy}"));
    let ended = |error: io::Error, what: &str| match error.kind() {
        io::ErrorKind::UnexpectedEof => wrong(what),
        _ => cannot_read(error),
    };
    let mut magic = [0; 8];
    file.read_exact(&mut magic)
        .map_err(|error| ended(error, "is no NumPy file"))?;
    if magic[..6] != MAGIC {
        return Err(wrong("is no NumPy file"));
    }
    // The length of the header has two bytes in version 1, four later.
    let mut length = [0; 4];
    let bytes = if magic[6] == 1 { 2 } else { 4 };
    file.read_exact(&mut length[..bytes])
        .map_err(|error| ended(error, "ends in its header"))?;
    let length = u32::from_le_bytes(length) as usize;
    if length > LONGEST_HEADER {
        return Err(wrong(&format!("has a header of {length} bytes")));
    }
    let mut header = vec![0; length];
    file.read_exact(&mut header)
        .map_err(|error| ended(error, "ends in its header"))?;
    let header = String::from_utf8_lossy(&header);

    let Some(Layout { dtype, shape }) = Layout::of(&header) else {
        return Err(wrong(&format!("holds {}", header.trim())));
    };
    let size = if dtype == "<f8" { 8 } else { 4 };
    let product = |sides: &[usize]| {
        let sides = sides.iter().map(|&side| side as u64);
        sides.fold(size, u64::saturating_mul)
    };
    let (row, all) = (product(shape.get(1..).unwrap_or_default()), product(&shape));
    // As much as there is, whatever the header says.
    let mut read = Vec::new();
    let count = file.by_ref().take(all).read_to_end(&mut read);
    if (count.map_err(cannot_read)? as u64) < all {
        let rows = shape.first().copied().unwrap_or(1);
        let whole = read.len() as u64 / row;
        return Err(wrong(&format!("ends in row {whole} of {rows}")));
    }
    if file.read(&mut [0]).map_err(cannot_read)? > 0 {
        return Err(wrong("goes on after its last number"));
    }
    let words = || read.as_chunks().0.iter().copied();
    let numbers = match dtype {
        "<f4" => Numbers::F32(words().map(f32::from_le_bytes).collect()),
        "<u4" => Numbers::U32(words().map(u32::from_le_bytes).collect()),
        _ => {
            let words = read.as_chunks().0.iter().copied();
            Numbers::F64(words.map(f64::from_le_bytes).collect())
        }
    };
    Ok(Array { shape, numbers })
}

/// What a header says.
struct Layout {
    dtype: &'static str,
    shape: Vec<usize>,
}

impl Layout {
    /// By its text, `{'descr': '<f4', 'fortran_order': False, 'shape': (5, 3), }`; none where it holds anything else.
    fn of(header: &str) -> Option<Self> {
        let value = |key: &str| {
            let (_, after) = header.split_once(&format!("'{key}':"))?;
            Some(after.trim_start())
        };
        let found = value("descr")?.get(..5)?;
        let dtype = ["<f4", "<f8", "<u4"]
            .into_iter()
            .find(|dtype| found == format!("'{dtype}'"))?;
        let sides = value("shape")?.strip_prefix('(')?.split_once(')')?.0;
        let sides = sides.strip_suffix(',').unwrap_or(sides);
        let shape: Option<Vec<usize>> = match sides.trim() {
            "" => Some(Vec::new()),
            sides => sides
                .split(',')
                .map(|side| side.trim().parse().ok())
                .collect(),
        };
        let by_rows = value("fortran_order")?.starts_with("False");
        by_rows.then_some(Self {
            dtype,
            shape: shape?,
        })
    }
}

impl Array {
    /// Its shape as NumPy writes it: `(5, 3)`, `(5,)`.
    pub fn sides(&self) -> String {
        match &self.shape[..] {
            [one] => format!("({one},)"),
            all => {
                let all: Vec<String> = all.iter().map(usize::to_string).collect();
                format!("({})", all.join(", "))
            }
        }
    }

    /// Writes it as a file of format 1.0.
    ///
    /// # Errors
    /// What the file says.
    pub fn write(&self, file: &mut impl Write) -> io::Result<()> {
        let sides = self.sides();
        let dtype = self.numbers.dtype();
        let header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {sides}, }}");
        // Everything before the numbers is a multiple of 64 bytes long and ends in a new line.
        let before = MAGIC.len() + 4;
        let length = (before + header.len() + 1).next_multiple_of(64) - before;
        file.write_all(&MAGIC)?;
        file.write_all(&[1, 0])?;
        file.write_all(&(length as u16).to_le_bytes())?;
        writeln!(file, "{header:<width$}", width = length - 1)?;
        match &self.numbers {
            Numbers::F32(all) => all
                .iter()
                .try_for_each(|n| file.write_all(&n.to_le_bytes())),
            Numbers::F64(all) => all
                .iter()
                .try_for_each(|n| file.write_all(&n.to_le_bytes())),
            Numbers::U32(all) => all
                .iter()
                .try_for_each(|n| file.write_all(&n.to_le_bytes())),
        }
    }
}
