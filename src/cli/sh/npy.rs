//! NumPy's files, as far as they are needed: tables of floats, row by row.
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

/// Rows of three numbers, in 32 or 64 bits; 64 are rounded to 32.
///
/// # Errors
/// [`Error::Read`] where there is no such file, [`Error::Format`] where it is something else or ends too soon.
pub(super) fn read_rows_of_three(path: &Path) -> Result<Vec<[f32; 3]>> {
    let cannot_read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let wrong = |what: &str| {
        let remedy = "write it with numpy.save, as an array of shape [n, 3] and dtype float32";
        Error::format(path, format!("{what}; {remedy}"))
    };
    let ended = |error: io::Error, what: &str| match error.kind() {
        io::ErrorKind::UnexpectedEof => wrong(what),
        _ => cannot_read(error),
    };
    let mut file = BufReader::new(File::open(path).map_err(cannot_read)?);
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

    let Some(Layout { wide, rows }) = Layout::of(&header) else {
        return Err(wrong(&format!("holds {}", header.trim())));
    };
    let mut read = Vec::new();
    // As many as there are, whatever the header says.
    for row in 0..rows {
        let mut component = || {
            if wide {
                let mut bytes = [0; 8];
                file.read_exact(&mut bytes)
                    .map(|()| f64::from_le_bytes(bytes) as f32)
            } else {
                let mut bytes = [0; 4];
                file.read_exact(&mut bytes)
                    .map(|()| f32::from_le_bytes(bytes))
            }
        };
        let mut three = || Ok([component()?, component()?, component()?]);
        read.push(three().map_err(|error| ended(error, &format!("ends in row {row} of {rows}")))?);
    }
    Ok(read)
}

/// What a header says of a table of three columns.
struct Layout {
    /// 64 bits a number, not 32.
    wide: bool,
    rows: u64,
}

impl Layout {
    /// By its text, `{'descr': '<f4', 'fortran_order': False, 'shape': (5, 3), }`; none where it holds anything else.
    fn of(header: &str) -> Option<Self> {
        let value = |key: &str| {
            let (_, after) = header.split_once(&format!("'{key}':"))?;
            Some(after.trim_start())
        };
        let wide = match value("descr")?.get(..5)? {
            "'<f4'" => false,
            "'<f8'" => true,
            _ => return None,
        };
        let shape = value("shape")?.strip_prefix('(')?.split_once(')')?.0;
        let mut sides = shape.split(',').map(str::trim);
        let rows = sides.next()?.parse().ok()?;
        let three = sides.next()? == "3" && sides.all(str::is_empty);
        let by_rows = value("fortran_order")?.starts_with("False");
        (three && by_rows).then_some(Self { wide, rows })
    }
}

/// Writes a table of 32-bit floats, `columns` a row.
pub(super) fn write_table(file: &mut impl Write, columns: usize, values: &[f32]) -> io::Result<()> {
    let rows = values.len() / columns;
    let header =
        format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // Everything before the numbers is a multiple of 64 bytes long and ends in a new line.
    let before = MAGIC.len() + 4;
    let length = (before + header.len() + 1).next_multiple_of(64) - before;
    file.write_all(&MAGIC)?;
    file.write_all(&[1, 0])?;
    file.write_all(&(length as u16).to_le_bytes())?;
    writeln!(file, "{header:<width$}", width = length - 1)?;
    for value in values {
        file.write_all(&value.to_le_bytes())?;
    }
    Ok(())
}
