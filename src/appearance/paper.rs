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
use super::estimate::mean_of;
use super::slab::Slab;
use crate::wave::Side;
use ndarray::Array2;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use thiserror::Error;

/// Largest excess over 1 that a total may have: solver residual, not physics.
const ENERGY_SLACK: f64 = 1e-2;

/// Angles for the hemispherical means of the baseline: rounding for layers of a few wavelengths.
const BASELINE_POINTS: usize = 48;

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

/// What is between the layer and the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coupling {
    /// A thin gap of vacuum, wide enough to be incoherent (P1).
    #[default]
    Gap,
    /// The paper's scatterers sit in a medium of this index that touches the layer.
    OpticalContact { index: f64 },
}

impl Coupling {
    /// Index of the half-space below that the solves must have.
    pub fn index_below(self) -> f64 {
        match self {
            Self::Gap => 1.0,
            Self::OpticalContact { index } => index,
        }
    }
}

/// Albedo ρ of the paper, 0–1: the same at every wavelength, or (wavelength_nm, ρ) rows, linear in between.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Albedo {
    Constant(f64),
    Spectral(Vec<[f64; 2]>),
}

impl Albedo {
    /// ρ(λ).
    ///
    /// # Errors
    /// Values outside 0–1, tables that do not increase, wavelengths outside the table.
    pub fn at(&self, wavelength_nm: f64) -> Result<f64, PaperError> {
        let value = match self {
            Self::Constant(value) => *value,
            Self::Spectral(rows) => interpolate(rows, wavelength_nm)?,
        };
        if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(PaperError::Albedo { value }) }
    }
}

fn interpolate(rows: &[[f64; 2]], nm: f64) -> Result<f64, PaperError> {
    let unordered = rows.windows(2).find(|w| !(w[1][0] > w[0][0]));
    if rows.len() < 2 || unordered.is_some() {
        return Err(PaperError::AlbedoTable { value: unordered.map_or(nm, |w| w[1][0]) });
    }
    let (lo, hi) = (rows[0][0], rows[rows.len() - 1][0]);
    if !(lo..=hi).contains(&nm) {
        return Err(PaperError::AlbedoRange { value: nm, lo, hi });
    }
    let after = rows.partition_point(|r| r[0] < nm).clamp(1, rows.len() - 1);
    let ([x0, y0], [x1, y1]) = (rows[after - 1], rows[after]);
    Ok(y0 + (nm - x0) / (x1 - x0) * (y1 - y0))
}

/// The paper under the layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Substrate {
    pub albedo: Albedo,
    #[serde(default)]
    pub coupling: Coupling,
}

/// What the solves say about the layer at one wavelength, at the angles of an [`AngleRule`].
///
/// One realisation, or a mean over several ([`LayerOptics::mean`]).
#[derive(Clone, Debug, PartialEq)]
pub struct LayerOptics {
    /// Total R from above at `rule.above`.
    pub reflectance: Vec<f64>,
    /// The part of R in the specular order, at `rule.above`.
    pub specular: Vec<f64>,
    /// Total T from above at `rule.above`.
    pub transmittance: Vec<f64>,
    /// The part of T in the specular order, at `rule.above`.
    pub specular_transmittance: Vec<f64>,
    /// Total R_b from below at `rule.below`.
    pub reflectance_below: Vec<f64>,
    /// Diffuse BRDF of the layer alone, azimuthal mean, 1/sr: \[illumination node, viewing node\] of `rule.above`.
    pub diffuse_brdf: Array2<f64>,
    /// A homogeneous slab like the layer, if there is one.
    pub baseline: Option<Slab>,
}

impl LayerOptics {
    /// A layer that does not scatter.
    pub fn specular_only(
        reflectance: Vec<f64>,
        transmittance: Vec<f64>,
        reflectance_below: Vec<f64>,
    ) -> Self {
        let diffuse_brdf = Array2::zeros((reflectance.len(), reflectance.len()));
        let (specular, specular_transmittance) = (reflectance.clone(), transmittance.clone());
        Self {
            reflectance,
            specular,
            transmittance,
            specular_transmittance,
            reflectance_below,
            diffuse_brdf,
            baseline: None,
        }
    }

    /// A homogeneous layer (the molecular mixture, or the clear binder): no solve needed, its own baseline.
    pub fn homogeneous(rule: &AngleRule, slab: Slab) -> Self {
        let index = rule.coupling.index_below();
        let at = |side, deg| slab.reflectance_transmittance(side, deg, index);
        let (r, t) = rule.above.iter().map(|n| at(Side::Above, n.polar_deg)).unzip();
        let below = rule.below.iter().map(|n| at(Side::Below, n.polar_deg).0).collect();
        Self { baseline: Some(slab), ..Self::specular_only(r, t, below) }
    }

    /// Mean over realisations.
    ///
    /// # Errors
    /// No samples, or samples on different rules.
    pub fn mean<'a>(samples: impl Iterator<Item = &'a Self> + Clone) -> Result<Self, PaperError> {
        let first = samples.clone().next().ok_or(PaperError::NoRealisations)?;
        let count = samples.clone().count() as f64;
        let mut diffuse_brdf = Array2::zeros(first.diffuse_brdf.raw_dim());
        for sample in samples.clone() {
            sample.check_lengths(first.reflectance.len(), first.reflectance_below.len())?;
            diffuse_brdf.scaled_add(1.0 / count, &sample.diffuse_brdf);
        }
        Ok(Self {
            reflectance: mean_of(samples.clone().map(|s| s.reflectance.as_slice())),
            specular: mean_of(samples.clone().map(|s| s.specular.as_slice())),
            transmittance: mean_of(samples.clone().map(|s| s.transmittance.as_slice())),
            specular_transmittance: mean_of(samples.clone().map(|s| s.specular_transmittance.as_slice())),
            reflectance_below: mean_of(samples.map(|s| s.reflectance_below.as_slice())),
            diffuse_brdf,
            baseline: first.baseline,
        })
    }

    fn check_lengths(&self, above: usize, below: usize) -> Result<(), PaperError> {
        let columns = [
            ("reflectance", self.reflectance.len(), above),
            ("specular", self.specular.len(), above),
            ("transmittance", self.transmittance.len(), above),
            ("specular_transmittance", self.specular_transmittance.len(), above),
            ("reflectance_below", self.reflectance_below.len(), below),
            ("diffuse_brdf rows", self.diffuse_brdf.nrows(), above),
            ("diffuse_brdf columns", self.diffuse_brdf.ncols(), above),
        ];
        match columns.into_iter().find(|(_, count, expected)| count != expected) {
            Some((field, count, expected)) => Err(PaperError::WrongLength { field, count, expected }),
            None => Ok(()),
        }
    }

    pub(super) fn check(&self, rule: &AngleRule) -> Result<(), PaperError> {
        self.check_lengths(rule.above.len(), rule.below.len())?;
        check_range("reflectance", &self.reflectance, 1.0 + ENERGY_SLACK)?;
        check_range("specular", &self.specular, 1.0 + ENERGY_SLACK)?;
        check_range("transmittance", &self.transmittance, 1.0 + ENERGY_SLACK)?;
        check_range("specular_transmittance", &self.specular_transmittance, 1.0 + ENERGY_SLACK)?;
        check_range("reflectance_below", &self.reflectance_below, 1.0 + ENERGY_SLACK)?;
        let brdf: Vec<f64> = self.diffuse_brdf.iter().copied().collect();
        check_range("diffuse_brdf", &brdf, f64::MAX)
    }
}

fn check_range(field: &'static str, values: &[f64], hi: f64) -> Result<(), PaperError> {
    let lo = -ENERGY_SLACK;
    match values.iter().position(|v| !(lo..=hi).contains(v)) {
        Some(index) => Err(PaperError::BadValue { field, index, value: values[index], lo, hi }),
        None => Ok(()),
    }
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

    fn slab(&self, at: &PolarAngle) -> (f64, f64) {
        let of = |s: &Slab| s.reflectance_transmittance(Side::Above, at.polar_deg, self.index_below);
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
