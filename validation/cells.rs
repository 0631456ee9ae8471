//! Small cells that claims on strategies and identities share.

use inkwave::ink::Sphere;
use inkwave::solve::{Goal, Silent, Solution, SolveError, Solver};
use inkwave::wave::{Body, BodyShape, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;

/// A real mean, which relaxation needs.
pub const REAL: Mean = Mean { depends_on_z: true, absorbing: false };

/// A direction of incidence: polar and azimuth in degrees, and the side.
pub type Direction = (f64, f64, Side);

/// Five grains of ink-like index in a cell of some wavelength's side, different half-spaces.
pub struct Cell {
    pub kappa: f64,
    pub resolution: Resolution,
    pub mean: Mean,
}

impl Cell {
    pub fn new(kappa: f64, points: [usize; 2], cells: usize) -> Self {
        let resolution = Resolution { nx: points[0], ny: points[1], cells, scheme: Scheme::default() };
        Self { kappa, resolution, mean: Mean::default() }
    }

    pub fn scene() -> Scene {
        let grains = [
            [0.10, 0.12, 0.15, 0.10],
            [0.42, 0.20, 0.30, 0.12],
            [0.25, 0.48, 0.18, 0.11],
            [0.55, 0.50, 0.42, 0.09],
            [0.12, 0.33, 0.40, 0.08],
        ];
        let grain = |[x, y, z, radius_um]: [f64; 4]| {
            Body::new(BodyShape::Balls(vec![Sphere { center_um: [x, y, z], radius_um }]), 0)
        };
        Scene::layer([0.7, 0.62], 0.55, grains.map(grain).to_vec())
    }

    pub fn media(&self) -> Media {
        Media {
            incident: 1.0.into(),
            exit: 1.3.into(),
            backgrounds: vec![1.558.into()],
            inclusions: vec![Complex64::new(1.4, self.kappa)],
        }
    }

    /// The same cell with grains of the binder's own index: nothing scatters, and nothing remains to be iterated.
    pub fn clear_problem(&self, (polar_deg, azimuth_deg, from): Direction) -> Problem {
        let incidence = Incidence { wavelength_um: 0.5, polar_deg, azimuth_deg, from };
        let media = Media { inclusions: vec![1.558.into()], ..self.media() };
        Problem::from_scene(&Self::scene(), &media, &incidence, self.resolution, self.mean)
            .expect("a sound cell")
    }

    pub fn problem(&self, (polar_deg, azimuth_deg, from): Direction) -> Problem {
        let incidence = Incidence { wavelength_um: 0.5, polar_deg, azimuth_deg, from };
        Problem::from_scene(&Self::scene(), &self.media(), &incidence, self.resolution, self.mean)
            .expect("a sound cell")
    }
}

/// Solves, or says which strategy failed and why.
pub fn solve(solver: &dyn Solver, problem: &Problem, tolerance: f64) -> Result<Solution, SolveError> {
    solver.solve(problem, Goal { tolerance, max_applications: 50_000 }, &mut Silent)
}
