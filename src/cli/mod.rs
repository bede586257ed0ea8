//! Floor 7: the command line. Raw arguments become validated settings, and those a command.
//!
//! Results go to stdout; progress and messages to stderr. Exit codes: 0 done, 1 the answer is no or a job failed, 2 bad input or usage, 130 interrupted.

mod args;
mod bars;
mod batch;
mod bench;
mod compare;
mod dump;
mod info;
mod info_image;
mod info_scene;
mod interrupt;
mod memory;
mod merge;
mod outputs;
mod page;
mod plot;
mod progress;
mod rays;
mod render;
mod report;
mod scenes;
mod sh;
mod target;
#[cfg(feature = "view")]
mod view;

use crate::error::Result;
use args::{Arguments, Command};
use clap::Parser;
use clap::error::ErrorKind;
use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

/// What a command ends with, where it is no error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Done,
    /// The answer is no.
    Differs,
    Interrupted,
}

/// The exit code of an answer that is no.
const DIFFERS: u8 = 1;
/// The exit code of bad input and of wrong usage.
const BAD_INPUT: u8 = 2;
/// The exit code of a program that Ctrl-C ended: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

/// Runs the program; `args` begins with its name. Never panics on what a user types.
pub fn run(args: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    // Before anything eight lanes wide.
    match target::check() {
        Err(message) => return fail(message),
        Ok(Some(advice)) => say(format_args!("warning: {advice}")),
        Ok(None) => {}
    }
    let arguments = match Arguments::try_parse_from(args) {
        Ok(arguments) => arguments,
        Err(error) => return explain(&error),
    };
    let outcome = match &arguments.command {
        Command::Render(args) => render::run(args),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args),
        Command::Batch(args) => batch::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Info(args) => info::run(args),
        Command::Rays(args) => rays::run(args),
        Command::Sh(command) => sh::run(command),
        Command::Scenes(args) => scenes::run(args),
        Command::Dump(args) => dump::run(args),
        Command::Bench(args) => bench::run(args),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Differs) => ExitCode::from(DIFFERS),
        Ok(Outcome::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) => fail(error),
    }
}

fn fail(message: impl std::fmt::Display) -> ExitCode {
    say(format_args!("error: {message}"));
    ExitCode::from(BAD_INPUT)
}

/// What clap found wrong; or help and version, which it calls errors too.
fn explain(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            // A closed pipe is no reason to complain.
            let _ = error.print();
        }
        // Its own parser's message says what to write instead.
        ErrorKind::ValueValidation => say(in_one_line(&error.to_string())),
        _ => say(in_one_line(&error.to_string()) + "; try --help"),
    }
    u8::try_from(error.exit_code()).map_or(ExitCode::from(BAD_INPUT), ExitCode::from)
}

/// The paragraphs of an error of clap's, but for the usage at its end, as one line like any other error.
fn in_one_line(text: &str) -> String {
    let mut line = String::new();
    let paragraphs = text
        .lines()
        .map(str::trim)
        .take_while(|part| !part.starts_with("Usage:") && !part.starts_with("For more information"))
        .filter(|part| !part.is_empty());
    for part in paragraphs {
        let continues = part.starts_with('[') || line.ends_with(':') || line.is_empty();
        line += match (line.is_empty(), continues) {
            (true, _) => "",
            (false, true) => " ",
            (false, false) => "; ",
        };
        line += part.strip_prefix("tip: ").unwrap_or(part);
    }
    line
}

/// A message on stderr. Where nobody can read it, nothing is lost by going on.
fn say(message: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{message}");
}

/// Text on stdout. A reader that has gone away (`| head`) has had enough: no error.
///
/// # Errors
/// [`Error::Write`](crate::error::Error::Write) where stdout cannot take it, as on a full disk.
fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(crate::error::Error::Usage(format!(
                "stdout cannot be written: {source}; send it elsewhere"
            )))
        }
        _ => Ok(()),
    }
}

/// One JSON object on stdout.
fn print_json(value: &impl serde::Serialize) -> Result<()> {
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|error| crate::error::Error::Usage(format!("no JSON can be made: {error}")))?;
    text.push('\n');
    print(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_several_paragraphs_becomes_a_line() {
        let text = "error: invalid value 'cosin' for '--strategy'\n  [possible values: cosine, mis]\n\n  tip: a \
                    similar value exists: 'cosine'\n\nFor more information, try '--help'.\n";
        assert_eq!(
            in_one_line(text),
            "error: invalid value 'cosin' for '--strategy' [possible values: cosine, mis]; a similar value exists: \
             'cosine'"
        );
        let text = "error: these were not provided:\n  <SCENE>\n\nUsage: ondine render <SCENE>\n";
        assert_eq!(in_one_line(text), "error: these were not provided: <SCENE>");
    }
}
