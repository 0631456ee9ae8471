//! Ensembles of packed layers, solved: what the statistical claims share.

use inkwave::ink::pack;
use inkwave::ink::{PackingRequest, PigmentGrains};
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{FarField, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;
use rayon::prelude::*;

const WAVELENGTH_UM: f64 = 0.55;

/// Layers of 250 nm grains, 30 % by volume, 0.6 µm thick, in cells of one size.
#[derive(Clone, Copy, Debug)]
pub struct Layers {
    /// Grains of one cell; they set its side.
    pub grains: usize,
    pub kappa: f64,
    pub polar_deg: f64,
    pub seed: u64,
    pub realisations: u64,
}

const THICKNESS_UM: f64 = 0.6;
const DIAMETER_NM: f64 = 250.0;
const FRACTION: f64 = 0.3;
/// Points per µm, and cells of the cubic scheme: amplitudes to some 3e-3, far below the ensembles' scatter.
const POINTS_PER_UM: f64 = 12.0;
const CELLS: usize = 6;

impl Layers {
    /// Side of the square cell that these grains fill to `FRACTION`.
    pub fn side_um(&self) -> f64 {
        let volume = std::f64::consts::PI / 6.0 * (1e-3 * DIAMETER_NM).powi(3);
        (self.grains as f64 * volume / (FRACTION * THICKNESS_UM)).sqrt()
    }

    /// Far fields of all realisations, in their order.
    pub fn solved(&self) -> Vec<FarField> {
        (0..self.realisations).into_par_iter().map(|stream| self.realisation(stream)).collect()
    }

    fn realisation(&self, stream: u64) -> FarField {
        let request = PackingRequest {
            period_um: [self.side_um(); 2],
            thickness_um: THICKNESS_UM,
            pigments: vec![PigmentGrains::spheres(DIAMETER_NM, FRACTION)],
            seed: self.seed,
            stream,
            ..Default::default()
        };
        let scene = Scene::from_packing(&pack(&request, &mut ()).expect("30 % packs"));
        let media = Media {
            incident: 1.0.into(),
            exit: 1.0.into(),
            backgrounds: vec![1.558.into()],
            inclusions: vec![Complex64::new(1.4, self.kappa)],
        };
        let incidence = Incidence {
            wavelength_um: WAVELENGTH_UM,
            polar_deg: self.polar_deg,
            azimuth_deg: 0.0,
            from: Side::Incident,
        };
        let points = inkwave::solve::accuracy::smooth_size((POINTS_PER_UM * self.side_um()) as usize);
        let resolution = Resolution { nx: points, ny: points, cells: CELLS, scheme: Scheme::default() };
        let problem =
            Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("a layer");
        let goal = Goal { tolerance: 1e-6, ..Goal::default() };
        let field = Gmres::default().solve(&problem, goal, &mut Silent).expect("ink converges").field;
        problem.far_field(&field)
    }
}
