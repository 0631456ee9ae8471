//! Folders of finished studies, and what is exported of them.

use super::composed::StoredSlabs;
use super::exporter::{Exported, export};
use super::request::{ExportResult, Request};
use super::stored::{self, Stored};
use crate::run::watch::RunWatch;
use std::path::Path;

/// A finished study, read back from its folder.
#[derive(Debug)]
pub enum StoredFolder {
    /// A layer that is solved as a whole.
    Whole(Box<Stored>),
    /// A layer composed of slabs.
    Composed(Box<StoredSlabs>),
}

impl StoredFolder {
    /// Reads a folder of `inkwave run`, or of one variant of a sweep.
    ///
    /// # Errors
    /// No results there, an unfinished study, or results and store that do not fit.
    pub fn read(path: &Path) -> ExportResult<Self> {
        let study = stored::study(path)?;
        match study.composed().is_some() {
            true => StoredSlabs::of_study(study, path).map(|slabs| Self::Composed(Box::new(slabs))),
            false => Stored::of_study(study, path).map(|stored| Self::Whole(Box::new(stored))),
        }
    }

    /// Makes all files that `request` asks for, in memory.
    ///
    /// # Errors
    /// As [`export`].
    pub fn export(&self, request: &Request, watch: &dyn RunWatch) -> ExportResult<Exported> {
        match self {
            Self::Whole(stored) => export(stored.as_ref(), request, watch),
            Self::Composed(slabs) => export(&slabs.evaluated(), request, watch),
        }
    }
}
