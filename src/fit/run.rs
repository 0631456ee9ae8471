//! Carries a fit out: table, search, Gauss–Newton, errors.

mod advice;
mod descent;
mod fitted;
mod forecast;
mod outcome;
mod planned;
mod solutions;

pub(super) use descent::{Branch, descend, near, prior_of};
pub use fitted::{FaceLight, FittedIndex};
pub use forecast::Forecast;
pub use outcome::{FitOutcome, FittedNumber, FittedSpectrum, OtherSolution, Trust};
pub use planned::{FitCosts, PlannedSolves};

use super::data::Data;
use super::law::FitStep;
use super::load::{Drawdown, FitTask};
use super::prior::IndexPrior;
use super::response::{Origin, Response};
use super::start::{Surface, TABLE_CELLS, TABLE_ERROR, paths};
use crate::evaluate::seen::NoInk;
use crate::input::limits::{ABSORPTION, INDEX};
use crate::input::study::Study;
use crate::run::collected::{RunSettings, Stores};
use crate::run::resolve::{Resolved, resolve};
use crate::run::tangents::{Linearised, Tangents};
use crate::run::watch::{RunError, RunWatch};
use crate::solve::accuracy::grid_error::GridError;
use crate::store::Store;
use crate::store::folder::OutputFolder;
use crate::wave::Scene;
use descent::{between, share_of_step};
use num_complex::Complex64;
use outcome::UNDETERMINED;
use thiserror::Error;

/// Linearisations of one branch on all cells: at least, and at most.
const LINEARISATIONS: [usize; 2] = [2, 6];
/// Share of a step that is taken where the one before led uphill.
const DAMPED: f64 = 0.4;
/// Standard errors of the unknowns within which the least χ² is reached.
const CLOSE: f64 = 0.5;
/// Standard errors within which no further step is worth its solves.
const THERE: f64 = 0.1;

/// Why there is no fit.
#[derive(Debug, Error)]
pub enum FitError {
    /// A solve, packing or grid.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The layers on their cards give no spectra.
    #[error("the layers on their cards give no spectra: {0}")]
    NoInk(#[from] NoInk),
    /// A covariance is not positive definite: rounding of extreme numbers.
    #[error(
        "the least squares have no solution: take noise of at least 0.0001 and wavelengths further apart"
    )]
    Singular,
    /// A node of the table of a composed base without a reflectance.
    #[error("no reflectance of {0}: solve more realisations, or a narrower range of fit.n and fit.kappa")]
    Node(String),
    /// The spectra lead to numbers that are no refractive index.
    #[error(
        "the spectra lead to n = {n:.2}, κ = {kappa:.2} at {wavelength_nm} nm, which is no refractive index (n from 0.1 to 10, κ up to 10): \
         check thickness, volume fraction and the backings' albedos, or narrow fit.n and fit.kappa"
    )]
    NoIndex {
        /// Vacuum wavelength, nm.
        wavelength_nm: f64,
        /// Real part.
        n: f64,
        /// Imaginary part.
        kappa: f64,
    },
}

/// A fit in progress.
pub struct FitRun<'a> {
    task: &'a FitTask,
    cells: Vec<Tangents>,
    resolved: Vec<Resolved>,
    watch: &'a dyn RunWatch,
}

impl<'a> FitRun<'a> {
    /// Chooses the grids and packs the cells of all layers; solves are kept in the folder.
    ///
    /// # Errors
    /// No grid, no packing, or a stop.
    pub fn new(
        task: &'a FitTask,
        folder: &OutputFolder,
        settings: RunSettings,
        watch: &'a dyn RunWatch,
    ) -> Result<Self, RunError> {
        let grids = Stores::open(folder)?.grids;
        folder.begin()?;
        let (mut cells, mut resolved) = (Vec::new(), Vec::new());
        let [n, kappa] = typical(task);
        let typical = Complex64::new(n, kappa);
        for coat in &task.coats {
            let study = coat.with_index(task.pigment, &vec![typical; coat.wavelengths_nm.len()]);
            let mut packings = crate::run::realisation::Packings::new(&study, watch);
            let resolved_coat = resolve(&study, &grids, settings.memory, watch, |r| {
                packings.get(r).map(|packing| Scene::from_packing(&packing))
            });
            let resolved_coat = resolved_coat.map_err(RunError::stopped)?;
            let tangents = Store::of(grids.database());
            cells.push(Tangents::new((&study, task.pigment), resolved_coat, tangents, settings, watch)?);
            resolved.push(resolved_coat);
        }
        Ok(Self { task, cells, resolved, watch })
    }

    /// Solves all layers up to number `coats` at an index for every wavelength.
    fn solved(&self, index: &[[f64; 2]], coats: usize, cells: usize) -> Result<Vec<Linearised>, RunError> {
        let eta: Vec<Complex64> = index.iter().map(|&[n, k]| Complex64::new(n, k)).collect();
        let linearised = |(coat, tangents): (&Study, &Tangents)| {
            tangents.linearised(&coat.with_index(self.task.pigment, &eta), cells, self.watch)
        };
        self.task.coats.iter().zip(&self.cells).take(coats).map(linearised).collect()
    }

    /// The fit.
    ///
    /// # Errors
    /// A stop, a failure of the solves or of the least squares.
    pub fn fit(&self) -> Result<FitOutcome, FitError> {
        let task = self.task;
        let coats = task.coats_measured;
        self.watch.stage("coarse table of n and κ");
        let (mut solved, mut films) = (Vec::new(), Vec::new());
        for eta in Surface::indices(task) {
            let index = vec![eta; task.wavelengths_nm().len()];
            let linearised = self.solved(&index, coats, TABLE_CELLS)?;
            solved.push(Origin::Solved(&linearised).response(task, &task.measured, &index, 0.0)?);
            films.push(Origin::Film.response(task, &task.measured, &index, 0.0)?);
        }
        self.watch.stage("search over both branches of n");
        let surface = Surface::new(task, &solved, &films);
        let candidates = self.candidates(&surface)?;
        let mut outcome = solutions::concluded(task, self.carried_out(&surface, &candidates)?)?;
        for forecast in self.forecasts(&outcome)? {
            match forecast.impossible(task.wavelengths_nm()) {
                Some(reason) => outcome.remarks.push(reason),
                None => outcome.forecasts.push(forecast),
            }
        }
        Ok(outcome)
    }

    /// The best branch, and every other one that fits the table as well at another n, with solves
    /// on all cells.
    fn carried_out(&self, surface: &Surface, candidates: &[Branch]) -> Result<Vec<FitSolution>, FitError> {
        let least = candidates.first().ok_or(FitError::Singular)?.cost;
        let prior = self.prior();
        let mut known: Vec<Vec<f64>> = Vec::new();
        let mut solutions = Vec::new();
        for branch in candidates.iter().filter(|branch| branch.cost < least + solutions::AS_GOOD) {
            let start: Vec<f64> = prior.index(&branch.unknowns).iter().map(|row| row[0]).collect();
            let is_new = known.iter().all(|n| solutions::apart(n, &start) > UNDETERMINED);
            if is_new && solutions.len() < PlannedSolves::BRANCHES {
                let solution = self.refine(surface, branch)?;
                known.push(start);
                known.push(solution.outcome.index.iter().map(|row| row.n).collect());
                solutions.push(solution);
            }
        }
        Ok(solutions)
    }

    /// The prior of this fit.
    fn prior(&self) -> IndexPrior {
        prior_of(self.task)
    }

    /// The branches that fit on the table, the best one first.
    fn candidates(&self, surface: &Surface) -> Result<Vec<Branch>, FitError> {
        let prior = self.prior();
        let mut all = Vec::new();
        for path in paths(self.task, surface)? {
            all.push(self.settle(surface, &prior, near(&prior, &path).ok_or(FitError::Singular)?)?);
        }
        all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        Ok(all)
    }

    /// Gauss–Newton on the table.
    fn settle(&self, surface: &Surface, prior: &IndexPrior, start: Vec<f64>) -> Result<Branch, FitError> {
        let response_at = |unknowns: &[f64]| {
            let log = prior.log_thickness(unknowns);
            Ok(surface.response(self.task, &prior.index(unknowns), log)?)
        };
        descend(self.task, prior, start, &[TABLE_ERROR], response_at)
    }

    /// Gauss–Newton with solves on all cells. What is stated is solved: the unknowns of the least
    /// cost of all that were, which is near the minimum of its linearisation or has not converged.
    fn refine(&self, surface: &Surface, branch: &Branch) -> Result<FitSolution, FitError> {
        let mut rounds = 1;
        let mut share = 1.0;
        let mut best = self.place(surface, branch.unknowns.clone(), rounds)?;
        loop {
            let (strength, step) = best.data(self, &best.prior).chosen().ok_or(FitError::Singular)?;
            let here = best.data(self, &best.prior).here(strength).ok_or(FitError::Singular)?;
            let least = if share < 1.0 { CLOSE } else { THERE };
            let is_last = here.to_go() < least && rounds >= LINEARISATIONS[0];
            if is_last || rounds == LINEARISATIONS[1] {
                let outcome = best.data(self, &best.prior).outcome(strength, &here, rounds);
                return Ok(best.concluded(outcome, here));
            }
            let limit = share_of_step(&best.prior, &best.unknowns, &step.unknowns);
            rounds += 1;
            let tried =
                self.place(surface, between(&best.unknowns, &step.unknowns, share * limit), rounds)?;
            let loss = |place: &SolvedPlace| place.data(self, &best.prior).loss(strength);
            if loss(&tried).zip(loss(&best)).is_some_and(|(tried, best)| tried < best) {
                (best, share) = (tried, 1.0);
            } else {
                share *= DAMPED;
            }
        }
    }

    /// Solves all cells at some unknowns.
    fn place(&self, surface: &Surface, unknowns: Vec<f64>, round: usize) -> Result<SolvedPlace, FitError> {
        let task = self.task;
        self.watch.stage(&format!("linearisation {round} on all cells"));
        let prior = self.prior().adapted(&unknowns);
        let index = prior.index(&unknowns);
        is_an_index(task, &index)?;
        let linearised = self.solved(&index, task.coats_measured, usize::MAX)?;
        let log_thickness = prior.log_thickness(&unknowns);
        let solved = Origin::Solved(&linearised);
        let mut response = solved.response(task, &task.measured, &index, log_thickness)?;
        surface.steady(task, &mut response, &index, log_thickness)?;
        let grid = task.measured.iter().map(|drawdown| self.grid_error(drawdown)).collect();
        Ok(SolvedPlace { unknowns, prior, index, log_thickness, linearised, response, grid })
    }

    /// Error of a reflectance factor due to the grid: that of R, and that of T on both ways.
    fn grid_error(&self, drawdown: &Drawdown) -> f64 {
        let nm = self.task.wavelengths_nm();
        let albedo = drawdown.albedo(nm[nm.len() / 2]).unwrap_or(1.0);
        on_card(self.resolved[drawdown.coat].grid_error, albedo)
    }

    /// The layers that are to be predicted, at the index found.
    fn forecasts(&self, outcome: &FitOutcome) -> Result<Vec<Forecast>, FitError> {
        let task = self.task;
        if task.predicted.is_empty() {
            return Ok(Vec::new());
        }
        self.watch.stage("predictions of other layers");
        let index: Vec<[f64; 2]> = outcome.index.iter().map(|row| [row.n, row.kappa]).collect();
        let source = Origin::Solved(&self.solved(&index, task.coats.len(), usize::MAX)?);
        let response = source.response(task, &task.predicted, &index, outcome.log_thickness)?;
        let forecast = |(k, drawdown): (usize, &Drawdown)| {
            Forecast::new(task, drawdown, k, &response, &outcome.index, outcome.face_light)
        };
        Ok(task.predicted.iter().enumerate().map(forecast).collect())
    }
}

/// Error of the reflectance factor of a layer on a card, at most R + ρ T², from those of R and T.
fn on_card(error: GridError, albedo: f64) -> f64 {
    error.reflectance.hypot(2.0 * albedo * error.transmittance)
}

/// \[n, κ\] in the middle of what pigments have.
fn typical(task: &FitTask) -> [f64; 2] {
    let [_, most] = task.settings.kappa;
    [task.binder_index() + 0.2, 0.25 * most]
}

/// Refuses an index that no study would take.
fn is_an_index(task: &FitTask, index: &[[f64; 2]]) -> Result<(), FitError> {
    for (&[n, kappa], &wavelength_nm) in index.iter().zip(task.wavelengths_nm()) {
        if !(INDEX.holds(n) && ABSORPTION.holds(kappa)) {
            return Err(FitError::NoIndex { wavelength_nm, n, kappa });
        }
    }
    Ok(())
}

/// Unknowns at which all cells are solved.
struct SolvedPlace {
    unknowns: Vec<f64>,
    prior: IndexPrior,
    index: Vec<[f64; 2]>,
    log_thickness: f64,
    linearised: Vec<Linearised>,
    response: Response,
    /// Error of the grid of every drawdown.
    grid: Vec<f64>,
}

impl SolvedPlace {
    /// The data linearised here, under a prior.
    fn data<'a>(&'a self, run: &FitRun<'a>, prior: &'a IndexPrior) -> Data<'a> {
        Data::new(run.task, prior, &self.unknowns, &self.response, &self.grid)
    }

    fn concluded(self, outcome: FitOutcome, step: FitStep) -> FitSolution {
        let Self { prior, index, log_thickness, linearised, .. } = self;
        FitSolution { outcome, prior, step, linearised, index, log_thickness }
    }
}

/// A branch carried to the end with solves on all cells.
struct FitSolution {
    outcome: FitOutcome,
    /// The prior, the unknowns with the way left, and the solves there.
    prior: IndexPrior,
    step: FitStep,
    linearised: Vec<Linearised>,
    /// Index and logarithm of the factor on the thicknesses.
    index: Vec<[f64; 2]>,
    log_thickness: f64,
}

#[cfg(test)]
pub(super) mod coverage_tests;
#[cfg(test)]
mod statistics_tests;
