//! A small typed reader over TOML's spanned tables: whatever it refuses, it says where, what, and what to do.

use super::names::{did_you_mean, list, nearest, quoted};
use crate::error::{Error, Place, Result};
use crate::lanes::Rgb;
use glam::{Vec2, Vec3};
use std::str::FromStr;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Greatest coordinate of a point. Squared areas of quads this large still fit in 32-bit floats.
const FARTHEST: f32 = 1e9;

/// The text of a scene file or any other of TOML, to turn offsets into places.
pub(crate) struct Source<'a> {
    /// The file as the user named it.
    pub file: &'a str,
    /// Its whole text.
    pub text: &'a str,
}

impl<'a> Source<'a> {
    /// What the text says.
    pub fn document(&self) -> Result<Spanned<DeTable<'a>>> {
        DeTable::parse(self.text).map_err(|error| {
            let offset = error.span().map_or(self.text.len(), |span| span.start);
            let message = format!("this is not valid TOML: {}", error.message());
            self.error(offset, message)
        })
    }

    /// The line and column of a byte offset; one past the end is the end.
    pub fn place(&self, offset: usize) -> Place {
        Place::of(self.file, self.text, offset)
    }

    /// An error at a byte offset.
    pub fn error(&self, offset: usize, message: impl Into<String>) -> Error {
        Error::Scene {
            place: self.place(offset),
            message: message.into(),
        }
    }
}

/// A table of the file.
#[derive(Clone, Copy)]
pub(crate) struct Table<'a> {
    source: &'a Source<'a>,
    entries: &'a DeTable<'a>,
    /// Byte offset of its header or brace.
    at: usize,
}

impl<'a> Table<'a> {
    /// The whole file.
    pub fn root(source: &'a Source<'a>, root: &'a Spanned<DeTable<'a>>) -> Self {
        Self {
            source,
            entries: root.get_ref(),
            at: 0,
        }
    }

    /// Where the table is.
    pub fn place(&self) -> Place {
        self.source.place(self.at)
    }

    /// An error about the table as a whole.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.source.error(self.at, message)
    }

    /// The value of a key, where the table has it.
    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        let (name, value) = self.entries.get_key_value(key)?;
        Some(self.value(name, value))
    }

    /// The value of a key that must be there; `example` is what to add where it is not.
    pub fn require(&self, owner: &str, key: &str, example: &str) -> Result<Value<'a>> {
        self.get(key)
            .ok_or_else(|| self.error(format!("{owner} has no {key}; add {example}")))
    }

    /// All values in file order.
    pub fn values(&self) -> Vec<Value<'a>> {
        let mut values: Vec<_> = self
            .entries
            .iter()
            .map(|(name, value)| self.value(name, value))
            .collect();
        values.sort_by_key(|value| value.key_at);
        values
    }

    /// Refuses any key that is not `known`, naming the nearest.
    pub fn keys(&self, owner: &str, known: &[&str]) -> Result<()> {
        for value in self.values() {
            if known.contains(&value.key) {
                continue;
            }
            let hint = match nearest(value.key, known.iter().copied()) {
                Some((best, true)) => format!("did you mean {}?", quoted(best)),
                Some((best, false)) => format!("the nearest known key is {}.", quoted(best)),
                None => "remove it.".to_owned(),
            };
            let message = format!(
                "unknown key {} in {owner}; {hint} Known keys: {}",
                quoted(value.key),
                list(known.iter().copied())
            );
            return Err(self.source.error(value.key_at, message));
        }
        Ok(())
    }

    fn value(
        &self,
        key: &'a Spanned<std::borrow::Cow<'a, str>>,
        value: &'a Spanned<DeValue<'a>>,
    ) -> Value<'a> {
        Value {
            source: self.source,
            key: key.get_ref(),
            component: None,
            key_at: key.span().start,
            at: value.span().start,
            end: value.span().end,
            node: value.get_ref(),
        }
    }
}

/// A value of the file and the key it belongs to.
#[derive(Clone, Copy)]
pub(crate) struct Value<'a> {
    source: &'a Source<'a>,
    /// The key.
    pub key: &'a str,
    /// Where the value is one component of a vector or colour: its letter.
    component: Option<char>,
    /// Byte offset of the key.
    pub key_at: usize,
    /// Byte offsets of the value and of what follows it.
    at: usize,
    end: usize,
    node: &'a DeValue<'a>,
}

impl<'a> Value<'a> {
    /// An error at the value.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.source.error(self.at, message)
    }

    /// An error at the key.
    pub fn key_error(&self, message: impl Into<String>) -> Error {
        self.source.error(self.key_at, message)
    }

    /// The key, with its component.
    pub fn name(&self) -> String {
        let key = quoted(self.key);
        let key = key.trim_matches('"');
        match self.component {
            Some(component) => format!("{component} of {key}"),
            None => key.to_owned(),
        }
    }

    fn not(&self, wanted: &str) -> Error {
        let kind = match self.node {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) => "a whole number",
            DeValue::Float(_) => "a number with a decimal point",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date or time",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        };
        self.error(format!(
            "{} must be {wanted}, and this is {kind}",
            self.name()
        ))
    }

    /// A finite number.
    pub fn number(&self) -> Result<f32> {
        let (text, number) = match self.node {
            // Straight to 32 bits: by way of 64 bits a decimal may be rounded twice.
            DeValue::Float(float) => (float.as_str(), float.as_str().parse().ok()),
            DeValue::Integer(integer) if integer.radix() == 10 => {
                (integer.as_str(), integer.as_str().parse().ok())
            }
            DeValue::Integer(integer) => {
                let exact = i128::from_str_radix(integer.as_str(), integer.radix());
                (integer.as_str(), exact.ok().map(|exact| exact as f32))
            }
            _ => return Err(self.not("a number")),
        };
        let text = quoted(text);
        let text = text.trim_matches('"');
        match number {
            Some(number) if f32::is_finite(number) => Ok(number),
            _ if text.ends_with("nan") || text.ends_with("inf") => Err(self.error(format!(
                "{} must be a finite number, and this is {text}",
                self.name()
            ))),
            _ => Err(self.error(format!(
                "{} = {text} is too large for a 32-bit float; stay within ±3.4e38",
                self.name()
            ))),
        }
    }

    /// A finite number that `accepts`; `wanted` says which those are.
    pub fn number_where(&self, wanted: &str, accepts: impl Fn(f32) -> bool) -> Result<f32> {
        let number = self.number()?;
        if accepts(number) {
            return Ok(number);
        }
        Err(self.error(format!(
            "{} must be {wanted}, and this is {number}",
            self.name()
        )))
    }

    /// A whole number in `min..=max`.
    pub fn integer(&self, min: u64, max: u64) -> Result<u64> {
        let DeValue::Integer(integer) = self.node else {
            return Err(self.not("a whole number without a decimal point"));
        };
        let value = u64::from_str_radix(integer.as_str(), integer.radix()).ok();
        value
            .filter(|value| (min..=max).contains(value))
            .ok_or_else(|| {
                let text = quoted(integer.as_str());
                self.error(format!(
                    "{} must be a whole number from {min} to {max}, and this is {}",
                    self.name(),
                    text.trim_matches('"')
                ))
            })
    }

    /// A whole number in `1..=max`.
    pub fn count(&self, max: u32) -> Result<u32> {
        Ok(self.integer(1, u64::from(max))? as u32)
    }

    /// `true` or `false`.
    pub fn flag(&self) -> Result<bool> {
        match self.node {
            DeValue::Boolean(flag) => Ok(*flag),
            _ => Err(self.not("true or false, without quotes")),
        }
    }

    /// A string.
    pub fn text(&self) -> Result<&'a str> {
        match self.node {
            DeValue::String(text) => Ok(text),
            _ => Err(self.not("a string in quotes")),
        }
    }

    /// A string that names one of several choices.
    pub fn choice<T: FromStr<Err = Error>>(&self) -> Result<T> {
        self.text()?
            .parse()
            .map_err(|error: Error| self.error(error.to_string()))
    }

    /// A name that must be among the `defined` ones of a `kind`; its index.
    pub fn reference(
        &self,
        kind: &str,
        defined: &std::collections::HashMap<&str, usize>,
    ) -> Result<usize> {
        let name = self.text()?;
        if let Some(&index) = defined.get(name) {
            return Ok(index);
        }
        let mut names: Vec<&str> = defined.keys().copied().collect();
        names.sort_unstable();
        let hint = did_you_mean(name, names.iter().copied());
        let remedy = match (hint.as_str(), names.as_slice()) {
            ("", []) => format!("; add [{kind}s.{}]", quoted(name)),
            ("", _) => format!("; defined are: {}", list(names)),
            (hint, _) => hint.to_owned(),
        };
        Err(self.error(format!("{kind} {} is not defined{remedy}", quoted(name))))
    }

    /// An item of a list.
    fn item(&self, item: &'a Spanned<DeValue<'a>>) -> Self {
        Self {
            at: item.span().start,
            end: item.span().end,
            node: item.get_ref(),
            ..*self
        }
    }

    /// The items of a list, at least one; the value itself where it is none.
    pub fn one_or_more(&self) -> Result<Vec<Self>> {
        match self.node {
            DeValue::Array(array) if array.is_empty() => Err(self.error(format!(
                "{} is an empty list; give it a value or remove it",
                self.name()
            ))),
            DeValue::Array(array) => Ok(array.iter().map(|item| self.item(item)).collect()),
            _ => Ok(vec![*self]),
        }
    }

    /// Where the value is.
    pub fn place(&self) -> Place {
        self.source.place(self.at)
    }

    /// The value as it is written.
    pub fn written(&self) -> &'a str {
        let text: &'a str = self.source.text;
        text.get(self.at..self.end).unwrap_or_default()
    }

    fn components(&self, letters: [char; 3], example: &str) -> Result<[Value<'a>; 3]> {
        match self.node {
            DeValue::Array(array) => match &array[..] {
                [a, b, c] => {
                    let component = |node: &'a Spanned<DeValue<'a>>, letter| Value {
                        component: Some(letter),
                        ..self.item(node)
                    };
                    Ok([
                        component(a, letters[0]),
                        component(b, letters[1]),
                        component(c, letters[2]),
                    ])
                }
                other => Err(self.error(format!(
                    "{} must have 3 numbers, as in {example}, and this has {}",
                    self.name(),
                    other.len()
                ))),
            },
            DeValue::Table(table) if table.contains_key("texture") => Err(self.error(format!(
                "{} takes no texture; give it as a colour, as in {example}",
                self.name()
            ))),
            _ => Err(self.not(&format!("a list of 3 numbers, as in {example}"))),
        }
    }

    /// Two numbers within ±1e9.
    pub fn pair(&self) -> Result<Vec2> {
        let DeValue::Array(array) = self.node else {
            return Err(self.not("a list of 2 numbers, as in [1.0, 1.0]"));
        };
        let [x, y] = &array[..] else {
            return Err(self.error(format!(
                "{} must have 2 numbers, as in [1.0, 1.0], and this has {}",
                self.name(),
                array.len()
            )));
        };
        let number = |node: &'a Spanned<DeValue<'a>>| {
            self.item(node)
                .number_where("within ±1e9", |x| x.abs() <= FARTHEST)
        };
        Ok(Vec2::new(number(x)?, number(y)?))
    }

    /// Whether it is a list.
    pub fn is_list(&self) -> bool {
        matches!(self.node, DeValue::Array(_))
    }

    /// Whether it is a table.
    pub fn is_table(&self) -> bool {
        matches!(self.node, DeValue::Table(_))
    }

    /// The value of a key, where it is a table that has it.
    pub fn entry(&self, key: &str) -> Option<Value<'a>> {
        self.table("").ok()?.get(key)
    }

    /// A point or vector of world space, near enough to be traced in 32-bit floats.
    pub fn point(&self) -> Result<Vec3> {
        let [x, y, z] = self.components(['x', 'y', 'z'], "[0.0, 1.0, 0.0]")?;
        let coordinate = |value: Value| value.number_where("within ±1e9", |x| x.abs() <= FARTHEST);
        Ok(Vec3::new(coordinate(x)?, coordinate(y)?, coordinate(z)?))
    }

    /// A radiance: three channels of at least 0.
    pub fn radiance(&self) -> Result<Rgb> {
        self.channels("[1.0, 1.0, 1.0]", |channel| {
            channel.number_where("at least 0", |value| value >= 0.0)
        })
    }

    /// A reflectance or albedo: three channels from 0 to 1.
    pub fn reflectance(&self) -> Result<Rgb> {
        self.channels("[0.8, 0.8, 0.8]", |channel| {
            channel.number_where(
                "from 0 to 1 (a surface reflects no more light than it gets)",
                |value| (0.0..=1.0).contains(&value),
            )
        })
    }

    fn channels(&self, example: &str, read: impl Fn(Value) -> Result<f32>) -> Result<Rgb> {
        let [r, g, b] = self.components(['r', 'g', 'b'], example)?;
        // + 0.0 turns −0 into 0.
        Ok(Rgb::new(read(r)? + 0.0, read(g)? + 0.0, read(b)? + 0.0))
    }

    /// A table; `example` is how to write it.
    pub fn table(&self, example: &str) -> Result<Table<'a>> {
        match self.node {
            DeValue::Table(entries) => Ok(Table {
                source: self.source,
                entries,
                at: self.at,
            }),
            _ => Err(self.not(&format!("a table, as in {example}"))),
        }
    }

    /// A list of tables; `example` is how to write one.
    pub fn tables(&self, example: &str) -> Result<Vec<Table<'a>>> {
        let DeValue::Array(array) = self.node else {
            return Err(self.not(&format!("a list of tables, each written {example}")));
        };
        array
            .iter()
            .map(|item| self.item(item).table(example))
            .collect()
    }
}
