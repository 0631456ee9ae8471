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

/// All results of a run in one object. Standard errors hold chance, cell, angles and wavelengths (by the jackknife over realisations), the
/// grid's error and the residual's, added as squares; `null` where one realisation leaves them unknown.
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
    /// Degrees of freedom of the standard errors: realisations less one; 0 where nothing is left to chance.
    pub degrees_of_freedom: usize,
    /// Standard errors times this give 95 % intervals (Student's t).
    pub coverage_factor_95: Option<f64>,
    /// What the placing of the directions costs in T̄ at the worst wavelength: a standard error, part of those of all colours.
    pub angle_error_estimate: Option<f64>,
    /// T̄ from every other stratum less T̄ from all, mean over the wavelengths: an independent check, zero within its error.
    pub half_strata_difference: Option<Estimate>,
    /// R̄ from the exit side by its own quadrature less 1 − T̄/n² − Ā, mean over the wavelengths, where that side was solved: a second check.
    pub exit_reflectance_difference: Option<Estimate>,
    /// Mean |R + T + A − 1| of all solves: what the solver's residual does to R and T; part of the standard errors.
    pub mean_energy_error: f64,
    /// Largest |R + T + A − 1| of all solves.
    pub largest_energy_error: f64,
    /// Largest relative residual of all solves.
    pub largest_residual: f64,
    /// Mean number of solver steps.
    pub mean_steps: f64,
    pub operator_applications: usize,
}

/// What a colour's error is made of: root mean square distances in Lab (ΔE*ab). The squares of all parts but `wavelengths` add up to that of
/// the standard error; the wavelengths' part is corrected for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// Random packings, each in its own cell; `null` where one realisation leaves it unknown.
    pub chance_and_cell: Option<f64>,
    /// The directions over the hemisphere.
    pub angles: Option<f64>,
    /// What the spacing of the wavelengths would cost without the correction that the colour holds.
    pub wavelengths: f64,
    /// The grid.
    pub grid: f64,
    /// The solver's residual.
    pub residual: f64,
}

/// A colour under named conditions.
#[derive(Clone, Debug, Serialize)]
pub struct ColourNote {
    pub conditions: String,
    pub chroma: Estimate,
    pub hue_deg: Estimate,
    pub lab_standard_error: Option<[f64; 3]>,
    /// Half width of the 95 % interval as a CIEDE2000 difference.
    pub delta_e_2000_95: Option<f64>,
    /// What the standard error is made of.
    pub budget: Budget,
    #[serde(flatten)]
    pub colour: Colour,
}

/// One wavelength and angle. R, T, A and their specular parts are those of the layer alone.
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
