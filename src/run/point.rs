//! The physics of a run, step by step: packing → scene → coverage → solve → far field.

use super::watch::RunWatch;
use crate::ink::pack;
use crate::ink::{PackError, PackProgress, PackWatch, Packing};
use crate::input::study::{Point, Study};
use crate::solve::{GridTrial, SolveError, Step, Watch};
use crate::store::record::{NotFinite, PointRecord, SolveAccount};
use crate::wave::{Coverage, Mean, Problem, WaveError};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Why a point has no result.
#[derive(Debug, thiserror::Error)]
pub enum PointError {
    #[error(transparent)]
    Wave(#[from] WaveError),
    #[error(transparent)]
    Solve(#[from] SolveError),
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

/// Solves one point and keeps what it found under `key`.
///
/// It starts from nothing. The field of a neighbouring angle or wavelength was tried as a start (2.5 µm, 30 % of 200 nm,
/// residual 2e-5): another angle costs 1 to 2 steps more of 12 to 19, 20 nm and even 5 nm save none or one, since the
/// phase of the incident wave changes everywhere. What is shared is the coverage.
pub fn solve_point(
    study: &Study,
    coverage: &Arc<Coverage>,
    point: &Point,
    key: &str,
    watch: &dyn RunWatch,
) -> Result<PointRecord, PointError> {
    let media = study.media(point.wavelength);
    let problem = Problem::new(coverage, &media, &point.incidence, Mean::default())?;
    let solution = study.solver.build().solve(&problem, study.goal, &mut Stopper(watch))?;
    let account = SolveAccount {
        solver: solution.account.solver.clone(),
        steps: solution.account.steps,
        operator_applications: solution.account.operator_applications,
        residual: solution.account.residual,
        seconds: solution.account.seconds,
    };
    let far_field = problem.far_field(&solution.field);
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
