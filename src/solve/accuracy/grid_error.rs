//! What the grid may cost in R and T: differences to a coarser grid at the probes.
//!
//! The error of single amplitudes ([`super::search`]) says little about sums over orders, where most of it
//! averages out. So R and T themselves are compared with those on four fifths of the points and cells. At third order or
//! better, what the observed convergence is, the finer grid's error is no larger than the difference.

use super::search::{AccuracyError, Task, smooth_size};
use crate::run::resolve::is_stop;
use crate::solve::Watch;
use crate::wave::physical::largest;
use crate::wave::{Coverage, Problem, Resolution};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Share of points and cells of the coarser grid.
const COARSER: f64 = 0.8;

/// Differences of this size are rounding.
const ROUNDING: f64 = 1e-12;

/// Expected errors of the layer's R and T from the grid, over the probes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GridError {
    pub reflectance: f64,
    pub transmittance: f64,
}

impl GridError {
    pub fn max(self, other: Self) -> Self {
        Self {
            reflectance: largest([self.reflectance, other.reflectance]),
            transmittance: largest([self.transmittance, other.transmittance]),
        }
    }

    /// Compares the probes at `own` with a coarser grid, or with a finer one where the coarser is refused.
    pub(crate) fn measure(
        tasks: &[Task],
        own: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Self, AccuracyError> {
        let mut error = Self::default();
        let Some(coverages) = tasks.first().map(|task| task.coverages) else { return Ok(error) };
        let cover = |r: Resolution| coverages.at(r);
        let (here, coarse) = (cover(own)?, cover(scaled(own, COARSER))?);
        for task in tasks {
            let one = totals(task, &here, watch)?;
            let other = match totals(task, &coarse, watch) {
                Ok(other) => other,
                Err(stopped) if is_stop(&stopped) => return Err(stopped),
                Err(_) => totals(task, &cover(scaled(own, 1.0 / COARSER))?, watch)?,
            };
            let apart = |i: usize| (one[i] - other[i]).abs();
            // Layers without grains are exact on every grid: rounding is no error of theirs.
            let difference = |i: usize| if apart(i) <= ROUNDING { 0.0 } else { apart(i) };
            error = error.max(Self { reflectance: difference(0), transmittance: difference(1) });
        }
        Ok(error)
    }
}

/// R and T of one probe.
fn totals(task: &Task, coverage: &Arc<Coverage>, watch: &mut dyn Watch) -> Result<[f64; 2], AccuracyError> {
    let problem = Problem::new(coverage, task.media, task.incidence, task.mean)?;
    let far_field = problem.far_field(&task.solver.solve(&problem, task.goal, watch)?.field);
    Ok([far_field.reflectance, far_field.transmittance])
}

/// A grid with about `factor` times the points and cells, different from `r` wherever that has several.
fn scaled(r: Resolution, factor: f64) -> Resolution {
    let points = |n: usize| if n == 1 { 1 } else { scaled_points(n, factor) };
    let cells = r.cells as f64 * factor;
    let cells = if factor < 1.0 { cells.floor() } else { cells.ceil() };
    Resolution { nx: points(r.nx), ny: points(r.ny), cells: (cells as usize).max(1), ..r }
}

fn scaled_points(n: usize, factor: f64) -> usize {
    let wanted = n as f64 * factor;
    if factor > 1.0 {
        return smooth_size(wanted.ceil() as usize);
    }
    (1..=wanted as usize).rev().find(|&k| smooth_size(k) == k).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wave::Scheme;

    #[test]
    fn companions_are_coarser_or_finer_and_transform_fast() {
        for n in [1, 2, 12, 25, 128, 135] {
            let own = Resolution { nx: n, ny: 1, cells: n, scheme: Scheme::default() };
            let (coarse, fine) = (scaled(own, COARSER), scaled(own, 1.0 / COARSER));
            assert!(n == 1 || coarse.nx < n && n < fine.nx, "{n}");
            assert!(coarse.ny == 1 && fine.cells > n && (n == 1 || coarse.cells < n));
        }
    }
}
