//! One solve of a search: what it takes and what it gives.

use super::coverages::Coverages;
use super::error::AccuracyError;
use crate::solve::demand::{Admitted, Size, TooLarge};
use crate::solve::solver::{Account, Goal, Solution, Solver, Watch};
use crate::wave::{FarField, Incidence, Mean, Media, Resolution, Scheme, System, WaveError};
use num_complex::Complex64;

/// One solve to be made: everything but the resolution.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The scene, and its geometry on the grids tried.
    pub coverages: &'a Coverages<'a>,
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

/// One polarisation's problem on a grid, or the scalar wave's, and its solution.
pub struct Solved {
    /// The discrete problem.
    pub system: Box<dyn System>,
    /// What the strategy delivered.
    pub solution: Solution,
}

impl Solved {
    /// What leaves the layer.
    pub fn far_field(&self) -> FarField {
        self.system.far_field(&self.solution.field)
    }
}

/// A solve with its error estimate.
pub struct Estimated {
    /// On the grid that was chosen: of the scalar wave, or of s and p light.
    pub solved: Vec<Solved>,
    /// What leaves the layer, for each of them; all have passed the gate ([`Physical`](crate::wave::Physical)).
    pub far_fields: Vec<FarField>,
    /// Largest expected error of any complex amplitude that [`largest_difference`](super::largest_difference) counts.
    pub error_estimate: f64,
    /// The estimate's parts: plane, z.
    pub parts: [f64; 2],
    /// Seconds for coverage and factors.
    pub seconds_setup: f64,
    /// Seconds for the companions.
    pub seconds_estimate: f64,
}

impl Estimated {
    /// The first problem, the only one of the scalar wave.
    pub fn system(&self) -> &dyn System {
        &*self.solved[0].system
    }

    /// What leaves the layer in the first polarisation, or in the scalar wave.
    pub fn far_field(&self) -> &FarField {
        &self.far_fields[0]
    }

    /// The accounts of all polarisations as one: steps, applications and seconds together, the larger residual.
    pub fn account(&self) -> Account {
        let mut joint = self.solved[0].solution.account.clone();
        for Solved { solution: Solution { account, .. }, .. } in &self.solved[1..] {
            joint.steps += account.steps;
            joint.operator_applications += account.operator_applications;
            joint.seconds += account.seconds;
            joint.residual = joint.residual.max(account.residual);
            joint.bytes = joint.bytes.max(account.bytes);
        }
        joint
    }
}

impl Task<'_> {
    /// The strategy as the memory holds it on that grid, with leave to grow into the rest of it.
    ///
    /// # Errors
    /// Nothing holds it.
    pub fn admitted(&self, resolution: Resolution) -> Result<Admitted<'_>, TooLarge> {
        self.size(resolution).admit(self.solver, self.memory)
    }

    /// The discrete problems on one grid.
    ///
    /// # Errors
    /// Grids, bodies, media and lights that are refused.
    pub fn systems(&self, resolution: Resolution) -> Result<Vec<Box<dyn System>>, WaveError> {
        self.coverages.at(resolution)?.systems(self.media, self.incidence, self.mean)
    }

    /// Solves at one resolution: the solutions, and the seconds that coverage and factors took.
    pub fn solve(
        &self,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<(Vec<Solved>, f64), AccuracyError> {
        self.solve_from(None, resolution, watch)
    }

    /// Solves at one resolution, with another's solutions as first guesses.
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

    /// What a solve on that grid will take.
    pub(super) fn size(&self, resolution: Resolution) -> Size {
        let Coverages { wave, scene, .. } = *self.coverages;
        Size::new(wave, scene, self.media, self.incidence.wavelength_um, resolution)
    }
}
