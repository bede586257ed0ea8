//! Floor 0: what can go wrong, each with place and remedy. Every one of these ends a command with exit code 2.

use std::path::{Path, PathBuf};

/// A place in a text file; line and column count from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it, or `built-in scene NAME`.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Place {
    /// That of a byte offset in a text; one past the end is the end.
    pub fn of(file: &str, text: &str, offset: usize) -> Self {
        let mut offset = offset.min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &text[..offset];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        // Editors do not count a byte order mark as a column.
        let line = before[line_start..].trim_start_matches('\u{feff}');
        Self {
            file: file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: line.chars().count() + 1,
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// What went wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene or a job file says something that cannot be rendered.
    #[error("{place}: {message}")]
    Scene {
        /// Where.
        place: Place,
        /// What, and what to do.
        message: String,
    },
    /// A file could not be read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The file as the user named it.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// A file could not be written; nothing is left at `path`.
    #[error("{}: cannot write: {source}; nothing was written there", path.display())]
    Write {
        /// The file as the user named it.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// A file was read but is not what it should be.
    #[error("{}: {message}", path.display())]
    Format {
        /// The file as the user named it.
        path: PathBuf,
        /// What, and what to do.
        message: String,
    },
    /// An argument or setting is out of its range.
    #[error("{0}")]
    Usage(String),
}

/// The result of everything here that can fail.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A file's content is wrong.
    pub fn format(path: &Path, message: impl Into<String>) -> Self {
        Self::Format {
            path: path.to_owned(),
            message: message.into(),
        }
    }
}
