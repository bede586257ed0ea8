//! `ondine scenes`: the built-in scenes.

use super::Outcome;
use super::args::ScenesArgs;
use crate::error::{Error, Result};
use crate::scene::builtin;
use crate::scene::toml::names;

pub(super) fn run(args: &ScenesArgs) -> Result<Outcome> {
    match &args.name {
        None => super::print(&list())?,
        Some(name) => {
            let scene = builtin::find(name).ok_or_else(|| unknown(name))?;
            super::print(scene.text)?;
        }
    }
    Ok(Outcome::Done)
}

fn list() -> String {
    let width = builtin::ALL
        .iter()
        .map(|scene| scene.name.len())
        .max()
        .unwrap_or(0);
    builtin::ALL
        .iter()
        .map(|scene| format!("{:width$}  {}\n", scene.name, scene.title()))
        .collect()
}

fn unknown(name: &str) -> Error {
    let known = || builtin::ALL.iter().map(|scene| scene.name);
    let hint = match names::did_you_mean(name, known()) {
        hint if hint.is_empty() => ".".to_owned(),
        hint => hint,
    };
    Error::Usage(format!(
        "there is no built-in scene {}{hint} Built-in scenes: {}",
        names::quoted(name),
        names::list(known())
    ))
}
