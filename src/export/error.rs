//! Errors of exports.

use crate::evaluate::ink::InkError;
use crate::ink::PackError;
use crate::solve::SolveError;
use crate::wave::WaveError;
use std::path::PathBuf;

/// Why something could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The folder holds no results.
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
    #[error("{} is unfinished: {finished} of {asked} solves are stored", path.display())]
    Unfinished {
        /// The folder.
        path: PathBuf,
        /// Finished solves.
        finished: usize,
        /// Solves of the study.
        asked: usize,
    },
    /// A composed layer has no orders of its own.
    #[error("{} holds a composed layer, which has no orders and no BDF", path.display())]
    Composed {
        /// The folder.
        path: PathBuf,
    },
    /// A composed layer has many slabs, each with packings of its own.
    #[error(
        "{format} shows one packing, and a composed layer has none of its own: allowed are mitsuba, cxf, cgats, npz and crate"
    )]
    OnePacking {
        /// The format.
        format: String,
    },
    /// No layer of this thickness.
    #[error("--thickness: found {found} µm; allowed is {allowed} µm")]
    Thickness {
        /// What was asked for.
        found: f64,
        /// The study's thicknesses.
        allowed: String,
    },
    /// A composed layer that cannot be evaluated.
    #[error("{0}")]
    Slabs(String),
    /// The store cannot be opened.
    #[error("cannot open the store of {}: {source}", path.display())]
    Store {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Colours and materials need the ink on its paper.
    #[error("{format} needs the ink on its paper: {reason}")]
    NoInk {
        /// The format.
        format: &'static str,
        /// Why there is none.
        reason: String,
    },
    /// Materials of renderers lie in vacuum.
    #[error("layer.index_in is {index}; a renderer's material lies in air: allowed is 1")]
    NotInAir {
        /// Index of the incident side.
        index: f64,
    },
    /// The wavelength is not one of the study's.
    #[error("near field: found {found} nm; allowed is one of the study's wavelengths, {allowed} nm")]
    Wavelength {
        /// Asked for, nm.
        found: f64,
        /// The study's own, nm.
        allowed: String,
    },
    /// The near field of Maxwell's equations is known only as moments.
    #[error(
        "near field: light.wave is {wave}; allowed is \"scalar\": Maxwell's equations are solved for moments of E, which no volume shows yet"
    )]
    VectorNearField {
        /// The study's wave.
        wave: &'static str,
    },
    /// Too few wavelengths for spectra on a grid of 10 nm.
    #[error("{format} needs at least two multiples of 10 nm inside the study's wavelengths")]
    TooFewWavelengths {
        /// The format.
        format: &'static str,
    },
    /// Records that do not belong together.
    #[error(transparent)]
    Seen(#[from] crate::appearance::bdf::BdfError),
    /// The appearance cannot be computed.
    #[error(transparent)]
    Ink(#[from] InkError),
    /// A table cannot be written.
    #[error("cannot write a table: {0}")]
    Csv(#[from] csv::Error),
    /// JSON cannot be written.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file made from a template.
    #[error("cannot write the file: {0}")]
    Template(#[from] minijinja::Error),
    /// The archive of arrays cannot be written.
    #[error("cannot write the archive of arrays: {0}")]
    Npz(#[from] ndarray_npy::WriteNpzError),
    /// The packing could not be reproduced.
    #[error(transparent)]
    Packing(#[from] PackError),
    /// The near field's problem is not valid.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The near field's solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl ExportError {
    /// What to try, unless the message includes it.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::NoResults { .. } => Some(
                "give the folder written by `inkwave run STUDY.toml`, or for a sweep a folder under variants/",
            ),
            Self::Changed { .. } => {
                Some("results.json was edited or is of another version: run the study again")
            }
            Self::Unfinished { .. } => {
                Some("run the study again in that folder: it resumes where it stopped")
            }
            Self::Composed { .. } => Some("spectra.csv, medium.csv and results.json have its numbers"),
            Self::Store { .. } => Some("check the folder's permissions"),
            Self::Seen(_) => Some("run the study again in a new folder"),
            _ => None,
        }
    }
}
