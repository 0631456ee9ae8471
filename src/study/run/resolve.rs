//! The grid of a study, as requested or chosen for the requested accuracy, and its error.
//!
//! Three test solves on the first packing that succeeds represent the whole study: the shortest
//! wavelength at the smallest and at the largest angle, and the wavelength of the largest
//! difference between grains and binder. The largest of their error estimates is the study's.
//! Longer waves get coarser grids as far as two more test solves allow (`longer_waves`). All slabs
//! of a composed layer have the grid of the first ([`Study::grid_source`]).

mod lists;
mod probed;

use super::longer_waves::{self, Finest, coarsened, largest_contrast, probed_angles_deg};
use super::point::Stopper;
use super::watch::{RunError, RunWatch};
use crate::input::study::{Study, WantedResolution};
use crate::input::variation::Draw;
use crate::numerics::estimate::largest;
use crate::solve::Size;
use crate::solve::accuracy::grid_error::{GridError, JUDGEMENT, scaled};
use crate::solve::accuracy::{AccuracyError, Task, smooth_size};
use crate::store::{Key, Record, Store};
use crate::wave::{Incidence, Mean, Resolution, Scene, Side};
use probed::Probing;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Number of packings on which two grids are compared: enough for a standard error of the
/// difference.
const GRID_PACKINGS: usize = 4;
/// Points and cells of the grid that checks another one, relative to that one: the difference is
/// then more than half of its error at third order, for 2.4 times the work.
const FINER: f64 = 4.0 / 3.0;

/// The grid of a study's shortest wave, and its coarsening for longer ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolved {
    /// The grid of the cell it was chosen on (the first that could be packed), for the shortest
    /// wavelength and wherever the contrast is largest.
    pub resolution: Resolution,
    /// Period of that cell, µm.
    pub period_um: [f64; 2],
    /// Thickness of the layer in that cell, µm.
    pub thickness_um: f64,
    /// Largest estimated error of an order's complex amplitude in the test solves.
    pub error_estimate: f64,
    /// Expected errors of R and T.
    pub grid_error: GridError,
    /// Exponent of the coarsening for longer waves: 1 uses all of it, 0 none, as in older records.
    #[serde(default)]
    pub longer_waves: f64,
    /// What the coarsening is relative to: the list of wavelengths that the grid was chosen for. A
    /// part of that list keeps its grids. Absent in older records: the study's own list.
    #[serde(default)]
    pub chosen_for: Option<Finest>,
}

impl Resolved {
    /// The grid of a wave in a cell: that of the shortest wave, coarsened if the wave is longer. A
    /// slab beside a denser medium than that slab has on which the grid was chosen has points for
    /// the orders there.
    pub fn for_wave(&self, study: &Study, draw: &Draw, wavelength_um: f64) -> Resolution {
        let finest = self.chosen_for.unwrap_or_else(|| Finest::of(study));
        let grid = coarsened(study, self.for_cell(draw), wavelength_um, finest, self.longer_waves);
        let Some(index) = study.denser_surroundings(wavelength_um) else { return grid };
        if study.given_grid(draw).is_some() {
            return grid;
        }
        let points = |n: usize, period_um: f64| {
            let outermost = (index * period_um / wavelength_um + 0.5).floor() as usize;
            if n == 1 { 1 } else { n.max(smooth_size(2 * outermost + 1)) }
        };
        let [x_um, y_um] = draw.period_um;
        Resolution { nx: points(grid.nx, x_um), ny: points(grid.ny, y_um), ..grid }
    }

    /// The grid of the longest wave, in the cell on which the finest grid was chosen.
    pub fn longest(&self, study: &Study) -> Resolution {
        let last_um = 1e-3 * study.wavelengths_nm[study.wavelengths_nm.len() - 1];
        let finest = self.chosen_for.unwrap_or_else(|| Finest::of(study));
        coarsened(study, self.resolution, last_um, finest, self.longer_waves)
    }

    /// The grid on which some realisations are solved again ([`Study::is_checked`]): a third finer
    /// along every axis.
    pub fn finer(&self) -> Self {
        Self { resolution: scaled(self.resolution, FINER), ..*self }
    }

    /// Ratio of the mesh widths of both grids: the cube root of the ratio of their unknowns.
    pub fn refinement(&self) -> f64 {
        let unknowns = |r: Resolution| (r.nx * r.ny * r.cells) as f64;
        (unknowns(self.finer().resolution) / unknowns(self.resolution)).cbrt()
    }

    /// The finest grid in another cell, no coarser than in the first.
    pub fn for_cell(&self, draw: &Draw) -> Resolution {
        let points = |count: usize, first_um: f64, um: f64| {
            let needed = (count as f64 * um / first_um * (1.0 - 1e-9)).ceil() as usize;
            if count == 1 { 1 } else { smooth_size(needed.max(1)) }
        };
        let chosen = self.resolution;
        let first = self.period_um;
        let cells = (chosen.cells as f64 * draw.thickness_um / self.thickness_um * (1.0 - 1e-9)).ceil();
        if draw.period_um == first && draw.thickness_um == self.thickness_um {
            return chosen;
        }
        Resolution {
            nx: points(chosen.nx, first[0], draw.period_um[0]),
            ny: points(chosen.ny, first[1], draw.period_um[1]),
            cells: (cells as usize).max(1),
            scheme: chosen.scheme,
        }
    }
}

/// What a solve of the study needs on a grid.
pub fn size(study: &Study, resolution: Resolution) -> Size {
    let indices = study.materials().chain(study.extraordinary_indices()).chain(study.binders());
    let densest = indices.flat_map(|material| &material.index).map(|eta| eta.re).fold(1.0, f64::max);
    let k0 = std::f64::consts::TAU / (1e-3 * study.wavelengths_nm[0]);
    let [lx, ly] = study.layer.period_um;
    let h = study.layer.thickness_um;
    let channels = study.materials().count() + usize::from(study.packing.relief.is_some());
    let crystals = study.pigments.iter().filter(|pigment| pigment.extraordinary.is_some()).count();
    let vector = study.wave.is_vector();
    let wavenumbers = if vector { [0.0; 2] } else { [k0 * densest, k0] };
    Size { resolution, channels, crystals, layer_um: [lx, ly, h], wavenumbers, vector }
}

impl Record for Resolved {
    const KIND: &'static str = "grid";
}

/// The study's grid: from the store, or from test solves on the first realisations of
/// [`Study::grid_source`], whose scenes are made on demand.
///
/// # Errors
/// The accuracy cannot be reached, the grid does not fit into `memory` (bytes), or a test solve
/// fails.
pub fn resolve(
    study: &Study,
    store: &Store<Resolved>,
    memory: f64,
    watch: &dyn RunWatch,
    scene: impl FnMut(usize) -> Result<Scene, RunError>,
) -> Result<Resolved, RunError> {
    let source = study.grid_source();
    let study = &*source;
    if let Some(resolved) = kept(study, store) {
        return Ok(resolved);
    }
    if let Some(resolved) = lists::grid_of_longer_list(study, store) {
        store.put(key(study).as_str(), &resolved)?;
        return Ok(resolved);
    }
    if let Some(grid) = study.given_grid(&study.draw(0)) {
        size(study, grid).admit(&*study.solver.build(), memory).map_err(AccuracyError::Memory)?;
    }
    let scenes = with_room(0..compared(study), packings_compared(study), scene)?;
    watch.stage("estimating the error of the grid");
    let on = |realisation: usize, scene| {
        let draw = study.draw(realisation);
        Probing { study, realisation, draw, scene, memory, watch }
    };
    let mut resolved = settle(&on(scenes[0].0, &scenes[0].1))?;
    let differences = scenes.iter().enumerate().map(|(k, (r, scene))| {
        watch.stage(&format!("comparing two grids on packing {}/{}", k + 1, scenes.len()));
        grid_differences(&on(*r, scene), &resolved)
    });
    resolved.grid_error = GridError::from_differences(&differences.collect::<Result<Vec<_>, _>>()?);
    store.put(key(study).as_str(), &resolved)?;
    lists::keep_for_shorter_lists(study, &resolved, store)?;
    Ok(resolved)
}

/// What `make` gives for the first realisations that can be packed, `enough` of them at most and at
/// least one: a failed packing affects only its own realisation.
pub(super) fn with_room<T>(
    realisations: Range<usize>,
    enough: usize,
    mut make: impl FnMut(usize) -> Result<T, RunError>,
) -> Result<Vec<(usize, T)>, RunError> {
    let mut made = Vec::new();
    let mut refusal = None;
    for realisation in realisations {
        match make(realisation) {
            Ok(one) => made.push((realisation, one)),
            Err(error) if error.has_no_room() => refusal = refusal.or(Some(error)),
            Err(error) => return Err(error),
        }
        if made.len() == enough {
            break;
        }
    }
    refusal.filter(|_| made.is_empty()).map_or(Ok(made), Err)
}

/// The study's grid if it is stored.
pub fn kept(study: &Study, store: &Store<Resolved>) -> Option<Resolved> {
    store.get(key(study).as_str())
}

/// Number of packings on which two grids are compared: one is enough if whole realisations are
/// solved on two grids later.
pub fn packings_compared(study: &Study) -> usize {
    if study.has_two_levels() { 1 } else { compared(study).max(1) }
}

/// Number of test solves on one packing and one grid: for Maxwell's equations with s and p light.
pub fn probed_solves(study: &Study) -> usize {
    probes(study, 0).len() * if study.wave.is_vector() { 2 } else { 1 }
}

/// Number of realisations on which two grids are compared.
fn compared(study: &Study) -> usize {
    study.realisations.min(GRID_PACKINGS)
}

/// Content hash of everything that the choice of the grid and its error depend on. It includes all
/// packings compared: studies may share the first and differ in others, because cells are drawn to
/// hold whole grains.
pub fn key(study: &Study) -> Key {
    let source = study.grid_source();
    let study = &*source;
    let packing = |realisation: usize| {
        let probes = probes(study, realisation);
        let media: Vec<_> = probes.iter().map(|probe| study.indices(probe.wavelength_um)).collect();
        (Key::of_packing(&study.packing_request(realisation)), media, probes)
    };
    let packings: Vec<_> = (0..compared(study)).map(packing).collect();
    // Older records halve the error where a finer grid was needed for comparison: the grids are
    // computed again, the solves are not.
    let method = (study.resolution, Mean::default(), &study.solver, &study.goal, JUDGEMENT);
    // s, p and unpolarised light share a grid.
    let vector = study.wave.is_vector().then_some(());
    let longest = longer_waves::probes(study, 0);
    match longest.is_empty() {
        true => Key::of_wave("resolution", &(packings, method), vector),
        false => Key::of_wave("resolution", &(packings, method, longest), vector),
    }
}

fn probes(study: &Study, realisation: usize) -> Vec<Incidence> {
    let azimuth_deg = study.draw(realisation).azimuth_deg;
    let from = Side::Incident;
    let incidence =
        |nm: f64, polar_deg: f64| Incidence { wavelength_um: nm * 1e-3, polar_deg, azimuth_deg, from };
    let contrast = |nm: f64| largest_contrast(study, nm);
    let [smallest, largest] = probed_angles_deg(study);
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

fn settle(on: &Probing) -> Result<Resolved, AccuracyError> {
    let probes = probes(on.study, on.realisation);
    let (resolution, error_estimate) = on.with_tasks(&probes, |tasks| on.grid(tasks))?;
    let Draw { period_um, thickness_um, .. } = on.draw;
    let one = Resolved {
        resolution,
        period_um,
        thickness_um,
        error_estimate,
        grid_error: GridError::default(),
        longer_waves: 0.0,
        chosen_for: Some(Finest::of(on.study)),
    };
    on.with_tasks(&longer_waves::probes(on.study, on.realisation), |longest| coarsen(on, longest, one))
}

/// Uses the largest coarsening that keeps the accuracy at the longest wavelength.
fn coarsen(on: &Probing, longest: &[Task], one: Resolved) -> Result<Resolved, AccuracyError> {
    let WantedResolution::Accuracy { amplitude, .. } = on.study.resolution else { return Ok(one) };
    let Some(first) = longest.first() else { return Ok(one) };
    'shares: for longer_waves in longer_waves::SHARES {
        let mut tried = Resolved { longer_waves, ..one };
        let grid = tried.for_wave(on.study, &on.draw, first.incidence.wavelength_um);
        for task in longest {
            match task.solve_with_estimate(grid, &mut Stopper(on.watch)) {
                Err(stopped) if stopped.is_stop() => return Err(stopped),
                Ok(probed) if probed.error_estimate <= amplitude => {
                    tried.error_estimate = largest([tried.error_estimate, probed.error_estimate]);
                }
                _ => continue 'shares,
            }
        }
        return Ok(tried);
    }
    Ok(one)
}

/// Changes of R and T due to the grid, for the test solves on one packing.
fn grid_differences(on: &Probing, resolved: &Resolved) -> Result<Vec<[f64; 2]>, AccuracyError> {
    let differences = |probes: &[Incidence], resolution: Resolution| {
        on.with_tasks(probes, |tasks| GridError::differences(tasks, resolution, &mut Stopper(on.watch)))
    };
    let mut all = differences(&probes(on.study, on.realisation), resolved.for_cell(&on.draw))?;
    let longest = longer_waves::probes(on.study, on.realisation);
    if let (Some(first), true) = (longest.first(), resolved.longer_waves > 0.0) {
        all.extend(differences(&longest, resolved.for_wave(on.study, &on.draw, first.wavelength_um))?);
    }
    Ok(all)
}
