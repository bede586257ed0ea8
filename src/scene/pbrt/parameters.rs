//! Typed parameter lists: `"float radius" 2 "rgb reflectance" [0.8 0.8 0.8]`.

use super::files::{Files, finite};
use super::lexer::{At, Kind, Token};
use super::names::{did_you_mean, quoted};
use super::spectra::Spectrum;
use crate::error::Result;
use crate::lanes::Rgb;
use glam::{DVec3, Vec2, Vec3};
use std::cell::Cell;

/// The types of parameters; the numbers are those in a group.
const TYPES: [&str; 15] = [
    "integer",
    "float",
    "point2",
    "vector2",
    "point3",
    "vector3",
    "normal3",
    "point",
    "vector",
    "normal",
    "spectrum",
    "rgb",
    "blackbody",
    "bool",
    "string",
];

/// Most values of a parameter that `Attribute` sets.
const LONGEST_DEFAULT: usize = 64;

/// The values of a parameter.
#[derive(Clone, Debug)]
pub(super) enum Values {
    /// Finite.
    Floats(Vec<f32>),
    /// Of the type `integer`.
    Integers(Vec<i32>),
    /// Of the types `string` and `texture`, and names or files of spectra.
    Texts(Vec<String>),
    /// Of the type `bool`.
    Flags(Vec<bool>),
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Floats(values) => values.len(),
            Self::Integers(values) => values.len(),
            Self::Texts(values) => values.len(),
            Self::Flags(values) => values.len(),
        }
    }
}

/// One parameter.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// `float`, `rgb`, ...
    pub kind: String,
    /// Its name.
    pub name: String,
    /// In file order.
    pub values: Values,
    /// Where its declaration begins.
    pub at: At,
    /// Whether anything asked for it.
    used: Cell<bool>,
}

impl Parameter {
    fn wrong(&self, wanted: &str) -> crate::error::Error {
        let count = self.values.len();
        self.at.error(format!(
            "{} is {wanted}, and this is {count} of type {}; write {wanted}",
            self.name, self.kind
        ))
    }
}

/// A colour or number, or the name of a texture.
#[derive(Clone, Debug)]
pub(super) enum Textured {
    /// The name of a texture, and where it is used.
    Texture(String, At),
    /// The same everywhere.
    Constant(Spectrum),
}

/// The parameters of one directive, those of `Attribute` after its own.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    list: Vec<Parameter>,
    /// The directive.
    pub at: At,
    /// What it makes: the directive and the text after it.
    pub owner: String,
}

impl Parameters {
    /// Reads all that follows.
    pub fn read(files: &mut Files, at: At, owner: String) -> Result<Self> {
        let mut list = Vec::new();
        while let Some(declaration) = files.next_if(|token| token.kind == Kind::Text)? {
            list.push(parameter(files, &declaration)?);
        }
        Ok(Self { list, at, owner })
    }

    /// Those of `Attribute` hold where a directive says nothing.
    pub fn inherit(&mut self, defaults: &[Parameter]) {
        for default in defaults {
            if !self.list.iter().any(|own| own.name == default.name) {
                // Nobody need use what was said of many.
                default.used.set(true);
                self.list.push(default.clone());
            }
        }
    }

    /// The list, for `Attribute`: none of them long, for each directive has a copy.
    pub fn into_defaults(self) -> Result<Vec<Parameter>> {
        match self.list.iter().find(|parameter| parameter.values.len() > LONGEST_DEFAULT) {
            None => Ok(self.list),
            Some(long) => Err(long.at.error(format!(
                "{} has more than {LONGEST_DEFAULT} values, too many for all that follows; write it where it is used",
                long.name
            ))),
        }
    }

    /// Whether there is one of that name.
    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// Nothing asks for the parameters of what is left out.
    pub fn ignore(&self) {
        for parameter in &self.list {
            parameter.used.set(true);
        }
    }

    /// What nothing asked for.
    pub fn unused(&self) -> impl Iterator<Item = &Parameter> {
        self.list.iter().filter(|parameter| !parameter.used.get())
    }

    /// The parameter of that name, whatever its type.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        let found = self.list.iter().find(|parameter| parameter.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// A number.
    pub fn float(&self, name: &str) -> Result<Option<f32>> {
        let read = |parameter: &Parameter| match &parameter.values {
            Values::Floats(values) if values.len() == 1 => Ok(values[0]),
            Values::Integers(values) if values.len() == 1 => Ok(values[0] as f32),
            _ => Err(parameter.wrong("one float")),
        };
        self.get(name).map(read).transpose()
    }

    /// A number in a range, which `range` names.
    pub fn float_in(
        &self,
        name: &str,
        range: &str,
        holds: impl Fn(f32) -> bool,
    ) -> Result<Option<f32>> {
        let value = self.float(name)?;
        match (value, self.get(name)) {
            (Some(value), Some(parameter)) if !holds(value) => Err(parameter
                .at
                .error(format!("{name} is {value}; it must be {range}"))),
            _ => Ok(value),
        }
    }

    /// An integer in a range.
    pub fn integer(&self, name: &str, range: std::ops::RangeInclusive<i32>) -> Result<Option<i32>> {
        let read = |parameter: &Parameter| match &parameter.values {
            Values::Integers(values) if values.len() == 1 => {
                if range.contains(&values[0]) {
                    return Ok(values[0]);
                }
                Err(parameter.at.error(format!(
                    "{name} is {}; it must be from {} to {}",
                    values[0],
                    range.start(),
                    range.end()
                )))
            }
            _ => Err(parameter.wrong("one integer")),
        };
        self.get(name).map(read).transpose()
    }

    /// Integers.
    pub fn integers(&self, name: &str) -> Result<Option<&[i32]>> {
        let read = |parameter| match parameter {
            &Parameter {
                values: Values::Integers(ref values),
                ..
            } => Ok(values.as_slice()),
            other => Err(other.wrong("integers")),
        };
        self.get(name).map(read).transpose()
    }

    /// `true` or `false`.
    pub fn flag(&self, name: &str) -> Result<Option<bool>> {
        let read = |parameter: &Parameter| match &parameter.values {
            Values::Flags(values) if values.len() == 1 => Ok(values[0]),
            _ => Err(parameter.wrong("one bool")),
        };
        self.get(name).map(read).transpose()
    }

    /// A text.
    pub fn text(&self, name: &str) -> Result<Option<&str>> {
        let read = |parameter| match parameter {
            &Parameter {
                values: Values::Texts(ref values),
                ref kind,
                ..
            } if values.len() == 1 && kind == "string" => Ok(values[0].as_str()),
            other => Err(other.wrong("one string")),
        };
        self.get(name).map(read).transpose()
    }

    /// Texts.
    pub fn texts(&self, name: &str) -> Result<Option<&[String]>> {
        let read = |parameter| match parameter {
            &Parameter {
                values: Values::Texts(ref values),
                ..
            } => Ok(values.as_slice()),
            other => Err(other.wrong("strings")),
        };
        self.get(name).map(read).transpose()
    }

    /// Numbers, `group` at a time.
    pub fn floats(&self, name: &str, group: usize) -> Result<Option<&[f32]>> {
        let read = |parameter| match parameter {
            &Parameter {
                values: Values::Floats(ref values),
                ..
            } if values.len() % group == 0 => Ok(values.as_slice()),
            other => Err(other.wrong(&format!("floats in groups of {group}"))),
        };
        self.get(name).map(read).transpose()
    }

    /// A point or a vector.
    pub fn point(&self, name: &str) -> Result<Option<DVec3>> {
        let Some(values) = self.floats(name, 3)? else {
            return Ok(None);
        };
        match values {
            &[x, y, z] => Ok(Some(Vec3::new(x, y, z).as_dvec3())),
            _ => Err(self.at.error(format!("{name} needs three numbers"))),
        }
    }

    /// Points or vectors.
    pub fn points(&self, name: &str) -> Result<Option<Vec<Vec3>>> {
        let values = self.floats(name, 3)?;
        Ok(values.map(|values| values.chunks_exact(3).map(Vec3::from_slice).collect()))
    }

    /// Pairs.
    pub fn pairs(&self, name: &str) -> Result<Option<Vec<Vec2>>> {
        let values = self.floats(name, 2)?;
        Ok(values.map(|values| values.chunks_exact(2).map(Vec2::from_slice).collect()))
    }

    /// A colour, a spectrum, a number or the name of a texture.
    pub fn textured(&self, name: &str) -> Result<Option<Textured>> {
        self.get(name).map(textured).transpose()
    }

    /// A colour or a spectrum.
    pub fn spectrum(&self, name: &str) -> Result<Option<Spectrum>> {
        match self.textured(name)? {
            None => Ok(None),
            Some(Textured::Constant(spectrum)) => Ok(Some(spectrum)),
            Some(Textured::Texture(_, at)) => Err(at.error(format!(
                "{name} of {} is a colour, not a texture; write \"rgb {name}\" [r g b]",
                self.owner
            ))),
        }
    }
}

fn textured(parameter: &Parameter) -> Result<Textured> {
    let spectrum = match (parameter.kind.as_str(), &parameter.values) {
        ("texture", Values::Texts(names)) if names.len() == 1 => {
            return Ok(Textured::Texture(names[0].clone(), parameter.at.clone()));
        }
        ("rgb", Values::Floats(values)) => match values.as_slice() {
            &[r, g, b] => Spectrum::Rgb(Rgb::new(r, g, b)),
            _ => return Err(parameter.wrong("an rgb of three numbers")),
        },
        ("float", Values::Floats(values)) if values.len() == 1 => Spectrum::Constant(values[0]),
        ("blackbody", Values::Floats(values)) => match values.first() {
            Some(&kelvin) if (100.0..=1e6).contains(&kelvin) => Spectrum::Blackbody(kelvin),
            _ => return Err(parameter.wrong("a temperature from 100 to 1000000 kelvin")),
        },
        ("spectrum", Values::Texts(names)) if names.len() == 1 => Spectrum::Named(names[0].clone()),
        ("spectrum", Values::Floats(values)) if values.len() >= 4 && values.len() % 2 == 0 => {
            let samples: Vec<(f32, f32)> = values
                .chunks_exact(2)
                .map(|pair| (pair[0], pair[1]))
                .collect();
            if samples.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
                return Err(parameter.wrong("pairs of rising wavelengths in nm and values"));
            }
            Spectrum::Sampled(samples)
        }
        _ => return Err(parameter.wrong("an rgb, a float, a spectrum or a texture")),
    };
    Ok(Textured::Constant(spectrum))
}

fn parameter(files: &mut Files, declaration: &Token) -> Result<Parameter> {
    let text = declaration.unescaped();
    let mut words = text.split_ascii_whitespace();
    let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
        return Err(declaration.error(format!(
            "{} declares no parameter; write \"type name\", as in \"float radius\"",
            quoted(&text)
        )));
    };
    let known = || TYPES.into_iter().chain(["texture"]);
    if !known().any(|known| known == kind) {
        return Err(declaration.error(format!(
            "unknown parameter type {}{}",
            quoted(kind),
            match did_you_mean(kind, known()) {
                hint if hint.is_empty() => "; float, integer, rgb and string are some".to_owned(),
                hint => hint,
            }
        )));
    }
    let mut values = match kind {
        "integer" => Values::Integers(Vec::new()),
        "bool" => Values::Flags(Vec::new()),
        "string" | "texture" => Values::Texts(Vec::new()),
        _ => Values::Floats(Vec::new()),
    };
    let missing = || {
        declaration.error(format!(
            "the parameter {} has no value; add one, or several in [ ]",
            quoted(name)
        ))
    };
    let is_value = |token: &Token| matches!(token.kind, Kind::Text | Kind::Word);
    if files.next_if(|token| token.kind == Kind::Open)?.is_some() {
        while let Some(token) = files.next_if(is_value)? {
            add(&mut values, kind, &token)?;
        }
        if files.next_if(|token| token.kind == Kind::Close)?.is_none() {
            return Err(declaration.error(format!(
                "the values of {} have no closing bracket; add ]",
                quoted(name)
            )));
        }
    } else {
        let token = files.next_if(is_value)?.ok_or_else(missing)?;
        add(&mut values, kind, &token)?;
    }
    Ok(Parameter {
        kind: kind.to_owned(),
        name: name.to_owned(),
        values,
        at: declaration.at(),
        used: Cell::new(false),
    })
}

/// Adds a value of the declared type.
fn add(values: &mut Values, kind: &str, token: &Token) -> Result<()> {
    // A spectrum is named, or given by numbers.
    let is_text = token.kind == Kind::Text;
    if kind == "spectrum"
        && is_text
        && matches!(values, Values::Floats(floats) if floats.is_empty())
    {
        *values = Values::Texts(Vec::new());
    }
    match values {
        Values::Texts(texts) if is_text => texts.push(token.unescaped()),
        Values::Flags(flags) if matches!(token.raw(), "true" | "false") => {
            flags.push(token.raw() == "true");
        }
        Values::Integers(integers) if !is_text => match token.raw().parse() {
            Ok(value) => integers.push(value),
            Err(_) => {
                return Err(token.error(format!(
                    "{} is not an integer of 32 bits",
                    quoted(token.raw())
                )));
            }
        },
        Values::Floats(floats) if !is_text => match finite(token)? as f32 {
            value if value.is_finite() => floats.push(value),
            _ => {
                return Err(token.error(format!(
                    "{} is too large for a 32-bit float",
                    quoted(token.raw())
                )));
            }
        },
        _ => {
            return Err(token.error(format!(
                "{} is no value of type {kind}",
                quoted(token.raw())
            )));
        }
    }
    Ok(())
}
