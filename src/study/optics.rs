//! The physics of a run, step by step: packing → scene → coverage → solve → far field.

use super::checked::{Point, Study};
use super::watch::RunWatch;
use crate::ink::{PackError, PackProgress, PackWatch, Packing, pack};
use crate::report::record::{NotFinite, PointRecord, SolveAccount};
use crate::solve::{SolveError, Step, Watch};
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

/// Packs the grains of a realisation; stops when the watch says so. A clear layer has nothing to pack.
pub fn pack_realisation(
    study: &Study,
    realisation: usize,
    watch: &dyn RunWatch,
) -> Result<Packing, PackError> {
    let request = study.packing_request(realisation);
    if request.pigments.is_empty() {
        return Packing::from_grains(request.period_um, request.thickness_um, true, Vec::new());
    }
    pack(&request, &mut Stopper(watch))
}

/// Solves one point and keeps what it found under `key`.
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
pub(super) struct Stopper<'a>(pub &'a dyn RunWatch);

impl Stopper<'_> {
    fn go_on(&self) -> ControlFlow<()> {
        if self.0.stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Watch for Stopper<'_> {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        self.go_on()
    }
}

impl PackWatch for Stopper<'_> {
    fn progress(&mut self, _: &PackProgress) -> ControlFlow<()> {
        self.go_on()
    }
}
