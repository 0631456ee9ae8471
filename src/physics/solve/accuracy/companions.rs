//! Error estimates by comparison with coarser grids (companions).
//!
//! A result is compared with one that has a fifth fewer points in the plane and one that has a
//! fifth fewer cells in z; the expected orders of convergence turn the differences into an estimate
//! of the finer result's error.

use super::error::{AccuracyError, Result};
use super::search::{error_share, scaled_cells, scaled_plane};
use super::task::{Estimated, Solved, Task};
use crate::numerics::estimate::largest;
use crate::solve::account::{SolveError, Watch};
use crate::wave::grid::share_cells;
use crate::wave::{BodyShape, FarField, Grid, Order, Resolution, TotalErrors, Unphysical, WaveError};

/// Ratio of the number of points or cells of a coarser companion to that of the result.
const COMPANION: f64 = 0.8;
/// Ratio of cells in a second companion for layers uniform along y: grains' tops are whole lines,
/// and a companion with nodes on them is so accurate that its difference underestimates the error.
const SECOND: f64 = 0.7;
/// Ratio of points in that second companion: a line that fills a half or a third of the period has
/// no harmonics of that number, so that a grid which adds only those shows no difference.
const SECOND_LATERAL: f64 = 0.6;
/// Upper limit of the search for a finer companion, as a factor on the number of cells.
const MOST_TIMES: usize = 16;
/// Points and cells per wavelength in the densest medium beyond which convergence slows to its
/// asymptotic order.
const FINE: [f64; 2] = [8.0, 3.3];
/// Amplitude error per unit of residual: trapped waves amplify it slightly.
const RESIDUAL_WEIGHT: f64 = 3.0;
/// Safety factor for the scatter of the two differences; with it the estimate covers nine cases out
/// of ten.
const SAFETY: f64 = 1.4;

impl Task<'_> {
    /// Solves on one grid and estimates the error from two companions.
    pub fn solve_with_estimate(&self, resolution: Resolution, watch: &mut dyn Watch) -> Result<Estimated> {
        self.estimated_from(None, resolution, watch)
    }

    pub(super) fn estimated_from(
        &self,
        guess: Option<&[Solved]>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Estimated> {
        let (mut solved, seconds_setup) = self.solve_from(guess, resolution, watch)?;
        let mut far_fields: Vec<FarField> = solved.iter().map(Solved::far_field).collect();
        let clock = std::time::Instant::now();
        let parts = self.error_parts(&solved, &far_fields, watch)?;
        let seconds_estimate = clock.elapsed().as_secs_f64();
        let mut task = *self;
        loop {
            let residual = largest(solved.iter().map(|s| s.solution.account.residual));
            let error_estimate = error_estimate(parts, residual);
            let judged = judged(far_fields, parts, residual);
            let broken = matches!(judged, Err(AccuracyError::Unphysical(Unphysical::OutOfBalance { .. })));
            let Some(goal) = task.goal.smaller().filter(|_| broken) else {
                let far_fields = judged?;
                return Ok(Estimated {
                    solved,
                    far_fields,
                    error_estimate,
                    parts,
                    seconds_setup,
                    seconds_estimate,
                });
            };
            task.goal = goal;
            solved = task.continued(solved, resolution, watch)?;
            far_fields = solved.iter().map(Solved::far_field).collect();
        }
    }

    /// Solves on from fields already found, to this task's goal.
    fn continued(
        &self,
        solved: Vec<Solved>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Vec<Solved>> {
        let solver = self.admitted(resolution)?;
        let each = solved.into_iter().map(|Solved { system, solution: before }| {
            let mut solution = solver.solver().solve_from(&*system, Some(&before.field), self.goal, watch)?;
            solution.account.follow(&before.account);
            Ok(Solved { system, solution })
        });
        each.collect()
    }

    /// Estimated errors due to the grid in the plane and along z, from two companions.
    ///
    /// # Errors
    /// Neither a coarser nor a finer companion can be solved.
    pub fn error_parts(&self, known: &[Solved], far: &[FarField], watch: &mut dyn Watch) -> Result<[f64; 2]> {
        let system = &known[0].system;
        if !system.has_contrast() {
            return Ok([0.0; 2]);
        }
        let resolution = system.grid().resolution;
        // Held of the result meanwhile: its problem, its field, and the incident wave.
        let size = self.size(resolution);
        let companion = Self { memory: self.memory - size.problem() - size.fields(2.0), ..*self };
        let scene = self.coverages.scene;
        let uniform = [scene.uniform_in_plane(), scene.uniform_in_y()];
        let mut across =
            |share: f64| companion.compare(known, far, self.z_companions(resolution, share), watch);
        let in_z = match uniform {
            [false, true] => largest([across(COMPANION)?, across(SECOND)?]),
            _ => across(COMPANION)?,
        };
        let mut lateral = |share: f64| {
            companion.compare(
                known,
                far,
                [share, 1.0 / share].map(|f| scaled_plane(resolution, f, uniform)),
                watch,
            )
        };
        let in_plane = match uniform {
            [true, _] => 0.0,
            [false, true] => largest([lateral(COMPANION)?, lateral(SECOND_LATERAL)?]),
            _ => lateral(COMPANION)?,
        };
        Ok([in_plane, in_z])
    }

    /// Grids with fewer and with more cells in every stratum that contains a body: cells elsewhere
    /// do not affect the error. The coarser one equals `resolution` if a stratum has only its
    /// minimum number of cells.
    fn z_companions(&self, resolution: Resolution, share: f64) -> [Resolution; 2] {
        let coarse = scaled_cells(resolution, share).cells;
        let fine = scaled_cells(resolution, 1.0 / share).cells;
        let cells = |n: &usize| Resolution { cells: *n, ..resolution };
        let mut coarser = (1..=coarse).rev().map(|n| n.max(self.coverages.scene.strata.len()));
        let coarser = coarser.find(|&n| self.times_finer(resolution.cells, n) > 1.0);
        let mut finer = fine..=MOST_TIMES * fine;
        let finer = finer.find(|&n| self.times_finer(n, resolution.cells) > 1.0).unwrap_or(fine);
        [coarser.as_ref().map_or(resolution, cells), cells(&finer)]
    }

    /// Smallest ratio of cells between two grids over the strata that contain a body.
    fn times_finer(&self, cells: usize, other: usize) -> f64 {
        let scene = self.coverages.scene;
        let shares = |cells: usize| share_cells(scene, cells).unwrap_or_default();
        let other = shares(other);
        let shares = shares(cells);
        let ratio = |i: usize| Some(*shares.get(i)? as f64 / *other.get(i)? as f64);
        scene.patterned_strata().into_iter().filter_map(ratio).fold(f64::INFINITY, f64::min)
    }

    /// Estimated error of the result: the corresponding fraction of its difference to the coarser
    /// companion, or to the finer one if the coarser grid is rejected.
    fn compare(
        &self,
        finer: &[Solved],
        far: &[FarField],
        companions: [Resolution; 2],
        watch: &mut dyn Watch,
    ) -> Result<f64> {
        let resolution = finer[0].system.grid().resolution;
        let [coarse, fine] = companions;
        let (solved, _) = match self.solve_coarser(coarse, finer, watch)? {
            Some(solved) => solved,
            None => self.solve_from(Some(finer), fine, watch)?,
        };
        let others: Vec<FarField> = solved.iter().map(Solved::far_field).collect();
        let difference = largest_of_all(far, &others);
        let used = solved[0].system.grid().resolution;
        let plane = resolution.nx as f64 / used.nx as f64;
        let across =
            if resolution.cells == used.cells { 1.0 } else { self.times_finer(resolution.cells, used.cells) };
        Ok(difference * error_share([plane, across], self.orders(resolution)))
    }

    /// Orders of convergence in the plane and across z, conservatively at the lower end of those
    /// observed.
    ///
    /// For grains 4 (3 for the vector wave, which has no folding) and 5 while the grid is coarse.
    /// Each of the following lowers them by one, down to 2 and 3: a fine grid; strong contrast;
    /// walls or cylinders, whose edges average out in two dimensions instead of three; walls along
    /// z, whose edges average out in one. Linear elements (tents) and second differences are of
    /// order 2 across z.
    fn orders(&self, resolution: Resolution) -> [i32; 2] {
        let scene = self.coverages.scene;
        let upright = scene.bodies.iter().any(|b| matches!(b.shape, BodyShape::BarY { .. }));
        let sharp = i32::from(scene.uniform_in_y()) + i32::from(self.is_strong()) + i32::from(upright);
        let waves = [scene.period_um[0], scene.thickness_um()].map(|l| l * self.waves_per_um());
        let fine = |i: usize, count: usize| i32::from(count as f64 > FINE[i] * waves[i]);
        let plane = if self.coverages.wave.is_vector() { 3 } else { 4 };
        let across =
            if resolution.scheme.degree() > 1 { (5 - sharp - fine(1, resolution.cells)).max(3) } else { 2 };
        [(plane - sharp - fine(0, resolution.nx)).max(2), across]
    }

    /// Whether an inclusion's contrast exceeds k² of a background: the series of the folded terms
    /// then converges slowly.
    fn is_strong(&self) -> bool {
        self.media.backgrounds.iter().any(|b| {
            let k2 = b * b;
            self.inclusions().any(|i| (i * i - k2).norm() > k2.norm())
        })
    }

    /// Solves the coarser companion; cells too high for the wave are refined only as far as
    /// necessary.
    fn solve_coarser(
        &self,
        coarser: Resolution,
        finer: &[Solved],
        watch: &mut dyn Watch,
    ) -> Result<Option<(Vec<Solved>, f64)>> {
        let resolution = finer[0].system.grid().resolution;
        let cells = finer[0].system.cells_needed(&Grid::new(self.coverages.scene, coarser)?);
        let coarser = Resolution { cells, ..coarser };
        if coarser == resolution
            || cells != resolution.cells && self.times_finer(resolution.cells, cells) <= 1.0
        {
            return Ok(None);
        }
        let solved = match self.solve_from(Some(finer), coarser, watch) {
            Err(AccuracyError::Wave(WaveError::CellTooHigh { needed, .. }))
                if needed < resolution.cells && self.times_finer(resolution.cells, needed) > 1.0 =>
            {
                self.solve_from(Some(finer), Resolution { cells: needed, ..coarser }, watch)
            }
            other => other,
        };
        match solved {
            Err(stopped @ AccuracyError::Solve(SolveError::Cancelled { .. })) => Err(stopped),
            other => Ok(other.ok()),
        }
    }
}

/// Largest expected error of any amplitude, from the parts given by [`Task::error_parts`] and
/// the residual.
pub fn error_estimate(parts: [f64; 2], residual: f64) -> f64 {
    SAFETY * (parts[0] + parts[1]) + 1e-13 + RESIDUAL_WEIGHT * residual
}

/// The far fields that break no physical law beyond their errors: parts of the grid, residual.
///
/// # Errors
/// One of them breaks a law.
pub(super) fn judged(far: Vec<FarField>, parts: [f64; 2], residual: f64) -> Result<Vec<FarField>> {
    let errors = TotalErrors::of_amplitudes(error_estimate(parts, residual), residual);
    Ok(far.into_iter().map(|far| far.judged(errors)).collect::<Result<_, _>>()?)
}

/// Largest difference of any propagating amplitude in any polarisation, or of a neighbour of the
/// specular order.
///
/// The amplitudes of other evanescent orders exist within a fraction of a wavelength of the faces,
/// carry no power, and converge more slowly.
pub fn largest_difference(a: &FarField, b: &FarField) -> f64 {
    let counts =
        |o: &&Order| o.reflected_propagates || o.transmitted_propagates || (o.m.abs() <= 1 && o.n.abs() <= 1);
    let pairs = a.orders.iter().filter(counts);
    let pairs = pairs.filter_map(|a| Some((a, b.orders.iter().find(|b| (a.m, a.n) == (b.m, b.n))?)));
    let amplitudes = pairs.flat_map(|(a, b)| a.amplitudes().zip(b.amplitudes()));
    largest(amplitudes.flat_map(|(a, b)| [(a[0] - b[0]).norm(), (a[1] - b[1]).norm()]))
}

/// Maximum of [`largest_difference`] over all polarisations.
pub fn largest_of_all(a: &[FarField], b: &[FarField]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| largest_difference(a, b)))
}
