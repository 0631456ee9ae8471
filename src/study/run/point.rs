//! The physics of a run, step by step: packing → scene → coverage → solve → far field, and one
//! packing on the grids that its waves need.

use super::watch::{Event, RunWatch};
use crate::ink::pack;
use crate::ink::{PackError, PackProgress, PackWatch, Packing};
use crate::input::study::{Point, Study};
use crate::solve::accuracy::grid_error::GridError;
use crate::solve::accuracy::raised;
use crate::solve::{Account, GridTrial, SolveError, Solver, Step, Watch};
use crate::store::record::{NotFinite, PointRecord, SolveAccount};
use crate::store::{Key, Record, Store};
use crate::wave::{
    FarField, Geometry, Mean, Precision, Resolution, Scene, System, TotalErrors, Unphysical, WaveError,
};
use std::io;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

/// Why a point has no result.
#[derive(Debug, thiserror::Error)]
pub enum PointError {
    /// The scene, the light or the grid was refused.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The solver gave up or was stopped.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The result violates a physical law.
    #[error(transparent)]
    Unphysical(#[from] Unphysical),
    /// A number in the record is not finite.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
}

impl PointError {
    /// True if the user stopped the solve, which is not a failure.
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Solve(SolveError::Cancelled { .. }) | Self::Wave(WaveError::Stopped))
    }
}

/// Packs the grains of a realisation, if they have room in the memory; can be stopped by the watch.
pub fn pack_realisation(
    study: &Study,
    realisation: usize,
    watch: &dyn RunWatch,
) -> Result<Packing, PackError> {
    let request = study.packing_request(realisation);
    request.fits(super::memory::usable())?;
    pack(&request, &mut Stopper(watch))
}

/// Safety factor: other solves may have errors of R and T this many times those of the test solves.
const BEYOND_PROBES: f64 = 3.0;

fn total_errors(grid: GridError, residual: f64) -> TotalErrors {
    TotalErrors::of_totals([grid.reflectance, grid.transmittance].map(|e| BEYOND_PROBES * e), residual)
}

/// Whether a stored record passes the check for new results, which older programs did not make.
pub fn is_physical(record: &PointRecord, grid: GridError) -> bool {
    record.far_field().judged(total_errors(grid, record.account.residual)).is_ok()
}

/// What the solves of one realisation share.
#[derive(Clone, Copy)]
pub struct PointSolver<'a> {
    /// The study.
    pub study: &'a Study,
    /// The solver.
    pub solver: &'a dyn Solver,
    /// Expected errors of R and T.
    pub grid: GridError,
    /// Follows the progress.
    pub watch: &'a dyn RunWatch,
}

impl PointSolver<'_> {
    /// Solves one point on the one of `systems` with its polarisation and returns the record with
    /// its `key`.
    ///
    /// It starts from zero. Starting from the field of a neighbouring angle or wavelength was tried
    /// (2.5 µm, 30 % of 200 nm, residual 2e-5): a neighbouring angle costs 1 to 2 more of 12 to 19
    /// iterations, 20 nm or even 5 nm save one at most, because the phase of the incident wave
    /// changes everywhere. The geometry is shared, and so is the problem of s and p.
    pub fn solve(
        &self,
        systems: &[Box<dyn System>],
        point: &Point,
        key: &str,
    ) -> Result<PointRecord, PointError> {
        let system = system_of(systems, point);
        let mut goal = self.study.goal;
        let mut solution = self.solver.solve(&**system, goal, &mut Stopper(self.watch))?;
        loop {
            let account = solution.account.clone();
            let record = self.record(system.far_field(&solution.field), account, point, key);
            let broken = matches!(record, Err(PointError::Unphysical(Unphysical::OutOfBalance { .. })));
            let Some(smaller) = goal.smaller().filter(|_| broken) else { return record };
            goal = smaller;
            let start = Some(&solution.field);
            let mut further = self.solver.solve_from(&**system, start, goal, &mut Stopper(self.watch))?;
            further.account.follow(&solution.account);
            solution = further;
        }
    }

    /// The record of a solve whose result violates no physical law.
    pub(super) fn record(
        &self,
        far_field: FarField,
        account: Account,
        point: &Point,
        key: &str,
    ) -> Result<PointRecord, PointError> {
        let Account { solver, steps, operator_applications, residual, seconds, .. } = account;
        let far_field = far_field.judged(total_errors(self.grid, residual))?;
        let account = SolveAccount { solver, steps, operator_applications, residual, seconds };
        let key = key.to_owned();
        let Point { realisation, polarisation, .. } = *point;
        Ok(PointRecord::new(key, realisation, polarisation, &far_field, account)?)
    }
}

/// The one of the systems with a point's polarisation.
pub(super) fn system_of<S: AsRef<dyn System>>(systems: impl IntoIterator<Item = S>, point: &Point) -> S {
    let system = systems.into_iter().find(|system| system.as_ref().polarisation() == point.polarisation);
    system.expect("points have the polarisations of their study's wave")
}

/// Runs a solve, announces it and stores its record. Without a result it returns the reason, or
/// nothing after a stop. The outer error is that of the store.
pub(super) fn attempt<R: Record>(
    study: &Study,
    store: &Store<R>,
    watch: &dyn RunWatch,
    keyed: &(Point, Key),
    solve: impl FnOnce() -> Result<R, PointError>,
) -> io::Result<Result<R, Option<String>>> {
    let (point, key) = keyed;
    watch.hear(Event::Solving(study, point));
    let solved = solve();
    watch.hear(Event::Ended);
    let reason = match solved {
        Ok(record) => {
            store.put(key.as_str(), &record)?;
            watch.hear(Event::Solved(point, None));
            return Ok(Ok(record));
        }
        Err(error) => (!error.is_stop()).then(|| error.to_string()),
    };
    reason.iter().for_each(|reason| watch.hear(Event::Solved(point, Some(reason))));
    Ok(Err(reason))
}

/// Problems of a point, one per polarisation.
pub type Systems = Vec<Box<dyn System>>;

/// The problems of a point.
///
/// # Errors
/// The scene cannot be discretised on the grid.
pub fn systems_of(study: &Study, geometry: &Geometry, point: &Point) -> Result<Systems, WaveError> {
    geometry.systems(&study.media(point.incidence.wavelength_um), &point.incidence, Mean::default())
}

/// Forwards the run's request to stop to packings and solvers.
pub struct Stopper<'a>(pub &'a dyn RunWatch);

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
        self.0.hear(Event::Grid(trial));
    }
}

impl PackWatch for Stopper<'_> {
    fn progress(&mut self, _: &PackProgress) -> ControlFlow<()> {
        self.go_on()
    }
}

/// The problems of a wave, one per polarisation, with the geometry that they share.
pub type Problems = (Systems, Geometry);

/// A packing on grids.
///
/// The grid of a wave was chosen on other packings and at the probed wavelengths. A cell of this
/// packing may contain more pigment, and a wavelength between the probes may meet a larger index,
/// for which the cells of the chosen grid are too high.
pub struct Grids {
    /// The packing.
    pub packing: Packing,
    /// By wave (vector or not), grid and error: inks that share a packing share them, and so do the
    /// polarisations.
    geometries: Mutex<Vec<((bool, Resolution, f64), Geometry)>>,
}

impl Grids {
    /// A packing on no grid yet.
    pub fn new(packing: Packing) -> Self {
        Self { packing, geometries: Mutex::default() }
    }

    /// The packing on a grid, computed once.
    ///
    /// # Errors
    /// The grid or the packing is refused, or a stop.
    pub fn geometry(
        &self,
        study: &Study,
        resolution: Resolution,
        watch: &dyn RunWatch,
    ) -> Result<Geometry, WaveError> {
        let error = study.resolution.coverage_error();
        let stop = || watch.stop();
        let requested = (study.wave.is_vector(), resolution, error);
        let mut all = self.geometries.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, geometry)) = all.iter().find(|(kept, _)| *kept == requested) {
            return Ok(geometry.clone());
        }
        let scene = Scene::from_packing(&self.packing);
        let geometry = Geometry::new(study.wave, &scene, resolution, Precision { error, stop: &stop })?;
        all.push((requested, geometry.clone()));
        Ok(geometry)
    }

    /// The problems of a point on the coarsest grid that can represent its wave, from `resolution`
    /// on; the choice depends on the point alone.
    ///
    /// # Errors
    /// The scene cannot be discretised, or a stop.
    pub fn problems(
        &self,
        study: &Study,
        mut resolution: Resolution,
        point: &Point,
        watch: &dyn RunWatch,
    ) -> Result<Problems, WaveError> {
        loop {
            let geometry = self.geometry(study, resolution, watch)?;
            match systems_of(study, &geometry, point) {
                Err(refusal @ WaveError::CellTooHigh { .. }) => {
                    resolution = raised(resolution, &refusal).ok_or(refusal)?;
                }
                made => return Ok((made?, geometry)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::record::tests::{account, two_orders};

    /// The seals of records written before this check are valid, so that only this check keeps them
    /// out of a report.
    #[test]
    fn a_kept_record_that_breaks_a_law_counts_as_absent() {
        let grid = GridError { reflectance: 1e-3, transmittance: 1e-3 };
        let kept = |reflectance: f64, absorptance: f64| {
            let mut far = two_orders();
            (far.reflectance, far.absorptance) = (reflectance, absorptance);
            far.orders[0].reflected_efficiency = reflectance;
            is_physical(&PointRecord::new("k".into(), 0, None, &far, account()).expect("finite"), grid)
        };
        assert!(kept(0.05, 0.45));
        assert!(!kept(29.6, -29.1), "light out of nothing");
        assert!(!kept(0.6, -0.1), "an absorptance below zero");
    }
}
