//! One solve of a search: inputs and results.

use super::coverages::Coverages;
use super::error::AccuracyError;
use crate::solve::account::{Account, Goal, Solution, Watch};
use crate::solve::demand::{Admitted, Size, TooLarge};
use crate::solve::solver::Solver;
use crate::wave::{FarField, Incidence, Mean, Media, Resolution, Scheme, System, WaveError};
use num_complex::Complex64;

/// Everything that defines a solve except the resolution.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The scene, and its geometry on the grids tried.
    pub coverages: &'a Coverages<'a>,
    /// Indices of all media.
    pub media: &'a Media,
    /// The incident light.
    pub incidence: &'a Incidence,
    /// Mean medium of the operator A.
    pub mean: Mean,
    /// Discretisation along z.
    pub scheme: Scheme,
    /// The strategy.
    pub solver: &'a dyn Solver,
    /// Requested residual, and the limit on operator applications.
    pub goal: Goal,
    /// Memory limit of one solve in bytes, including what is held for its companions.
    pub memory: f64,
}

/// One polarisation's problem on a grid, or that of the scalar wave, with its solution.
pub struct Solved {
    /// The discrete problem.
    pub system: Box<dyn System>,
    /// The strategy's result.
    pub solution: Solution,
}

impl Solved {
    /// Far field of the solution.
    pub fn far_field(&self) -> FarField {
        self.system.far_field(&self.solution.field)
    }
}

/// A solve with its error estimate.
pub struct Estimated {
    /// Solutions on the grid chosen: of the scalar wave, or of s and p light.
    pub solved: Vec<Solved>,
    /// Far field of each solution; all have passed the physical checks
    /// ([`FarField::judged`]).
    pub far_fields: Vec<FarField>,
    /// Largest expected error of any complex amplitude considered by
    /// [`largest_difference`](super::largest_difference).
    pub error_estimate: f64,
    /// Contributions of the grid to the estimate: plane, z.
    pub parts: [f64; 2],
    /// Time for coverage and factorisation, s.
    pub seconds_setup: f64,
    /// Time for the companions, s.
    pub seconds_estimate: f64,
}

impl Estimated {
    /// The first problem; the scalar wave has only one.
    pub fn system(&self) -> &dyn System {
        &*self.solved[0].system
    }

    /// Far field of the first polarisation, or of the scalar wave.
    pub fn far_field(&self) -> &FarField {
        &self.far_fields[0]
    }

    /// Combined account of all polarisations: sums of steps, applications and seconds, the larger
    /// residual.
    pub fn account(&self) -> Account {
        let mut joint = self.solved[0].solution.account.clone();
        self.solved[1..].iter().for_each(|solved| joint.join(&solved.solution.account));
        joint
    }
}

impl Task<'_> {
    /// The strategy adapted to the memory available on a grid, with permission to grow into the
    /// rest.
    ///
    /// # Errors
    /// The memory is too small for any variant of the strategy.
    pub fn admitted(&self, resolution: Resolution) -> Result<Admitted<'_>, TooLarge> {
        self.size(resolution).admit(self.solver, self.memory)
    }

    /// The discrete problems on a grid.
    ///
    /// # Errors
    /// Invalid grids, bodies, media or lights.
    pub fn systems(&self, resolution: Resolution) -> Result<Vec<Box<dyn System>>, WaveError> {
        self.coverages.at(resolution)?.systems(self.media, self.incidence, self.mean)
    }

    /// Solves on one grid; returns the solutions and the time for coverage and factorisation, s.
    pub fn solve(
        &self,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<(Vec<Solved>, f64), AccuracyError> {
        self.solve_from(None, resolution, watch)
    }

    /// Solves on one grid, with other solutions as initial guesses.
    pub(super) fn solve_from(
        &self,
        guess: Option<&[Solved]>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<(Vec<Solved>, f64), AccuracyError> {
        let clock = std::time::Instant::now();
        let solver = self.admitted(resolution)?;
        let systems = self.systems(resolution)?;
        let setup = clock.elapsed().as_secs_f64();
        let mut solved = Vec::new();
        for (i, system) in systems.into_iter().enumerate() {
            let start =
                guess.and_then(|known| known[i].system.transferred(&known[i].solution.field, &*system));
            let solution = solver.solver().solve_from(&*system, start.as_ref(), self.goal, watch)?;
            solved.push(Solved { system, solution });
        }
        Ok((solved, setup))
    }

    /// Wavelengths per µm in the densest medium.
    pub(super) fn waves_per_um(&self) -> f64 {
        let backgrounds = self.media.backgrounds.iter().copied();
        backgrounds.chain(self.inclusions()).map(|eta| eta.norm()).fold(1.0, f64::max)
            / self.incidence.wavelength_um
    }

    /// Indices of the bodies' materials.
    pub(super) fn inclusions(&self) -> impl Iterator<Item = Complex64> {
        self.coverages.scene.bodies.iter().map(|b| self.media.index_of(b.material))
    }

    /// Size of a solve on a grid.
    pub(super) fn size(&self, resolution: Resolution) -> Size {
        let Coverages { wave, scene, .. } = *self.coverages;
        Size::new(wave, scene, self.media, self.incidence.wavelength_um, resolution)
    }
}
