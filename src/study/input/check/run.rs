//! Realisations, the requested accuracy or the grid, the solver and the picture.

use crate::input::file::{OutputTable, ResolutionTable, RunTable, SolverTable};
use crate::input::study::WantedResolution;
use crate::input::{CellRule, Faults, keys_in_words, limits};
use crate::solve::{Goal, SolveError};
use crate::wave::Wave;

/// Default number of packings with varied cells.
const VARIED_CELLS: usize = 24;
/// Default maximum number of packings with `run.target_delta_e`.
const MOST_CELLS: usize = 400;
/// Default number of packings with fixed cells.
const FIXED_CELLS: usize = 4;

impl RunTable {
    /// The number of packings.
    pub(super) fn checked(&self, cell: CellRule, faults: &mut Faults) -> usize {
        let remedy = "0.1 leaves out every tenth; with more of them the means are those of different cells";
        faults.number("run.failed_packings", self.failed_packings, limits::FAILED_PACKINGS, remedy);
        if let Some(target) = self.target_delta_e {
            let remedy = "0.3 is hard to see; a hundredth of that needs 10 000 times the cells";
            faults.number("run.target_delta_e", target, limits::TARGET_DELTA_E, remedy);
            if self.realisations == Some(1) {
                let allowed = "2 or more with run.target_delta_e: one packing has no interval";
                let remedy = "leave it out: the run ends when the target is reached";
                faults.add("run.realisations", 1, allowed, remedy);
            }
        }
        let usual = match cell {
            _ if self.target_delta_e.is_some() => MOST_CELLS,
            CellRule::Varied => VARIED_CELLS,
            CellRule::Fixed => FIXED_CELLS,
        };
        let realisations = self.realisations.unwrap_or(usual);
        let remedy = "24 small cells are a fair start";
        faults.whole("run.realisations", realisations, limits::REALISATIONS, remedy);
        realisations
    }
}

impl OutputTable {
    /// The form of the results.
    pub(super) fn checked(&self, faults: &mut Faults) -> Self {
        let remedy = "360 is usual";
        faults.whole("output.picture_pixels", self.picture_pixels, limits::PICTURE_PIXELS, remedy);
        if self.folder.as_ref().is_some_and(|folder| folder.trim().is_empty()) {
            let remedy = "name one, or leave it out: out/ and the study's name";
            faults.add("output.folder", "a blank name", "the path of a folder", remedy);
        }
        self.clone()
    }
}

/// Accuracy at which a grid per wavelength pays: 1.2 to 1.5 times faster at 1e-3 to 3e-4 (inks of
/// 15–30 %, 200–300 nm).
const PER_WAVELENGTH: f64 = 1e-3;

impl ResolutionTable {
    /// The accuracy or the grid. `has_target`: whether the run has a target of the colour's
    /// interval.
    pub(super) fn checked(&self, wave: Wave, has_target: bool, faults: &mut Faults) -> WantedResolution {
        let scheme = wave.scheme(self.scheme);
        match (self.accuracy, self.points_per_um, self.planes_per_um) {
            (accuracy, None, None) => {
                // with `run.target_delta_e` the grid's error is corrected by solves on a finer one,
                // so that it only has to be regular
                let usual = if has_target { 3e-2 } else { 1e-2 };
                let accuracy = accuracy.unwrap_or(usual);
                let remedy = "1e-2 for pictures, 1e-3 for numbers to publish";
                faults.number("resolution.accuracy", accuracy, limits::ACCURACY, remedy);
                let per_wavelength = self.per_wavelength.unwrap_or(accuracy <= PER_WAVELENGTH);
                WantedResolution::Accuracy { amplitude: accuracy, scheme, per_wavelength }
            }
            (None, Some(points_per_um), Some(planes_per_um)) => {
                let remedy = "12 to 16 is usual";
                faults.number("resolution.points_per_um", points_per_um, limits::PER_UM, remedy);
                let remedy = "20 to 40 is usual";
                faults.number("resolution.planes_per_um", planes_per_um, limits::PER_UM, remedy);
                if self.per_wavelength == Some(true) {
                    let remedy = "leave it out, or write accuracy instead of points and planes";
                    let found = "true beside points_per_um and planes_per_um, which are one grid";
                    faults.add("resolution.per_wavelength", found, "with accuracy", remedy);
                }
                WantedResolution::Grid { points_per_um, planes_per_um, scheme }
            }
            _ => {
                let allowed = "either accuracy alone, or both points_per_um and planes_per_um";
                let found = keys_in_words(self, &["accuracy", "points_per_um", "planes_per_um"]);
                faults.add("resolution", found, allowed, "write accuracy = 1e-2");
                WantedResolution::Accuracy { amplitude: 1e-2, scheme, per_wavelength: false }
            }
        }
    }
}

impl SolverTable {
    /// When a solve has converged, and when it is given up.
    pub(super) fn checked(&self, resolution: &WantedResolution, faults: &mut Faults) -> Goal {
        let usual = match resolution {
            // an amplitude's error is up to three times the residual: a third of the accuracy, and
            // random from solve to solve
            WantedResolution::Accuracy { amplitude, .. } => (0.1 * amplitude).clamp(1e-13, 1e-3),
            WantedResolution::Grid { .. } => Goal::default().tolerance,
        };
        let tolerance = self.tolerance.unwrap_or(usual);
        let remedy = "leave it out: a tenth of resolution.accuracy is ample";
        faults.number("solver.tolerance", tolerance, limits::TOLERANCE, remedy);
        let most = self.max_applications;
        faults.whole("solver.max_applications", most, limits::APPLICATIONS, "2000 is usual");
        if let Err(SolveError::Setting { field, value, allowed, remedy }) = self.strategy.build().check() {
            faults.add(format!("solver.strategy.{field}"), value, allowed, remedy);
        }
        Goal { tolerance, max_applications: most }
    }
}
