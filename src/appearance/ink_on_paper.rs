//! The ink on its paper over all wavelengths and realisations: spectra, colours and the picture, with errors.

use super::angles::{AngleRule, PolarAngle};
use super::bdf::{Bdf, BdfError, Lobe};
use super::colour::{Colorimeter, Colour, ColourError};
use super::paper::{Coupling, LayerOnPaper, LayerOptics, MirroredSky, PaperError, Substrate};
use super::picture::InkPicture;
use super::slab::Slab;
use crate::numerics::estimate::{Estimate, jackknife_covariance};
use crate::wave::{FarField, Side};
use ndarray::Array2;
use std::f64::consts::PI;
use thiserror::Error;

/// Far fields solved at other angles than the rule's (degrees): snapping to Fourier directions spoils the weights.
const NODE_SLACK_DEG: f64 = 1e-6;

#[derive(Debug, Error, PartialEq)]
pub enum InkError {
    #[error(transparent)]
    Paper(#[from] PaperError),
    #[error(transparent)]
    Colour(#[from] ColourError),
    #[error(transparent)]
    Bdf(#[from] BdfError),
    #[error(
        "{field}: far field {index} was solved at {value}°, the rule's angle is {expected}°; solve at the rule's angles, without snapping"
    )]
    WrongAngle { field: &'static str, index: usize, value: f64, expected: f64 },
    #[error("{field}: far field {index} was lit from the other side")]
    WrongSide { field: &'static str, index: usize },
    #[error("optical contact needs solves from below (angles inside the medium); give them, or use the gap")]
    BelowNeeded,
    #[error("{field}: {count} entries where {expected} are needed")]
    Count { field: &'static str, count: usize, expected: usize },
}

impl LayerOptics {
    /// One realisation at one wavelength from its solves: `above[k]` at `rule.above[k]`, `below[k]` at `rule.below[k]`.
    ///
    /// Without solves from below (`None`) the layer is taken as the same from both sides: R_b = R, allowed for a gap
    /// only. `bandwidth` (direction cosines, [`suggested_bandwidth`](super::bdf::suggested_bandwidth)) smooths the diffuse
    /// BRDF, which is 0 where the cell is too narrow to scatter. The specular part is the order (0, 0).
    ///
    /// # Errors
    /// Numbers of fields or angles that are not the rule's; a bandwidth too small to reach an order.
    pub fn from_far_fields(
        rule: &AngleRule,
        above: &[FarField],
        below: Option<&[FarField]>,
        baseline: Option<Slab>,
        bandwidth: f64,
    ) -> Result<Self, InkError> {
        check_angles("above", Side::Incident, &rule.above, above)?;
        let reflectance: Vec<f64> = above.iter().map(|f| f.reflectance).collect();
        let reflectance_below = match below {
            Some(fields) => {
                check_angles("below", Side::Exit, &rule.below, fields)?;
                fields.iter().map(|f| f.reflectance).collect()
            }
            None if rule.coupling != Coupling::Gap => return Err(InkError::BelowNeeded),
            None => reflectance.clone(),
        };
        let mut diffuse_brdf = Array2::zeros((above.len(), above.len()));
        for (i, field) in above.iter().enumerate() {
            let bdf = Bdf::from_ensemble(std::slice::from_ref(field))?;
            let viewing = if bdf.scatters(Lobe::Reflected) { rule.above.as_slice() } else { &[] };
            for (o, node) in viewing.iter().enumerate() {
                diffuse_brdf[[i, o]] =
                    bdf.azimuthal_mean(Lobe::Reflected, node.polar_deg, bandwidth)?.bdf.value;
            }
        }
        Ok(Self {
            reflectance,
            specular: above.iter().map(|f| f.specular().reflected_efficiency).collect(),
            transmittance: above.iter().map(|f| f.transmittance).collect(),
            specular_transmittance: above.iter().map(|f| f.specular().transmitted_efficiency).collect(),
            reflectance_below,
            diffuse_brdf,
            baseline,
        })
    }
}

fn check_angles(
    field: &'static str,
    side: Side,
    nodes: &[super::angles::AngleNode],
    fields: &[FarField],
) -> Result<(), InkError> {
    if nodes.len() != fields.len() {
        return Err(InkError::Count { field, count: fields.len(), expected: nodes.len() });
    }
    for (index, (node, far)) in nodes.iter().zip(fields).enumerate() {
        if far.incidence.from != side {
            return Err(InkError::WrongSide { field, index });
        }
        let (value, expected) = (far.incidence.polar_deg, node.polar_deg);
        let apart = (value - expected).abs();
        if apart.is_nan() || apart > NODE_SLACK_DEG {
            return Err(InkError::WrongAngle { field, index, value, expected });
        }
    }
    Ok(())
}

/// A spectrum with the values of every leave-one-out ensemble.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumEstimate {
    pub values: Vec<f64>,
    /// \[realisation left out\]\[wavelength\]; empty for one realisation.
    pub replicates: Vec<Vec<f64>>,
}

impl SpectrumEstimate {
    /// Value and jackknife standard error at each wavelength.
    pub fn estimates(&self) -> Vec<Estimate> {
        let column = |k: usize| self.replicates.iter().map(|r| r[k]).collect::<Vec<_>>();
        self.values.iter().enumerate().map(|(k, &v)| Estimate::jackknife(v, &column(k))).collect()
    }
}

/// The ink on its paper. Every quantity is computed from ensemble means (a print shows many cells at once); the
/// errors are jackknife errors over realisations, so that noise common to wavelengths and angles of one packing
/// counts once.
///
/// ```
/// use super::angles::AngleRule;
/// use super::ink_on_paper::InkOnPaper;
/// use super::paper::{Albedo, Coupling, LayerOptics, MirroredSky, Substrate};
/// use super::slab::Slab;
/// use crate::material::spectra::{Spectrum, molecular_mixture};
///
/// let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
/// let rule = AngleRule::new(4, 60.0, substrate.coupling)?;
/// let yellow = Spectrum::synthetic("yellow")?;
/// let wavelengths_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
/// let mut layers = Vec::new();
/// for nm in &wavelengths_nm {
///     let wavelength_um = nm / 1000.0;
///     let index = molecular_mixture(1.558.into(), &[(0.3, yellow.index(wavelength_um)?)]);
///     layers.push(vec![LayerOptics::homogeneous(&rule, Slab { index, thickness_um: 1.0, wavelength_um })]);
/// }
/// let ink = InkOnPaper::new(rule, &wavelengths_nm, &layers, &substrate)?;
/// let view = ink.rule().at(0.0)?;
/// let colour = ink.colour(|layer| layer.natural_light(&view, MirroredSky::Included))?;
/// assert!(colour.chroma().value > 90.0 && (80.0..110.0).contains(&colour.hue_deg().value));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct InkOnPaper {
    rule: AngleRule,
    wavelengths_nm: Vec<f64>,
    whole: Vec<LayerOnPaper>,
    /// \[realisation left out\]\[wavelength\]
    replicates: Vec<Vec<LayerOnPaper>>,
}

impl InkOnPaper {
    /// `layers[wavelength][realisation]`, the same realisations in the same order at every wavelength.
    ///
    /// # Errors
    /// Empty or ragged `layers`; a rule made for another coupling than the substrate's; what [`LayerOnPaper::new`]
    /// refuses.
    pub fn new(
        rule: AngleRule,
        wavelengths_nm: &[f64],
        layers: &[Vec<LayerOptics>],
        substrate: &Substrate,
    ) -> Result<Self, InkError> {
        let realisations = layers.first().map_or(0, Vec::len);
        check_counts(wavelengths_nm.len(), layers, realisations)?;
        if rule.coupling != substrate.coupling {
            return Err(PaperError::CouplingMismatch.into());
        }
        let rho = wavelengths_nm.iter().map(|&nm| substrate.albedo.at(nm)).collect::<Result<Vec<_>, _>>()?;
        let baselines = layers.iter().map(|s| common_baseline(&rule, s)).collect::<Result<Vec<_>, _>>()?;
        let without = |left_out: Option<usize>| -> Result<Vec<LayerOnPaper>, PaperError> {
            let at = |((samples, &rho), &baseline): ((&Vec<LayerOptics>, &f64), &Option<Slab>)| {
                let kept = samples.iter().enumerate().filter(|(r, _)| Some(*r) != left_out).map(|(_, s)| s);
                let mean = LayerOptics { baseline, ..LayerOptics::mean(kept)? };
                LayerOnPaper::new(&rule, &mean, rho)
            };
            layers.iter().zip(&rho).zip(&baselines).map(at).collect()
        };
        let left_out = if realisations > 1 { 0..realisations } else { 0..0 };
        let (whole, replicates) =
            (without(None)?, left_out.map(|r| without(Some(r))).collect::<Result<_, _>>()?);
        Ok(Self { wavelengths_nm: wavelengths_nm.to_vec(), whole, replicates, rule })
    }

    pub fn rule(&self) -> &AngleRule {
        &self.rule
    }

    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// The ensemble mean at every wavelength.
    pub fn layers(&self) -> &[LayerOnPaper] {
        &self.whole
    }

    /// What the number of angles may cost at each wavelength: see [`LayerOnPaper::angle_error`].
    pub fn angle_errors(&self) -> Vec<f64> {
        self.whole.iter().map(|layer| layer.angle_error(&self.rule)).collect()
    }

    /// Any quantity of the layer on paper against wavelength:
    /// `ink.spectrum(|layer| layer.natural_light(&view, MirroredSky::Included))`.
    pub fn spectrum(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> SpectrumEstimate {
        let of = |layers: &Vec<LayerOnPaper>| layers.iter().map(&quantity).collect::<Vec<f64>>();
        SpectrumEstimate { values: of(&self.whole), replicates: self.replicates.iter().map(of).collect() }
    }

    /// Any scalar of the whole ink (a mean over wavelengths, a ratio) with its jackknife error.
    pub fn scalar(&self, quantity: impl Fn(&[LayerOnPaper]) -> f64) -> Estimate {
        let replicates: Vec<[f64; 1]> = self.replicates.iter().map(|r| [quantity(r)]).collect();
        let standard_error = jackknife_covariance(&replicates).map(|c| c[0][0].sqrt());
        Estimate { value: quantity(&self.whole), standard_error }
    }

    /// Colour of a quantity that is 1 for a perfect white diffuser, with the covariance of Lab.
    ///
    /// # Errors
    /// A grid of wavelengths that cannot carry a colour.
    pub fn colour(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<Colour, InkError> {
        let spectrum = self.spectrum(quantity);
        let meter = Colorimeter::new(&self.wavelengths_nm)?;
        Ok(meter.colour_with_error(&spectrum.values, &spectrum.replicates)?)
    }

    /// The picture of P1 Fig. 6 at the given angles (0–60° there), rows viewing, columns illumination.
    ///
    /// The strip is natural light, with or without the mirrored sky; the square is π f(i, o), diffuse, averaged over
    /// the azimuth between the two planes (P1 leaves both open).
    ///
    /// # Errors
    /// Angles outside the rule, or a grid of wavelengths that cannot carry a colour.
    pub fn picture(&self, angles_deg: &[f64], sky: MirroredSky) -> Result<InkPicture, InkError> {
        let meter = Colorimeter::new(&self.wavelengths_nm)?;
        let angles = angles_deg.iter().map(|&a| self.rule.at(a)).collect::<Result<Vec<PolarAngle>, _>>()?;
        let colour = |f: &dyn Fn(&LayerOnPaper) -> f64| {
            let values: Vec<f64> = self.whole.iter().map(f).collect();
            meter.colour(&values)
        };
        let strip =
            angles.iter().map(|o| colour(&|l| l.natural_light(o, sky))).collect::<Result<Vec<_>, _>>()?;
        let cells = angles.iter().flat_map(|o| angles.iter().map(move |i| (o, i)));
        let square = cells.map(|(o, i)| colour(&|l| PI * l.brdf(i, o))).collect::<Result<Vec<_>, _>>()?;
        let square =
            Array2::from_shape_fn((angles.len(), angles.len()), |(o, i)| square[o * angles.len() + i]);
        Ok(InkPicture { angles_deg: angles_deg.to_vec(), strip, square })
    }
}

/// The baseline of the first realisation, fitted to the ensemble's specular R and T; replicates share it.
fn common_baseline(rule: &AngleRule, samples: &[LayerOptics]) -> Result<Option<Slab>, PaperError> {
    let mut mean = LayerOptics::mean(samples.iter())?;
    mean.check(rule)?;
    mean.fit_baseline(rule);
    Ok(mean.baseline)
}

fn check_counts(
    wavelengths: usize,
    layers: &[Vec<LayerOptics>],
    realisations: usize,
) -> Result<(), InkError> {
    if layers.len() != wavelengths {
        return Err(InkError::Count { field: "layers", count: layers.len(), expected: wavelengths });
    }
    if realisations == 0 {
        return Err(PaperError::NoRealisations.into());
    }
    match layers.iter().find(|l| l.len() != realisations) {
        Some(l) => Err(InkError::Count { field: "realisations", count: l.len(), expected: realisations }),
        None => Ok(()),
    }
}

#[cfg(test)]
#[path = "ink_on_paper_tests.rs"]
pub(crate) mod tests;
