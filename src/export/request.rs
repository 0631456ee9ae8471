//! What to export, and the errors of exports.

use crate::evaluate::evaluated::EvaluateError;
use crate::evaluate::ink::InkError;
use crate::ink::PackError;
use crate::solve::SolveError;
use crate::wave::WaveError;
use clap::ValueEnum;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// A format, or a group of files that belong together; in the order in which they are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Format {
    /// Material for Mitsuba 3 (spectral and RGB), scenes, and tables to check it.
    Mitsuba,
    /// Spectra with Lab, CxF3.
    Cxf,
    /// Spectra with Lab, CGATS.17 and ArgyllCMS's sp.
    Cgats,
    /// Far fields as NumPy arrays.
    Npz,
    /// Contrast of the first packing as a VTK image.
    Vti,
    /// Positions of the first packing's grains of spheres: CSV, LAMMPS dump and extended XYZ.
    Positions,
    /// Labels of the first packing's voxels as a NumPy array.
    Labels,
    /// Interactive view of the first packing for a browser.
    Viewer,
    /// RO-Crate and Data Package.
    Crate,
}

/// Light of a near field, which is solved again as no run stores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearField {
    /// One of the study's wavelengths, nm.
    pub wavelength_nm: f64,
    /// Angle of incidence, degrees.
    pub polar_deg: f64,
}

/// What to export.
#[derive(Clone, Debug)]
pub struct Request {
    /// Formats.
    pub formats: BTreeSet<Format>,
    /// Light of a solve for `near-field.vti`, if requested.
    pub near_field: Option<NearField>,
    /// Which layer of a composed study, µm; without it, the first one.
    pub thickness_um: Option<f64>,
    /// Date and time for the files that carry one, RFC 3339.
    pub created: String,
}

/// Why something could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The folder has no results that can be used.
    #[error("{reason}")]
    Folder {
        /// What is wrong with it.
        reason: String,
        /// What to try.
        remedy: &'static str,
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
    /// The study has no such file: what was requested, and what is allowed.
    #[error("{0}")]
    Refused(String),
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

/// What an export gives.
pub type ExportResult<T = ()> = Result<T, ExportError>;

impl From<EvaluateError> for ExportError {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Slabs(reason) => Self::Refused(reason),
            EvaluateError::Ink(error) => Self::Ink(error),
            EvaluateError::Bdf(error) => Self::Seen(error),
        }
    }
}

impl ExportError {
    /// What to try, unless the message includes it.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::Folder { remedy, .. } => Some(remedy),
            Self::Seen(_) => Some("run the study again in a new folder"),
            _ => None,
        }
    }

    /// No layer of this thickness.
    pub(super) fn thickness(found: f64, allowed: &str) -> Self {
        Self::Refused(format!("--thickness: found {found} µm; allowed is {allowed} µm"))
    }

    /// A format that needs the ink on its paper, and why there is none.
    pub(super) fn no_ink(format: &str, reason: &str) -> Self {
        Self::Refused(format!("{format} needs the ink on its paper: {reason}"))
    }
}
