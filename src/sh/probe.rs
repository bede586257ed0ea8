//! Light as coefficients: what is known from all directions at one place, and its files.
//!
//! A file says all that its numbers mean: format and version, the convention of the basis, the quantity and its unit.

use super::{Lobe, MAX_DEGREE, coefficients};
use crate::error::{Error, Place, Result};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::io::Read;
use std::path::Path;

/// What a file says of its basis.
pub const CONVENTION: &str = "real orthonormal spherical harmonics without the Condon-Shortley sign; degree l and order m at \
                              l^2 + l + m; Y(1,-1) ~ y, Y(1,0) ~ z, Y(1,1) ~ x; axes of the world, right-handed, y up";

const FORMAT: &str = "ondine-sh";
const VERSION: u64 = 1;

/// What the file of a grid of probes says that it is.
pub const GRID_FORMAT: &str = "ondine-sh-grid";

/// The greatest magnitude of a coefficient of light to shade with: no sample of the film is larger.
const GREATEST: f64 = 4_294_967_296.0;

/// The largest file that is read, bytes; one of the greatest degree with errors has some 3 million.
const LARGEST_FILE: u64 = 1 << 24;

/// RGB coefficients of radiance, or of radiance convolved with a lobe, by direction *towards* the light, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The greatest degree.
    pub degree: usize,
    /// `(degree + 1)²` of them, in the order of [`index`](super::index); finite.
    pub coefficients: Vec<[f64; 3]>,
    /// Standard error of each coefficient, where they are estimates; finite, not negative.
    pub standard_errors: Option<Vec<[f64; 3]>>,
    /// The lobe that radiance was convolved with: none is radiance.
    pub lobe: Option<Lobe>,
    /// Where the numbers are from, for people.
    pub source: Option<String>,
}

impl Probe {
    /// Coefficients of radiance, W·sr⁻¹·m⁻².
    ///
    /// # Errors
    /// [`Error::Usage`] where they are not `(l + 1)²` of a degree up to [`MAX_DEGREE`], or one is not finite.
    pub fn radiance(coefficients: Vec<[f64; 3]>) -> Result<Self> {
        let probe = Self {
            degree: coefficients.len().isqrt().saturating_sub(1),
            coefficients,
            standard_errors: None,
            lobe: None,
            source: None,
        };
        probe.check().map_err(Error::Usage)?;
        Ok(probe)
    }

    /// Reads a file: CSV where its name ends in `.csv`, else JSON.
    ///
    /// # Errors
    /// [`Error::Read`], [`Error::Scene`] at a line and column, or [`Error::Format`]; each says what to do.
    pub fn read(path: &Path) -> Result<Self> {
        let cannot_read = |source| Error::Read {
            path: path.to_owned(),
            source,
        };
        let mut bytes = Vec::new();
        std::fs::File::open(path)
            .and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes))
            .map_err(cannot_read)?;
        if bytes.len() as u64 > LARGEST_FILE {
            return Err(Error::format(
                path,
                format!("is larger than 16 MiB; coefficients up to degree {MAX_DEGREE} need less"),
            ));
        }
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::format(
                path,
                "is no text in UTF-8; coefficients are JSON or CSV, an image goes through `ondine sh project`",
            )
        })?;
        let file = path.display().to_string();
        match is_csv(path) {
            true => Self::from_csv(&file, &text),
            false => Self::from_json(&file, &text),
        }
    }

    /// Reads JSON; `file` is its name in errors.
    ///
    /// # Errors
    /// [`Error::Scene`] at a line and column, or [`Error::Format`].
    pub fn from_json(file: &str, text: &str) -> Result<Self> {
        let document: Document = serde_json::from_str(text).map_err(|error| {
            if is_grid(text) {
                return Error::format(
                    Path::new(file),
                    "holds a grid of probes, and one is wanted; bake it alone with `ondine sh probe SCENE --at x,y,z`, at \
                     the position that the grid has for it",
                );
            }
            let (line, column) = (error.line(), error.column());
            let what = error.to_string();
            let what = what.split(" at line ").next().unwrap_or_default();
            Error::Scene {
                place: Place {
                    file: file.to_owned(),
                    line,
                    // In an empty file the reader has not come to the first.
                    column: column.max(1),
                },
                message: format!(
                    "these are no coefficients: {what}; write {{\"format\": \"{FORMAT}\", \"version\": {VERSION}, \
                     \"convention\": .., \"quantity\": \"radiance\", \"l_max\": 2, \"coefficients\": [[r, g, b], ..]}}"
                ),
            }
        })?;
        document
            .probe()
            .map_err(|message| Error::format(Path::new(file), message))
    }

    /// Reads CSV: what JSON says beside the numbers stands as `# key: value`, then come a header and a row for each
    /// coefficient.
    ///
    /// # Errors
    /// [`Error::Scene`] at a line and column, or [`Error::Format`].
    pub fn from_csv(file: &str, text: &str) -> Result<Self> {
        super::table::read(file, text)?
            .probe()
            .map_err(|message| Error::format(Path::new(file), message))
    }

    /// The file for a name: CSV where it ends in `.csv`, else JSON.
    ///
    /// # Errors
    /// [`Error::Usage`] where a number is not finite, or their count is not that of the degree.
    pub fn to_text(&self, path: &Path) -> Result<String> {
        match is_csv(path) {
            true => self.to_csv(),
            false => self.to_json(),
        }
    }

    /// As JSON, a coefficient on each line. What is read from it again has the same bits.
    ///
    /// # Errors
    /// As [`Probe::to_text`].
    pub fn to_json(&self) -> Result<String> {
        let document = self.document()?;
        let text = |value: &str| serde_json::Value::from(value).to_string();
        let mut json = String::from("{\n");
        for (key, value) in document.facts() {
            let _ = writeln!(json, "  {}: {},", text(key), text(&value));
        }
        let _ = write!(
            json,
            "  \"version\": {VERSION},\n  \"l_max\": {}",
            self.degree
        );
        let lists = [
            ("coefficients", Some(&document.coefficients)),
            ("standard_errors", document.standard_errors.as_ref()),
        ];
        for (key, rows) in lists {
            let Some(rows) = rows else { continue };
            let rows: Vec<String> = rows
                .iter()
                .map(|[r, g, b]| format!("    [{r:?}, {g:?}, {b:?}]"))
                .collect();
            let _ = write!(json, ",\n  \"{key}\": [\n{}\n  ]", rows.join(",\n"));
        }
        json.push_str("\n}\n");
        Ok(json)
    }

    /// As CSV. What is read from it again has the same bits.
    ///
    /// # Errors
    /// As [`Probe::to_text`].
    pub fn to_csv(&self) -> Result<String> {
        super::table::write(&self.document()?)
    }

    /// Those of degrees up to `degree` alone.
    #[must_use]
    pub fn truncated(mut self, degree: usize) -> Self {
        let count = coefficients(degree.min(self.degree));
        self.degree = degree.min(self.degree);
        self.coefficients.truncate(count);
        if let Some(errors) = &mut self.standard_errors {
            errors.truncate(count);
        }
        self
    }

    /// What a file says.
    ///
    /// # Errors
    /// As [`Probe::to_text`].
    pub fn document(&self) -> Result<Document> {
        self.check().map_err(Error::Usage)?;
        Ok(Document {
            format: FORMAT.to_owned(),
            version: VERSION,
            convention: CONVENTION.to_owned(),
            quantity: quantity(self.lobe).to_owned(),
            unit: Some(unit(self.lobe).to_owned()),
            lobe: self.lobe.map(|lobe| lobe.to_string()),
            source: self.source.clone(),
            l_max: self.degree,
            coefficients: self.coefficients.clone(),
            standard_errors: self.standard_errors.clone(),
        })
    }

    /// What is wrong with coefficients that are so large that sums of them, or films of such light, could overflow, and what
    /// to do.
    pub(crate) fn check_magnitude(&self) -> std::result::Result<(), String> {
        let all = self.coefficients.iter().flatten();
        let large = all.copied().find(|value| value.abs() > GREATEST);
        large.map_or(Ok(()), |large| {
            Err(format!(
                "has a coefficient of {large:e}, and 2^32 is the greatest; choose another unit"
            ))
        })
    }

    /// What is wrong with the numbers, and what to do.
    fn check(&self) -> std::result::Result<(), String> {
        if self.degree > MAX_DEGREE {
            return Err(format!(
                "l_max is {}; write at most {MAX_DEGREE}, and leave the coefficients above out",
                self.degree
            ));
        }
        let lists = [
            ("coefficients", Some(&self.coefficients)),
            ("standard_errors", self.standard_errors.as_ref()),
        ];
        for (name, list) in lists {
            let Some(list) = list else { continue };
            let (found, wanted) = (list.len(), coefficients(self.degree));
            if found != wanted {
                let root = found.isqrt();
                let of_whole_bands = match found > 0 && root * root == found {
                    true => format!("; {found} are those of l_max = {}", root - 1),
                    false => format!("; {found} is not (l_max + 1)^2 of any l_max"),
                };
                return Err(format!(
                    "{name} has {found} rows, and l_max = {} needs {wanted}{of_whole_bands}",
                    self.degree
                ));
            }
            let rows = list.iter().zip(orders());
            for (rgb, (l, m)) in rows {
                for (value, channel) in rgb.iter().zip(["red", "green", "blue"]) {
                    if !value.is_finite() || (name == "standard_errors" && *value < 0.0) {
                        return Err(format!(
                            "{name} at l = {l}, m = {m} has {channel} = {value}; write a finite number{}",
                            if name == "standard_errors" {
                                ", at least 0"
                            } else {
                                ""
                            }
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}

/// Degree and order of each coefficient, without end.
pub(super) fn orders() -> impl Iterator<Item = (usize, isize)> {
    (0..).flat_map(|l: usize| {
        let order = l.cast_signed();
        (-order..=order).map(move |m| (l, m))
    })
}

/// Whether a file of coefficients is CSV, by its name; else it is JSON.
#[must_use]
pub fn is_csv(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Whether a text is the file of a grid of probes.
fn is_grid(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Any {
        format: String,
    }
    serde_json::from_str(text).is_ok_and(|any: Any| any.format == GRID_FORMAT)
}

fn quantity(lobe: Option<Lobe>) -> &'static str {
    match lobe {
        None => "radiance",
        Some(Lobe::Cosine) => "irradiance",
        Some(Lobe::Phong(_)) => "reflected radiance",
    }
}

fn unit(lobe: Option<Lobe>) -> &'static str {
    match lobe {
        Some(Lobe::Cosine) => "W m^-2",
        None | Some(Lobe::Phong(_)) => "W sr^-1 m^-2",
    }
}

/// What a file of coefficients says, as it says it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Document {
    pub(super) format: String,
    pub(super) version: u64,
    pub(super) convention: String,
    pub(super) quantity: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) lobe: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) source: Option<String>,
    pub(super) l_max: usize,
    pub(super) coefficients: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) standard_errors: Option<Vec<[f64; 3]>>,
}

impl Document {
    /// All that is text, by its key.
    pub(super) fn facts(&self) -> impl Iterator<Item = (&'static str, String)> {
        [
            ("format", Some(&self.format)),
            ("convention", Some(&self.convention)),
            ("quantity", Some(&self.quantity)),
            ("unit", self.unit.as_ref()),
            ("lobe", self.lobe.as_ref()),
            ("source", self.source.as_ref()),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key, value?.clone())))
    }

    /// What it stands for; or what is wrong with it, and what to do.
    fn probe(self) -> std::result::Result<Probe, String> {
        let wanted = |key: &str, found: &str, known: &str| {
            format!("{key} {found:?} is unknown; convert the coefficients to {known:?} and say so")
        };
        if self.format != FORMAT {
            return Err(wanted("format", &self.format, FORMAT));
        }
        if self.version != VERSION {
            return Err(format!(
                "version {} is unknown; this program reads version {VERSION}, a later one may read it",
                self.version
            ));
        }
        if self.convention != CONVENTION {
            return Err(wanted("convention", &self.convention, CONVENTION));
        }
        let lobe = self.lobe.as_deref().map(str::parse::<Lobe>);
        let lobe = lobe.transpose().map_err(|error| format!("lobe: {error}"))?;
        if self.quantity != quantity(lobe) {
            let lobe = self
                .lobe
                .map_or("no lobe".to_owned(), |lobe| format!("lobe {lobe:?}"));
            return Err(format!(
                "quantity {:?} with {lobe} is unknown; write \"radiance\" without a lobe, \"irradiance\" with \"cosine\" or \
                 \"reflected radiance\" with \"phong:N\"",
                self.quantity
            ));
        }
        let probe = Probe {
            degree: self.l_max,
            coefficients: self.coefficients,
            standard_errors: self.standard_errors,
            lobe,
            source: self.source,
        };
        probe.check().map(|()| probe)
    }
}
