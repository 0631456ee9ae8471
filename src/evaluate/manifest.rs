//! `results.json`: the numbers and where they come from.

use crate::appearance::colour::Colour;
use crate::numerics::estimate::Estimate;
use crate::store::packing_record::PackingRecord;
use crate::wave::Resolution;
use serde::Serialize;
use std::collections::BTreeSet;

/// Whether every solve of the study is in the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Complete,
    Partial,
}

/// All results of a run in one object. Standard errors hold the chance over realisations and the error of the grid, added
/// as squares; `null` where one realisation leaves them unknown.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest<Study: Serialize> {
    pub status: Status,
    pub title: String,
    /// Content hash of the checked study.
    pub study_hash: String,
    /// Name and version of the program.
    pub program: String,
    /// Builds that made the solves; several where the results are mixed.
    pub builds: BTreeSet<String>,
    pub method_version: u32,
    pub seed: u64,
    pub realisations: Count,
    pub solves: Count,
    pub failures: Vec<FailureNote>,
    pub resolution: Resolution,
    pub certainty: Certainty,
    pub packings: Vec<PackingRecord>,
    pub colours: Vec<ColourNote>,
    /// Why there are no colours, where there are none.
    pub no_colour: Option<String>,
    pub spectra: Vec<SpectrumRow>,
    /// Seconds of processor time in solves.
    pub solve_seconds: f64,
    /// The study with every default filled in.
    pub study: Study,
}

/// How many were asked for, and how many are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Count {
    pub asked: usize,
    pub finished: usize,
}

/// A solve without a result.
#[derive(Clone, Debug, Serialize)]
pub struct FailureNote {
    pub realisation: usize,
    pub wavelength_nm: f64,
    pub polar_deg: f64,
    pub reason: String,
}

/// What limits the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Largest expected error of an order's complex amplitude from the grid, over the probed points.
    pub amplitude_error_estimate: f64,
    /// Expected errors of the layer's R and T from the grid, over the probed points; part of the standard errors.
    pub reflectance_grid_error: f64,
    pub transmittance_grid_error: f64,
    /// Upper estimate of the error of R and T between the angles that were solved, at the worst wavelength.
    pub angle_error_estimate: Option<f64>,
    /// Largest |R + T + A − 1| of all solves.
    pub largest_energy_error: f64,
    /// Largest relative residual of all solves.
    pub largest_residual: f64,
    /// Mean number of solver steps.
    pub mean_steps: f64,
    pub operator_applications: usize,
}

/// A colour under named conditions.
#[derive(Clone, Debug, Serialize)]
pub struct ColourNote {
    pub conditions: String,
    pub chroma: Estimate,
    pub hue_deg: Estimate,
    pub lab_standard_error: Option<[f64; 3]>,
    #[serde(flatten)]
    pub colour: Colour,
}

/// One wavelength. R, T, A and their specular parts are those of the layer alone at the smallest angle.
#[derive(Clone, Debug, Serialize)]
pub struct SpectrumRow {
    pub wavelength_nm: f64,
    pub polar_deg: f64,
    pub reflectance: Estimate,
    pub specular_reflectance: Estimate,
    pub transmittance: Estimate,
    pub specular_transmittance: Estimate,
    pub absorptance: Estimate,
    /// The ink on its paper under a uniform sky, seen along the normal (white diffuser: 1).
    pub natural_light: Option<Estimate>,
    /// π × BRDF of the ink on its paper, lit at 45° and seen along the normal (white diffuser: 1).
    pub lit_at_45: Option<Estimate>,
}
