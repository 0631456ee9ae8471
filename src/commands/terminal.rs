//! The program and its terminal: results on standard output, everything else on standard error; the
//! command line that was typed; Ctrl-C, whose first stops cleanly and whose second at once. A
//! closed stream never causes a panic.

use inkwave::store::marker::shell_word;
use miette::{Result, miette};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
#[cfg(unix)]
use std::time::Duration;

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
    ($($part:tt)+) => { $crate::commands::terminal::say(format_args!($($part)+)) };
}

/// Prints a formatted line on standard error.
macro_rules! note {
    ($($part:tt)+) => { $crate::commands::terminal::note(format_args!($($part)+)) };
}

/// Removes the control characters that a terminal would execute: a title may contain any character.
pub(super) fn printable(text: &str) -> String {
    text.chars().filter(|&c| !c.is_control() || c == '\n' || c == '\t').collect()
}

/// The whole command line, quoted for a shell where that is needed.
pub fn this_command() -> String {
    std::env::args_os().map(|word| shell_word(&word.to_string_lossy())).collect::<Vec<_>>().join(" ")
}

/// How to go on after a stop.
pub fn to_resume() -> String {
    format!("to resume: {}", this_command())
}

/// Exit code of a program ended by Ctrl-C (128 + SIGINT).
const INTERRUPTED: i32 = 130;

/// Raised when the user has asked to stop.
#[derive(Clone, Debug, Default)]
pub struct StopFlag {
    raised: Arc<AtomicBool>,
    /// Whether nothing would be lost if the program ended now: no solve is under way, every
    /// finished one is stored, and files are written whole or not at all.
    at_once: Arc<AtomicBool>,
}

impl StopFlag {
    /// Listens for Ctrl-C and for a request to terminate. Where the system refuses, Ctrl-C ends the
    /// program at once; finished points are safe then, too.
    pub fn listen() -> Self {
        let flag = Self::default();
        let heard = flag.clone();
        if let Err(error) = ctrlc::set_handler(move || heard.interrupt()) {
            note!("Ctrl-C will end the program at once ({error}).");
        }
        #[cfg(unix)]
        if std::env::var_os("INKWAVE_ENDS_WITH_PARENT").is_some() {
            let orphan = flag.clone();
            std::thread::spawn(move || orphan.stop_without_parent());
        }
        flag
    }

    /// Stops the program when the one that started it is gone, such as a notebook's kernel that
    /// was restarted, and that would read the results.
    #[cfg(unix)]
    fn stop_without_parent(&self) {
        use std::os::unix::process::parent_id;
        let parent = parent_id();
        while parent_id() == parent {
            std::thread::sleep(Duration::from_secs(1));
        }
        if !self.is_raised() {
            self.interrupt();
        }
    }

    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::SeqCst)
    }

    /// Says whether a request to stop may end the program at once: while numbers are made of stored
    /// solves, drawn and written, and not while solves are under way.
    pub fn end_at_once(&self, at_once: bool) {
        self.at_once.store(at_once, Ordering::SeqCst);
    }

    /// Raises the flag, or ends the program if it is already raised or nothing would be lost.
    fn interrupt(&self) {
        if self.raised.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
        if self.at_once.load(Ordering::SeqCst) {
            note!("\nStopped; everything solved is kept. {}", to_resume());
            std::process::exit(INTERRUPTED);
        }
        note!("\nStopping after the current step; press Ctrl-C again to quit at once.");
    }
}
