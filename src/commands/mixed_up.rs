//! Recognises files meant for another command.

use inkwave::input::fault::StudyError;
use inkwave::input::tree::parse_toml;
use miette::{Report, miette};

/// Kind of file that a command reads.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `inkwave run`
    Study,
    /// `inkwave sweep`
    Sweep,
}

impl Kind {
    /// The kind of a file, by tables that only one kind has.
    fn of(text: &str) -> Option<Self> {
        let table = parse_toml(text).ok()?;
        let has = |keys: &[&str]| keys.iter().any(|key| table.contains_key(*key));
        match (has(&["layer", "pigment"]), has(&["base", "axis"])) {
            (true, false) => Some(Self::Study),
            (false, true) => Some(Self::Sweep),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Study => "study",
            Self::Sweep => "sweep",
        }
    }

    fn command(self) -> &'static str {
        match self {
            Self::Study => "run",
            Self::Sweep => "sweep",
        }
    }
}

/// Error for a file meant for another command; `None` if that is not what is wrong.
pub(super) fn not_for(error: &StudyError, wanted: Kind) -> Option<Report> {
    let StudyError::Values { path, text, .. } = error else { return None };
    let found = Kind::of(text).filter(|found| *found != wanted)?;
    let (path, name, command) = (path.display(), found.name(), found.command());
    let help = format!("run it with `inkwave {command} {path}`");
    Some(miette!(help = help, "{path} is a {name}, and this command reads a {}", wanted.name()))
}
