//! Interface of the strategies, and the size of a solve with the memory of its parts.

use super::{Goal, Ledger, Solution, SolveError, Watch};
use crate::wave::{Field, Material, Mean, Media, Resolution, Scene, System, Wave};
use std::f64::consts::PI;

/// A strategy with its memory demand.
pub struct Demand {
    /// Largest memory besides the problem in bytes, unless a stalled solve lets it grow.
    pub bytes: f64,
    /// The strategy with less memory, or with permission to grow; `None` if it is unchanged.
    pub solver: Option<Box<dyn Solver>>,
}

impl Demand {
    /// The demand of a strategy with constant memory.
    pub fn fixed(bytes: f64) -> Demand {
        Demand { bytes, solver: None }
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
/// let glass = vec![1.5.into()];
/// let media =
///     Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds: glass, inclusions: vec![] };
/// let light =
///     Incidence { wavelength_um: 0.6, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
/// let grid = Resolution { nx: 1, ny: 1, cells: 4, scheme: Scheme::Cubic };
/// let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
///
/// // λ/n = 0.4 µm: a full wavelength in the plate, which therefore transmits everything (Fresnel
/// // and Airy).
/// let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?;
/// let far = problem.far_field(&solution.field);
/// assert!((far.transmittance - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Solver: Send + Sync {
    /// Name in tables and in [`Account::solver`](super::Account::solver).
    fn name(&self) -> &'static str;

    /// Whether the settings are possible, whatever the problem.
    ///
    /// # Errors
    /// [`SolveError::Setting`], with what is allowed.
    fn check(&self) -> Result<(), SolveError> {
        Ok(())
    }

    /// Solves the ledger's problem to its goal, or fails with the reason. `start` is an optional
    /// initial guess of u.
    ///
    /// # Errors
    /// [`SolveError`]: not converged, diverged, cancelled by the watch, or settings that do not
    /// suit the problem.
    fn run(&self, ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError>;

    /// Calls [`Solver::run`] with a new ledger, if the settings are possible.
    fn solve_from(
        &self,
        problem: &dyn System,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError> {
        self.check()?;
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
    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        Demand::fixed(size.fields(50.0))
    }

    /// Largest number of unknowns of strategies that store a dense matrix; comparisons omit larger
    /// cases by default.
    fn most_unknowns(&self) -> Option<usize> {
        None
    }
}

/// Bytes of a complex number.
const COMPLEX: f64 = 16.0;
/// Ratio of the coverage's harmonics to those of the grid: twice as many along both axes.
const WIDE: f64 = 4.0;
/// Ratio of the coverage's source points to its harmonics: twice as many along both axes.
const FINE: f64 = 4.0;

/// Quantities that determine the memory of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// The grid.
    pub resolution: Resolution,
    /// Pairs of a background and a body material; 0 for films.
    pub channels: usize,
    /// How many of them are of uniaxial crystals.
    pub crystals: usize,
    /// Periods and thickness, µm.
    pub layer_um: [f64; 3],
    /// Largest wavenumber in a medium and wavenumber in vacuum, 1/µm; zeros if no guided modes are
    /// treated.
    pub wavenumbers: [f64; 2],
    /// Whether the wave is the vector wave, with three components per unknown.
    pub vector: bool,
}

/// Bytes per point and plane of the vector wave: the contrast tensor in both precisions.
const VECTOR_TENSOR: f64 = 9.0 * COMPLEX;
/// Bytes of the mean operator: two tables of its cells and four of its nodes for every two
/// planes, in both precisions.
const VECTOR_TABLES: f64 = 4.5 * COMPLEX;
/// Bytes of a channel: seven real moments.
const VECTOR_MOMENTS: f64 = 7.0 * 8.0;
/// Further bytes of a channel of crystals: 42 real moments.
const CRYSTAL_MOMENTS: f64 = 42.0 * 8.0;

impl Size {
    /// Size of a scene on a grid; guided modes are treated for the scalar wave only.
    pub fn new(wave: Wave, scene: &Scene, media: &Media, wavelength_um: f64, resolution: Resolution) -> Size {
        let backgrounds = distinct(scene.strata.iter().map(|s| s.background));
        let materials = distinct(scene.bodies.iter().map(|b| b.material));
        let crystals = scene.bodies.iter().map(|b| b.material);
        let crystals = backgrounds * distinct(crystals.filter(|m| matches!(m, Material::Uniaxial(_))));
        let k0 = 2.0 * PI / wavelength_um;
        let densest = media.backgrounds.iter().chain(&media.inclusions).map(|eta| eta.re).fold(1.0, f64::max);
        let [lx, ly] = scene.period_um;
        let layer_um = [lx, ly, scene.thickness_um()];
        let vector = wave.is_vector();
        let wavenumbers = if vector { [0.0; 2] } else { [k0 * densest, k0] };
        let channels = backgrounds * materials;
        Size { resolution, channels, crystals, layer_um, wavenumbers, vector }
    }

    /// Number of points of a plane.
    pub fn points(&self) -> f64 {
        self.resolution.nx as f64 * self.resolution.ny as f64
    }

    /// Number of planes with unknowns.
    pub fn planes(&self) -> f64 {
        self.resolution.scheme.degree() as f64 * self.resolution.cells as f64 + 1.0
    }

    /// Upper limit on the number of unknowns.
    pub fn unknowns(&self) -> f64 {
        let components = if self.vector { 3.0 } else { 1.0 };
        components * self.points() * self.planes()
    }

    /// Memory of `count` fields, bytes.
    pub fn fields(&self, count: f64) -> f64 {
        count * COMPLEX * self.unknowns()
    }

    /// Number of eigenvalues of the mean slab's operator within `threshold` k0² of zero:
    /// wavevectors in a shell of half of k-space, plus those of the two faces.
    pub fn near_null_modes(&self, threshold: f64) -> f64 {
        let [lx, ly, h] = self.layer_um;
        let [k, k0] = self.wavenumbers;
        let shell = threshold * k0 * k0;
        lx * ly * shell * (h * k / (2.0 * PI * PI) + 1.0 / (2.0 * PI)) + 1.0
    }

    /// Memory held by a problem, bytes: coverage and factors of the mean operator.
    pub fn problem(&self) -> f64 {
        let channels = self.channels as f64;
        let degree = self.resolution.scheme.degree() as f64;
        if self.vector {
            let moments = VECTOR_MOMENTS * channels + CRYSTAL_MOMENTS * self.crystals as f64;
            let each = VECTOR_TENSOR + VECTOR_TABLES + moments;
            return self.points() * self.planes() * each;
        }
        let moments = channels + 0.5 * channels * (channels + 1.0);
        // Tables of the mean operator and contrast in double precision, and those of A⁻¹V in single
        // precision.
        let factors = COMPLEX * (4.5 + 2.0 / degree);
        self.unknowns() * (8.0 * moments + factors)
    }

    /// Memory needed while the coverage is computed beyond its result, bytes: coefficients of every
    /// cell, and source grids of every thread.
    pub fn making(&self) -> f64 {
        if self.channels == 0 {
            return 0.0;
        }
        let wide = |n: usize| if n == 1 { 1.0 } else { WIDE.sqrt() * n as f64 };
        let harmonics = wide(self.resolution.nx) * wide(self.resolution.ny);
        let planes = self.resolution.scheme.degree() as f64 + 1.0;
        let threads = rayon::current_num_threads() as f64;
        let cells = self.resolution.cells as f64;
        COMPLEX * harmonics * planes * (self.channels as f64 * cells + (FINE + 1.0) * threads)
    }
}

/// Number of different items.
fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> usize {
    let mut different = Vec::new();
    items.for_each(|item| {
        if !different.contains(&item) {
            different.push(item)
        }
    });
    different.len()
}
