//! What was left out or replaced: a line for each kind of thing, where it came first.

use super::lexer::At;
use super::names::quoted;
use super::parameters::Parameters;
use std::collections::HashSet;

/// The lines so far.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    seen: HashSet<String>,
    /// In the order they came up.
    pub lines: Vec<String>,
}

impl Warnings {
    /// Tells it, with its place, unless it was told before.
    pub fn tell(&mut self, at: &At, message: impl Into<String>) {
        let message = message.into();
        self.tell_once(message.clone(), at, || message);
    }

    /// Tells the first of a kind.
    pub fn tell_once(&mut self, kind: String, at: &At, message: impl FnOnce() -> String) {
        if self.seen.insert(kind) {
            let place = at.place();
            self.lines.push(format!("{place}: {}", message()));
        }
    }

    /// Tells of parameters that nothing asked for, once for all of the same `owner`.
    pub fn tell_unused(&mut self, parameters: &Parameters, owner: &str) {
        for parameter in parameters.unused() {
            let message = format!("{} of {owner} is not used", quoted(&parameter.name));
            self.tell(&parameter.at, message);
        }
    }
}
