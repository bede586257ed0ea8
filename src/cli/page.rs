//! What pages have in common: one file each, that needs no network and runs nothing but its own.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use sha2::{Digest, Sha256};
use std::io::{self, Write};

/// Colours, headings, tables.
pub(super) const STYLE: &str = include_str!("page/base.css");

/// A template, with what stands at `{{name}}` put in. Nothing that is put in is read again.
pub(super) fn fill(
    to: &mut impl Write,
    template: &str,
    part: impl Fn(&str) -> String,
) -> io::Result<()> {
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        to.write_all(before.as_bytes())?;
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        to.write_all(part(name).as_bytes())?;
        rest = after;
    }
    to.write_all(rest.as_bytes())
}

/// A source of the content security policy: this text and no other.
pub(super) fn policy(text: &str) -> String {
    format!(
        "'sha256-{}'",
        BASE64_STANDARD.encode(Sha256::digest(text.as_bytes()))
    )
}

/// Text as HTML.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_and_nothing_else() {
        assert_eq!(escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
    }

    #[test]
    fn what_is_put_in_is_not_read_again() {
        let mut page = Vec::new();
        let part = |name: &str| format!("[{name}{{{{b}}}}]");
        fill(&mut page, "x{{a}}y{{b", part).unwrap();
        assert_eq!(String::from_utf8(page).unwrap(), "x[a{{b}}]y[b{{b}}]");
    }
}
