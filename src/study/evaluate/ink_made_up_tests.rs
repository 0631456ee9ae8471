//! A layer with prescribed scattering, so that its true values are known, and ensembles of its
//! solves.

use crate::appearance::paper::{Albedo, Coupling, PRINT_DEG, Substrate};
use crate::evaluate::films::Films;
use crate::evaluate::ink::{InkInputs, InkOnPaper, SolvedLayer};
use crate::evaluate::layer::LayerEnsemble;
use crate::evaluate::samples::{Scattered, SolvedDirection, SolvedRealisation, SolvedWavelength};
use crate::evaluate::wavelengths::SpectralBasis;

/// A synthetic ensemble: the effect of the grains is smooth in angle and wavelength, plus noise in
/// each realisation.
pub struct MadeUp<'a> {
    pub(crate) films: Films<'a>,
    pub(crate) strata: usize,
    pub(crate) wavelengths: usize,
    pub(crate) noise: f64,
}

pub(crate) const RANGE_NM: [f64; 2] = [400.0, 700.0];

/// Scattering takes from T and adds to R and A; it vanishes at grazing incidence.
fn taken(nm: f64, mu: f64) -> [f64; 2] {
    let band = (-((nm - 520.0) / 60.0).powi(2)).exp();
    [mu * (0.05 + 0.1 * band) * (1.3 - 0.6 * mu), mu * (0.02 + 0.03 * band)]
}

/// Orders all around, brighter forward: f = 0.01 + 0.02 s − 0.01 s (μ + μ') + 0.005 (2 s² − sin²θ
/// sin²θ'), s = sin θ sin θ' cos Δφ.
fn scattered(polar_deg: f64) -> Vec<Scattered> {
    let (sine, lit) = polar_deg.to_radians().sin_cos();
    let around = |cosine: f64| (0..7).map(move |k| (cosine, (0.3 + 0.9 * f64::from(k)).cos()));
    let order = |(cosine, azimuth): (f64, f64)| {
        let along = (1.0 - cosine * cosine).sqrt() * azimuth;
        Scattered { cosine, along, density: density(lit, cosine, sine * along) }
    };
    [0.95, 0.8, 0.5, 0.2].into_iter().flat_map(around).map(order).collect()
}

/// f of the synthetic layer; s = sin θ sin θ' cos Δφ.
fn density(lit: f64, seen: f64, s: f64) -> f64 {
    let squares = (1.0 - lit * lit) * (1.0 - seen * seen);
    0.01 + 0.02 * s - 0.01 * s * (lit + seen) + 0.005 * (2.0 * s * s - squares)
}

/// Projected solid angle of an order of the synthetic cells, 2 µm².
fn order_area(nm: f64) -> f64 {
    (1e-3 * nm).powi(2) / 2.0
}

impl MadeUp<'_> {
    fn solved(&self, nm: f64, polar_deg: f64, error: f64) -> SolvedDirection {
        let film = self.films.at(nm).reflectance_transmittance(polar_deg);
        let [lost, back] = taken(nm, polar_deg.to_radians().cos());
        let r = film[0] + back;
        let t = film[1] - lost + error;
        let mu = polar_deg.to_radians().cos();
        let hidden = order_area(nm) * density(mu, mu, 1.0 - mu * mu);
        SolvedDirection {
            polar_deg,
            reflectance: r,
            specular_reflectance: film[0] + hidden,
            order_area: order_area(nm),
            transmittance: t,
            specular_transmittance: film[1] - 2.0 * lost,
            unscattered: Default::default(),
            absorptance: 1.0 - r - t,
            absorbed: Vec::new(),
            scattered: scattered(polar_deg),
        }
    }

    /// One realisation with these shifts of its wavelengths and directions.
    pub fn realisation(&self, shifts: [f64; 2], mut error: impl FnMut() -> f64) -> SolvedRealisation {
        let step = (RANGE_NM[1] - RANGE_NM[0]) / self.wavelengths as f64;
        let mut noise = || self.noise * error();
        let common = noise();
        let wavelength = |j: usize| {
            let nm = RANGE_NM[0] + step * (j as f64 + shifts[0]);
            let error = common + noise();
            let strata = crate::input::variation::stratified_deg(self.strata, shifts[1]);
            SolvedWavelength {
                wavelength_nm: nm,
                exact: [0.0, PRINT_DEG].map(|deg| self.solved(nm, deg, error)).to_vec(),
                strata: strata.into_iter().map(|deg| self.solved(nm, deg, error)).collect(),
                exit: Vec::new(),
            }
        };
        SolvedRealisation { thickness_um: 1.0, wavelengths: (0..self.wavelengths).map(wavelength).collect() }
    }

    /// The ink of this number of realisations, and their solves.
    pub fn ink(&self, realisations: usize, seed: u64) -> (InkOnPaper, Vec<SolvedRealisation>) {
        let mut draws = crate::numerics::Draws::new(seed, 3);
        let sequence = crate::numerics::Sequence::<2>::new(seed);
        let solved: Vec<_> =
            (0..realisations).map(|r| self.realisation(sequence.point(r), || draws.normal())).collect();
        let basis = SpectralBasis::Splines { range_nm: RANGE_NM, intervals: self.wavelengths };
        let layer = LayerEnsemble::new(&solved, basis, &self.films, &[0.0, PRINT_DEG]);
        let outputs_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
        let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
        let inputs = InkInputs { films: &self.films, substrate: &substrate, outputs_nm: &outputs_nm };
        (InkOnPaper::new(SolvedLayer { ensemble: layer, solved: &solved }, None, &inputs).unwrap(), solved)
    }
}

/// Natural light of the synthetic layer at the normal, by an independent dense sum.
pub fn truth(films: &Films, nm: f64) -> f64 {
    let film = films.at(nm);
    let count = 4000;
    let mut t_mean = 0.0;
    let mut a_mean = 0.0;
    for k in 0..count {
        let mu = ((k as f64 + 0.5) / count as f64).sqrt();
        let [r, t] = film.reflectance_transmittance(mu.acos().to_degrees());
        let [lost, back] = taken(nm, mu);
        t_mean += (t - lost) / count as f64;
        a_mean += (1.0 - r - t + lost - back) / count as f64;
    }
    let [r, t] = film.reflectance_transmittance(0.0);
    let [lost, back] = taken(nm, 1.0);
    let returned = crate::appearance::paper::returned(0.9, t_mean, a_mean, 1.0).unwrap();
    r + back + returned * (t - lost) * t_mean
}
