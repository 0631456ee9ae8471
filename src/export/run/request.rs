//! What to export.

use clap::ValueEnum;
use std::collections::BTreeSet;

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
    /// Positions of the first packing's spheres: CSV, LAMMPS dump and extended XYZ.
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
