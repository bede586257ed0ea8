//! Names in messages.

pub(super) use crate::scene::toml::names::{did_you_mean, list, quoted};

/// `material "rde" is not defined; did you mean "red"?`, or what to do where no name is near.
pub(super) fn undefined<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    remedy: &str,
) -> String {
    // In an order of their own: equal distances must not give different messages.
    let mut known: Vec<&str> = known.into_iter().collect();
    known.sort_unstable();
    let hint = did_you_mean(name, known);
    let name = quoted(name);
    if hint.is_empty() {
        format!("{what} {name} is not defined; {remedy}")
    } else {
        format!("{what} {name} is not defined{hint}")
    }
}
