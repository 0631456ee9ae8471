//! What the search for a grid needs to know of a wave: the scalar one and Maxwell's share all the rest.

use super::difference::largest_difference;
use crate::solve::demand::Size;
use crate::solve::solver::{Account, Goal, Solution, SolveError, Solver, Watch};
use crate::wave::contrast::coverage::Stop;
use crate::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorFarField, VectorProblem};
use crate::wave::{
    Coverage, FarField, Grid, Incidence, Mean, Media, Physical, Problem, Resolution, Scene, TotalErrors,
    Unphysical, WaveError,
};
use std::sync::Arc;

/// Geometry on a grid that a wave is solved on.
pub trait Discretisation: Sized + Send + Sync {
    /// One wavelength and direction on the geometry.
    type Problem;
    /// Converged fields.
    type Solution;
    /// What leaves the layer.
    type FarField;
    /// The same after it has passed the gate.
    type Judged;

    /// Points per wavelength in the densest medium, and planes per wavelength, from which the search starts at 1e-2.
    const START: [f64; 2];

    /// Order of convergence in the plane while the grid is coarse and the contrast weak.
    const PLANE_ORDER: i32;

    /// The geometry of a scene on a grid, with coefficients of a relative error.
    fn build(scene: &Scene, resolution: Resolution, error: f64, stop: Stop) -> Result<Self, WaveError>;

    /// The grid it was made for.
    fn grid(&self) -> &Grid;

    /// The discrete problem for one wavelength and direction.
    fn problem(
        geometry: &Arc<Self>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
    ) -> Result<Self::Problem, WaveError>;

    /// The grid of a problem.
    fn grid_of(problem: &Self::Problem) -> &Grid;

    /// Cells of another grid that a problem would be accepted on: its own, or as many as the wave needs.
    fn cells_needed(problem: &Self::Problem, other: &Grid) -> usize;

    /// False where the mean medium's wave is the solution.
    fn has_contrast(problem: &Self::Problem) -> bool;

    /// Runs a strategy, from another grid's solution where there is one and it helps.
    fn solve_from(
        problem: &Self::Problem,
        guess: Option<(&Self::Problem, &Self::Solution)>,
        solver: &dyn Solver,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Self::Solution, SolveError>;

    /// Reads off what leaves the layer.
    fn far_field(problem: &Self::Problem, solution: &Self::Solution) -> Self::FarField;

    /// Relative residual of a solution.
    fn residual(solution: &Self::Solution) -> f64;

    /// Largest difference of any amplitude that counts, see [`largest_difference`].
    fn difference(a: &Self::FarField, b: &Self::FarField) -> f64;

    /// \[R, T\] of every polarisation.
    fn totals(far: &Self::FarField) -> Vec<[f64; 2]>;

    /// Refuses totals that no passive layer has.
    fn judge(far: Self::FarField, errors: TotalErrors) -> Result<Self::Judged, Unphysical>;

    /// What a solve on a grid takes of the memory.
    fn size(scene: &Scene, media: &Media, wavelength_um: f64, resolution: Resolution) -> Size;
}

impl Discretisation for Coverage {
    type Problem = Problem;
    type Solution = Solution;
    type FarField = FarField;
    type Judged = Physical;

    const START: [f64; 2] = [3.0, 5.4];
    const PLANE_ORDER: i32 = 4;

    fn build(scene: &Scene, resolution: Resolution, error: f64, stop: Stop) -> Result<Coverage, WaveError> {
        Coverage::within_unless(scene, resolution, error, stop)
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn problem(
        geometry: &Arc<Coverage>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
    ) -> Result<Problem, WaveError> {
        Problem::new(geometry, media, incidence, mean)
    }

    fn grid_of(problem: &Problem) -> &Grid {
        &problem.coverage.grid
    }

    fn cells_needed(problem: &Problem, other: &Grid) -> usize {
        problem.cells_needed(other)
    }

    fn has_contrast(problem: &Problem) -> bool {
        problem.has_contrast()
    }

    fn solve_from(
        problem: &Problem,
        guess: Option<(&Problem, &Solution)>,
        solver: &dyn Solver,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError> {
        let start = guess.map(|(known, solution)| known.transferred(&solution.field, problem));
        solver.solve_from(problem, start.as_ref(), goal, watch)
    }

    fn far_field(problem: &Problem, solution: &Solution) -> FarField {
        problem.far_field(&solution.field)
    }

    fn residual(solution: &Solution) -> f64 {
        solution.account.residual
    }

    fn difference(a: &FarField, b: &FarField) -> f64 {
        largest_difference(a, b)
    }

    fn totals(far: &FarField) -> Vec<[f64; 2]> {
        vec![[far.reflectance, far.transmittance]]
    }

    fn judge(far: FarField, errors: TotalErrors) -> Result<Physical, Unphysical> {
        Physical::judge(far, errors)
    }

    fn size(scene: &Scene, media: &Media, wavelength_um: f64, resolution: Resolution) -> Size {
        Size::new(scene, media, wavelength_um, resolution)
    }
}

/// Solutions for s and p light.
pub type BothPolarisations = [Solution; 2];

/// The accounts of both solves as one: steps, applications and seconds together, the larger residual.
pub fn joint_account([s, p]: &BothPolarisations) -> Account {
    let (mut joint, p) = (s.account.clone(), &p.account);
    joint.steps += p.steps;
    joint.operator_applications += p.operator_applications;
    joint.seconds += p.seconds;
    joint.residual = joint.residual.max(p.residual);
    joint.bytes = joint.bytes.max(p.bytes);
    joint
}

impl Discretisation for NormalMoments {
    type Problem = VectorProblem;
    type Solution = BothPolarisations;
    type FarField = VectorFarField;
    type Judged = VectorFarField;

    const START: [f64; 2] = [3.2, 7.0];
    const PLANE_ORDER: i32 = 3;

    fn build(
        scene: &Scene,
        resolution: Resolution,
        error: f64,
        stop: Stop,
    ) -> Result<NormalMoments, WaveError> {
        NormalMoments::within_unless(scene, resolution, error, stop)
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn problem(
        geometry: &Arc<NormalMoments>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
    ) -> Result<VectorProblem, WaveError> {
        VectorProblem::new(geometry, media, incidence, mean, Averaging::Normal)
    }

    fn grid_of(problem: &VectorProblem) -> &Grid {
        &problem.moments.grid
    }

    fn cells_needed(problem: &VectorProblem, other: &Grid) -> usize {
        problem.cells_needed(other)
    }

    fn has_contrast(problem: &VectorProblem) -> bool {
        problem.has_contrast()
    }

    // Unknowns of the vector wave are moments, which do not interpolate from grid to grid: no guess.
    fn solve_from(
        problem: &VectorProblem,
        _guess: Option<(&VectorProblem, &BothPolarisations)>,
        solver: &dyn Solver,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<BothPolarisations, SolveError> {
        let [s, p] = Polarisation::BOTH.map(|polarisation| problem.polarised(polarisation));
        Ok([solver.solve(&s, goal, watch)?, solver.solve(&p, goal, watch)?])
    }

    fn far_field(problem: &VectorProblem, [s, p]: &BothPolarisations) -> VectorFarField {
        problem.far_field([&s.field, &p.field])
    }

    fn residual([s, p]: &BothPolarisations) -> f64 {
        s.account.residual.max(p.account.residual)
    }

    fn difference(a: &VectorFarField, b: &VectorFarField) -> f64 {
        a.largest_difference(b)
    }

    fn totals(far: &VectorFarField) -> Vec<[f64; 2]> {
        (0..2).map(|i| [far.reflectance[i], far.transmittance[i]]).collect()
    }

    fn judge(far: VectorFarField, errors: TotalErrors) -> Result<VectorFarField, Unphysical> {
        for polarisation in Polarisation::BOTH {
            Physical::judge(far.polarised(polarisation), errors)?;
        }
        Ok(far)
    }

    fn size(scene: &Scene, media: &Media, wavelength_um: f64, resolution: Resolution) -> Size {
        Size::vector(scene, media, wavelength_um, resolution)
    }
}
