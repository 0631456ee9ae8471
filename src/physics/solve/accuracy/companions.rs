//! How far off a result is: differences from coarser companions.
//!
//! A result is compared with one that has a fifth fewer points in the plane and one that has a fifth fewer cells
//! in z; the observed orders of convergence turn the differences into an estimate of the finer result's error.

use super::difference::largest_of_all;
use super::error::AccuracyError;
use super::resolution::{error_share, scaled_cells, scaled_plane};
use super::task::{Estimated, Solved, Task};
use crate::solve::solver::{SolveError, Watch};
use crate::wave::grid::share_cells;
use crate::wave::physical::largest;
use crate::wave::{BodyShape, FarField, Grid, Physical, Resolution, TotalErrors, WaveError};

/// Share of points or cells that a companion keeps.
const COMPANION: f64 = 0.8;
/// Share of cells that a second companion keeps where nothing changes along y. Tops of such grains are whole lines: a
/// companion with nodes on them is far more accurate than its spacing says, and its difference tells too little.
const SECOND: f64 = 0.7;
/// Share of points that a second companion keeps there: a line that fills a half or a third of the period has no harmonics of
/// that number, and a grid that adds only those tells nothing.
const SECOND_LATERAL: f64 = 0.6;
/// A stratum gains a cell within so many times the cells of all.
const MOST_TIMES: usize = 16;
/// Points and cells per wavelength in the densest medium beyond which convergence slows down to its last order.
const FINE: [f64; 2] = [8.0, 3.3];
/// Amplitude error per unit of residual: trapped waves amplify it a little.
const RESIDUAL_WEIGHT: f64 = 3.0;
/// The two differences scatter; with this factor the estimate covers nine cases of ten.
const SAFETY: f64 = 1.4;

impl Task<'_> {
    /// Solves at one resolution and estimates the error from two companions.
    pub fn solve_with_estimate(
        &self,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Estimated, AccuracyError> {
        self.estimated_from(None, resolution, watch)
    }

    pub(super) fn estimated_from(
        &self,
        guess: Option<&[Solved]>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Estimated, AccuracyError> {
        let (solved, seconds_setup) = self.solve_from(guess, resolution, watch)?;
        let far_fields: Vec<FarField> = solved.iter().map(Solved::far_field).collect();
        let clock = std::time::Instant::now();
        let parts = self.estimate_parts(&solved, &far_fields, watch)?;
        let residual = largest(solved.iter().map(|s| s.solution.account.residual));
        let error_estimate = error_estimate(parts, residual);
        let errors = TotalErrors::of_amplitudes(error_estimate, residual);
        let judged = |far| Ok(Physical::judge(far, errors)?.into_inner());
        let far_fields = far_fields.into_iter().map(judged).collect::<Result<_, AccuracyError>>()?;
        let seconds_estimate = clock.elapsed().as_secs_f64();
        Ok(Estimated { solved, far_fields, error_estimate, parts, seconds_setup, seconds_estimate })
    }

    /// The estimated error's parts from the plane and from z, by two companions.
    ///
    /// # Errors
    /// Neither a coarser nor a finer companion has a solution.
    pub fn estimate_parts(
        &self,
        known: &[Solved],
        far: &[FarField],
        watch: &mut dyn Watch,
    ) -> Result<[f64; 2], AccuracyError> {
        let system = &known[0].system;
        if !system.has_contrast() {
            return Ok([0.0; 2]);
        }
        let own = system.grid().resolution;
        // What is held of the result meanwhile: its problem, its field, and the incident wave.
        let size = self.size(own);
        let companion = Self { memory: self.memory - size.problem() - size.fields(2.0), ..*self };
        let scene = self.coverages.scene;
        let uniform = [scene.uniform_in_plane(), scene.uniform_in_y()];
        let mut across = |share: f64| companion.compare(known, far, self.z_companions(own, share), watch);
        let in_z = match uniform {
            [false, true] => largest([across(COMPANION)?, across(SECOND)?]),
            _ => across(COMPANION)?,
        };
        let mut lateral = |share: f64| {
            let plane = [share, 1.0 / share].map(|f| scaled_plane(own, f, uniform));
            companion.compare(known, far, plane, watch)
        };
        let in_plane = match uniform {
            [true, _] => 0.0,
            [false, true] => largest([lateral(COMPANION)?, lateral(SECOND_LATERAL)?]),
            _ => lateral(COMPANION)?,
        };
        Ok([in_plane, in_z])
    }

    /// Grids with fewer and with more cells in every stratum that holds a body: what happens elsewhere changes nothing. The
    /// coarser one is the own grid where a stratum has no cell to lose.
    fn z_companions(&self, own: Resolution, share: f64) -> [Resolution; 2] {
        let (coarse, fine) = (scaled_cells(own, share).cells, scaled_cells(own, 1.0 / share).cells);
        let cells = |n: &usize| Resolution { cells: *n, ..own };
        let is_coarser = |n: &usize| self.times_finer(own.cells, *n) > 1.0;
        let is_finer = |n: &usize| self.times_finer(*n, own.cells) > 1.0;
        let coarser = (1..=coarse).rev().map(|n| n.max(self.coverages.scene.strata.len())).find(is_coarser);
        let finer = (fine..=MOST_TIMES * fine).find(is_finer).unwrap_or(fine);
        [coarser.as_ref().map_or(own, cells), cells(&finer)]
    }

    /// How many times more cells a grid has than another, in the stratum with a body where that is least.
    fn times_finer(&self, cells: usize, other: usize) -> f64 {
        let scene = self.coverages.scene;
        let shares = |cells: usize| share_cells(scene, cells).unwrap_or_default();
        let (own, other) = (shares(cells), shares(other));
        let ratio = |i: usize| Some(*own.get(i)? as f64 / *other.get(i)? as f64);
        scene.patterned_strata().into_iter().filter_map(ratio).fold(f64::INFINITY, f64::min)
    }

    /// The finer result's share of the difference to the coarser companion, or to the finer one where that is refused.
    fn compare(
        &self,
        finer: &[Solved],
        far: &[FarField],
        companions: [Resolution; 2],
        watch: &mut dyn Watch,
    ) -> Result<f64, AccuracyError> {
        let own = finer[0].system.grid().resolution;
        let [coarse, fine] = companions;
        let (solved, _) = match self.solve_coarser(coarse, finer, watch)? {
            Some(solved) => solved,
            None => self.solve_from(Some(finer), fine, watch)?,
        };
        let others: Vec<FarField> = solved.iter().map(Solved::far_field).collect();
        let difference = largest_of_all(far, &others);
        let used = solved[0].system.grid().resolution;
        let plane = own.nx as f64 / used.nx as f64;
        let across = if own.cells == used.cells { 1.0 } else { self.times_finer(own.cells, used.cells) };
        Ok(difference * error_share([plane, across], self.orders(own)))
    }

    /// Orders of convergence, in the plane and across z, at the lower end of what is seen.
    ///
    /// For grains 4 (3 for the vector wave, which folds nothing) and 5 while the grid is coarse; one less, down to 2 and 3, for each of: a fine grid, strong contrast,
    /// walls or cylinders, whose edges average out in two dimensions instead of three, and walls along z, whose edges
    /// do so in one. Tents and second differences are of order 2 across z.
    fn orders(&self, own: Resolution) -> [i32; 2] {
        let upright = self.coverages.scene.bodies.iter().any(|b| matches!(b.shape, BodyShape::BarY { .. }));
        let sharp =
            i32::from(self.coverages.scene.uniform_in_y()) + i32::from(self.is_strong()) + i32::from(upright);
        let waves = [self.coverages.scene.period_um[0], self.coverages.scene.thickness_um()]
            .map(|l| l * self.waves_per_um());
        let fine = |i: usize, count: usize| i32::from(count as f64 > FINE[i] * waves[i]);
        let plane = if self.coverages.wave.is_vector() { 3 } else { 4 };
        let across = if own.scheme.degree() > 1 { (5 - sharp - fine(1, own.cells)).max(3) } else { 2 };
        [(plane - sharp - fine(0, own.nx)).max(2), across]
    }

    /// True when an inclusion's contrast exceeds k² of a background: the folded terms' series converges slowly then.
    fn is_strong(&self) -> bool {
        self.media.backgrounds.iter().any(|b| {
            let k2 = b * b;
            self.inclusions().any(|i| (i * i - k2).norm() > k2.norm())
        })
    }

    /// Solves the coarser companion; cells too high for the wave are made only as low as they must be.
    fn solve_coarser(
        &self,
        coarser: Resolution,
        finer: &[Solved],
        watch: &mut dyn Watch,
    ) -> Result<Option<(Vec<Solved>, f64)>, AccuracyError> {
        let own = finer[0].system.grid().resolution;
        let cells = finer[0].system.cells_needed(&Grid::new(self.coverages.scene, coarser)?);
        let coarser = Resolution { cells, ..coarser };
        if coarser == own || cells != own.cells && self.times_finer(own.cells, cells) <= 1.0 {
            return Ok(None);
        }
        let solved = match self.solve_from(Some(finer), coarser, watch) {
            Err(AccuracyError::Wave(WaveError::CellTooHigh { needed, .. }))
                if needed < own.cells && self.times_finer(own.cells, needed) > 1.0 =>
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

/// Largest expected error of any amplitude, from the parts of [`Task::estimate_parts`] and the residual.
pub fn error_estimate(parts: [f64; 2], residual: f64) -> f64 {
    SAFETY * (parts[0] + parts[1]) + 1e-13 + RESIDUAL_WEIGHT * residual
}
