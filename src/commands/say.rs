//! Output of the program: results on standard output, everything else on standard error; a closed
//! stream never causes a panic.

use miette::{Result, miette};
use std::fmt::Display;
use std::io::{ErrorKind, Write};

/// Prints a line on standard output; a closed pipe is not an error.
///
/// # Errors
/// The line cannot be written, for example because the disk is full: the result would be lost
/// silently.
pub fn say(line: impl Display) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{}", printable(&line.to_string())).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let help = "redirect the output to another disk, a file or a pipe that is read to its end";
            Err(miette!(help = help, "cannot write to standard output: {error}"))
        }
        _ => Ok(()),
    }
}

/// Prints a line on standard error; failures are ignored, as no result is lost with it.
pub fn note(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&line.to_string()));
}

/// Prints a formatted line on standard output, as the function of this name does.
macro_rules! say {
    ($($part:tt)+) => { $crate::commands::say::say(format_args!($($part)+)) };
}

/// Prints a formatted line on standard error.
macro_rules! note {
    ($($part:tt)+) => { $crate::commands::say::note(format_args!($($part)+)) };
}

/// Removes the control characters that a terminal would execute: a title may contain any character.
pub(super) fn printable(text: &str) -> String {
    text.chars().filter(|&c| !c.is_control() || c == '\n' || c == '\t').collect()
}
