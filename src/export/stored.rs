//! A finished study, read back from its folder: the study in `results.json` and the records of its
//! solves.

use super::request::{ExportError, ExportResult};
use crate::evaluate::seen::{Seen, see};
use crate::input::study::Study;
use crate::run::{Collected, Stores};
use crate::store::database::RECORDS;
use crate::work::rounds::collect;
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
    pub fn read(path: &Path) -> ExportResult<Self> {
        let study = study(path)?;
        if study.composed().is_some() {
            let reason = format!("{} holds a composed layer, which has no orders and no BDF", path.display());
            let remedy = "spectra.csv, medium.csv and results.json have its numbers";
            return Err(ExportError::Folder { reason, remedy });
        }
        let collected = collect(&study, &stores(path)?, 0);
        let asked = study.solves() - collected.as_ref().map_or(0, |collected| collected.spared(&study));
        let finished = collected.as_ref().map_or(0, Collected::finished);
        let Some(collected) = collected.filter(|_| finished >= asked) else {
            return Err(ExportError::Unfinished { path: path.to_owned(), finished, asked });
        };
        let seen = see(&study, &collected)?;
        Ok(Self { study, collected, seen })
    }
}

/// The checked study in `results.json`; its content hash shows that it is unchanged.
pub(super) fn study(path: &Path) -> ExportResult<Study> {
    let folder = path.display();
    let text = std::fs::read(path.join(RESULTS));
    let text = text.map_err(|e| e.to_string());
    let results = text.and_then(|text| serde_json::from_slice::<Results>(&text).map_err(|e| e.to_string()));
    let Results { study_hash, study } = results.map_err(|cause| ExportError::Folder {
        reason: format!("{folder} holds no results of `inkwave run`: {RESULTS}: {cause}"),
        remedy: "give the folder written by `inkwave run STUDY.toml`, or for a sweep a folder under variants/",
    })?;
    let found = study.key();
    if found.as_str() == study_hash {
        return Ok(study);
    }
    let reason = format!("{folder}: the study has hash {found}, its results were made for {study_hash}");
    let remedy = "results.json was edited or is of another version: run the study again";
    Err(ExportError::Folder { reason, remedy })
}

/// The store of the folder itself, or the one that the variants of a sweep share.
pub(super) fn stores(path: &Path) -> ExportResult<Stores> {
    let shared = path.join("../..");
    let place = if !path.join(RECORDS).exists() && shared.join(RECORDS).exists() { &shared } else { path };
    Stores::at(place).map_err(|cause| ExportError::Folder {
        reason: format!("cannot open the store of {}: {cause}", path.display()),
        remedy: "check the folder's permissions",
    })
}
