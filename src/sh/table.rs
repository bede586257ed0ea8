//! Coefficients as CSV: facts as comments, a header, a row for each coefficient.

use super::probe::{Document, orders};
use crate::error::{Error, Place, Result};
use std::fmt::Write;
use std::path::Path;

const HEADER: [&str; 5] = ["l", "m", "r", "g", "b"];
const ERRORS: [&str; 3] = ["r_error", "g_error", "b_error"];

/// The file of a document.
///
/// # Errors
/// [`Error::Usage`] where a text of it has more than one line.
pub(super) fn write(document: &Document) -> Result<String> {
    let mut text = String::new();
    let version = document.version.to_string();
    for (key, value) in document.facts().chain([("version", version)]) {
        if value.contains(['\n', '\r']) {
            return Err(Error::Usage(format!(
                "the {key} {value:?} has several lines, and CSV has room for one; write JSON"
            )));
        }
        let _ = writeln!(text, "# {key}: {value}");
    }
    let errors = document.standard_errors.as_deref();
    let header = HEADER
        .iter()
        .chain(ERRORS.iter().filter(|_| errors.is_some()));
    let _ = writeln!(text, "{}", header.copied().collect::<Vec<_>>().join(","));
    for (index, ((l, m), rgb)) in orders().zip(&document.coefficients).enumerate() {
        let _ = write!(text, "{l},{m}");
        for value in rgb
            .iter()
            .chain(errors.iter().flat_map(|errors| &errors[index]))
        {
            let _ = write!(text, ",{value:?}");
        }
        text.push('\n');
    }
    Ok(text)
}

/// The document of a file, whose name is `file`; what it says is for the document to check.
///
/// # Errors
/// [`Error::Scene`] at a line and column, [`Error::Format`] where a fact is missing.
pub(super) fn read(file: &str, text: &str) -> Result<Document> {
    let text = text.trim_start_matches('\u{feff}');
    let fact = |key: &str| {
        text.lines()
            .filter_map(|line| line.strip_prefix('#')?.split_once(':'))
            .find(|(found, _)| found.trim() == key)
            .map(|(_, value)| value.trim().to_owned())
    };
    let required = |key: &str| {
        fact(key).ok_or_else(|| {
            Error::format(
                Path::new(file),
                format!("does not say its {key}; add a line `# {key}: ..`, as `ondine sh project` writes it"),
            )
        })
    };
    let version = required("version")?;
    let mut rows = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let at = |line: u64, column: usize, message: String| Error::Scene {
        place: Place {
            file: file.to_owned(),
            line: usize::try_from(line).unwrap_or(usize::MAX),
            column,
        },
        message,
    };
    let broken = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        at(
            line,
            1,
            format!(
                "this is no row of the table ({error}); give each as many values as the header has names"
            ),
        )
    };
    let header = rows.headers().map_err(broken)?.clone();
    let line = 1 + text
        .lines()
        .take_while(|line| line.is_empty() || line.starts_with('#'))
        .count() as u64;
    let header: Vec<&str> = header.iter().collect();
    let has_errors = match header.strip_prefix(HEADER.as_slice()) {
        Some([]) => false,
        Some(rest) if rest == ERRORS => true,
        _ => {
            return Err(at(
                line,
                1,
                format!(
                    "the header is {:?}; write \"{}\", where there are standard errors with \",{}\"",
                    header.join(","),
                    HEADER.join(","),
                    ERRORS.join(",")
                ),
            ));
        }
    };
    let (mut coefficients, mut errors) = (Vec::new(), Vec::new());
    let mut record = csv::StringRecord::new();
    let mut places = orders();
    while rows.read_record(&mut record).map_err(broken)? {
        let line = record.position().map_or(1, csv::Position::line);
        let (l, m) = places.next().unwrap_or_default();
        if record[0] != l.to_string() || record[1] != m.to_string() {
            return Err(at(
                line,
                1,
                format!(
                    "this is row l = {}, m = {}, and l = {l}, m = {m} comes next; write the rows by l, then m, all of them",
                    &record[0], &record[1]
                ),
            ));
        }
        let number = |column: usize| {
            let before: usize = record
                .iter()
                .take(column)
                .map(|field| field.len() + 1)
                .sum();
            let field = &record[column];
            field.parse::<f64>().map_err(|_| {
                at(
                    line,
                    before + 1,
                    format!("{field:?} is no number; write one, such as -0.125"),
                )
            })
        };
        let three = |first: usize| Ok([number(first)?, number(first + 1)?, number(first + 2)?]);
        coefficients.push(three(2)?);
        if has_errors {
            errors.push(three(5)?);
        }
    }
    let l_max = coefficients.len().isqrt().saturating_sub(1);
    if coefficients.len() != super::coefficients(l_max) {
        let (l, m) = places.next().unwrap_or_default();
        return Err(Error::format(
            Path::new(file),
            format!(
                "ends before the row l = {l}, m = {m}; write the rows of l = {l} to m = {l}, or leave all of them out"
            ),
        ));
    }
    Ok(Document {
        format: required("format")?,
        version: version.parse().map_err(|_| {
            Error::format(
                Path::new(file),
                format!("version {version:?} is no whole number; write 1"),
            )
        })?,
        convention: required("convention")?,
        quantity: required("quantity")?,
        unit: fact("unit"),
        lobe: fact("lobe"),
        source: fact("source"),
        l_max,
        coefficients,
        standard_errors: has_errors.then_some(errors),
    })
}
