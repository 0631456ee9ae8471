//! The physics of a run, step by step: packing → scene → coverage → solve → far field.

use super::watch::RunWatch;
use crate::ink::pack;
use crate::ink::{PackError, PackProgress, PackWatch, Packing};
use crate::input::study::{Point, Study};
use crate::solve::accuracy::grid_error::GridError;
use crate::solve::{GridTrial, SolveError, Solver, Step, Watch};
use crate::store::record::{NotFinite, PointRecord, SolveAccount};
use crate::wave::{Coverage, Mean, Physical, Problem, TotalErrors, Unphysical, WaveError};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Why a point has no result.
#[derive(Debug, thiserror::Error)]
pub enum PointError {
    /// The scene does not make a problem on the grid.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The solve failed or was stopped.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The result breaks a law it must obey.
    #[error(transparent)]
    Unphysical(#[from] Unphysical),
    /// A number of the record is not finite.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
}

impl PointError {
    /// True when the user stopped the solve, which is no failure.
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Solve(SolveError::Cancelled { .. }))
    }
}

/// Packs the grains of a realisation; stops when the watch says so.
pub fn pack_realisation(
    study: &Study,
    realisation: usize,
    watch: &dyn RunWatch,
) -> Result<Packing, PackError> {
    let request = study.packing_request(realisation);
    pack(&request, &mut Stopper(watch))
}

/// How many times the errors of R and T at the probes others may have.
const BEYOND_PROBES: f64 = 3.0;

fn total_errors(grid: GridError, residual: f64) -> TotalErrors {
    TotalErrors::of_totals([grid.reflectance, grid.transmittance].map(|e| BEYOND_PROBES * e), residual)
}

/// True for a kept record that passes the gate a new one has to pass: older programs had none.
pub(crate) fn is_physical(record: &PointRecord, grid: GridError) -> bool {
    Physical::judge(record.far_field(), total_errors(grid, record.account.residual)).is_ok()
}

/// Solves one point and keeps what it found under `key`; `grid` is how wrong R and T may be.
///
/// It starts from nothing. The field of a neighbouring angle or wavelength was tried as a start (2.5 µm, 30 % of 200 nm,
/// residual 2e-5): another angle costs 1 to 2 steps more of 12 to 19, 20 nm and even 5 nm save none or one, since the
/// phase of the incident wave changes everywhere. What is shared is the coverage.
pub fn solve_point(
    study: &Study,
    solver: &dyn Solver,
    coverage: &Arc<Coverage>,
    point: &Point,
    grid: GridError,
    key: &str,
    watch: &dyn RunWatch,
) -> Result<PointRecord, PointError> {
    let media = study.media(point.incidence.wavelength_um);
    let problem = Problem::new(coverage, &media, &point.incidence, Mean::default())?;
    let solution = solver.solve(&problem, study.goal, &mut Stopper(watch))?;
    let account = SolveAccount {
        solver: solution.account.solver.clone(),
        steps: solution.account.steps,
        operator_applications: solution.account.operator_applications,
        residual: solution.account.residual,
        seconds: solution.account.seconds,
    };
    let errors = total_errors(grid, solution.account.residual);
    let far_field = Physical::judge(problem.far_field(&solution.field), errors)?;
    Ok(PointRecord::new(key.to_owned(), point.realisation, &far_field, account)?)
}

/// Passes the run's wish to stop on to packings and solvers.
pub(crate) struct Stopper<'a>(pub &'a dyn RunWatch);

impl Stopper<'_> {
    fn go_on(&self) -> ControlFlow<()> {
        if self.0.stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Watch for Stopper<'_> {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        self.go_on()
    }

    fn grid(&mut self, trial: &GridTrial) {
        self.0.stage(&format!("grid: {trial}"));
    }
}

impl PackWatch for Stopper<'_> {
    fn progress(&mut self, _: &PackProgress) -> ControlFlow<()> {
        self.go_on()
    }
}
