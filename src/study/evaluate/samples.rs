//! The parts of a solve used in the evaluation, and the arrangement of a realisation's solves.

use super::films::LIGHTS;
use crate::wave::FarField;
use num_complex::Complex64;

/// One solve: totals, their specular parts, and the directions of the diffuse light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolvedDirection {
    /// Polar angle of incidence in the half-space that the light comes from, degrees.
    pub polar_deg: f64,
    /// Total R.
    pub reflectance: f64,
    /// R of the specular order.
    pub specular_reflectance: f64,
    /// Total T.
    pub transmittance: f64,
    /// T of the unscattered order.
    pub specular_transmittance: f64,
    /// Amplitudes of the unscattered order, one for each polarisation of the light, in that
    /// polarisation; scaled so that their squares are its efficiencies.
    pub unscattered: [Complex64; LIGHTS],
    /// A, from the field inside the layer.
    pub absorptance: f64,
    /// What of A every layer of a stack absorbs; empty for one layer.
    pub absorbed: Vec<f64>,
    /// Projected solid angle λ²/(Lx Ly) of an order of the cell, sr.
    pub order_area: f64,
    /// Reflected orders except the specular one.
    pub scattered: Vec<Scattered>,
}

/// One reflected order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Cosine of its polar angle.
    pub cosine: f64,
    /// Its direction cosine along the plane of incidence, positive forward: sin θ cos Δφ.
    pub along: f64,
    /// BRDF as the density e Lx Ly/λ², 1/sr.
    pub density: f64,
}

impl From<&FarField> for SolvedDirection {
    fn from(field: &FarField) -> Self {
        let specular = field.specular();
        let density = field.period_um[0] * field.period_um[1] / field.incidence.wavelength_um.powi(2);
        let diffuse = field.orders.iter().filter(|o| o.reflected_propagates && (o.m, o.n) != (0, 0));
        let cosine = |[x, y]: [f64; 2]| (1.0 - x * x - y * y).max(0.0).sqrt();
        let azimuth = field.incidence.azimuth_deg.to_radians();
        let forward = [azimuth.cos(), azimuth.sin()];
        let scattered = diffuse.map(|o| Scattered {
            cosine: cosine(o.direction),
            along: o.direction[0] * forward[0] + o.direction[1] * forward[1],
            density: density * o.reflected_efficiency,
        });
        let amplitudes: Vec<Complex64> = specular.amplitudes().map(|[_, transmitted]| transmitted).collect();
        let power: f64 = amplitudes.iter().map(Complex64::norm_sqr).sum();
        let scale = if power > 0.0 { (specular.transmitted_efficiency / power).sqrt() } else { 0.0 };
        Self {
            unscattered: [scale * amplitudes[0], scale * amplitudes[2]],
            polar_deg: field.incidence.polar_deg,
            reflectance: field.reflectance,
            specular_reflectance: specular.reflected_efficiency,
            transmittance: field.transmittance,
            specular_transmittance: specular.transmitted_efficiency,
            absorptance: field.absorptance,
            absorbed: field.absorbed.clone(),
            order_area: 1.0 / density,
            scattered: scattered.collect(),
        }
    }
}

/// Number of totals of a solve.
pub(super) const TOTALS: usize = 5;

impl SolvedDirection {
    /// R, specular R, T, specular T, A.
    pub(super) fn totals(&self) -> [f64; TOTALS] {
        let Self { reflectance, specular_reflectance, transmittance, .. } = *self;
        [reflectance, specular_reflectance, transmittance, self.specular_transmittance, self.absorptance]
    }

    fn totals_mut(&mut self) -> [&mut f64; TOTALS] {
        [
            &mut self.reflectance,
            &mut self.specular_reflectance,
            &mut self.transmittance,
            &mut self.specular_transmittance,
            &mut self.absorptance,
        ]
    }

    /// Adds errors to the totals; the diffuse orders follow R in proportion, and what layers absorb
    /// follows A.
    pub(super) fn shift(&mut self, by: [f64; TOTALS]) {
        let absorbed = self.absorptance;
        let before = self.reflectance - self.specular_reflectance;
        self.totals_mut().into_iter().zip(by).for_each(|(total, by)| *total += by);
        let after = self.reflectance - self.specular_reflectance;
        let factor = if before > 0.0 { (after / before).max(0.0) } else { 1.0 };
        self.scattered.iter_mut().for_each(|order| order.density *= factor);
        let of_absorbed = if absorbed > 0.0 { self.absorptance / absorbed } else { 1.0 };
        self.absorbed.iter_mut().for_each(|share| *share *= of_absorbed);
    }

    /// Becomes the mean with the same solve of another packing in the same cell.
    fn average(&mut self, other: &Self) {
        let totals = self.totals_mut().into_iter().zip(other.totals());
        totals.for_each(|(value, other)| *value = 0.5 * (*value + other));
        let amplitudes = self.unscattered.iter_mut().zip(other.unscattered);
        amplitudes.for_each(|(value, other)| *value = 0.5 * (*value + other));
        let absorbed = self.absorbed.iter_mut().zip(&other.absorbed);
        absorbed.for_each(|(value, other)| *value = 0.5 * (*value + other));
        let orders = self.scattered.iter_mut().zip(&other.scattered);
        orders.for_each(|(value, other)| value.density = 0.5 * (value.density + other.density));
    }
}

/// All solves of a realisation at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct SolvedWavelength {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Solves at the angles common to all realisations, in the study's order.
    pub exact: Vec<SolvedDirection>,
    /// One solve in each stratum of μ², 0 < μ² < 1: their plain mean is the hemispherical one.
    pub strata: Vec<SolvedDirection>,
    /// Solves from the exit side; empty if the layer is the same from both sides.
    pub exit: Vec<SolvedDirection>,
}

/// One realisation of the layer, or the mean of two that share a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct SolvedRealisation {
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Its wavelengths, increasing.
    pub wavelengths: Vec<SolvedWavelength>,
}

impl SolvedRealisation {
    /// The mean with another packing in the same cell, solved in the same light.
    pub fn mean_with(mut self, other: &Self) -> Self {
        for (wavelength, other) in self.wavelengths.iter_mut().zip(&other.wavelengths) {
            let solves =
                wavelength.exact.iter_mut().chain(&mut wavelength.strata).chain(&mut wavelength.exit);
            let others = other.exact.iter().chain(&other.strata).chain(&other.exit);
            solves.zip(others).for_each(|(solve, other)| solve.average(other));
        }
        self
    }
}

/// Mean of a quantity over equally weighted solves.
pub fn mean(solves: &[SolvedDirection], quantity: impl Fn(&SolvedDirection) -> f64) -> f64 {
    solves.iter().map(quantity).sum::<f64>() / solves.len().max(1) as f64
}
