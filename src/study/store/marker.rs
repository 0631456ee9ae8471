//! The marker of a folder that the program made: a small file of its own, so that nobody else's folder is taken for ours.

use super::build::build;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// The marker's file.
pub const MARKER: &str = "inkwave.json";
/// Counts up when the folder's layout changes so that older programs cannot read it.
const LAYOUT: u32 = 2;

/// What a folder holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Holds {
    /// Results of one study.
    Study,
    /// Results of a sweep, or of a part of it.
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

/// The marker's content.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// What the folder holds.
    pub inkwave_folder: Holds,
    /// Version of the folder's layout.
    pub layout: u32,
    /// The build that made the folder.
    pub program: String,
}

impl Marker {
    /// The marker of a new folder.
    pub fn new(holds: Holds) -> Self {
        Self { inkwave_folder: holds, layout: LAYOUT, program: build().to_owned() }
    }

    /// The marker in `folder`; `None` where there is none of ours.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(folder.join(MARKER)).ok()?).ok()
    }

    /// Whether this program reads the folder.
    pub fn is_readable(&self) -> bool {
        self.layout == LAYOUT
    }
}
