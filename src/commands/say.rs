//! What the program says: results on standard output, the rest on standard error, neither with a panic when nobody can hear it.

use miette::{Result, miette};
use std::fmt::Display;
use std::io::{ErrorKind, Write};

/// A line on standard output. A reader that has gone has heard enough.
///
/// # Errors
/// The line cannot be written, for example because the disk is full: the result is lost, and that must show.
pub fn say(line: impl Display) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{}", printable(&line.to_string())).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let help = "give the output somewhere to go: another disk, a file, a pipe that reads on";
            Err(miette!(help = help, "cannot write to standard output: {error}"))
        }
        _ => Ok(()),
    }
}

/// A line on standard error, for whoever looks on; nothing is lost when nobody does.
pub fn note(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&line.to_string()));
}

/// The text without what a terminal would obey: a title may hold any character.
pub(super) fn printable(text: &str) -> String {
    text.chars().filter(|&c| !c.is_control() || c == '\n' || c == '\t').collect()
}
