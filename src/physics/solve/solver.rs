//! Interface of the strategies.

use super::account::{Goal, Solution, SolveError, Watch};
use super::ledger::Ledger;
use super::size::Size;
use crate::wave::{Field, Mean, System};

/// A strategy with its memory demand.
pub struct Fit {
    /// Largest memory besides the problem in bytes, unless a stalled solve lets it grow.
    pub bytes: f64,
    /// The strategy with less memory, or with permission to grow; `None` if it is unchanged.
    pub solver: Option<Box<dyn Solver>>,
}

impl Fit {
    /// The demand of a strategy with constant memory.
    pub fn fixed(bytes: f64) -> Fit {
        Fit { bytes, solver: None }
    }
}

/// A strategy: it controls its iteration, while the problem defines the residual. Strategies of
/// other crates implement this trait, keep their account in the [`Ledger`] and are
/// added to a [`Registry`](super::Registry).
///
/// ```
/// use inkwave_physics::solve::{Gmres, Goal, Silent, Solver};
/// use inkwave_physics::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
///
/// // A plate of glass, 0.4 µm: nothing varies along x and y, so that one point is enough.
/// let scene = Scene::layer([1.0, 1.0], 0.4, vec![]);
/// let media = Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds: vec![1.5.into()], inclusions: vec![] };
/// let light = Incidence { wavelength_um: 0.6, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
/// let grid = Resolution { nx: 1, ny: 1, cells: 4, scheme: Scheme::Cubic };
/// let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
///
/// // λ/n = 0.4 µm: a full wavelength in the plate, which therefore transmits everything (Fresnel and Airy).
/// let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?;
/// let far = problem.far_field(&solution.field);
/// assert!((far.transmittance - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Solver: Send + Sync {
    /// Name in tables and in [`Account::solver`](super::Account::solver).
    fn name(&self) -> &'static str;

    /// Solves the ledger's problem to its goal, or fails with the reason. `start` is an optional
    /// initial guess of u.
    ///
    /// # Errors
    /// [`SolveError`]: not converged, diverged, cancelled by the watch, or settings that do not
    /// suit the problem.
    fn run(&self, ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError>;

    /// Calls [`Solver::run`] with a new ledger.
    fn solve_from(
        &self,
        problem: &dyn System,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError> {
        self.run(Ledger::new(self.name(), problem, goal, watch), start)
    }

    /// Calls [`Solver::solve_from`] without an initial guess: most strategies start from the wave
    /// in the mean medium.
    fn solve(&self, problem: &dyn System, goal: Goal, watch: &mut dyn Watch) -> Result<Solution, SolveError> {
        self.solve_from(problem, None, goal, watch)
    }

    /// Mean medium that the strategy can use: relaxation needs a real one, most accept any.
    fn suited_mean(&self) -> Mean {
        Mean::default()
    }

    /// Memory demand besides a problem of the given size if `bytes` are available; more than that
    /// if the strategy cannot run with less.
    fn fit(&self, size: &Size, _bytes: f64) -> Fit {
        Fit::fixed(size.fields(50.0))
    }

    /// Largest number of unknowns of strategies that store a dense matrix; comparisons omit larger
    /// cases by default.
    fn most_unknowns(&self) -> Option<usize> {
        None
    }
}
