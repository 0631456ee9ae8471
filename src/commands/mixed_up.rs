//! A file that belongs to another command.

use inkwave::input::fault::StudyError;
use inkwave::input::tree::parse_toml;
use miette::{Report, miette};

/// What a command reads.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `inkwave run`
    Study,
    /// `inkwave sweep`
    Sweep,
}

impl Kind {
    /// What a file is, by the tables that one kind alone has.
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

/// The report for a file that is refused because another command reads it; `None` where that is not the reason.
pub(super) fn not_for(error: &StudyError, wanted: Kind) -> Option<Report> {
    let StudyError::Values { path, text, .. } = error else { return None };
    let found = Kind::of(text).filter(|found| *found != wanted)?;
    let (path, name, command) = (path.display(), found.name(), found.command());
    let help = format!("run it with `inkwave {command} {path}`");
    Some(miette!(help = help, "{path} is a {name}, and this command reads a {}", wanted.name()))
}
