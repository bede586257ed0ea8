//! Text to tokens: words, quoted texts, numbers and brackets, each with its place.

use crate::error::{Error, Place};
use std::ops::Range;
use std::sync::Arc;

/// A file that was read.
#[derive(Debug)]
pub(super) struct Source {
    /// As errors name it.
    pub file: String,
    /// Its whole text.
    pub text: String,
}

/// A place in a file; line and column are counted only when they are told.
#[derive(Clone, Debug)]
pub(super) struct At {
    source: Arc<Source>,
    offset: usize,
}

impl At {
    /// Line and column.
    pub fn place(&self) -> Place {
        Place::of(&self.source.file, &self.source.text, self.offset)
    }

    /// An error here.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::Scene {
            place: self.place(),
            message: message.into(),
        }
    }
}

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `"in quotes"`.
    Text,
    /// `[`.
    Open,
    /// `]`.
    Close,
    /// Anything else up to a blank: a directive, a number, `true`.
    Word,
}

/// A token of a file.
#[derive(Clone, Debug)]
pub(super) struct Token {
    source: Arc<Source>,
    /// What it is.
    pub kind: Kind,
    range: Range<usize>,
}

impl Token {
    /// As it stands in the file, without quotes; escapes are not resolved.
    pub fn raw(&self) -> &str {
        &self.source.text[self.range.clone()]
    }

    /// The text that a quoted token means.
    pub fn unescaped(&self) -> String {
        let mut text = String::with_capacity(self.range.len());
        let mut characters = self.raw().chars();
        while let Some(c) = characters.next() {
            text.push(match c {
                '\\' => match characters.next() {
                    Some('n') => '\n',
                    Some('t') => '\t',
                    Some('r') => '\r',
                    Some(other) => other,
                    None => '\\',
                },
                c => c,
            });
        }
        text
    }

    /// Where it begins.
    pub fn at(&self) -> At {
        At {
            source: Arc::clone(&self.source),
            // The quote belongs to a text.
            offset: self.range.start - usize::from(self.kind == Kind::Text),
        }
    }

    /// An error at this token.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.at().error(message)
    }
}

/// The tokens of a file.
#[derive(Debug)]
pub(super) struct Lexer {
    source: Arc<Source>,
    offset: usize,
}

impl Lexer {
    /// From the start of a file.
    pub fn new(source: Source) -> Self {
        Self {
            source: Arc::new(source),
            offset: 0,
        }
    }

    /// The file, as errors name it.
    pub fn file(&self) -> &str {
        &self.source.file
    }

    /// The next token; none at the end of the file.
    ///
    /// # Errors
    /// A text whose closing quote is missing.
    pub fn next(&mut self) -> Result<Option<Token>, Error> {
        let bytes = self.source.text.as_bytes();
        let find = |from: usize, what: &dyn Fn(u8) -> bool| {
            let rest = bytes.get(from..).unwrap_or_default();
            rest.iter()
                .position(|&byte| what(byte))
                .map_or(bytes.len(), |length| from + length)
        };
        let mut start = find(self.offset, &|byte| !byte.is_ascii_whitespace());
        while bytes.get(start) == Some(&b'#') {
            let line_end = find(start, &|byte| byte == b'\n');
            start = find(line_end, &|byte| !byte.is_ascii_whitespace());
        }
        let Some(&first) = bytes.get(start) else {
            self.offset = start;
            return Ok(None);
        };
        let (kind, range, end) = match first {
            b'[' => (Kind::Open, start..start + 1, start + 1),
            b']' => (Kind::Close, start..start + 1, start + 1),
            b'"' => {
                let end = closing_quote(bytes, start + 1).ok_or_else(|| {
                    let at = At {
                        source: Arc::clone(&self.source),
                        offset: start,
                    };
                    at.error("this text has no closing quote on its line; add it")
                })?;
                (Kind::Text, start + 1..end, end + 1)
            }
            _ => {
                let end = find(start, &|byte| {
                    byte.is_ascii_whitespace() || matches!(byte, b'"' | b'[' | b']' | b'#')
                });
                (Kind::Word, start..end, end)
            }
        };
        self.offset = end;
        Ok(Some(Token {
            source: Arc::clone(&self.source),
            kind,
            range,
        }))
    }
}

/// The quote that ends a text whose content begins at `from`; none on this line.
fn closing_quote(bytes: &[u8], from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        match bytes.get(at)? {
            b'"' => return Some(at),
            b'\n' => return None,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
}
