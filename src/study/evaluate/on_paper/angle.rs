//! Directions of light and view, with the coherent film there at every wavelength of interest.

use super::CURVES;
use super::curves::{BENDS, anchor_weights, weighted};
use crate::appearance::paper::PaperError;
use crate::evaluate::films::FilmAt;
use crate::evaluate::wavelengths::Weights;

/// Everything known at the wavelengths of interest.
#[derive(Clone, Debug)]
pub struct AngleNodes {
    /// Vacuum wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// The coherent film at each wavelength.
    pub films: Vec<FilmAt>,
    /// The paper's albedo at each wavelength.
    pub albedos: Vec<f64>,
    /// Values of the spectral functions at each wavelength.
    pub weights: Vec<Weights>,
    /// The film's T̄ and Ā from the exit side.
    pub means: Vec<[f64; 2]>,
}

impl AngleNodes {
    /// Keeps the first wavelengths only.
    pub(in crate::evaluate) fn cut(&mut self, count: usize) {
        self.wavelengths_nm.truncate(count);
        self.films.truncate(count);
        self.albedos.truncate(count);
        self.weights.truncate(count);
        self.means.truncate(count);
    }
}

/// A viewing or illumination angle, with the film's R and T.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarAngle {
    /// Angle from the normal, degrees.
    pub polar_deg: f64,
    /// Its cosine.
    pub(super) mu: f64,
    /// Weights of the values at 0° and 45° in curves over the angle.
    pub(super) between: [f64; 2],
    /// The other functions of these curves.
    pub(super) bends: [f64; BENDS],
    /// Totals of the film at every node.
    pub(super) film: Vec<[f64; CURVES]>,
    /// T of the film in the light returned by the paper, at every node.
    pub(super) film_returned: Vec<f64>,
}

impl PolarAngle {
    /// The part of a curve with these coefficients.
    pub fn bent(&self, coefficients: &[f64; BENDS]) -> f64 {
        weighted(&self.bends, coefficients)
    }

    /// Evaluates the films at an angle.
    ///
    /// # Errors
    /// The angle is outside 0° ≤ θ < 90°.
    pub fn new(polar_deg: f64, nodes: &AngleNodes) -> Result<Self, PaperError> {
        if !(0.0..90.0).contains(&polar_deg) {
            return Err(PaperError::AngleOutOfRange { value: polar_deg });
        }
        let mu = polar_deg.to_radians().cos();
        let (between, bends) = anchor_weights(mu);
        let mut film = Vec::new();
        let mut film_returned = Vec::new();
        for node_film in &nodes.films {
            let [r, t] = node_film.reflectance_transmittance(polar_deg);
            let back = node_film.returned();
            film.push([r, t, r]);
            film_returned.push(if back == *node_film {
                t
            } else {
                back.reflectance_transmittance(polar_deg)[1]
            });
        }
        Ok(Self { polar_deg, mu, between, bends, film, film_returned })
    }
}
