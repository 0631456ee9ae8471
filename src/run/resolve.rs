//! The grid of a study: as asked, or chosen for the accuracy that was asked; with its error in either case.
//!
//! Three probes on the first packing that comes about stand for the whole study: the shortest wavelength at the smallest and
//! at the largest angle, and the wavelength at which grains and binder differ most. The largest of
//! their error estimates is the study's.

use super::error::RunError;
use super::point::Stopper;
use super::watch::RunWatch;
use crate::input::study::{Pigment, Study, WantedResolution};
use crate::input::variation::{Draw, stratified_deg};
use crate::solve::accuracy::discretisation::Discretisation;
use crate::solve::accuracy::grid_error::GridError;
use crate::solve::accuracy::{AccuracyError, Estimated, Task, smooth_size};
use crate::solve::demand::Size;
use crate::solve::{Coverages, Solver};
use crate::store::identity::Key;
use crate::store::{Record, Store};
use crate::wave::maxwell::NormalMoments;
use crate::wave::physical::largest;
use crate::wave::{Coverage, Incidence, Mean, Media, Resolution, Scene, Scheme, Side};
use serde::{Deserialize, Serialize};

/// Packings on which two grids are compared: enough for a standard error of the difference.
const GRID_PACKINGS: usize = 4;

/// The grid that all solves of a study share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolved {
    /// Of the cell it was chosen on, the first that could be packed.
    pub resolution: Resolution,
    /// Period of that cell, µm.
    pub period_um: [f64; 2],
    /// Thickness of its layer, µm.
    pub thickness_um: f64,
    /// Largest expected error of an order's complex amplitude, over the probes.
    pub error_estimate: f64,
    /// Expected errors of R and T.
    pub grid_error: GridError,
}

impl Resolved {
    /// The grid of another cell: no coarser than the first one's.
    pub fn for_cell(&self, draw: &Draw) -> Resolution {
        let points = |own: usize, first_um: f64, um: f64| {
            let wanted = (own as f64 * um / first_um * (1.0 - 1e-9)).ceil() as usize;
            if own == 1 { 1 } else { smooth_size(wanted.max(1)) }
        };
        let (own, first) = (self.resolution, self.period_um);
        let cells = (own.cells as f64 * draw.thickness_um / self.thickness_um * (1.0 - 1e-9)).ceil();
        if draw.period_um == first && draw.thickness_um == self.thickness_um {
            return own;
        }
        Resolution {
            nx: points(own.nx, first[0], draw.period_um[0]),
            ny: points(own.ny, first[1], draw.period_um[1]),
            cells: (cells as usize).max(1),
            scheme: own.scheme,
        }
    }
}

/// What the study's solves take on a grid.
pub fn size(study: &Study, resolution: Resolution) -> Size {
    let indices = study.pigments.iter().map(|p| &p.material).chain([&study.layer.binder]);
    let densest = indices.flat_map(|material| &material.index).map(|eta| eta.re).fold(1.0, f64::max);
    let k0 = std::f64::consts::TAU / (1e-3 * study.wavelengths_nm[0]);
    let ([lx, ly], h) = (study.layer.period_um, study.layer.thickness_um);
    let channels = study.pigments.len() + usize::from(study.packing.relief.is_some());
    let vector = study.wave.is_vector();
    let wavenumbers = if vector { [0.0; 2] } else { [k0 * densest, k0] };
    Size { resolution, channels, layer_um: [lx, ly, h], wavenumbers, vector }
}

impl Record for Resolved {
    const KIND: &'static str = "grid";
}

/// The study's grid: from the store, or from solves on the first realisations' scenes, which are made when they are needed.
///
/// # Errors
/// The accuracy is out of reach, the grid does not fit `memory` (bytes), or a probe cannot be solved.
pub(crate) fn resolve(
    study: &Study,
    store: &Store<Resolved>,
    memory: f64,
    watch: &dyn RunWatch,
    scene: impl FnMut(usize) -> Result<Scene, RunError>,
) -> Result<Resolved, RunError> {
    let key = key(study);
    if let Some(resolved) = store.get(key.as_str()) {
        return Ok(resolved);
    }
    if let WantedResolution::Grid { points_per_um, planes_per_um, scheme } = study.resolution {
        let grid = grid(&study.draw(0), points_per_um, planes_per_um, scheme);
        size(study, grid).admit(&*study.solver.build(), memory).map_err(AccuracyError::Memory)?;
    }
    let scenes = scenes(study, scene)?;
    watch.stage("estimating the error of the grid");
    let mut resolved = match study.wave.is_vector() {
        false => settle::<Coverage>(study, &scenes[0], memory, watch)?,
        true => settle::<NormalMoments>(study, &scenes[0], memory, watch)?,
    };
    let difference = |scene: &(usize, Scene)| match study.wave.is_vector() {
        false => grid_differences::<Coverage>(study, &resolved, scene, memory, watch),
        true => grid_differences::<NormalMoments>(study, &resolved, scene, memory, watch),
    };
    let differences: Vec<Vec<[f64; 2]>> = scenes.iter().map(difference).collect::<Result<_, _>>()?;
    resolved.grid_error = GridError::from_differences(&differences);
    store.put(key.as_str(), &resolved)?;
    Ok(resolved)
}

/// The first realisations whose packings come about, one at least: what cannot be packed costs its own realisation alone.
fn scenes(
    study: &Study,
    mut scene: impl FnMut(usize) -> Result<Scene, RunError>,
) -> Result<Vec<(usize, Scene)>, RunError> {
    let (mut scenes, mut refusal) = (Vec::new(), None);
    for realisation in 0..compared(study) {
        match scene(realisation) {
            Ok(scene) => scenes.push((realisation, scene)),
            Err(error) if error.has_no_room() => refusal = refusal.or(Some(error)),
            Err(error) => return Err(error),
        }
    }
    refusal.filter(|_| scenes.is_empty()).map_or(Ok(scenes), Err)
}

/// The study's grid if the store has it.
pub fn kept(study: &Study, store: &Store<Resolved>) -> Option<Resolved> {
    store.get(key(study).as_str())
}

/// Realisations whose packings two grids are compared on.
fn compared(study: &Study) -> usize {
    study.realisations.min(GRID_PACKINGS)
}

/// Content hash of all that the choice of the grid and its error depend on. Every packing compared counts: studies may share the
/// first one and differ in others, since cells are drawn to hold whole grains.
pub(crate) fn key(study: &Study) -> Key {
    let packing = |realisation: usize| {
        let probes = probes(study, realisation);
        let media: Vec<_> = probes.iter().map(|probe| study.indices(probe.wavelength_um)).collect();
        (Key::of_packing(&study.packing_request(realisation)), media, probes)
    };
    let packings: Vec<_> = (0..compared(study)).map(packing).collect();
    let method = (&study.resolution, Mean::default(), &study.solver, &study.goal);
    // s, p and unpolarised light share a grid.
    Key::of_wave("resolution", &(packings, method), study.wave.is_vector().then_some(()))
}

fn probes(study: &Study, realisation: usize) -> Vec<Incidence> {
    let (azimuth_deg, from) = (study.draw(realisation).azimuth_deg, Side::Incident);
    let incidence =
        |nm: f64, polar_deg: f64| Incidence { wavelength_um: nm * 1e-3, polar_deg, azimuth_deg, from };
    let contrast = |nm: f64| largest_contrast(study, nm);
    let slanted =
        stratified_deg(study.angles.strata, 0.5).into_iter().chain(study.angles.exact_deg.iter().copied());
    let (smallest, largest) = (study.angles.exact_deg[0], slanted.fold(0.0, f64::max));
    let nm = &study.wavelengths_nm;
    let strongest = nm.iter().copied().max_by(|&a, &b| contrast(a).total_cmp(&contrast(b))).unwrap_or(nm[0]);
    let mut probes = vec![incidence(nm[0], smallest), incidence(nm[0], largest)];
    let worst = incidence(strongest, smallest);
    if !probes.contains(&worst) {
        probes.push(worst);
    }
    probes.dedup();
    probes
}

/// Largest |η² − η_b²|/λ² of any pigment in the binder, what its contrast V grows with, 1/nm².
fn largest_contrast(study: &Study, nm: f64) -> f64 {
    let binder = study.layer.binder.index_at(1e-3 * nm);
    let of = |p: &Pigment| {
        let eta = p.material.index_at(1e-3 * nm);
        ((eta * eta - binder * binder) / (nm * nm)).norm()
    };
    study.pigments.iter().map(of).fold(0.0, f64::max)
}

fn settle<G: Discretisation>(
    study: &Study,
    (realisation, scene): &(usize, Scene),
    memory: f64,
    watch: &dyn RunWatch,
) -> Result<Resolved, AccuracyError> {
    let (draw, probes) = (study.draw(*realisation), probes(study, *realisation));
    let (mut resolution, mut error_estimate) = (None, 0.0_f64);
    for task in &Prepared::<G>::new(study, scene, &probes, memory, watch).tasks() {
        let probed = probe(study, &draw, task, resolution, watch)?;
        error_estimate = largest([error_estimate, probed.error_estimate]);
        resolution = Some(G::grid_of(&probed.problem).resolution);
    }
    let resolution = resolution.ok_or(AccuracyError::Accuracy(f64::NAN))?;
    let Draw { period_um, thickness_um, .. } = draw;
    Ok(Resolved { resolution, period_um, thickness_um, error_estimate, grid_error: GridError::default() })
}

/// What the grid does to R and T of the probes on one packing.
fn grid_differences<G: Discretisation>(
    study: &Study,
    resolved: &Resolved,
    (realisation, scene): &(usize, Scene),
    memory: f64,
    watch: &dyn RunWatch,
) -> Result<Vec<[f64; 2]>, AccuracyError> {
    let probes = probes(study, *realisation);
    let own = resolved.for_cell(&study.draw(*realisation));
    GridError::differences(
        &Prepared::<G>::new(study, scene, &probes, memory, watch).tasks(),
        own,
        &mut Stopper(watch),
    )
}

/// What the probes of one packing borrow.
struct Prepared<'a, G> {
    study: &'a Study,
    coverages: Coverages<'a, G>,
    solver: Box<dyn Solver>,
    media: Vec<Media>,
    probes: &'a [Incidence],
    /// Most bytes of one solve.
    memory: f64,
}

impl<'a, G: Discretisation> Prepared<'a, G> {
    fn new(
        study: &'a Study,
        scene: &'a Scene,
        probes: &'a [Incidence],
        memory: f64,
        watch: &'a dyn RunWatch,
    ) -> Self {
        let media = probes.iter().map(|probe| study.media(probe.wavelength_um)).collect();
        let coverages = Coverages::of_any(scene, study.resolution.coverage_error());
        let coverages = coverages.unless(|| watch.stop());
        Self { study, coverages, solver: study.solver.build(), media, probes, memory }
    }

    fn tasks(&self) -> Vec<Task<'_, G>> {
        let probes = self.media.iter().zip(self.probes);
        probes.map(|(media, incidence)| self.task(media, incidence)).collect()
    }

    /// The solve of one probe.
    fn task<'b>(&'b self, media: &'b Media, incidence: &'b Incidence) -> Task<'b, G> {
        Task {
            coverages: &self.coverages,
            media,
            incidence,
            mean: Mean::default(),
            scheme: self.study.resolution.scheme(),
            solver: &*self.solver,
            goal: self.study.goal,
            memory: self.memory,
        }
    }
}

/// Tries the grid found so far and refines it for this probe where that is asked.
fn probe<G: Discretisation>(
    study: &Study,
    draw: &Draw,
    task: &Task<G>,
    before: Option<Resolution>,
    watch: &dyn RunWatch,
) -> Result<Estimated<G>, AccuracyError> {
    let watch = &mut Stopper(watch);
    let accuracy = match study.resolution {
        WantedResolution::Grid { points_per_um, planes_per_um, scheme } => {
            let grid = grid(draw, points_per_um, planes_per_um, scheme);
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
    let (fine, Some(coarse)) = (G::grid_of(&refined.problem).resolution, before) else { return Ok(refined) };
    let both = Resolution {
        nx: fine.nx.max(coarse.nx),
        ny: fine.ny.max(coarse.ny),
        cells: fine.cells.max(coarse.cells),
        scheme: fine.scheme,
    };
    if both == fine { Ok(refined) } else { task.solve_with_estimate(both, watch) }
}

/// Points and cells for the asked points and planes per µm: at least that fine, in sizes that transform fast.
fn grid(draw: &Draw, points_per_um: f64, planes_per_um: f64, scheme: Scheme) -> Resolution {
    let points = draw.period_um.map(|period| smooth_size((points_per_um * period).ceil() as usize));
    let planes = planes_per_um * draw.thickness_um;
    let cells = (planes / scheme.degree() as f64).ceil().max(1.0) as usize;
    Resolution { nx: points[0], ny: points[1], cells, scheme }
}
