//! `results.json`: the numbers and where they come from.

use super::ink_maker::InkMaker;
use super::survivors::Survivors;
pub use super::uncertainty::Budget;
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
    /// All solves asked for are in.
    Complete,
    /// Some are missing.
    Partial,
}

/// All results of a run in one object. Standard errors hold chance, cell, angles and wavelengths (by the jackknife over realisations), the
/// grid's error and the residual's, added as squares; `null` where one realisation leaves them unknown.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest<Study: Serialize> {
    /// Whether anything is missing.
    pub status: Status,
    /// The study's title.
    pub title: String,
    /// Content hash of the checked study.
    pub study_hash: String,
    /// Name and version of the program.
    pub program: String,
    /// Builds that made the solves; several where the results are mixed.
    pub builds: BTreeSet<String>,
    /// Version of the methods that the results depend on.
    pub method_version: u32,
    /// Seed of the study.
    pub seed: u64,
    /// Realisations asked for and finished.
    pub realisations: Count,
    /// Solves asked for and finished.
    pub solves: Count,
    /// Packings whose grains found room, and the others.
    pub tried_packings: Survivors,
    /// What failed, and why.
    pub failures: Vec<FailureNote>,
    /// The grid of the shortest waves and of the largest contrast.
    pub resolution: Resolution,
    /// That of the longest waves, where it is another one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution_longest: Option<Resolution>,
    /// What is known about the errors.
    pub certainty: Certainty,
    /// One record a realisation.
    pub packings: Vec<PackingRecord>,
    /// Colours under all conditions.
    pub colours: Vec<ColourNote>,
    /// Hiding power, Kubelka–Munk coefficients and differences, where there are colours.
    pub ink_maker: Option<InkMaker>,
    /// Why there are no colours, where there are none.
    pub no_colour: Option<String>,
    /// Why there are colours but no numbers for the ink maker, such as an illuminant that the wavelengths cannot carry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_ink_maker: Option<String>,
    /// Numbers that cannot be, such as a contrast ratio below 0, and why each is missing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub withheld: Vec<Withheld>,
    /// One row for each wavelength and angle.
    pub spectra: Vec<SpectrumRow>,
    /// Seconds that the solves took, added up: of a clock on the wall, while several solves may run side by side on
    /// several threads each.
    pub solve_seconds: f64,
    /// Processor seconds of the whole process that wrote this, of all its threads: packings, grids, solves and evaluation since it
    /// was started. Absent in sweeps, whose process works for all variants at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process_seconds: Option<f64>,
    /// The study with every default filled in.
    pub study: Study,
}

/// Totals outside of 0 … 1 by more than this are no results; every single solve has passed a narrower gate.
const BEYOND: f64 = 0.03;

impl<Study: Serialize> Manifest<Study> {
    /// The first number that is no result: NaN, infinite, or a total outside of 0 … 1 beyond its error.
    pub fn unphysical(&self) -> Option<String> {
        let c = &self.certainty;
        let certainty = [
            ("amplitude_error_estimate", c.amplitude_error_estimate),
            ("reflectance_grid_error", c.reflectance_grid_error),
            ("transmittance_grid_error", c.transmittance_grid_error),
            ("largest_energy_error", c.largest_energy_error),
            ("largest_residual", c.largest_residual),
        ];
        let wrong = certainty.into_iter().find(|(_, value)| !value.is_finite());
        wrong.map(|(name, value)| format!("certainty.{name} is {value}")).or_else(|| {
            self.spectra.iter().find_map(SpectrumRow::unphysical).or_else(|| self.unphysical_colour())
        })
    }

    fn unphysical_colour(&self) -> Option<String> {
        let wrong = self.colours.iter().find(|note| !note.colour.lab.iter().all(|x| x.is_finite()));
        wrong.map(|note| format!("Lab under {} is {:?}", note.conditions, note.colour.lab))
    }
}

impl SpectrumRow {
    fn unphysical(&self) -> Option<String> {
        let totals = [
            ("reflectance", self.reflectance),
            ("transmittance", self.transmittance),
            ("absorptance", self.absorptance),
        ];
        let outside = |e: &Estimate| !(-BEYOND..=1.0 + BEYOND).contains(&e.value);
        let no_number =
            |e: &Estimate| !e.value.is_finite() || e.standard_error.is_some_and(|s| !s.is_finite());
        let seen = [("natural_light", self.natural_light), ("lit_at_45", self.lit_at_45)];
        let seen = seen.into_iter().filter_map(|(name, e)| Some((name, e?))).find(|(_, e)| no_number(e));
        let wrong = totals.into_iter().find(|(_, e)| no_number(e) || outside(e)).or(seen);
        wrong.map(|(name, e)| format!("{name} is {} at {} nm", e.value, self.wavelength_nm))
    }
}

/// A number that was not published.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Withheld {
    /// Which one.
    pub number: String,
    /// Why not.
    pub reason: String,
}

impl Withheld {
    /// In one line.
    pub fn in_words(&self) -> String {
        format!("{}: {}", self.number, self.reason)
    }
}

/// How many were asked for, and how many are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Count {
    /// How many were asked for.
    pub asked: usize,
    /// How many are in.
    pub finished: usize,
}

/// A solve without a result, or a packing that did not come about.
#[derive(Clone, Debug, Serialize)]
pub struct FailureNote {
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// Wavelength, nm; none of a packing.
    pub wavelength_nm: Option<f64>,
    /// Polar angle, degrees; none of a packing.
    pub polar_deg: Option<f64>,
    /// The error's message.
    pub reason: String,
}

/// What limits the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Largest expected error of an order's complex amplitude from the grid, over the probed points.
    pub amplitude_error_estimate: f64,
    /// Expected errors of the layer's R and T from the grid, over the probed points; part of the standard errors.
    pub reflectance_grid_error: f64,
    /// Expected error of the transmittance from the grid, over the probed points.
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
    /// Operator applications of all solves together.
    pub operator_applications: usize,
}

/// A colour under named conditions.
#[derive(Clone, Debug, Serialize)]
pub struct ColourNote {
    /// Light and viewing.
    pub conditions: String,
    /// C*ab with its error.
    pub chroma: Estimate,
    /// hab with its error, degrees.
    pub hue_deg: Estimate,
    /// Standard errors of L*, a*, b*; unknown for one realisation.
    pub lab_standard_error: Option<[f64; 3]>,
    /// Half width of the 95 % interval as a CIEDE2000 difference.
    pub delta_e_2000_95: Option<f64>,
    /// What the standard error is made of.
    pub budget: Budget,
    /// What each realisation, by its number, moves Lab by: colours of the same realisations err together.
    #[serde(skip)]
    pub deviations: Vec<(usize, [f64; 3])>,
    /// The colour itself.
    #[serde(flatten)]
    pub colour: Colour,
}

/// One wavelength and angle. R, T, A and their specular parts are those of the layer alone.
#[derive(Clone, Debug, Serialize)]
pub struct SpectrumRow {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Polar angle, degrees.
    pub polar_deg: f64,
    /// Reflected share of the incident power.
    pub reflectance: Estimate,
    /// Its specular order.
    pub specular_reflectance: Estimate,
    /// Transmitted share.
    pub transmittance: Estimate,
    /// Its specular order.
    pub specular_transmittance: Estimate,
    /// Absorbed share.
    pub absorptance: Estimate,
    /// The ink on its paper under a uniform sky, seen along the normal (white diffuser: 1).
    pub natural_light: Option<Estimate>,
    /// π × BRDF of the ink on its paper, lit at 45° and seen along the normal (white diffuser: 1).
    pub lit_at_45: Option<Estimate>,
    /// What each realisation, by its number, moves R and T by.
    #[serde(skip)]
    pub deviations: Vec<(usize, [f64; 2])>,
}
