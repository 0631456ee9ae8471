//! Solves with their derivatives with respect to one pigment's index, on common packings.
//!
//! One study after another, equal but for that index, is solved on the same cells and the same
//! grids: so differences between them are those of the index alone.

use super::collected::{Collected, Realisation, RunSettings};
use super::crew::{processor_seconds, work_through};
use super::point::{Grids, PointError, PointSolver, Stopper, attempt, system_of, systems_of};
use super::realisation::Packings;
use super::resolve::{Resolved, size, with_room};
use super::watch::{Event, RunError, RunWatch};
use crate::input::study::{IndexSpectrum, Point, Study};
use crate::material::mixing::MixingRule;
use crate::material::spectra::{Sample, Spectrum};
use crate::solve::demand::{Admitted, TooLarge};
use crate::solve::gradient::{Neighbour, Slopes, tangent};
use crate::solve::{Solution, Solver};
use crate::store::record::{NotFinite, PointRecord};
use crate::store::{Key, PackingRecord, Record, Store};
use crate::wave::{Resolution, WaveError};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// Step in n to both sides; the error of the derivatives is its square.
const STEP: f64 = 1e-4;
/// Systems held at a time: at the index and on both sides of it.
const SYSTEMS: f64 = 3.0;
/// Part of the list of solves between two of a trial: the golden section, which spreads any number
/// of them over wavelengths and directions.
const SPREAD: f64 = 0.618;

/// One solve, and the derivatives of its efficiencies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TangentRecord {
    /// The solve.
    pub point: PointRecord,
    /// Order → \[reflected, transmitted\] → \[d/dn, d/dκ\] of the efficiency.
    pub slopes: Vec<[Slopes; 2]>,
}

impl Record for TangentRecord {
    const KIND: &'static str = "tangent";
}

impl TangentRecord {
    /// The solve as it would be, to first order, with n and κ changed by `step`.
    pub fn moved(&self, step: Slopes) -> PointRecord {
        let mut moved = self.point.clone();
        let mut totals = [0.0; 2];
        for (order, slopes) in moved.orders.iter_mut().zip(&self.slopes) {
            for side in 0..2 {
                let change = slopes[side][0] * step[0] + slopes[side][1] * step[1];
                order.efficiencies[side] += change;
                totals[side] += change;
            }
        }
        moved.reflectance += totals[0];
        moved.transmittance += totals[1];
        moved.absorptance -= totals[0] + totals[1];
        moved
    }
}

/// All solves of a study with their derivatives; a realisation lacks what failed.
#[derive(Clone, Debug)]
pub struct Linearised {
    resolved: Resolved,
    realisations: Vec<(PackingRecord, Vec<Option<TangentRecord>>)>,
}

impl Linearised {
    /// The records of the study with n and κ changed by `step` everywhere, to first order.
    pub fn collected(&self, step: Slopes) -> Collected {
        let moved = |record: &Option<TangentRecord>| record.as_ref().map(|r| r.moved(step));
        let realisation = |(packing, points): &(PackingRecord, Vec<Option<TangentRecord>>)| Realisation {
            packing: packing.clone(),
            points: points.iter().map(moved).collect(),
            finer: Vec::new(),
            moved: Vec::new(),
            failures: Vec::new(),
        };
        Collected {
            resolved: self.resolved,
            realisations: self.realisations.iter().map(realisation).collect(),
            refused: Vec::new(),
            enough: false,
            substacks: Vec::new(),
            damages: Vec::new(),
        }
    }
}

impl Study {
    /// This study with another index of one pigment, at the study's wavelengths.
    pub fn with_index(&self, pigment: usize, index: &[Complex64]) -> Study {
        let mut study = self.clone();
        let rows = self.wavelengths_nm.iter().zip(index);
        let samples: Vec<Sample> =
            rows.map(|(&wavelength_nm, eta)| Sample { wavelength_nm, n: eta.re, kappa: eta.im }).collect();
        // n and κ of a fit are positive and finite; a single wavelength is a constant
        let spectrum = match samples[..] {
            [only] => Spectrum::Constant { n: only.n, kappa: only.kappa },
            _ => Spectrum::tabulated("fitted", samples).unwrap_or(Spectrum::VACUUM),
        };
        let source = "fitted".into();
        let index = index.to_vec();
        let dissolved = Vec::new();
        study.pigments[pigment].material =
            IndexSpectrum { source, index, spectrum, dissolved, mixing: MixingRule::default() };
        study
    }
}

/// One packing on the grids that its waves need.
struct TangentCell {
    record: PackingRecord,
    key: Key,
    grids: Arc<Grids>,
}

/// The cells of a study, kept for all indices of a pigment.
pub struct Tangents {
    pigment: usize,
    resolved: Resolved,
    cells: Vec<TangentCell>,
    store: Store<TangentRecord>,
    settings: RunSettings,
}

impl Tangents {
    /// Packs the study's realisations; those without room are left out.
    ///
    /// # Errors
    /// No packing at all, or a stop.
    pub fn new(
        (study, pigment): (&Study, usize),
        resolved: Resolved,
        store: Store<TangentRecord>,
        settings: RunSettings,
        watch: &dyn RunWatch,
    ) -> Result<Self, RunError> {
        let mut packings = Packings::new(study, watch);
        let all = study.realisations;
        let packed = with_room(0..all, all, |r| packings.on_grids(r).map_err(RunError::stopped))?;
        let cell = |(realisation, grids): (usize, Arc<Grids>)| TangentCell {
            record: PackingRecord::new(realisation, &grids.packing),
            key: Key::of_packing(&study.packing_request(realisation)),
            grids,
        };
        Ok(Self { pigment, resolved, cells: packed.into_iter().map(cell).collect(), store, settings })
    }

    /// Solves `study` and its derivatives in the first `most` cells, where the store lacks them.
    ///
    /// # Errors
    /// A stop, a store that cannot be written, or a study without any result; a solve that fails
    /// costs its realisation.
    pub fn linearised(
        &self,
        study: &Study,
        most: usize,
        watch: &dyn RunWatch,
    ) -> Result<Linearised, RunError> {
        let cells = self.cells.iter().take(most).map(|cell| CellTask { tangents: self, study, cell, watch });
        let solved = cells.map(|task| Ok((task.cell.record.clone(), task.solve_all()?)));
        let realisations = solved.collect::<Result<_, RunError>>()?;
        Ok(Linearised { resolved: self.resolved, realisations })
    }

    /// What one of these studies' solves costs, a mean over one of each, which are not stored, and
    /// what the geometry of a cell costs.
    ///
    /// # Errors
    /// The grid does not fit into memory.
    pub fn trial(&self, studies: &[Study], watch: &dyn RunWatch) -> Result<TrialCost, RunError> {
        let mut geometry = 0.0;
        let mut solve = 0.0;
        for (k, study) in studies.iter().enumerate() {
            let task = CellTask { tangents: self, study, cell: &self.cells[k % self.cells.len()], watch };
            let keyed = task.keyed();
            let requested = study.solver.build();
            let solver = task.admitted(&*requested)?.0;
            let place = (SPREAD * k as f64).fract() * keyed.len() as f64;
            let tried = &keyed[place as usize];
            // kept by the cell: the first solve of a grid would pay for all
            let made =
                timed(|| task.cell.grids.problems(study, task.grid(&tried.0), &tried.0, watch).is_ok());
            geometry += made.0;
            // a solve that fails takes its time as well
            solve += timed(|| task.solve(tried, solver.solver()).is_ok()).0;
        }
        let count = studies.len().max(1);
        let cells = count.min(self.cells.len());
        Ok(TrialCost { geometry: geometry / cells as f64, solve: solve / count as f64 })
    }
}

/// Processor seconds of parts of the work.
#[derive(Clone, Copy, Debug)]
pub struct TrialCost {
    /// Of the geometry of a cell.
    pub geometry: f64,
    /// Of one solve with its derivatives.
    pub solve: f64,
}

/// Processor seconds of some work (on the clock where the system does not tell), and its result.
pub fn timed<R>(work: impl FnOnce() -> R) -> (f64, R) {
    let clock = std::time::Instant::now();
    let before = processor_seconds();
    let result = work();
    let used = processor_seconds().zip(before).map(|(after, before)| after - before);
    (used.unwrap_or_else(|| clock.elapsed().as_secs_f64()), result)
}

/// The solves of one study in one cell.
#[derive(Clone, Copy)]
struct CellTask<'a> {
    tangents: &'a Tangents,
    study: &'a Study,
    cell: &'a TangentCell,
    watch: &'a dyn RunWatch,
}

impl CellTask<'_> {
    /// The strategy with its share of the memory, and the number of solves at a time.
    fn admitted<'s>(&self, requested: &'s dyn Solver) -> Result<(Admitted<'s>, usize), TooLarge> {
        let draw = self.study.draw(self.cell.record.realisation);
        let size = size(self.study, self.tangents.resolved.for_cell(&draw));
        self.tangents.settings.admit(&size, requested, SYSTEMS, self.watch)
    }

    /// Solves what the store lacks.
    fn solve_all(&self) -> Result<Vec<Option<TangentRecord>>, RunError> {
        let Self { tangents, study, watch, .. } = *self;
        let keyed = self.keyed();
        let stored = keyed.iter().map(|(_, key)| tangents.store.get(key.as_str()));
        let records: Vec<_> =
            stored.map(|record| record.map_or_else(OnceLock::new, OnceLock::from)).collect();
        let todo: Vec<_> = keyed.iter().zip(&records).filter(|(_, record)| record.get().is_none()).collect();
        watch.hear(Event::Kept(keyed.len() - todo.len()));
        let requested = study.solver.build();
        let (solver, jobs) = self.admitted(&*requested)?;
        work_through(todo.len(), jobs, watch, |k| {
            let (keyed, record) = todo[k];
            let solved =
                attempt(study, &tangents.store, watch, keyed, || self.solve(keyed, solver.solver()))?;
            Ok(keep(solved, record))
        })?;
        if watch.stop() {
            return Err(RunError::Stopped);
        }
        Ok(records.into_iter().map(OnceLock::into_inner).collect())
    }

    /// The solves in a cell, with content hashes of all that they and their derivatives depend on.
    fn keyed(&self) -> Vec<(Point, Key)> {
        let study = self.study;
        let mut keyed = Vec::new();
        let error = study.resolution.coverage_error();
        for point in study.points(self.cell.record.realisation) {
            let method = (self.grid(&point), &study.solver, &study.goal, error, STEP);
            let indices = study.indices(point.incidence.wavelength_um);
            let inputs = (&self.cell.key, indices, &point.incidence, method, self.tangents.pigment);
            keyed.push((point, Key::of_wave("tangent", &inputs, point.polarisation)));
        }
        keyed
    }

    fn grid(&self, point: &Point) -> Resolution {
        let draw = self.study.draw(self.cell.record.realisation);
        self.tangents.resolved.for_wave(self.study, &draw, point.incidence.wavelength_um)
    }

    fn solve(&self, (point, key): &(Point, Key), solver: &dyn Solver) -> Result<TangentRecord, PointError> {
        let Self { tangents: &Tangents { pigment, resolved, .. }, study, cell, watch } = *self;
        let (systems, geometry) = cell.grids.problems(study, self.grid(point), point, watch)?;
        let system = system_of(&systems, point);
        let Solution { field, account } = solver.solve(&**system, study.goal, &mut Stopper(watch))?;
        let neighbour = |step: f64| -> Result<Neighbour, WaveError> {
            let eta = study.pigments[pigment].material.index_at(point.incidence.wavelength_um);
            let moved = study.with_index(pigment, &vec![eta + step; study.wavelengths_nm.len()]);
            Ok(Neighbour {
                step: step.into(),
                system: system_of(systems_of(&moved, &geometry, point)?, point),
            })
        };
        let neighbours = [neighbour(STEP)?, neighbour(-STEP)?];
        let slopes = tangent(&**system, &field, &neighbours, solver, study.goal, &mut Stopper(watch))?;
        let far = system.far_field(&field);
        let kept = far.orders.iter().zip(&slopes.orders);
        let kept = kept.filter(|(order, _)| order.reflected_propagates || order.transmitted_propagates);
        let slopes: Vec<_> = kept.map(|(_, slopes)| [slopes.reflected, slopes.transmitted]).collect();
        if !slopes.iter().flatten().flatten().all(|slope| slope.is_finite()) {
            return Err(NotFinite.into());
        }
        let point_solver = PointSolver { study, solver, grid: resolved.grid_error, watch };
        Ok(TangentRecord { point: point_solver.record(far, account, point, key.as_str())?, slopes })
    }
}

/// Keeps the record of a solve; a failure leaves its place empty.
fn keep<E>(solved: Result<TangentRecord, E>, place: &OnceLock<TangentRecord>) {
    if let Ok(record) = solved {
        place.get_or_init(|| record);
    }
}
