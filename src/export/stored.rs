//! A finished study, read back from its folder: what `results.json` says was asked, and the records that answer it.

use crate::evaluate::seen::{Seen, see};
use crate::input::study::Study;
use crate::run::{Collected, Stores};
use crate::store::database::RECORDS;
use crate::sweep::outcome::collect;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Numbers and provenance of a run.
const RESULTS: &str = "results.json";

/// Why a folder cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum StoredError {
    /// No results there.
    #[error("{} holds no results of `inkwave run`: {reason}", path.display())]
    NoResults {
        /// The folder.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The study in `results.json` is not the one that was run.
    #[error("{}: the study has hash {found}, its results were made for {expected}", path.display())]
    Changed {
        /// The folder.
        path: PathBuf,
        /// Content hash of the study.
        found: String,
        /// The hash that is written beside it.
        expected: String,
    },
    /// Solves are missing.
    #[error("{} is not finished: {finished} of {asked} solves are there", path.display())]
    Unfinished {
        /// The folder.
        path: PathBuf,
        /// Solves that are there.
        finished: usize,
        /// Solves of the study.
        asked: usize,
    },
    /// The store cannot be opened.
    #[error("cannot open the store of {}: {source}", path.display())]
    Store {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Records that do not belong together.
    #[error(transparent)]
    Seen(#[from] crate::appearance::bdf::BdfError),
}

impl StoredError {
    /// What to try.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NoResults { .. } => {
                "give the folder that `inkwave run STUDY.toml` has written; of a sweep, a folder under variants/"
            }
            Self::Changed { .. } => "results.json was edited or is of another version: run the study again",
            Self::Unfinished { .. } => "run the study again in that folder: it goes on where it stopped",
            Self::Store { .. } => "check the folder's permissions",
            Self::Seen(_) => "run the study again in a new folder",
        }
    }
}

/// A finished study with all that follows from its solves.
#[derive(Debug)]
pub struct Stored {
    /// What was asked.
    pub study: Study,
    /// Every record.
    pub collected: Collected,
    /// What the records say.
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
    pub fn read(path: &Path) -> Result<Self, StoredError> {
        let study = study(path)?;
        let stores = stores(path)?;
        let missing =
            || StoredError::Unfinished { path: path.to_owned(), finished: 0, asked: study.solves() };
        let collected = collect(&study, &stores).ok_or_else(missing)?;
        let (finished, asked) = (collected.finished(), study.solves());
        if finished < asked {
            return Err(StoredError::Unfinished { path: path.to_owned(), finished, asked });
        }
        let seen = see(&study, &collected)?;
        Ok(Self { study, collected, seen })
    }
}

/// The checked study that `results.json` holds; its content hash proves that it is whole.
fn study(path: &Path) -> Result<Study, StoredError> {
    let no_results = |reason: String| StoredError::NoResults { path: path.to_owned(), reason };
    let text = std::fs::read(path.join(RESULTS)).map_err(|e| no_results(format!("{RESULTS}: {e}")))?;
    let results: Results =
        serde_json::from_slice(&text).map_err(|e| no_results(format!("{RESULTS}: {e}")))?;
    let found = results.study.key().to_string();
    match found == results.study_hash {
        true => Ok(results.study),
        false => Err(StoredError::Changed { path: path.to_owned(), found, expected: results.study_hash }),
    }
}

/// The store of the folder itself, or the one that the variants of a sweep share.
fn stores(path: &Path) -> Result<Stores, StoredError> {
    let failed = |source| StoredError::Store { path: path.to_owned(), source };
    let shared = path.join("../..");
    let place = if !path.join(RECORDS).exists() && shared.join(RECORDS).exists() { &shared } else { path };
    Stores::at(place).map_err(failed)
}
