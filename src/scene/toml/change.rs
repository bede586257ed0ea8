//! Changes of a text of TOML before it is read: other values for some of its keys.

use super::names::{did_you_mean, list, quoted};
use crate::error::{Error, Result};
use std::str::FromStr;
use std::sync::Arc;
use toml_edit::{DocumentMut, Item, Key, TableLike, Value};

/// The tables whose keys are names that the author chose: what is not there cannot be changed.
const NAMED: [&str; 2] = ["materials", "cameras"];

/// Another value for a key of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The key, a dotted path: `materials.ball.roughness`, `lights.0.radiance`.
    pub key: String,
    /// The value, as TOML; a word that is none is a text.
    pub value: String,
    /// Who asks for it: what errors begin with, such as `--set KEY=VALUE`.
    pub origin: String,
}

impl Change {
    /// From `KEY=VALUE`; whether a scene has such a key is only known with the scene.
    ///
    /// # Errors
    /// [`Error::Usage`] where it has no `=`, the key is no path or the value no TOML.
    pub fn parse(text: &str) -> Result<Self> {
        // A name in quotes may have one itself.
        let mut splits = text.match_indices('=').map(|(at, _)| text.split_at(at));
        let is_key = |(key, _): &(&str, &str)| Key::parse(key).is_ok();
        let split = splits.find(is_key).map(|(key, value)| (key, &value[1..]));
        let (key, value) = split.or_else(|| text.split_once('=')).ok_or_else(|| {
            Error::Usage(format!(
                "--set {text} has no value; write KEY=VALUE, as in materials.ball.roughness=0.2"
            ))
        })?;
        let change = Self {
            key: key.trim().to_owned(),
            value: value.trim().to_owned(),
            origin: format!("--set {text}"),
        };
        change.check()?;
        Ok(change)
    }

    /// Whether key and value can be read at all.
    ///
    /// # Errors
    /// [`Error::Usage`], with the origin.
    pub fn check(&self) -> Result<()> {
        self.path()?;
        self.toml().map(drop)
    }

    /// The key, part by part: the same however it is quoted.
    ///
    /// # Errors
    /// [`Error::Usage`], with the origin, where it is no path.
    pub fn names(&self) -> Result<Vec<String>> {
        let path = self.path()?;
        Ok(path.iter().map(|key| key.get().to_owned()).collect())
    }

    fn path(&self) -> Result<Vec<Key>> {
        Key::parse(&self.key).map_err(|_| {
            self.error(format!(
                "{} is no key; write names with dots between, and quotes around a name with blanks or dots, as in materials.\"dark wood\".albedo",
                quoted(&self.key)
            ))
        })
    }

    fn toml(&self) -> Result<Value> {
        let is_word = |text: &str| {
            let mut letters = text.chars();
            letters.next().is_some_and(char::is_alphabetic)
                && letters.all(|c| c.is_alphanumeric() || "_-./".contains(c))
        };
        match Value::from_str(&self.value) {
            Ok(value) => Ok(value),
            Err(_) if is_word(&self.value) => Ok(self.value.as_str().into()),
            Err(_) => Err(self.error(format!(
                "{} is no value of TOML; write a number, true, [1.0, 2.0, 3.0] or \"text\"",
                quoted(&self.value)
            ))),
        }
    }

    /// An error that begins with the origin.
    pub(super) fn error(&self, message: impl std::fmt::Display) -> Error {
        Error::Usage(format!("{}: {message}", self.origin))
    }
}

/// A change, and the key that it changes, part by part.
pub(super) type Edit = (Arc<Change>, Vec<String>);

/// The text of a scene with all of the changes made, in their order; nothing else of it is touched.
///
/// # Errors
/// [`Error::Usage`] with a change's origin where the scene has no such place. Text that is no TOML comes back as it is: whoever
/// reads it says what is wrong.
pub(super) fn apply(text: &str, file: &str, edits: &[Edit]) -> Result<String> {
    let Ok(mut document) = text.parse::<DocumentMut>() else {
        return Ok(text.to_owned());
    };
    for (change, names) in edits {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let value = change.toml()?;
        set(document.as_item_mut(), &names, 0, value)
            .map_err(|message| change.error(format!("{file}: {message}")))?;
    }
    Ok(document.to_string())
}

/// What an error of reading a changed scene says: it may be the changes' fault.
pub(super) fn blame<'a>(error: Error, changes: impl Iterator<Item = &'a Change>) -> Error {
    let mut origins: Vec<&str> = changes.map(|change| change.origin.as_str()).collect();
    origins.dedup();
    Error::Usage(format!("{}: {error}", origins.join(", ")))
}

/// That a table has no such name.
pub(super) fn unknown<'a>(
    name: &str,
    owner: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> String {
    let hint = did_you_mean(name, known.clone());
    let there_are = match hint.as_str() {
        "" => "; there are:",
        _ => " There are:",
    };
    format!(
        "there is no {} in {owner}{hint}{there_are} {}",
        quoted(name),
        list(known)
    )
}

/// That a table is changed key by key.
pub(super) fn is_table<'a>(owner: &str, keys: impl Iterator<Item = &'a str>) -> String {
    format!("{owner} is a table; change one of its keys: {}", list(keys))
}

/// Sets `names[depth..]` of an item; what is wrong otherwise.
fn set(
    item: &mut Item,
    names: &[&str],
    depth: usize,
    value: Value,
) -> std::result::Result<(), String> {
    let Some(&name) = names.get(depth) else {
        replace(item, value);
        return Ok(());
    };
    let owner = match depth {
        0 => "the scene".to_owned(),
        _ => names[..depth].join("."),
    };
    match item {
        Item::ArrayOfTables(tables) => {
            let length = tables.len();
            let index = index(name, length, &owner)?;
            let table = tables.get_mut(index);
            let table = table.ok_or_else(|| beyond(name, length, &owner))?;
            match names.len() - depth {
                1 => Err(is_table(
                    &format!("{owner}.{name}"),
                    table.iter().map(|(key, _)| key),
                )),
                _ => set_in(table, names, depth + 1, value),
            }
        }
        Item::Value(Value::Array(array)) => {
            let length = array.len();
            let index = index(name, length, &owner)?;
            let inner = array.get_mut(index);
            let inner = inner.ok_or_else(|| beyond(name, length, &owner))?;
            // Down by way of an item, as everywhere; back in its place afterwards.
            let mut item = Item::Value(inner.clone());
            set(&mut item, names, depth + 1, value)?;
            if let Item::Value(changed) = item {
                *inner = changed;
            }
            Ok(())
        }
        other => match other.as_table_like_mut() {
            Some(table) => set_in(table, names, depth, value),
            None => Err(format!(
                "{owner} is a single value and has no {}; set {owner} itself",
                quoted(name)
            )),
        },
    }
}

/// The same, of a table.
fn set_in(
    table: &mut dyn TableLike,
    names: &[&str],
    depth: usize,
    value: Value,
) -> std::result::Result<(), String> {
    let name = names[depth];
    let last = depth + 1 == names.len();
    if let Some(item) = table.get_mut(name) {
        return set(item, names, depth + 1, value);
    }
    if depth == 1 && NAMED.contains(&names[0]) {
        let known: Vec<&str> = table.iter().map(|(key, _)| key).collect();
        return Err(unknown(name, names[0], known.into_iter()));
    }
    if depth == 0 && NAMED.contains(&name) {
        return Err(format!(
            "the scene has no {name}; it has: {}",
            list(table.iter().map(|(key, _)| key))
        ));
    }
    let mut item = match last {
        true => Item::Value(value.clone()),
        false => Item::Value(Value::InlineTable(Default::default())),
    };
    if !last {
        set(&mut item, names, depth + 1, value)?;
    }
    table.insert(name, item);
    Ok(())
}

/// Puts a value in the place of what was there, with the blanks and comments around it.
fn replace(item: &mut Item, mut value: Value) {
    if let Item::Value(old) = item {
        *value.decor_mut() = old.decor().clone();
    }
    *item = Item::Value(value);
}

fn index(name: &str, length: usize, owner: &str) -> std::result::Result<usize, String> {
    name.parse().map_err(|_| {
        format!(
            "{owner} is a list, and {} is no place in it; write {owner}.0 {}",
            quoted(name),
            upwards(length)
        )
    })
}

fn beyond(name: &str, length: usize, owner: &str) -> String {
    match length {
        0 => format!("{owner} is empty, and has no {name}"),
        _ => format!("{owner} has no {name}; write {owner}.0 {}", upwards(length)),
    }
}

fn upwards(length: usize) -> String {
    match length {
        0 | 1 => "(its only one)".to_owned(),
        _ => format!("to {}", length - 1),
    }
}
