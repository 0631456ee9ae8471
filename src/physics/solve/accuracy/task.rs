//! One solve of a search: what it takes and what it gives.

use super::coverages::Coverages;
use super::discretisation::Discretisation;
use super::error::AccuracyError;
use crate::solve::demand::{Admitted, Size, TooLarge};
use crate::solve::solver::{Goal, Solver, Watch};
use crate::wave::{Coverage, Incidence, Mean, Media, Resolution, Scheme};
use num_complex::Complex64;

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

/// A problem and its solution.
pub type Known<'a, G> = (&'a <G as Discretisation>::Problem, &'a <G as Discretisation>::Solution);

impl<G: Discretisation> Task<'_, G> {
    /// The strategy as the memory holds it on that grid, with leave to grow into the rest of it.
    ///
    /// # Errors
    /// Nothing holds it.
    pub fn admitted(&self, resolution: Resolution) -> Result<Admitted<'_>, TooLarge> {
        let size = self.size(resolution);
        Ok(size.admit(self.solver, self.memory)?.with_room(&size, self.memory))
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
    pub(super) fn solve_from(
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

    /// What a solve on that grid will take.
    pub(super) fn size(&self, resolution: Resolution) -> Size {
        G::size(self.coverages.scene, self.media, self.incidence.wavelength_um, resolution)
    }
}
