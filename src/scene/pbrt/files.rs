//! The files that a scene is made of: the stack of includes, where names lead, and the hash over all that was read.

use super::lexer::{At, Kind, Lexer, Source, Token};
use super::names::quoted;
use crate::error::{Error, Result};
use crate::scene::hash;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Greatest size of the text of a file, bytes.
const LARGEST: u64 = 1 << 30;
/// Deepest chain of includes.
const DEEPEST: usize = 64;
/// Most files that a scene may include: a few that include each other twice would never end.
const MOST: usize = 100_000;

/// A file that is being read.
#[derive(Debug)]
struct Open {
    lexer: Lexer,
    path: PathBuf,
    /// The `Import` that named it: what it sets ends with it.
    import: Option<At>,
}

/// What the end of a file means.
pub(super) enum Next {
    /// A token.
    Token(Token),
    /// A file is at its end that was imported here.
    EndOfImport(At),
    /// Everything was read.
    End,
}

/// The stack of includes.
pub(super) struct Files {
    stack: Vec<Open>,
    /// The token that was looked at and not taken.
    ahead: Option<Token>,
    /// Names of files are relative to that of the scene file (pbrt-v4, `SetSearchDirectory`).
    folder: PathBuf,
    hasher: Sha256,
    count: usize,
}

impl Files {
    /// Opens the scene file.
    pub fn open(path: &Path) -> Result<Self> {
        let mut files = Self {
            stack: Vec::new(),
            ahead: None,
            folder: path.parent().map(Path::to_owned).unwrap_or_default(),
            hasher: Sha256::new(),
            count: 0,
        };
        files.push(path.to_owned(), None)?;
        Ok(files)
    }

    fn push(&mut self, path: PathBuf, import: Option<At>) -> Result<()> {
        let text = self.text(&path)?;
        self.stack.push(Open {
            lexer: Lexer::new(Source {
                file: path.display().to_string(),
                text,
            }),
            path,
            import,
        });
        Ok(())
    }

    /// The text of a file, unpacked where its name ends with `.gz`.
    fn text(&mut self, path: &Path) -> Result<String> {
        let cannot_read = |source| Error::Read {
            path: path.to_owned(),
            source,
        };
        let file = File::open(path).map_err(cannot_read)?;
        let mut bytes = Vec::new();
        let mut limited: Box<dyn Read> = if is_packed(path) {
            Box::new(flate2::read::MultiGzDecoder::new(file).take(LARGEST + 1))
        } else {
            Box::new(file.take(LARGEST + 1))
        };
        limited.read_to_end(&mut bytes).map_err(cannot_read)?;
        if bytes.len() as u64 > LARGEST {
            let message =
                "is larger than 1 GiB; write its meshes as .ply files, and split it by Include";
            return Err(Error::format(path, message));
        }
        self.hasher.update(&bytes);
        // Comments in any encoding do no harm.
        Ok(match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => String::from_utf8_lossy(error.as_bytes()).into_owned(),
        })
    }

    /// Reads a file at this place of the one that names it.
    pub fn include(&mut self, name: &str, at: &At, import: bool) -> Result<()> {
        let path = self.path(name);
        let same = |open: &Open| match (open.path.canonicalize(), path.canonicalize()) {
            (Ok(a), Ok(b)) => a == b,
            _ => open.path == path,
        };
        if let Some(first) = self.stack.iter().position(same) {
            let mut chain = String::new();
            for open in self.stack.iter().skip(first) {
                let _ = write!(chain, "{} includes ", open.lexer.file());
            }
            return Err(at.error(format!(
                "{chain}{}: this would never end; remove one of these includes",
                path.display()
            )));
        }
        if self.stack.len() >= DEEPEST {
            return Err(at.error(format!(
                "includes are nested more than {DEEPEST} deep; include fewer levels"
            )));
        }
        self.count += 1;
        if self.count > MOST {
            return Err(at.error(format!(
                "the scene includes more than {MOST} files; join some of them"
            )));
        }
        self.push(path, import.then(|| at.clone()))
            .map_err(|error| match error {
                Error::Scene { .. } => error,
                error => at.error(format!("cannot include {}: {error}", quoted(name))),
            })
    }

    /// Where a file name leads.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Adds a file that is decoded elsewhere to the hash.
    pub fn hash(&mut self, path: &Path) -> std::io::Result<()> {
        hash::add_file(path, &mut self.hasher)
    }

    /// SHA-256 over everything read, in hexadecimal.
    pub fn digest(&self) -> String {
        hash::finish(self.hasher.clone())
    }

    /// The next token of the innermost file, or what has come to its end.
    pub fn next(&mut self) -> Result<Next> {
        if let Some(token) = self.ahead.take() {
            return Ok(Next::Token(token));
        }
        while let Some(open) = self.stack.last_mut() {
            if let Some(token) = open.lexer.next()? {
                return Ok(Next::Token(token));
            }
            let import = open.import.take();
            self.stack.pop();
            if let Some(at) = import {
                return Ok(Next::EndOfImport(at));
            }
        }
        Ok(Next::End)
    }

    /// The next token of the same file, if it is of a kind that is wanted; else it stays.
    pub fn next_if(&mut self, wanted: impl Fn(&Token) -> bool) -> Result<Option<Token>> {
        if let (None, Some(open)) = (&self.ahead, self.stack.last_mut()) {
            self.ahead = open.lexer.next()?;
        }
        Ok(self.ahead.take_if(|token| wanted(token)))
    }

    /// The quoted text that a directive needs.
    pub fn text_after(&mut self, directive: &Token, example: &str) -> Result<Token> {
        self.next_if(|token| token.kind == Kind::Text)?
            .ok_or_else(|| {
                directive.error(format!(
                    "{} needs a text in quotes; write {example}",
                    directive.raw()
                ))
            })
    }

    /// The numbers that a directive needs, in brackets or not.
    pub fn numbers_after<const N: usize>(
        &mut self,
        directive: &Token,
        example: &str,
    ) -> Result<[f64; N]> {
        let short = |directive: &Token| {
            directive.error(format!(
                "{} needs {N} numbers; write {example}",
                directive.raw()
            ))
        };
        let bracket = self.next_if(|token| token.kind == Kind::Open)?.is_some();
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let token = self
                .next_if(|token| token.kind == Kind::Word)?
                .ok_or_else(|| short(directive))?;
            *number = finite(&token)?;
        }
        if bracket && self.next_if(|token| token.kind == Kind::Close)?.is_none() {
            return Err(short(directive));
        }
        Ok(numbers)
    }
}

fn is_packed(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gz"))
}

/// A finite number.
pub(super) fn finite(token: &Token) -> Result<f64> {
    match token.raw().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(token.error(format!("{} is not a finite number", quoted(token.raw())))),
    }
}
