//! Carries a fit out: table, search, Gauss–Newton, errors.

mod advice;
mod outcome;
mod solutions;

pub use outcome::{FitOutcome, FittedIndex, FittedSpectrum, Forecast, OtherSolution, Trust};

use super::law::{Data, FitStep, LinearFit};
use super::load::{Drawdown, FitTask};
use super::prior::IndexPrior;
use super::response::{Origin, Response};
use super::start::{Surface, TABLE_ERROR, paths};
use crate::evaluate::seen::NoInk;
use crate::input::limits::{ABSORPTION, INDEX};
use crate::input::study::Study;
use crate::run::collected::{RunSettings, Stores};
use crate::run::resolve::{Resolved, resolve};
use crate::run::tangents::{Linearised, Tangents, timed};
use crate::run::watch::{RunError, RunWatch};
use crate::solve::accuracy::grid_error::GridError;
use crate::store::Store;
use crate::store::folder::OutputFolder;
use crate::wave::Scene;
use faer::Mat;
use num_complex::Complex64;
use outcome::UNDETERMINED;
use thiserror::Error;

/// Cells of the coarse table.
const TABLE_CELLS: usize = 2;
/// Linearisations of one branch on all cells: at least, and at most.
const LINEARISATIONS: [usize; 2] = [2, 4];
/// A step that moves the data by less than this share of the noise is the last one.
const SMALL_STEP: f64 = 0.5;
/// Largest change of n in one step.
const LARGEST_STEP: f64 = 0.15;
/// Strength before any is chosen.
const FIRST_STRENGTH: f64 = 0.06;
/// Iterations on the table, and halvings of a step that leads uphill.
const ITERATIONS: usize = 12;
const HALVINGS: usize = 5;
/// Points of the global search, and evaluations of the table in the descents from its paths, of
/// which a plan times one.
const EVALUATIONS: f64 = 400.0;
/// Solves that a plan times at the nodes of the table, and at a typical index.
const TRIED: [usize; 2] = [12, 6];

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

/// Solves, each with its derivatives, that a fit takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedSolves {
    /// Of the coarse table.
    pub table: usize,
    /// Of one linearisation on all cells.
    pub linearisation: usize,
    /// Of the predicted layers.
    pub predicted: usize,
}

impl PlannedSolves {
    /// Branches of n that are carried to the end at most.
    pub const BRANCHES: usize = 3;
    /// Linearisations of a fit: at least, and at most where all branches are carried to the end.
    pub const LINEARISATIONS: [usize; 2] = [LINEARISATIONS[0], Self::BRANCHES * LINEARISATIONS[1]];

    /// The solves of a fit.
    pub fn of(task: &FitTask) -> Self {
        let each = |coats: &[Study]| coats.iter().map(Study::solves_each).sum::<usize>();
        let cells = task.coats[0].realisations;
        let measured = each(&task.coats[..task.coats_measured]);
        Self {
            table: measured * Surface::indices(task).len() * TABLE_CELLS.min(cells),
            linearisation: measured * cells,
            predicted: if task.predicted.is_empty() { 0 } else { each(&task.coats) * cells },
        }
    }

    /// Most solves.
    pub fn most(&self) -> usize {
        self.table + Self::LINEARISATIONS[1] * self.linearisation + self.predicted
    }
}

/// Processor seconds of the parts of a fit.
#[derive(Clone, Copy, Debug)]
pub struct FitCosts {
    /// Of the coarse table, with the search on it.
    pub table: f64,
    /// Of one linearisation on all cells.
    pub linearisation: f64,
    /// Of the predicted layers.
    pub predicted: f64,
}

impl FitCosts {
    /// Processor seconds of a fit with a number of linearisations.
    pub fn total(&self, linearisations: usize) -> f64 {
        self.table + linearisations as f64 * self.linearisation + self.predicted
    }
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

    /// Processor seconds of the parts of this fit, from a few solves of every layer, spread over
    /// the nodes of the table, the wavelengths and the directions, and from one evaluation.
    ///
    /// # Errors
    /// As [`Tangents::linearised`]; the films give no spectra.
    pub fn trial(&self) -> Result<FitCosts, FitError> {
        let task = self.task;
        let nodes = Surface::indices(task);
        let typical = self.typical();
        let solves = PlannedSolves::of(task);
        let layers = task.coats.len();
        let mut costs = FitCosts { table: 0.0, linearisation: 0.0, predicted: 0.0 };
        for (number, (coat, tangents)) in task.coats.iter().zip(&self.cells).enumerate() {
            let coat_at = |eta: [f64; 2]| {
                let eta = Complex64::new(eta[0], eta[1]);
                coat.with_index(task.pigment, &vec![eta; coat.wavelengths_nm.len()])
            };
            let spread = TRIED[0].div_ceil(layers).max(4);
            let of_table: Vec<Study> =
                (0..spread).map(|k| coat_at(nodes[k * nodes.len() / spread])).collect();
            let of_fit = vec![coat_at(typical); TRIED[1].div_ceil(layers).max(3)];
            let of_fit = tangents.trial(&of_fit, self.watch)?;
            let cells = coat.realisations as f64;
            let all_cells = cells * (of_fit.geometry + coat.solves_each() as f64 * of_fit.solve);
            if number < task.coats_measured {
                let of_table = tangents.trial(&of_table, self.watch)?;
                let each = (nodes.len() * TABLE_CELLS * coat.solves_each()) as f64;
                costs.table += each * of_table.solve + cells * of_fit.geometry;
                costs.linearisation += cells * coat.solves_each() as f64 * of_fit.solve;
            }
            if solves.predicted > 0 {
                costs.predicted += all_cells;
            }
        }
        let index = vec![typical; task.wavelengths_nm().len()];
        let (seconds, response) =
            timed(|| Origin::Film.response(task, &task.measured, &index, 0.0).map(drop));
        response?;
        costs.table += EVALUATIONS * seconds;
        Ok(costs)
    }

    /// \[n, κ\] for which grids are chosen and plans made.
    fn typical(&self) -> [f64; 2] {
        typical(self.task)
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
        let candidates = self.candidates(&Surface::new(task, &solved, &films))?;
        let mut outcome = solutions::concluded(task, self.carried_out(&candidates)?)?;
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
    fn carried_out(&self, candidates: &[Branch]) -> Result<Vec<FitSolution>, FitError> {
        let least = candidates.first().ok_or(FitError::Singular)?.cost;
        let prior = self.prior();
        let mut known: Vec<Vec<f64>> = Vec::new();
        let mut solutions = Vec::new();
        for branch in candidates.iter().filter(|branch| branch.cost < least + solutions::AS_GOOD) {
            let start: Vec<f64> = prior.index(&branch.unknowns).iter().map(|row| row[0]).collect();
            let is_new = known.iter().all(|n| solutions::apart(n, &start) > UNDETERMINED);
            if is_new && solutions.len() < PlannedSolves::BRANCHES {
                let solution = self.refine(branch)?;
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

    /// Gauss–Newton with solves on all cells.
    fn refine(&self, branch: &Branch) -> Result<FitSolution, FitError> {
        let task = self.task;
        let mut unknowns = branch.unknowns.clone();
        let grid: Vec<f64> = task.measured.iter().map(|drawdown| self.grid_error(drawdown)).collect();
        let mut rounds = 0;
        loop {
            rounds += 1;
            self.watch.stage(&format!("linearisation {rounds} on all cells"));
            let prior = self.prior().adapted(&unknowns);
            let index = prior.index(&unknowns);
            is_an_index(task, &index)?;
            let linearised = self.solved(&index, task.coats_measured, usize::MAX)?;
            let log_thickness = prior.log_thickness(&unknowns);
            let response =
                Origin::Solved(&linearised).response(task, &task.measured, &index, log_thickness)?;
            let data = Data::new(task, &prior, &unknowns, &response, &grid);
            let (strength, step) = data.chosen().ok_or(FitError::Singular)?;
            let moved = data.moved(&step.unknowns) / task.settings.noise;
            let share = share_of_step(&prior, &unknowns, &step.unknowns);
            let last = share == 1.0 && moved < SMALL_STEP && rounds >= LINEARISATIONS[0];
            if last || rounds == LINEARISATIONS[1] {
                is_an_index(task, &prior.index(&step.unknowns))?;
                let outcome = data.outcome(strength, &step, rounds);
                return Ok(FitSolution { outcome, prior, step, linearised, index, log_thickness });
            }
            unknowns = between(&unknowns, &step.unknowns, share);
        }
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
        let forecast =
            |(k, drawdown): (usize, &Drawdown)| Forecast::new(task, drawdown, k, &response, outcome);
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

/// A branch carried to the end with solves on all cells.
struct FitSolution {
    outcome: FitOutcome,
    /// The prior, the step and the solves of the last linearisation.
    prior: IndexPrior,
    step: FitStep,
    linearised: Vec<Linearised>,
    /// Index and logarithm of the factor on the thicknesses at that linearisation.
    index: Vec<[f64; 2]>,
    log_thickness: f64,
}

/// A branch that fits the data on the table.
pub(super) struct Branch {
    pub unknowns: Vec<f64>,
    /// Minus twice the logarithm of the evidence.
    cost: f64,
}

/// The prior of a fit.
pub(super) fn prior_of(task: &FitTask) -> IndexPrior {
    let thickness = !task.settings.also.is_empty();
    let nm = task.wavelengths_nm();
    let prior = IndexPrior::new(task.settings.prior, nm, task.binder_index(), thickness);
    match task.settings.known_n {
        Some(known) => prior.with_known(nm, known),
        None => prior,
    }
}

/// Gauss–Newton on a table, with the strength of the prior chosen by the evidence on the way;
/// `systematic` are the table's errors as [`Data::new`] takes them.
pub(super) fn descend(
    task: &FitTask,
    prior: &IndexPrior,
    start: Vec<f64>,
    systematic: &[f64],
    response_at: impl Fn(&[f64]) -> Result<Response, FitError>,
) -> Result<Branch, FitError> {
    let mut unknowns = start;
    let mut response = response_at(&unknowns)?;
    for round in 0..ITERATIONS {
        let early = round < ITERATIONS / 3;
        let prior = if early { prior } else { &prior.adapted(&unknowns) };
        let data = Data::new(task, prior, &unknowns, &response, systematic);
        let chosen =
            if early { data.step(FIRST_STRENGTH).map(|step| (FIRST_STRENGTH, step)) } else { data.chosen() };
        let (strength, step) = chosen.ok_or(FitError::Singular)?;
        let before = data.cost(strength).ok_or(FitError::Singular)?;
        let mut share = 1.0;
        let mut moved = None;
        for _ in 0..HALVINGS {
            let tried = between(&unknowns, &step.unknowns, share);
            let response = response_at(&tried)?;
            let data = Data::new(task, prior, &tried, &response, systematic);
            if data.cost(strength).is_some_and(|cost| cost < before) {
                moved = Some((tried, response));
                break;
            }
            share *= 0.4;
        }
        let Some((next, there)) = moved else { break };
        (unknowns, response) = (next, there);
    }
    let prior = prior.adapted(&unknowns);
    let data = Data::new(task, &prior, &unknowns, &response, systematic);
    let cost = -2.0 * data.chosen().ok_or(FitError::Singular)?.1.log_evidence;
    Ok(Branch { unknowns, cost })
}

/// The unknowns whose index is nearest to a path of \[n, κ\].
pub(super) fn near(prior: &IndexPrior, path: &[[f64; 2]]) -> Option<Vec<f64>> {
    let waves = path.len();
    let count = prior.count();
    let rows = |i: usize| if i < waves { &prior.n[i] } else { &prior.kappa[i - waves] };
    let expected = |i: usize| rows(i).iter().zip(&prior.mean).map(|(a, x)| a * x).sum::<f64>();
    let residual: Vec<f64> = (0..2 * waves).map(|i| path[i % waves][i / waves] - expected(i)).collect();
    let covariance = Mat::from_fn(2 * waves, 2 * waves, |i, j| if i == j { 4e-4 } else { 0.0 });
    let problem = LinearFit {
        jacobian: &Mat::from_fn(2 * waves, count, |i, j| rows(i)[j]),
        residual: &residual,
        covariance: &covariance,
        point: &prior.mean,
        mean: &prior.mean,
        precision: &prior.precision(FIRST_STRENGTH),
        positive: &prior.positive,
    };
    Some(problem.step()?.unknowns)
}

fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
}

/// Share of a step that keeps the change of n within its limit.
fn share_of_step(prior: &IndexPrior, from: &[f64], to: &[f64]) -> f64 {
    let (from, to) = (prior.index(from), prior.index(to));
    let largest = from.iter().zip(&to).map(|(a, b)| (b[0] - a[0]).abs()).fold(0.0, f64::max);
    (LARGEST_STEP / largest.max(1e-12)).min(1.0)
}

#[cfg(test)]
pub(super) mod coverage_tests;
#[cfg(test)]
mod statistics_tests;
