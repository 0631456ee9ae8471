//! The marker file that identifies folders written by this program, so that no other folder is
//! overwritten; and the mark of unfinished work, with the command that resumes it.

use super::identity::build;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Name of the marker file.
pub const MARKER: &str = "inkwave.json";
/// Version of the folder layout, increased when older programs can no longer read it.
const LAYOUT: u32 = 2;
/// File that marks a folder as unfinished.
pub const PARTIAL: &str = "PARTIAL";
/// Precedes the command.
const INDENT: &str = "    ";

/// What a folder holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Holds {
    /// Results of one study.
    Study,
    /// Results of a sweep, or of a shard of it.
    Sweep,
    /// A comparison of strategies.
    Comparison,
    /// A pigment's index fitted to spectra.
    Fit,
    /// A recipe designed for a colour.
    Design,
    /// Packings with their statistics.
    Packings,
    /// Files for other programs.
    Exports,
}

impl fmt::Display for Holds {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Study => "a study",
            Self::Sweep => "a sweep",
            Self::Comparison => "a comparison",
            Self::Fit => "a fit",
            Self::Design => "a design",
            Self::Packings => "packings",
            Self::Exports => "exports",
        })
    }
}

/// Content of the marker file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// What the folder holds.
    pub inkwave_folder: Holds,
    /// Version of the folder layout.
    pub layout: u32,
    /// The build that created the folder.
    pub program: String,
    /// What the results belong to, as a hash of all that they depend on; none where nothing was
    /// begun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
}

impl Marker {
    /// Marker for a new folder.
    pub fn new(holds: Holds) -> Self {
        Self { inkwave_folder: holds, layout: LAYOUT, program: build().to_owned(), input: None }
    }

    /// Reads the marker in `folder`; `None` if there is none of this program.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(folder.join(MARKER)).ok()?).ok()
    }

    /// Whether this program can read the folder.
    pub fn is_readable(&self) -> bool {
        self.layout == LAYOUT
    }
}

/// Text of the mark of unfinished work.
pub(super) fn partial(go_on: Option<&str>) -> String {
    let begun =
        "The work here is unfinished, and files may be from an earlier run. The same command resumes it";
    match go_on {
        Some(command) => format!("{begun}:\n\n{INDENT}{command}\n"),
        None => format!("{begun}.\n"),
    }
}

/// The command that resumes the work in a folder, if its mark contains one.
pub fn go_on(folder: &Path) -> Option<String> {
    let text = std::fs::read_to_string(folder.join(PARTIAL)).ok()?;
    text.lines().find_map(|line| line.strip_prefix(INDENT)).map(str::to_owned)
}

/// Puts a word in single quotes unless every character is harmless to a shell.
pub fn shell_word(word: &str) -> String {
    if !word.is_empty() && word.chars().all(|c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c)) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_only_where_a_shell_needs_it() {
        assert_eq!(shell_word("--output=out/yellow"), "--output=out/yellow");
        assert_eq!(shell_word("my ink.toml"), "'my ink.toml'");
        assert_eq!(shell_word("it's"), r"'it'\''s'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn the_mark_tells_how_to_go_on() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(go_on(folder.path()), None);
        for command in [None, Some("inkwave run yellow.toml --output 'my ink'")] {
            std::fs::write(folder.path().join(PARTIAL), partial(command)).unwrap();
            assert_eq!(go_on(folder.path()).as_deref(), command);
        }
    }
}
