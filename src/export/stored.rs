//! A finished study, read back from its folder: the study in `results.json` and the records of its
//! solves.

use super::error::ExportError;
use crate::evaluate::seen::{Seen, see};
use crate::input::study::Study;
use crate::run::{Collected, Stores};
use crate::store::database::RECORDS;
use crate::sweep::work::rounds::collect;
use serde::Deserialize;
use std::path::Path;

/// Numbers and provenance of a run.
const RESULTS: &str = "results.json";

/// A finished study with the evaluation of its solves.
#[derive(Debug)]
pub struct Stored {
    /// The study.
    pub study: Study,
    /// Every record.
    pub collected: Collected,
    /// The evaluated records.
    pub seen: Seen,
}

#[derive(Deserialize)]
struct Results {
    study_hash: String,
    study: Study,
}

impl Stored {
    /// Reads a folder of `inkwave run`, or of one variant of a sweep.
    ///
    /// # Errors
    /// No results there, an unfinished study, or results and store that do not fit.
    pub fn read(path: &Path) -> Result<Self, ExportError> {
        let study = study(path)?;
        if study.layer.composed.is_some() {
            return Err(ExportError::Composed { path: path.to_owned() });
        }
        let stores = stores(path)?;
        let missing =
            || ExportError::Unfinished { path: path.to_owned(), finished: 0, asked: study.solves() };
        let collected = collect(&study, &stores, 0).ok_or_else(missing)?;
        let (finished, asked) = (collected.finished(), study.solves());
        if finished < asked {
            return Err(ExportError::Unfinished { path: path.to_owned(), finished, asked });
        }
        let seen = see(&study, &collected)?;
        Ok(Self { study, collected, seen })
    }
}

/// The checked study in `results.json`; its content hash shows that it is unchanged.
pub(super) fn study(path: &Path) -> Result<Study, ExportError> {
    let no_results = |reason: String| ExportError::NoResults { path: path.to_owned(), reason };
    let text = std::fs::read(path.join(RESULTS)).map_err(|e| no_results(format!("{RESULTS}: {e}")))?;
    let results: Results =
        serde_json::from_slice(&text).map_err(|e| no_results(format!("{RESULTS}: {e}")))?;
    let found = results.study.key().to_string();
    match found == results.study_hash {
        true => Ok(results.study),
        false => Err(ExportError::Changed { path: path.to_owned(), found, expected: results.study_hash }),
    }
}

/// The store of the folder itself, or the one that the variants of a sweep share.
pub(super) fn stores(path: &Path) -> Result<Stores, ExportError> {
    let shared = path.join("../..");
    let place = if !path.join(RECORDS).exists() && shared.join(RECORDS).exists() { &shared } else { path };
    Stores::at(place).map_err(|source| ExportError::Store { path: path.to_owned(), source })
}
