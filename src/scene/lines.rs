//! Lines of text files that may be anything.

use std::borrow::Cow;
use std::io::{BufRead, Read};

/// Longest line, bytes: what is longer is no text.
pub(super) const LONGEST: u64 = 1 << 20;

/// Reads lines one at a time and counts them.
pub(super) struct Lines<R> {
    source: R,
    /// The line read last, from 1.
    pub number: usize,
    text: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    /// Goes on after line `number`.
    pub fn after(number: usize, source: R) -> Self {
        Self {
            source,
            number,
            text: Vec::new(),
        }
    }

    /// What the lines are read from.
    pub fn source(&mut self) -> &mut R {
        &mut self.source
    }

    /// The next line, `None` at the end of the file. What is no UTF-8 is replaced: it stands in names and comments.
    pub fn next(&mut self) -> Result<Option<Cow<'_, str>>, String> {
        self.text.clear();
        self.number += 1;
        let mut line = self.source.by_ref().take(LONGEST);
        match line.read_until(b'\n', &mut self.text) {
            Ok(0) => Ok(None),
            Ok(length) if length as u64 == LONGEST => {
                Err("the line is longer than 1 MiB; export the file again".to_owned())
            }
            Ok(_) => Ok(Some(String::from_utf8_lossy(&self.text))),
            Err(error) => Err(format!("cannot read: {error}")),
        }
    }
}
