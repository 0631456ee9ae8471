//! Solves with their derivatives with respect to one pigment's index, on common packings.
//!
//! One study after another, equal but for that index, is solved on the same cells and the same
//! grids: so differences between them are those of the index alone.

use super::collected::{Collected, Realisation, RunSettings};
use super::crew::{processor_seconds, work_through};
use super::error::RunError;
use super::point::{PointError, Stopper, pack_realisation, systems_of, total_errors};
use super::resolve::{Resolved, size};
use super::watch::{Event, RunWatch};
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::material::mixing::MixingRule;
use crate::material::spectra::{Sample, Spectrum};
use crate::solve::accuracy::raised;
use crate::solve::demand::Admitted;
use crate::solve::gradient::{Neighbour, Slopes, tangent};
use crate::solve::{Solution, Solver};
use crate::store::identity::Key;
use crate::store::packing_record::PackingRecord;
use crate::store::record::{NotFinite, PointRecord, SolveAccount};
use crate::store::{Record, Store};
use crate::wave::{Geometry, Physical, Precision, Resolution, Scene, System, WaveError};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::io;
use std::sync::{Mutex, PoisonError};

/// Step in n to both sides; the error of the derivatives is its square.
const STEP: f64 = 1e-4;
/// Systems held at a time: at the index and on both sides of it.
const SYSTEMS: f64 = 3.0;
/// Solves of a trial.
const TRIED: usize = 6;

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

    fn is_finite(&self) -> bool {
        self.slopes.iter().flatten().flatten().all(|x| x.is_finite())
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
            failures: Vec::new(),
        };
        Collected {
            resolved: self.resolved,
            realisations: self.realisations.iter().map(realisation).collect(),
            refused: Vec::new(),
            enough: false,
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
        let material = &mut study.pigments[pigment].material;
        // n and κ of a fit are positive and finite; a single wavelength is a constant
        let spectrum = match samples[..] {
            [only] => Spectrum::Constant { n: only.n, kappa: only.kappa },
            _ => Spectrum::tabulated("fitted", samples).unwrap_or(Spectrum::VACUUM),
        };
        *material = crate::input::study::IndexSpectrum {
            source: "fitted".into(),
            index: index.to_vec(),
            spectrum,
            dissolved: Vec::new(),
            mixing: MixingRule::default(),
        };
        study
    }
}

/// One packing, and it on the grids that its waves need.
struct TangentCell {
    realisation: usize,
    packing: Packing,
    record: PackingRecord,
    key: Key,
    geometries: Mutex<Vec<(Resolution, Geometry)>>,
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
        let (mut cells, mut refusal) = (Vec::new(), None);
        for realisation in 0..study.realisations {
            watch.stage(&format!("packing realisation {}/{}", realisation + 1, study.realisations));
            let packed = pack_realisation(study, realisation, watch)
                .map_err(|source| RunError::Packing { realisation, source }.stopped());
            match packed {
                Ok(packing) => cells.push(TangentCell::new(study, realisation, packing)),
                Err(error) if error.has_no_room() => refusal = Some(error),
                Err(error) => return Err(error),
            }
        }
        match refusal {
            Some(error) if cells.is_empty() => Err(error),
            _ => Ok(Self { pigment, resolved, cells, store, settings }),
        }
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
        let mut realisations = Vec::new();
        for cell in self.cells.iter().take(most) {
            realisations.push((cell.record.clone(), self.of_cell(study, cell, watch)?));
        }
        Ok(Linearised { resolved: self.resolved, realisations })
    }

    /// Processor seconds of one solve with its derivatives, a mean over a few that are not stored.
    ///
    /// # Errors
    /// The grid does not fit into memory.
    pub fn trial(&self, study: &Study, watch: &dyn RunWatch) -> Result<f64, RunError> {
        let cell = &self.cells[0];
        let points = study.points(cell.realisation);
        let asked = study.solver.build();
        let solver = self.admitted(study, cell, &*asked)?.0;
        let chosen = points.iter().step_by(points.len().div_ceil(TRIED));
        let clock = std::time::Instant::now();
        let busy = || processor_seconds().unwrap_or_else(|| clock.elapsed().as_secs_f64());
        let before = busy();
        for point in chosen.clone() {
            let key = self.key(study, cell, point);
            // a solve that fails takes its time as well
            let _ = self.solve(study, cell, (point, &key), (solver.solver(), watch));
        }
        Ok((busy() - before) / chosen.count().max(1) as f64)
    }

    /// The strategy with its share of the memory, into which it may grow, and the number of solves
    /// at a time.
    fn admitted<'s>(
        &self,
        study: &Study,
        cell: &TangentCell,
        asked: &'s dyn Solver,
    ) -> Result<(Admitted<'s>, usize), RunError> {
        let size = size(study, self.resolved.for_cell(&study.draw(cell.realisation)));
        let memory = self.settings.memory / SYSTEMS;
        let most = (memory / size.admit(asked, memory)?.bytes) as usize;
        let jobs = self.settings.jobs.unwrap_or_else(rayon::current_num_threads).min(most).max(1);
        Ok((size.admit(asked, memory / jobs as f64)?, jobs))
    }

    fn of_cell(
        &self,
        study: &Study,
        cell: &TangentCell,
        watch: &dyn RunWatch,
    ) -> Result<Vec<Option<TangentRecord>>, RunError> {
        let points = study.points(cell.realisation);
        let key = |point: &Point| self.key(study, cell, point);
        let keys: Vec<Key> = points.iter().map(key).collect();
        let found: Vec<_> = keys.iter().map(|key| Mutex::new(self.store.get(key.as_str()))).collect();
        let todo: Vec<usize> = (0..points.len()).filter(|&i| lock(&found[i]).is_none()).collect();
        watch.hear(Event::Kept(points.len() - todo.len()));
        let asked = study.solver.build();
        let (solver, jobs) = self.admitted(study, cell, &*asked)?;
        let trouble: Mutex<Option<io::Error>> = Mutex::new(None);
        let stop = || watch.stop() || lock(&trouble).is_some();
        work_through(todo.len(), jobs, stop, |k| {
            let i = todo[k];
            let kept = self.attempt(study, cell, (&points[i], &keys[i]), (solver.solver(), watch));
            kept.map_or_else(|e| *lock(&trouble) = Some(e), |record| *lock(&found[i]) = record);
        })?;
        if let Some(error) = lock(&trouble).take() {
            return Err(RunError::Store(error));
        }
        if watch.stop() {
            return Err(RunError::Stopped);
        }
        Ok(found.into_iter().map(|f| f.into_inner().unwrap_or_else(PoisonError::into_inner)).collect())
    }

    /// Solves one point and keeps what it finds; nothing after a failure or a stop. The error is
    /// the store's alone.
    fn attempt(
        &self,
        study: &Study,
        cell: &TangentCell,
        (point, key): (&Point, &Key),
        (solver, watch): (&dyn Solver, &dyn RunWatch),
    ) -> io::Result<Option<TangentRecord>> {
        watch.hear(Event::Solving(study, point));
        let solved = self.solve(study, cell, (point, key), (solver, watch));
        watch.hear(Event::Ended);
        match solved {
            Ok(record) => {
                self.store.put(key.as_str(), &record)?;
                watch.hear(Event::Solved(point, None));
                Ok(Some(record))
            }
            Err(error) => {
                let reason = error.to_string();
                (!error.is_stop()).then(|| watch.hear(Event::Solved(point, Some(&reason))));
                Ok(None)
            }
        }
    }

    /// Content hash of all that a solve and its derivatives depend on.
    fn key(&self, study: &Study, cell: &TangentCell, point: &Point) -> Key {
        let grid = self.grid(study, cell, point);
        let method = (grid, &study.solver, &study.goal, study.resolution.coverage_error(), STEP);
        let indices = study.indices(point.incidence.wavelength_um);
        let inputs = (&cell.key, indices, &point.incidence, method, self.pigment);
        Key::of_wave("tangent", &inputs, point.polarisation)
    }

    fn grid(&self, study: &Study, cell: &TangentCell, point: &Point) -> Resolution {
        self.resolved.for_wave(study, &study.draw(cell.realisation), point.incidence.wavelength_um)
    }

    fn solve(
        &self,
        study: &Study,
        cell: &TangentCell,
        (point, key): (&Point, &Key),
        (solver, watch): (&dyn Solver, &dyn RunWatch),
    ) -> Result<TangentRecord, PointError> {
        let (system, geometry) = cell.system(study, self.grid(study, cell, point), point)?;
        let Solution { field, account } = solver.solve(&*system, study.goal, &mut Stopper(watch))?;
        let neighbour = |step: f64| -> Result<Neighbour, WaveError> {
            let eta = study.pigments[self.pigment].material.index_at(point.incidence.wavelength_um);
            let count = study.wavelengths_nm.len();
            let moved = study.with_index(self.pigment, &vec![eta + step; count]);
            let system = own(systems_of(&moved, &geometry, point)?, point);
            Ok(Neighbour { step: step.into(), system })
        };
        let neighbours = [neighbour(STEP)?, neighbour(-STEP)?];
        let slopes = tangent((&*system, &field), &neighbours, (solver, study.goal), &mut Stopper(watch))?;
        let far = system.far_field(&field);
        let kept = far.orders.iter().zip(&slopes.orders);
        let kept = kept.filter(|(order, _)| order.reflected_propagates || order.transmitted_propagates);
        let slopes = kept.map(|(_, slopes)| [slopes.reflected, slopes.transmitted]).collect();
        let far = Physical::judge(far, total_errors(self.resolved.grid_error, account.residual))?;
        let account = SolveAccount {
            solver: account.solver,
            steps: account.steps,
            operator_applications: account.operator_applications,
            residual: account.residual,
            seconds: account.seconds,
        };
        let (key, realisation) = (key.to_string(), cell.realisation);
        let point = PointRecord::new(key, realisation, point.polarisation, &far, account)?;
        let record = TangentRecord { point, slopes };
        if record.is_finite() { Ok(record) } else { Err(NotFinite.into()) }
    }
}

impl TangentCell {
    fn new(study: &Study, realisation: usize, packing: Packing) -> Self {
        let record = PackingRecord::new(realisation, &packing);
        let key = Key::of_packing(&study.packing_request(realisation));
        Self { realisation, packing, record, key, geometries: Mutex::default() }
    }

    /// The problem of a point with its geometry, on a finer grid where the wave does not fit.
    fn system(
        &self,
        study: &Study,
        mut resolution: Resolution,
        point: &Point,
    ) -> Result<(Box<dyn System>, Geometry), WaveError> {
        loop {
            let geometry = self.geometry(study, resolution)?;
            let made = systems_of(study, &geometry, point);
            let finer = made.as_ref().err().and_then(|refusal| raised(resolution, refusal));
            match finer {
                Some(finer) => resolution = finer,
                None => return Ok((own(made?, point), geometry)),
            }
        }
    }

    fn geometry(&self, study: &Study, resolution: Resolution) -> Result<Geometry, WaveError> {
        let mut all = lock(&self.geometries);
        if let Some((_, geometry)) = all.iter().find(|(kept, _)| *kept == resolution) {
            return Ok(geometry.clone());
        }
        let precision = Precision::of(study.resolution.coverage_error());
        let scene = Scene::from_packing(&self.packing);
        let geometry = Geometry::new(study.wave, &scene, resolution, precision)?;
        all.push((resolution, geometry.clone()));
        Ok(geometry)
    }
}

/// The system of a point's polarisation.
fn own(systems: Vec<Box<dyn System>>, point: &Point) -> Box<dyn System> {
    let own = systems.into_iter().find(|system| system.polarisation() == point.polarisation);
    own.expect("points have the polarisations of their study's wave")
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
