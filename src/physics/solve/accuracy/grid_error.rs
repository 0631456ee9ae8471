//! Discretisation error of R and T: differences to a coarser grid in the test solves (probes).
//!
//! The error of single amplitudes (`search`) says little about sums over orders, where most of it
//! averages out, so R and T themselves are compared with those on four fifths of the points and
//! cells. At third order, the lowest observed for grains, the finer grid's error equals the
//! difference and the coarser grid's is twice as large. The sign of a difference is largely random:
//! it averages out over several packings, and the mean difference with its standard error is the
//! uncertainty of the ensemble means.

use super::error::{AccuracyError, Result};
use super::search::{raised, scaled_cells, scaled_points};
use super::task::Task;
use crate::numerics::estimate::Estimate;
use crate::numerics::estimate::largest;
use crate::solve::Watch;
use crate::wave::{Geometry, Resolution, WaveError};

/// Ratio of points and cells of the coarser grid to the own grid.
const COARSER: f64 = 0.8;

/// Own error as a fraction of the difference to a finer grid, 1/(1 − 0.8³).
const OF_FINER: f64 = 2.05;

/// Name of this error estimate, part of the key of every stored grid. If the two numbers above
/// change, this name must change too, or existing folders would keep errors by the old estimate.
pub const JUDGEMENT: &str = "scaled companions";

/// Differences below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Expected discretisation errors of the layer's R and T: the largest over the probes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GridError {
    /// Error of the reflectance.
    pub reflectance: f64,
    /// Error of the transmittance.
    pub transmittance: f64,
}

impl GridError {
    /// Errors from the differences \[packing\]\[probe\]\[R, T\] to the other grid: for each probe
    /// the mean over packings with its standard error, then the maximum over the probes. A single
    /// packing counts with its difference.
    pub fn from_differences(differences: &[Vec<[f64; 2]>]) -> Self {
        let probes = differences.first().map_or(0, Vec::len);
        let error_of = |i: usize| largest((0..probes).map(|p| probe_error(differences, p, i)));
        Self { reflectance: error_of(0), transmittance: error_of(1) }
    }

    /// Differences \[R, T\] of the probes on one packing, for each polarisation: the result at
    /// `resolution` less that on a coarser grid, or on a finer one if the coarser grid is rejected.
    pub fn differences(
        tasks: &[Task],
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Vec<[f64; 2]>> {
        let Some(coverages) = tasks.first().map(|task| task.coverages) else { return Ok(Vec::new()) };
        let mut differences = Vec::new();
        let coarser = coverages.at(scaled(resolution, COARSER)).map_err(AccuracyError::from);
        for task in tasks {
            let one = totals_on(task, resolution, watch)?;
            let (other, share) = match coarser.as_ref().ok().map(|coarser| totals(task, coarser, watch)) {
                Some(Ok(other)) => (other, 1.0),
                Some(Err(stopped)) if stopped.is_stop() => return Err(stopped),
                _ => (totals(task, &coverages.at(scaled(resolution, 1.0 / COARSER))?, watch)?, OF_FINER),
            };
            // Layers without grains are exact on every grid: rounding does not count as a
            // discretisation error.
            let difference = |a: f64, b: f64| if (a - b).abs() > ROUNDING { share * (a - b) } else { 0.0 };
            let of_light = |(a, b): (&[f64; 2], &[f64; 2])| [difference(a[0], b[0]), difference(a[1], b[1])];
            differences.extend(one.iter().zip(&other).map(of_light));
        }
        Ok(differences)
    }
}

/// Mean over packings of one probe's difference in R (`i` = 0) or T (`i` = 1), with its standard
/// error.
fn probe_error(differences: &[Vec<[f64; 2]>], probe: usize, i: usize) -> f64 {
    let samples: Vec<f64> = differences.iter().map(|packing| packing[probe][i]).collect();
    let Estimate { value, standard_error } = Estimate::of_mean(&samples);
    value.hypot(standard_error.unwrap_or(0.0))
}

/// R and T of one probe for each polarisation on a grid, with more cells if these are too high for
/// the wave, as in [`crate::run`].
fn totals_on(task: &Task, mut resolution: Resolution, watch: &mut dyn Watch) -> Result<Vec<[f64; 2]>> {
    loop {
        let result = totals(task, &task.coverages.at(resolution)?, watch);
        let Err(AccuracyError::Wave(refusal @ WaveError::CellTooHigh { .. })) = &result else {
            return result;
        };
        let Some(finer) = raised(resolution, refusal) else { return result };
        resolution = finer;
    }
}

/// R and T of one probe for each polarisation.
fn totals(task: &Task, geometry: &Geometry, watch: &mut dyn Watch) -> Result<Vec<[f64; 2]>> {
    let admitted = task.admitted(geometry.grid().resolution).ok();
    let solver = admitted.as_ref().map_or(task.solver, |admitted| admitted.solver());
    let totals = geometry.systems(task.media, task.incidence, task.mean)?.into_iter().map(|system| {
        let far = system.far_field(&solver.solve(&*system, task.goal, watch)?.field);
        Ok([far.reflectance, far.transmittance])
    });
    totals.collect()
}

/// A grid with about `factor` times the points and cells, different from `r` along every axis with
/// several.
pub fn scaled(r: Resolution, factor: f64) -> Resolution {
    let points = |n: usize| match n {
        1 => 1,
        2 if factor < 1.0 => 1,
        n => scaled_points(n, factor),
    };
    Resolution { nx: points(r.nx), ny: points(r.ny), ..scaled_cells(r, factor) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::{Coverages, Gmres, Goal, Silent};
    use crate::wave::{Body, BodyShape, Incidence, Mean, Media, Scene, Scheme, Side};

    #[test]
    fn r_and_t_keep_their_own_errors() {
        // Two packings, two probes: means and their standard errors by hand, the larger probe
        // counts.
        let differences = [vec![[0.03, -0.001], [0.0, 0.0]], vec![[0.05, 0.003], [0.0, 0.004]]];
        let GridError { reflectance, transmittance } = GridError::from_differences(&differences);
        approx::assert_relative_eq!(reflectance, 0.04_f64.hypot(0.01), max_relative = 1e-12);
        approx::assert_relative_eq!(transmittance, 0.002_f64.hypot(0.002), max_relative = 1e-12);
        let single = GridError::from_differences(&differences[..1]);
        assert_eq!((single.reflectance, single.transmittance), (0.03, 0.001));
    }

    /// Grids judged by one set of numbers stayed in folders when the numbers changed, with half the
    /// error.
    #[test]
    fn the_judgement_has_a_name_of_its_own() {
        let known = (JUDGEMENT, COARSER, OF_FINER);
        assert_eq!(known, ("scaled companions", 0.8, 2.05), "numbers and name change together");
        // Third order, the least that grains show: what is left of a difference to a grid finer by
        // 1/0.8.
        approx::assert_relative_eq!(OF_FINER, 1.0 / (1.0 - COARSER.powi(3)), max_relative = 1e-3);
    }

    /// The phase per cell is 2.6 on five cells and 3.2 on four, where 2.9 are allowed: what counts
    /// is the difference to the finer grid over 1 − 0.8³, rounded to three digits.
    #[test]
    fn a_finer_grid_counts_with_its_share_where_the_coarser_one_is_refused() {
        let shape = BodyShape::CylinderY { x_um: 0.25, z_um: 0.3, radius_um: 0.1 };
        let scene = Scene::layer([0.5; 2], 0.73, vec![Body::new(shape, 0)]);
        let backgrounds = vec![1.558.into()];
        let inclusions = vec![1.4.into()];
        let media = Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds, inclusions };
        let incidence =
            Incidence { wavelength_um: 0.55, polar_deg: 20.0, azimuth_deg: 0.0, from: Side::Incident };
        let coverages = Coverages::of(&scene);
        let solver = Gmres::default();
        let task = Task {
            coverages: &coverages,
            media: &media,
            incidence: &incidence,
            mean: Mean::default(),
            scheme: Scheme::Cubic,
            solver: &solver,
            goal: Goal { tolerance: 1e-9, ..Goal::default() },
            memory: 1e9,
        };
        let resolution = Resolution { nx: 16, ny: 1, cells: 5, scheme: Scheme::Cubic };
        let on = |grid| totals(&task, &coverages.at(grid)?, &mut Silent);
        assert!(on(scaled(resolution, COARSER)).is_err());
        let one = on(resolution).unwrap()[0];
        let finer = on(scaled(resolution, 1.0 / COARSER)).unwrap()[0];
        let found = GridError::differences(&[task], resolution, &mut Silent).unwrap()[0];
        for i in 0..2 {
            let expected = (one[i] - finer[i]) / (1.0 - 0.8_f64.powi(3));
            assert!(expected != 0.0);
            approx::assert_relative_eq!(found[i], expected, max_relative = 1e-3);
        }
    }

    #[test]
    fn companions_are_coarser_or_finer_and_transform_fast() {
        for n in [1, 2, 12, 25, 128, 135] {
            let resolution = Resolution { nx: n, ny: 1, cells: n, scheme: Scheme::default() };
            let coarse = scaled(resolution, COARSER);
            let fine = scaled(resolution, 1.0 / COARSER);
            assert!(n == 1 || coarse.nx < n && n < fine.nx, "{n}");
            assert!(coarse.ny == 1 && fine.cells > n && (n == 1 || coarse.cells < n));
        }
    }
}
