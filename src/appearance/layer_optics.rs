//! What the solves say about a layer at one wavelength, at the angles of a rule.

use super::angles::AngleRule;
use super::paper::PaperError;
use super::slab::Slab;
use crate::numerics::estimate::mean_of;
use crate::wave::Side;
use ndarray::Array2;

/// Largest excess over 1 that a total may have: solver residual, not physics.
const ENERGY_SLACK: f64 = 1e-2;

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
        let (r, t) = rule.above.iter().map(|n| at(Side::Incident, n.polar_deg)).unzip();
        let below = rule.below.iter().map(|n| at(Side::Exit, n.polar_deg).0).collect();
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
