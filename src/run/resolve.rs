//! The grid of a study: as asked, or chosen for the accuracy that was asked; with its error in either case.
//!
//! Three probes on the first packing stand for the whole study: the shortest wavelength at the smallest and
//! at the largest angle, and the wavelength at which grains and binder differ most. The largest of
//! their error estimates is the study's.

use super::point::Stopper;
use super::watch::RunWatch;
use crate::input::study::{Layer, Pigment, Study, WantedResolution};
use crate::solve::accuracy::grid_error::GridError;
use crate::solve::accuracy::{AccuracyError, Estimated, Task, smooth_size};
use crate::solve::demand::Size;
use crate::solve::{Coverages, SolveError};
use crate::store::identity::Key;
use crate::store::{Record, Store};
use crate::wave::physical::largest;
use crate::wave::{Incidence, Mean, Media, Resolution, Scene, Scheme, Side};
use serde::{Deserialize, Serialize};

/// The grid that all solves of a study share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolved {
    pub resolution: Resolution,
    /// Largest expected error of an order's complex amplitude, over the probes.
    pub error_estimate: f64,
    /// Expected errors of R and T.
    pub grid_error: GridError,
}

/// What the study's solves take on a grid.
pub fn size(study: &Study, resolution: Resolution) -> Size {
    let indices = study.pigments.iter().map(|p| &p.material).chain([&study.layer.binder]);
    let densest = indices.flat_map(|material| &material.index).map(|eta| eta.re).fold(1.0, f64::max);
    let k0 = std::f64::consts::TAU / (1e-3 * study.wavelengths_nm[0]);
    let ([lx, ly], h) = (study.layer.period_um, study.layer.thickness_um);
    let channels = study.pigments.len() + usize::from(study.packing.relief.is_some());
    Size { resolution, channels, layer_um: [lx, ly, h], wavenumbers: [k0 * densest, k0] }
}

impl Record for Resolved {
    const KIND: &'static str = "grid";
}

/// The study's grid: from the store, or from solves on `scene`, which is made when it is needed.
///
/// # Errors
/// The accuracy is out of reach, the grid does not fit `memory` (bytes), or a probe cannot be solved.
pub fn resolve<E: From<AccuracyError> + From<std::io::Error>>(
    study: &Study,
    store: &Store<Resolved>,
    memory: f64,
    watch: &dyn RunWatch,
    scene: impl FnOnce() -> Result<Scene, E>,
) -> Result<Resolved, E> {
    let probes = probes(study);
    let key = key(study, &probes);
    if let Some(resolved) = store.get(key.as_str()) {
        return Ok(resolved);
    }
    if let WantedResolution::Grid { points_per_um, planes_per_um, scheme } = study.resolution {
        let grid = grid(&study.layer, points_per_um, planes_per_um, scheme);
        size(study, grid).admit(&*study.solver.build(), memory).map_err(AccuracyError::Memory)?;
    }
    let scene = scene()?;
    watch.stage("estimating the error of the grid");
    let resolved = settle(study, &scene, &probes, memory, watch)?;
    store.put(key.as_str(), &resolved)?;
    Ok(resolved)
}

/// The study's grid if the store has it.
pub fn kept(study: &Study, store: &Store<Resolved>) -> Option<Resolved> {
    store.get(key(study, &probes(study)).as_str())
}

/// Content hash of all that the choice of the grid depends on.
fn key(study: &Study, probes: &[Probe]) -> Key {
    let packing = Key::of("packing", &study.packing_request(0));
    let media: Vec<_> = probes.iter().map(|(wavelength, _)| study.indices(*wavelength)).collect();
    let method = (&study.resolution, Mean::default(), &study.solver, &study.goal);
    Key::of("resolution", &(packing, media, probes, method))
}

/// True when the user stopped the search, which is no failure.
pub fn is_stop(error: &AccuracyError) -> bool {
    matches!(error, AccuracyError::Solve(SolveError::Cancelled { .. }))
}

/// Place of the wavelength, and the incidence.
type Probe = (usize, Incidence);

fn probes(study: &Study) -> Vec<Probe> {
    let angles = &study.angles.above;
    let incidence = |wavelength: usize, polar_deg: f64| Incidence {
        wavelength_um: study.wavelengths_nm[wavelength] * 1e-3,
        polar_deg,
        azimuth_deg: study.angles.azimuth_deg,
        from: Side::Incident,
    };
    let contrast = |wavelength: usize| {
        let [binder, k] = [study.layer.binder.index[wavelength], study.wavelengths_nm[wavelength].into()];
        let of = |p: &Pigment| {
            let eta = p.material.index[wavelength];
            ((eta * eta - binder * binder) / (k * k)).norm()
        };
        study.pigments.iter().map(of).fold(0.0, f64::max)
    };
    let (smallest, largest) = (angles[0], angles[angles.len() - 1]);
    let strongest = (0..study.wavelengths_nm.len()).max_by(|&a, &b| contrast(a).total_cmp(&contrast(b)));
    let mut probes = vec![(0, smallest), (0, largest), (strongest.unwrap_or(0), smallest)];
    probes.dedup();
    probes.into_iter().map(|(wavelength, angle)| (wavelength, incidence(wavelength, angle))).collect()
}

fn settle(
    study: &Study,
    scene: &Scene,
    probes: &[Probe],
    memory: f64,
    watch: &dyn RunWatch,
) -> Result<Resolved, AccuracyError> {
    let (solver, coverages) =
        (study.solver.build(), Coverages::within(scene, study.resolution.coverage_error()));
    let media: Vec<Media> = probes.iter().map(|(wavelength, _)| study.media(*wavelength)).collect();
    let (mean, scheme, goal) = (Mean::default(), study.resolution.scheme(), study.goal);
    let task = |i: usize| {
        let (media, incidence) = (&media[i], &probes[i].1);
        Task { coverages: &coverages, media, incidence, mean, scheme, solver: &*solver, goal, memory }
    };
    let (mut resolution, mut error_estimate) = (None, 0.0_f64);
    for task in (0..probes.len()).map(task) {
        let probed = probe(study, &task, resolution, watch)?;
        error_estimate = largest([error_estimate, probed.error_estimate]);
        resolution = Some(probed.problem.coverage.grid.resolution);
    }
    let resolution = resolution.ok_or(AccuracyError::Accuracy(f64::NAN))?;
    let tasks: Vec<Task> = (0..probes.len()).map(task).collect();
    let grid_error = GridError::measure(&tasks, resolution, &mut Stopper(watch))?;
    Ok(Resolved { resolution, error_estimate, grid_error })
}

/// Tries the grid found so far and refines it for this probe where that is asked.
fn probe(
    study: &Study,
    task: &Task,
    before: Option<Resolution>,
    watch: &dyn RunWatch,
) -> Result<Estimated, AccuracyError> {
    let watch = &mut Stopper(watch);
    let accuracy = match study.resolution {
        WantedResolution::Grid { points_per_um, planes_per_um, scheme } => {
            let grid = grid(&study.layer, points_per_um, planes_per_um, scheme);
            return task.solve_with_estimate(grid, watch);
        }
        WantedResolution::Accuracy { amplitude, .. } => amplitude,
    };
    if let Some(resolution) = before {
        let tried = task.solve_with_estimate(resolution, watch)?;
        if tried.error_estimate <= accuracy {
            return Ok(tried);
        }
    }
    let refined = task.solve_to_accuracy(accuracy, watch)?;
    let (fine, Some(coarse)) = (refined.problem.coverage.grid.resolution, before) else { return Ok(refined) };
    let both = Resolution {
        nx: fine.nx.max(coarse.nx),
        ny: fine.ny.max(coarse.ny),
        cells: fine.cells.max(coarse.cells),
        scheme: fine.scheme,
    };
    if both == fine { Ok(refined) } else { task.solve_with_estimate(both, watch) }
}

/// Points and cells for the asked points and planes per µm: at least that fine, in sizes that transform fast.
fn grid(layer: &Layer, points_per_um: f64, planes_per_um: f64, scheme: Scheme) -> Resolution {
    let points = layer.period_um.map(|period| smooth_size((points_per_um * period).ceil() as usize));
    let planes = planes_per_um * layer.thickness_um;
    let cells = (planes / scheme.degree() as f64).ceil().max(1.0) as usize;
    Resolution { nx: points[0], ny: points[1], cells, scheme }
}
