//! How fine is fine enough: error estimates from coarser companions, and resolutions chosen for an accuracy.
//!
//! A result is compared with one that has a fifth fewer points in the plane and one that has a fifth fewer cells
//! in z; the observed orders of convergence turn the differences into an estimate of the finer result's error.

use super::coverages::Coverages;
use super::discretisation::Discretisation;
use super::resolution::{error_share, raised, refine, scaled_cells, scaled_plane};
use crate::solve::demand::{Admitted, Size, TooLarge};
use crate::solve::solver::{Goal, GridTrial, SolveError, Solver, Watch};
use crate::wave::grid::MOST_POINTS;
use crate::wave::{
    Coverage, Grid, Incidence, Mean, Media, Resolution, Scheme, Shape, TotalErrors, Unphysical, WaveError,
};
use num_complex::Complex64;
use thiserror::Error;

pub use super::resolution::smooth_size;

/// Share of points or cells that a companion keeps.
const COMPANION: f64 = 0.8;
/// Amplitude error per unit of residual: trapped waves amplify it a little.
const RESIDUAL_WEIGHT: f64 = 3.0;
/// The two differences scatter; with this factor the estimate covers nine cases of ten.
const SAFETY: f64 = 1.4;
/// Points and cells per wavelength in the densest medium beyond which convergence slows down to its last order.
const FINE: [f64; 2] = [8.0, 3.3];
/// Error that a result without physical sense counts as when the grid is refined.
const UNPHYSICAL: f64 = 1.0;
/// Resolutions tried before giving up.
const LEVELS: usize = 24;

/// One solve to be made: everything but the resolution.
pub struct Task<'a, G = Coverage> {
    /// The scene, and its geometry on the grids tried.
    pub coverages: &'a Coverages<'a, G>,
    /// Indices of all media.
    pub media: &'a Media,
    /// The light.
    pub incidence: &'a Incidence,
    /// Which mean medium the operator A has.
    pub mean: Mean,
    /// Discretisation along z.
    pub scheme: Scheme,
    /// The strategy.
    pub solver: &'a dyn Solver,
    /// Residual to reach, and the most operator applications.
    pub goal: Goal,
    /// Most bytes that one solve may take, with what is held for its companions.
    pub memory: f64,
}

impl<G> Clone for Task<'_, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<G> Copy for Task<'_, G> {}

/// A solve with its error estimate.
pub struct Estimated<G: Discretisation = Coverage> {
    /// The discrete problem on the grid that was chosen.
    pub problem: G::Problem,
    /// What the strategy delivered.
    pub solution: G::Solution,
    /// What leaves the layer.
    pub far_field: G::Judged,
    /// Largest expected error of any complex amplitude that [`largest_difference`](super::largest_difference) counts.
    pub error_estimate: f64,
    /// The estimate's parts: plane, z.
    pub parts: [f64; 2],
    /// Seconds for coverage and factors.
    pub seconds_setup: f64,
    /// Seconds for the companions.
    pub seconds_estimate: f64,
}

/// Why no result of the asked accuracy exists.
#[derive(Debug, Error)]
pub enum AccuracyError {
    /// The scene does not make a problem on some grid.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// A solve failed or was stopped.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The result breaks a law it must obey.
    #[error(transparent)]
    Unphysical(#[from] Unphysical),
    /// A solve would not fit into memory.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The next finer grid does not fit into memory.
    #[error(
        "accuracy {asked:.1e} is not reached: the estimate is {reached:.1e} on {nx} × {ny} points and {cells} cells, \
         and the next finer grid would need {need_gb:.2} GB of the {allowed_gb:.2} GB allowed; ask for less accuracy, \
         a smaller cell, or more memory (tried: {tried})"
    )]
    NotReached {
        /// Amplitude error asked for.
        asked: f64,
        /// Estimate on the finest grid solved.
        reached: f64,
        /// Points along x of that grid.
        nx: usize,
        /// Points along y.
        ny: usize,
        /// Cells along z.
        cells: usize,
        /// Memory that the next grid would take, GB.
        need_gb: f64,
        /// Memory allowed, GB.
        allowed_gb: f64,
        /// Every grid tried, with its estimate and time.
        tried: String,
    },
    /// Not even the coarsest sensible grid fits into memory.
    #[error(
        "accuracy {asked:.1e} is not reached: the coarsest grid to start from, {nx} × {ny} points and {cells} cells, would need {need_gb:.2} GB of the \
         {allowed_gb:.2} GB allowed; ask for less accuracy, a smaller cell, or more memory"
    )]
    TooLarge {
        /// Amplitude error asked for.
        asked: f64,
        /// Points along x of the coarsest grid.
        nx: usize,
        /// Points along y.
        ny: usize,
        /// Cells along z.
        cells: usize,
        /// Memory it would take, GB.
        need_gb: f64,
        /// Memory allowed, GB.
        allowed_gb: f64,
    },
    /// The error does not fall as the grid is refined.
    #[error(
        "accuracy {asked:.1e} is not reached: the estimate is {reached:.1e} after {LEVELS} finer and finer grids; ask for \
         less accuracy"
    )]
    GivenUp {
        /// Amplitude error asked for.
        asked: f64,
        /// Estimate on the finest grid solved.
        reached: f64,
    },
    /// The layer measures more wavelengths than any grid resolves.
    #[error(
        "accuracy {asked:.1e} is not reached: already the coarsest grid would need {need:.1e} points along an axis of at \
         most {MOST_POINTS}; check that the wavelength and all lengths are in µm"
    )]
    TooManyWaves {
        /// The accuracy asked for.
        asked: f64,
        /// Points or cells along the longest axis.
        need: f64,
    },
    /// An accuracy that makes no sense.
    #[error("accuracy is {0}; allowed is 1e-9 … 0.5: choose how large an amplitude error you accept")]
    Accuracy(f64),
}

/// A problem and its solution.
pub type Known<'a, G> = (&'a <G as Discretisation>::Problem, &'a <G as Discretisation>::Solution);

impl AccuracyError {
    /// True when the user stopped the search, which is no failure.
    pub fn is_stop(&self) -> bool {
        matches!(self, AccuracyError::Solve(SolveError::Cancelled { .. }))
    }
}

impl<G: Discretisation> Task<'_, G> {
    /// The strategy as the memory holds it on that grid.
    ///
    /// # Errors
    /// Nothing holds it.
    pub fn admitted(&self, resolution: Resolution) -> Result<Admitted<'_>, TooLarge> {
        self.size(resolution).admit(self.solver, self.memory)
    }

    /// Solves at one resolution.
    pub fn solve(
        &self,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<(G::Problem, G::Solution, f64), AccuracyError> {
        self.solve_from(None, resolution, watch)
    }

    /// Solves at one resolution, with another's solution as first guess.
    fn solve_from(
        &self,
        guess: Option<Known<G>>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<(G::Problem, G::Solution, f64), AccuracyError> {
        let clock = std::time::Instant::now();
        let solver = self.admitted(resolution)?;
        let coverage = self.coverages.at(resolution)?;
        let problem = G::problem(&coverage, self.media, self.incidence, self.mean)?;
        let setup = clock.elapsed().as_secs_f64();
        let solution = G::solve_from(&problem, guess, solver.solver(), self.goal, watch)?;
        Ok((problem, solution, setup))
    }

    /// Solves at one resolution and estimates the error from two companions.
    pub fn solve_with_estimate(
        &self,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Estimated<G>, AccuracyError> {
        self.estimated_from(None, resolution, watch)
    }

    fn estimated_from(
        &self,
        guess: Option<Known<G>>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<Estimated<G>, AccuracyError> {
        let (problem, solution, seconds_setup) = self.solve_from(guess, resolution, watch)?;
        let far_field = G::far_field(&problem, &solution);
        let clock = std::time::Instant::now();
        let parts = self.estimate_parts((&problem, &solution), &far_field, watch)?;
        let error_estimate = error_estimate(parts, G::residual(&solution));
        let errors = TotalErrors::of_amplitudes(error_estimate, G::residual(&solution));
        Ok(Estimated {
            far_field: G::judge(far_field, errors)?,
            error_estimate,
            seconds_estimate: clock.elapsed().as_secs_f64(),
            problem,
            solution,
            parts,
            seconds_setup,
        })
    }

    /// The estimated error's parts from the plane and from z, by two companions.
    ///
    /// # Errors
    /// Neither a coarser nor a finer companion has a solution.
    pub fn estimate_parts(
        &self,
        known: Known<G>,
        far: &G::FarField,
        watch: &mut dyn Watch,
    ) -> Result<[f64; 2], AccuracyError> {
        let problem = known.0;
        if !G::has_contrast(problem) {
            return Ok([0.0; 2]);
        }
        let own = G::grid_of(problem).resolution;
        // What is held of the result meanwhile: its problem, its field, and the incident wave.
        let size = self.size(own);
        let companion = Self { memory: self.memory - size.problem() - size.fields(2.0), ..*self };
        let scene = self.coverages.scene;
        let uniform = [scene.uniform_in_plane(), scene.uniform_in_y()];
        let plane = [COMPANION, 1.0 / COMPANION].map(|f| scaled_plane(own, f, uniform));
        let across = [COMPANION, 1.0 / COMPANION].map(|f| scaled_cells(own, f));
        let in_plane = match self.coverages.scene.uniform_in_plane() {
            true => 0.0,
            false => companion.compare(known, far, plane, watch)?,
        };
        Ok([in_plane, companion.compare(known, far, across, watch)?])
    }

    /// The finer result's share of the difference to the coarser companion, or to the finer one where that is refused.
    fn compare(
        &self,
        finer: Known<G>,
        far: &G::FarField,
        companions: [Resolution; 2],
        watch: &mut dyn Watch,
    ) -> Result<f64, AccuracyError> {
        let own = G::grid_of(finer.0).resolution;
        let [coarse, fine] = companions;
        let (problem, solution, _) = match self.solve_coarser(coarse, finer, watch)? {
            Some(solved) => solved,
            None => self.solve_from(Some(finer), fine, watch)?,
        };
        let difference = G::difference(far, &G::far_field(&problem, &solution));
        let used = G::grid_of(&problem).resolution;
        Ok(difference * error_share(own, used, self.orders(own)))
    }

    /// Orders of convergence, in the plane and across z, at the lower end of what is seen.
    ///
    /// For grains 4 (3 for the vector wave, which folds nothing) and 5 while the grid is coarse; one less, down to 2 and 3, for each of: a fine grid, strong contrast,
    /// walls or cylinders, whose edges average out in two dimensions instead of three, and walls along z, whose edges
    /// do so in one.
    fn orders(&self, own: Resolution) -> [i32; 2] {
        let upright = self.coverages.scene.bodies.iter().any(|b| matches!(b.shape, Shape::BarY { .. }));
        let sharp =
            i32::from(self.coverages.scene.uniform_in_y()) + i32::from(self.is_strong()) + i32::from(upright);
        let waves = [self.coverages.scene.period_um[0], self.coverages.scene.thickness_um()]
            .map(|l| l * self.waves_per_um());
        let fine = |i: usize, count: usize| i32::from(count as f64 > FINE[i] * waves[i]);
        [(G::PLANE_ORDER - sharp - fine(0, own.nx)).max(2), (5 - sharp - fine(1, own.cells)).max(3)]
    }

    /// Wavelengths per µm in the densest medium.
    fn waves_per_um(&self) -> f64 {
        let backgrounds = self.media.backgrounds.iter().copied();
        backgrounds.chain(self.inclusions()).map(|eta| eta.norm()).fold(1.0, f64::max)
            / self.incidence.wavelength_um
    }

    /// True when an inclusion's contrast exceeds k² of a background: the folded terms' series converges slowly then.
    fn is_strong(&self) -> bool {
        self.media.backgrounds.iter().any(|b| {
            let k2 = b * b;
            self.inclusions().any(|i| (i * i - k2).norm() > k2.norm())
        })
    }

    /// Indices of the bodies' materials.
    fn inclusions(&self) -> impl Iterator<Item = Complex64> {
        self.coverages.scene.bodies.iter().map(|b| self.media.index_of(b.material))
    }

    /// Solves the coarser companion; cells too high for the wave are made only as low as they must be.
    fn solve_coarser(
        &self,
        coarser: Resolution,
        finer: Known<G>,
        watch: &mut dyn Watch,
    ) -> Result<Option<(G::Problem, G::Solution, f64)>, AccuracyError> {
        let own = G::grid_of(finer.0).resolution;
        let cells = G::cells_needed(finer.0, &Grid::new(self.coverages.scene, coarser)?);
        let coarser = Resolution { cells, ..coarser };
        if coarser == own || cells > own.cells {
            return Ok(None);
        }
        let solved = match self.solve_from(Some(finer), coarser, watch) {
            Err(AccuracyError::Wave(WaveError::CellTooHigh { needed, .. })) if needed < own.cells => {
                self.solve_from(Some(finer), Resolution { cells: needed, ..coarser }, watch)
            }
            other => other,
        };
        match solved {
            Err(stopped @ AccuracyError::Solve(SolveError::Cancelled { .. })) => Err(stopped),
            other => Ok(other.ok()),
        }
    }

    /// Refines plane and z separately until the estimate meets `accuracy`.
    pub fn solve_to_accuracy(
        &self,
        accuracy: f64,
        watch: &mut dyn Watch,
    ) -> Result<Estimated<G>, AccuracyError> {
        if !(1e-9..=0.5).contains(&accuracy) {
            return Err(AccuracyError::Accuracy(accuracy));
        }
        let mut task = *self;
        task.goal.tolerance = task.goal.tolerance.min(accuracy / 50.0);
        let mut resolution = task.start(accuracy)?;
        let mut last: Option<Estimated<G>> = None;
        let mut refused: Option<AccuracyError> = None;
        let mut tried: Vec<GridTrial> = Vec::new();
        for _ in 0..LEVELS {
            if let Err(refusal) = task.admitted(resolution) {
                return Err(match &last {
                    Some(estimated) => not_reached(accuracy, estimated, &refusal, &tried),
                    None => too_large(accuracy, &refusal),
                });
            }
            let clock = std::time::Instant::now();
            watch.grid(&GridTrial { resolution, accuracy, estimate: None, seconds: 0.0 });
            let guess = last.as_ref().map(|coarser| (&coarser.problem, &coarser.solution));
            let estimated = match task.estimated_from(guess, resolution, watch) {
                Err(AccuracyError::Wave(refusal)) => {
                    let Some(finer) = raised(resolution, &refusal) else { return Err(refusal.into()) };
                    (resolution, refused) = (finer, Some(refusal.into()));
                    continue;
                }
                // Ringing of a grid that is too coarse for its contrast: a finer one rings less.
                Err(AccuracyError::Unphysical(refusal @ Unphysical::OutOfRange { .. })) => {
                    (resolution, refused) =
                        (refine(resolution, [UNPHYSICAL; 2], accuracy), Some(refusal.into()));
                    continue;
                }
                other => other?,
            };
            let (estimate, seconds) = (Some(estimated.error_estimate), clock.elapsed().as_secs_f64());
            let trial = GridTrial { resolution, accuracy, estimate, seconds };
            watch.grid(&trial);
            tried.push(trial);
            if estimated.error_estimate <= accuracy {
                return Ok(estimated);
            }
            resolution = refine(resolution, estimated.parts, accuracy);
            last = Some(estimated);
        }
        match last {
            Some(estimated) => {
                Err(AccuracyError::GivenUp { asked: accuracy, reached: estimated.error_estimate })
            }
            None => Err(refused.unwrap_or(AccuracyError::Accuracy(accuracy))),
        }
    }

    /// First resolution of the search.
    ///
    /// # Errors
    /// The layer measures more wavelengths than any grid resolves.
    fn start(&self, accuracy: f64) -> Result<Resolution, AccuracyError> {
        let finer = (1e-2 / accuracy).max(1.0);
        let waves = self.waves_per_um();
        let points = |period: f64| starting_size(accuracy, G::START[0] * finer.powf(0.25) * waves * period);
        let nx = if self.coverages.scene.uniform_in_plane() {
            1
        } else {
            points(self.coverages.scene.period_um[0])?
        };
        let ny =
            if self.coverages.scene.uniform_in_y() { 1 } else { points(self.coverages.scene.period_um[1])? };
        let planes = G::START[1] * finer.powf(0.2) * waves * self.coverages.scene.thickness_um();
        let cells = possible(accuracy, planes / self.scheme.degree() as f64)?;
        let cells = cells.max(self.coverages.scene.strata.len()).max(2);
        Ok(Resolution { nx, ny, cells, scheme: self.scheme })
    }

    /// What a solve on that grid will take.
    fn size(&self, resolution: Resolution) -> Size {
        G::size(self.coverages.scene, self.media, self.incidence.wavelength_um, resolution)
    }
}

fn too_large(asked: f64, refusal: &TooLarge) -> AccuracyError {
    let TooLarge { resolution: Resolution { nx, ny, cells, .. }, need_gb, allowed_gb } = *refusal;
    AccuracyError::TooLarge { asked, nx, ny, cells, need_gb, allowed_gb }
}

fn not_reached<G: Discretisation>(
    asked: f64,
    last: &Estimated<G>,
    refusal: &TooLarge,
    tried: &[GridTrial],
) -> AccuracyError {
    let Resolution { nx, ny, cells, .. } = G::grid_of(&last.problem).resolution;
    let TooLarge { need_gb, allowed_gb, .. } = *refusal;
    let tried = tried.iter().map(GridTrial::to_string).collect::<Vec<_>>().join("; ");
    AccuracyError::NotReached {
        asked,
        reached: last.error_estimate,
        nx,
        ny,
        cells,
        need_gb,
        allowed_gb,
        tried,
    }
}

/// Points to start with, in a size that transforms fast.
fn starting_size(accuracy: f64, points: f64) -> Result<usize, AccuracyError> {
    possible(accuracy, points).map(smooth_size)
}

/// A number of points or cells along one axis, if a grid can have so many.
fn possible(asked: f64, need: f64) -> Result<usize, AccuracyError> {
    if need <= MOST_POINTS as f64 {
        Ok(need.ceil() as usize)
    } else {
        Err(AccuracyError::TooManyWaves { asked, need })
    }
}

/// Largest expected error of any amplitude, from the parts of [`Task::estimate_parts`] and the residual.
pub fn error_estimate(parts: [f64; 2], residual: f64) -> f64 {
    SAFETY * (parts[0] + parts[1]) + 1e-13 + RESIDUAL_WEIGHT * residual
}

/// The scheme that reaches an accuracy with the fewest planes: higher cells pay once the planes are needed anyway.
pub fn suited_scheme(accuracy: f64) -> Scheme {
    if accuracy < 3e-3 { Scheme::Quartic } else { Scheme::Cubic }
}
