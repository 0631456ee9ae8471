//! The layer on a Lambertian substrate: light going back and forth between the layer and the paper (P1 section 5).
//!
//! With T(θ), R(θ) from above, R_b(θ) from below (totals, specular and diffuse), ρ the albedo of the paper:
//!
//! ```text
//! R̄_b = 2∫₀¹ R_b(μ) μ dμ     g = ρ/(1 − ρ R̄_b)     T̄ = 2∫₀¹ T(μ) μ dμ
//! f(i, o) = f_layer(i, o) + g T(i) T(o)/π           albedo(i) = R(i) + g T(i) T̄
//! uniform sky of radiance 1, seen at o:  R(o) + g T(o) T̄
//! ```
//!
//! T(o) of the light that leaves equals T from above at o by reciprocity, with roughness and absorption too.
//! [`Coupling::Gap`] is the paper's model: a thin gap, no interference between layer and paper.
//! [`Coupling::OpticalContact`] has the paper's scatterers in a medium of index n that touches the layer: the solves
//! then have n below, R_b is taken over the angles inside that medium (total internal reflection included) and
//! radiance that leaves drops by n²: g → g/n². Its limit for a plane film matched to the medium is Williams & Clapper
//! (1953). A clear film of 1.558 on paper 0.9 has π f(0→0) = 0.910 with a (coherent) gap, 0.818 in contact.
//!
//! A [`Slab`] as baseline carries the interference fringes of the layer through quadrature and interpolation, so that
//! only the smooth rest depends on how many angles are solved for.
//!
//! The wave model is scalar: all of this is for s-polarised light.

use super::angles::{AngleRule, PolarAngle, hemispherical_mean};
pub use super::layer_optics::LayerOptics;
use super::slab::Slab;
pub use super::substrate::{Albedo, Coupling, Substrate};
use crate::wave::Side;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use thiserror::Error;

/// Angles for the hemispherical means of the baseline: rounding for layers of a few wavelengths.
const BASELINE_POINTS: usize = 48;

/// Calibrated on the model layers of the tests; see [`LayerOnPaper::angle_error`].
const ANGLE_ERROR_SAFETY: f64 = 1.5;

#[derive(Debug, Error, PartialEq)]
pub enum PaperError {
    #[error("angles = {value}: allowed 1 to {most}; 5 to 8 are usual")]
    Points { value: usize, most: usize },
    #[error(
        "picture angle {value}° is outside 0° to {largest:.1}°, the largest of {points} quadrature angles; use more points or a smaller picture angle"
    )]
    PictureAngle { value: f64, largest: f64, points: usize },
    #[error("polar angle {value}° is outside 0° to {largest:.1}°, the rule's largest angle; use more points")]
    AngleOutOfRange { value: f64, largest: f64 },
    #[error(
        "optical contact index = {value}: must be finite and greater than 1 (the binder's, e.g. 1.558); use the gap for 1"
    )]
    ContactIndex { value: f64 },
    #[error("paper albedo = {value}: allowed 0 to 1")]
    Albedo { value: f64 },
    #[error("paper albedo is given from {lo} to {hi} nm, asked at {value} nm; extend the table")]
    AlbedoRange { value: f64, lo: f64, hi: f64 },
    #[error("paper albedo table: wavelength_nm = {value} does not increase, or fewer than 2 rows")]
    AlbedoTable { value: f64 },
    #[error("{field} has {count} values for {expected} angles of the rule")]
    WrongLength { field: &'static str, count: usize, expected: usize },
    #[error("{field}[{index}] = {value}: must be finite and in {lo} to {hi}; check the solve behind it")]
    BadValue { field: &'static str, index: usize, value: f64, lo: f64, hi: f64 },
    #[error(
        "the layer reflects all light from below (R̄_b = {mean}) on paper of albedo 1: the light never leaves; lower the albedo"
    )]
    TrapsAllLight { mean: f64 },
    #[error("no realisations: at least one is needed")]
    NoRealisations,
    #[error(
        "the angle rule was made for another coupling than the substrate's; make it with AngleRule::new(points, max, substrate.coupling)"
    )]
    CouplingMismatch,
}

/// Whether light of the sky mirrored by the layer counts: P1 leaves it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MirroredSky {
    /// R(o) + g T(o) T̄: all the light of a uniform sky.
    #[default]
    Included,
    /// Without the specular order, as when a viewer turns the print to avoid glare.
    Excluded,
}

/// The layer on paper at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerOnPaper {
    /// Differences from the baseline where there is one.
    layer: LayerOptics,
    index_below: f64,
    return_factor: f64,
    mean_transmittance: f64,
    mean_reflectance_below: f64,
}

impl LayerOnPaper {
    /// # Errors
    /// Lengths that do not fit the rule, values that are not finite or outside 0–1, albedo outside 0–1, or a
    /// lossless mirror over a lossless paper.
    pub fn new(rule: &AngleRule, layer: &LayerOptics, albedo: f64) -> Result<Self, PaperError> {
        layer.check(rule)?;
        if !(0.0..=1.0).contains(&albedo) {
            return Err(PaperError::Albedo { value: albedo });
        }
        let mut layer = layer.clone();
        // reciprocity holds for the ensemble, not for each realisation's two solves: the mean of both is closer
        layer.diffuse_brdf = (&layer.diffuse_brdf + &layer.diffuse_brdf.t()) / 2.0;
        let [slab_transmits, slab_returns] = subtract_baseline(rule, &mut layer)?;
        let mean = slab_returns + hemispherical_mean(&rule.below, &layer.reflectance_below);
        let escaping = 1.0 - albedo * mean;
        if escaping < 1e-12 {
            return Err(PaperError::TrapsAllLight { mean });
        }
        let index_below = rule.coupling.index_below();
        Ok(Self {
            return_factor: albedo / escaping / (index_below * index_below),
            mean_transmittance: slab_transmits + hemispherical_mean(&rule.above, &layer.transmittance),
            mean_reflectance_below: mean,
            layer,
            index_below,
        })
    }

    /// g = ρ/(1 − ρ R̄_b), over n² in optical contact.
    pub fn return_factor(&self) -> f64 {
        self.return_factor
    }

    /// T̄, the mean transmittance over the hemisphere above.
    pub fn mean_transmittance(&self) -> f64 {
        self.mean_transmittance
    }

    /// R̄_b, the mean reflectance over the hemisphere below.
    pub fn mean_reflectance_below(&self) -> f64 {
        self.mean_reflectance_below
    }

    /// T(θ) of the layer alone, total, from above.
    pub fn transmittance(&self, at: &PolarAngle) -> f64 {
        self.slab(at).1 + self.interpolate(at, &self.layer.transmittance)
    }

    /// R(θ) of the layer alone, total, from above.
    pub fn reflectance(&self, at: &PolarAngle) -> f64 {
        self.slab(at).0 + self.interpolate(at, &self.layer.reflectance)
    }

    /// Specular part of R(θ).
    pub fn specular(&self, at: &PolarAngle) -> f64 {
        self.slab(at).0 + self.interpolate(at, &self.layer.specular)
    }

    /// Diffuse f(i, o), 1/sr, azimuthal mean: layer's own plus paper. Symmetric in i and o.
    pub fn brdf(&self, illumination: &PolarAngle, viewing: &PolarAngle) -> f64 {
        let row = |i: usize| dot(&viewing.shares, self.layer.diffuse_brdf.row(i).iter());
        let own: f64 = illumination.shares.iter().enumerate().map(|(i, s)| s * row(i)).sum();
        own + self.return_factor * self.transmittance(illumination) * self.transmittance(viewing) / PI
    }

    /// Directional–hemispherical albedo R(i) + g T(i) T̄, specular included.
    pub fn albedo(&self, illumination: &PolarAngle) -> f64 {
        let returned = self.return_factor * self.transmittance(illumination) * self.mean_transmittance;
        self.reflectance(illumination) + returned
    }

    /// Radiance at `viewing` under a uniform sky of radiance 1 (white paper: 1).
    pub fn natural_light(&self, viewing: &PolarAngle, sky: MirroredSky) -> f64 {
        let mirrored = match sky {
            MirroredSky::Included => 0.0,
            MirroredSky::Excluded => self.specular(viewing),
        };
        self.albedo(viewing) - mirrored
    }

    /// Upper estimate of the largest error of R and T between the rule's nodes up to 60°: each node is left out in turn
    /// and interpolated from the others; 1.5 times the largest miss.
    ///
    /// The factor is calibrated, not derived: on the model layers of [`angle_rule`](super::angles::angle_rule)'s table
    /// with 4 to 10 angles it puts the estimate above the true error in nine cases of ten (median ratio 9). Layers
    /// unlike those have not been tried. With fewer than three angles nothing can be left out, and the estimate is 1.
    pub fn angle_error(&self, rule: &AngleRule) -> f64 {
        if rule.above.len() < 3 {
            return 1.0;
        }
        let nodes = rule.above.iter().take_while(|n| n.polar_deg < 70.0).count();
        // few nodes: normal incidence, extrapolated from the others, must join
        let first = if rule.above.len() < 5 { 0 } else { 1 };
        let miss = |values: &[f64], k: usize| {
            let shares = rule.shares_without(k, self.layer.baseline.is_some());
            (values[k] - dot(&shares, values)).abs()
        };
        let of = |k| miss(&self.layer.transmittance, k).max(miss(&self.layer.reflectance, k));
        ANGLE_ERROR_SAFETY * (first..nodes).map(of).fold(0.0, f64::max)
    }

    fn slab(&self, at: &PolarAngle) -> (f64, f64) {
        let of = |s: &Slab| s.reflectance_transmittance(Side::Incident, at.polar_deg, self.index_below);
        self.layer.baseline.as_ref().map_or((0.0, 0.0), of)
    }

    fn interpolate(&self, at: &PolarAngle, values: &[f64]) -> f64 {
        let shares = if self.layer.baseline.is_some() { &at.shares_of_difference } else { &at.shares };
        dot(shares, values)
    }
}

/// Leaves the layer's differences from its baseline; returns the slab's own \[T̄, R̄_b\] (zero without one).
fn subtract_baseline(rule: &AngleRule, layer: &mut LayerOptics) -> Result<[f64; 2], PaperError> {
    let Some(slab) = layer.baseline else {
        return Ok([0.0, 0.0]);
    };
    let own = LayerOptics::homogeneous(rule, slab);
    let subtract = |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(x, y)| *x -= y);
    subtract(&mut layer.reflectance, &own.reflectance);
    subtract(&mut layer.specular, &own.reflectance);
    subtract(&mut layer.transmittance, &own.transmittance);
    subtract(&mut layer.reflectance_below, &own.reflectance_below);
    let fine = AngleRule::new(BASELINE_POINTS, 0.0, rule.coupling)?;
    let slab = LayerOptics::homogeneous(&fine, slab);
    Ok([
        hemispherical_mean(&fine.above, &slab.transmittance),
        hemispherical_mean(&fine.below, &slab.reflectance_below),
    ])
}

fn dot<'a>(shares: &[f64], values: impl IntoIterator<Item = &'a f64>) -> f64 {
    shares.iter().zip(values).map(|(s, v)| s * v).sum()
}

#[cfg(test)]
#[path = "paper_tests.rs"]
mod tests;
