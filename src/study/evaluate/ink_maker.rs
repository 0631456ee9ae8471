//! Numbers for ink makers: hiding power, Kubelka–Munk coefficients, colours under a chosen
//! illuminant, the difference to a measurement or to a target. All are derived from the stored
//! solves; errors include randomness, the grid and the solver's residual.

pub mod bare;
mod coefficients;

pub use coefficients::KubelkaMunkRow;

use super::ink::{InkError, InkOnPaper, Sight, emitted_parts};
use super::on_paper::LayerOnPaper;
use super::prints::Brightened;
use super::uncertainty::{Conditions, Shift, UNMOVED, Uncertainty, Widened};
use crate::appearance::colour::Colour;
use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::tristimulus::visible;
use crate::appearance::viewing::{ColourError, Viewing};
use crate::input::measured::MeasuredSpectrum;
use crate::input::study::{Judgement, Study};
use crate::numerics::estimate::{Estimate, jackknife_deviations};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

/// Albedo of the black backing of a draw-down card.
pub const BLACK: f64 = 0.0;
/// Albedo of its white backing (ISO 6504-3: Y of 80).
pub const WHITE: f64 = 0.8;

/// All numbers for ink makers; colours at 45:0 under the study's own conditions, summed from its
/// spectra.
#[derive(Clone, Debug, Serialize)]
pub struct InkMaker {
    /// Illuminant, observer and summation rule.
    pub conditions: String,
    /// The ink on its paper.
    pub print: Swatch,
    /// The ink on its paper under natural light instead of at 45:0; `colours` gives it under D65.
    #[serde(skip)]
    pub natural_light: Swatch,
    /// The ink over black.
    pub over_black: Swatch,
    /// The ink over white.
    pub over_white: Swatch,
    /// Contrast ratio: Y over black divided by Y over white, 0–1, where 1 hides everything (ISO
    /// 6504-3).
    pub contrast_ratio: Estimate,
    /// Number of each realisation and its contribution to the contrast ratio.
    #[serde(skip)]
    pub contrast_deviations: Vec<(usize, f64)>,
    /// K and S of the layer without its faces (Saunderson's correction), at the wavelengths at
    /// which its light is diffuse.
    pub kubelka_munk: Vec<KubelkaMunkRow>,
    /// Why there are no K and S.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_kubelka_munk: Option<String>,
    /// Difference to the target colour.
    pub target: Option<Target>,
    /// Difference to a measured spectrum.
    pub measured: Option<MeasuredComparison>,
}

/// A colour and its appearance on a screen.
#[derive(Clone, Debug, Serialize)]
pub struct Swatch {
    /// `#rrggbb`, adapted to the illuminant.
    pub hex: String,
    /// Standard errors of L*, a*, b*.
    pub lab_standard_error: Option<[f64; 3]>,
    /// Contribution of each realisation to L*, a*, b*.
    #[serde(skip)]
    pub deviations: Vec<[f64; 3]>,
    /// The colour.
    #[serde(flatten)]
    pub colour: Colour,
}

/// The difference of the print to a target colour.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Target {
    /// Target L*, a*, b*.
    pub lab: [f64; 3],
    /// CIEDE2000; its error is that of the prediction.
    pub delta_e_2000: Estimate,
    /// Number of each realisation and its contribution to the difference.
    #[serde(skip)]
    pub deviations: Vec<(usize, f64)>,
}

/// A measured spectrum compared with the prediction.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredComparison {
    /// Name of the file.
    pub source: String,
    /// CIEDE2000 between both spectra over their common range, each summed over its own
    /// wavelengths; its error is that of the prediction.
    pub delta_e_2000: Option<Estimate>,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// The study's wavelengths within the measured range.
    pub rows: Vec<ComparedRow>,
}

/// One wavelength of a comparison of reflectance factors at 45:0.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ComparedRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Measured value.
    pub measured: f64,
    /// Predicted value.
    pub predicted: Estimate,
}

/// Reflectance factor lit at 45° and viewed along the normal: π times the BRDF, over the paper or
/// another backing.
struct Question<'a> {
    ink: &'a InkOnPaper,
    uncertainty: &'a Uncertainty,
    seen: Conditions,
    viewing: &'a Viewing,
    sight: Sight,
}

impl Question<'_> {
    /// The reflectance factor, shifted by errors of R and T.
    fn factor(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        self.seen.lit_at_45(layer, by)
    }

    /// The ink over a backing.
    fn over(&self, backing: impl Fn(&LayerOnPaper) -> LayerOnPaper) -> Result<Swatch, InkError> {
        self.swatch(&|layer, by| self.factor(&backing(layer), by))
    }

    /// Lab with all uncertainty (randomness, grid and residual), and the contribution of each
    /// realisation.
    fn swatch(&self, moved: &dyn Fn(&LayerOnPaper, Shift) -> f64) -> Result<Swatch, InkError> {
        let Widened { colour, deviations, .. } = self.uncertainty.widened(self.ink, &self.sight, moved)?;
        let [r, g, b] = colour.srgb8;
        let hex = format!("#{r:02x}{g:02x}{b:02x}");
        let lab_standard_error = colour.lab_standard_error();
        Ok(Swatch { hex, lab_standard_error, deviations, colour })
    }

    /// Y over black relative to Y over white, shifted by errors.
    fn luminance_ratio(&self, by: &dyn Fn(&LayerOnPaper) -> Shift) -> Result<f64, InkError> {
        let over = |albedo| move |layer: &LayerOnPaper| self.factor(&layer.over(albedo), by(layer));
        let black = self.ink.colour_of_mean(&self.sight, over(BLACK))?;
        let white = self.ink.colour_of_mean(&self.sight, over(WHITE))?;
        Ok(black.xyz[1] / white.xyz[1])
    }

    /// Contrast ratio, and the contribution of each realisation.
    fn contrast_ratio(&self) -> Result<(Estimate, Vec<f64>), InkError> {
        let sight = &self.sight;
        let over = |albedo: f64| move |layer: &LayerOnPaper| self.factor(&layer.over(albedo), UNMOVED);
        let black = self.ink.replicates_of(sight, over(BLACK))?;
        let white = self.ink.replicates_of(sight, over(WHITE))?;
        let replicates: Vec<f64> = black.iter().zip(&white).map(|(b, w)| b.xyz[1] / w.xyz[1]).collect();
        let estimate = Estimate::jackknife(self.luminance_ratio(&|_| UNMOVED)?, &replicates);
        let moved = self.uncertainty.moved(self.ink, |by| self.luminance_ratio(by))?;
        let beyond = |albedo| {
            let outside = sight.meter.beyond_luminance(&self.ink.values(sight, &over(albedo)));
            outside.hypot(self.ink.spacing_luminance(sight, &over(albedo)))
        };
        let white = self.ink.colour_of_mean(sight, over(WHITE))?.xyz[1];
        let beyond = beyond(BLACK).hypot(estimate.value * beyond(WHITE)) / white;
        let shared = moved.iter().fold(beyond, |sum: f64, ratio| sum.hypot(ratio - estimate.value));
        let shared = shared.hypot(self.input_error_of_contrast(estimate.value, white)?);
        let single: Vec<[f64; 1]> = replicates.iter().map(|&ratio| [ratio]).collect();
        let deviations = jackknife_deviations(&single).into_iter().map(|[by]| by).collect();
        Ok((self.uncertainty.widen(estimate, shared), deviations))
    }

    /// Standard error of a contrast ratio due to the errors of tables of indices; `white` is Y over
    /// white.
    fn input_error_of_contrast(&self, ratio: f64, white: f64) -> Result<f64, InkError> {
        let over = |albedo: f64| move |layer: &LayerOnPaper| self.factor(&layer.over(albedo), UNMOVED);
        let black_moves = self.ink.input_luminances(&self.sight, &over(BLACK))?;
        let white_moves = self.ink.input_luminances(&self.sight, &over(WHITE))?;
        let moves = black_moves.into_iter().zip(white_moves);
        let moved = moves.map(|(on_black, on_white)| (ratio * white + on_black) / (white + on_white) - ratio);
        Ok(moved.fold(0.0, |sum: f64, change| sum.hypot(FRAC_1_SQRT_2 * change)))
    }

    /// Compares a measured spectrum with the prediction.
    fn compare(&self, measured: &MeasuredSpectrum) -> MeasuredComparison {
        let predicted = self.ink.spectrum(|layer| self.factor(layer, UNMOVED));
        let predicted = predicted.estimates().into_iter().enumerate();
        let rows: Vec<ComparedRow> =
            predicted.filter_map(|(i, by_chance)| self.compared(measured, i, by_chance)).collect();
        let square: f64 = rows.iter().map(|r| (r.measured - r.predicted.value).powi(2)).sum();
        MeasuredComparison {
            source: measured.source.clone(),
            // with too few common wavelengths there is no colour, but there are residuals
            delta_e_2000: self.difference(measured).ok(),
            rms: (square / rows.len().max(1) as f64).sqrt(),
            rows,
        }
    }

    /// The `i`-th wavelength of the spectra, if it is within the measured range; the prediction
    /// includes its shared errors.
    fn compared(&self, measured: &MeasuredSpectrum, i: usize, by_chance: Estimate) -> Option<ComparedRow> {
        let layer = &self.ink.layers()[i];
        let wavelength_nm = self.ink.wavelengths_nm()[i];
        let moved = |by: Shift| self.factor(layer, by) - self.factor(layer, UNMOVED);
        let inputs = self.ink.input_error(i, |layer| self.factor(layer, UNMOVED));
        let predicted = self.uncertainty.widen_by(by_chance, wavelength_nm, inputs, moved);
        Some(ComparedRow { wavelength_nm, measured: measured.at(wavelength_nm)?, predicted })
    }

    /// ΔE₀₀ over the range of wavelengths common to prediction and measurement.
    /// Every spectrum is summed over its own wavelengths.
    fn difference(&self, measured: &MeasuredSpectrum) -> Result<Estimate, InkError> {
        let nm = self.ink.wavelengths_nm();
        let common: Vec<usize> = visible(nm).filter(|&i| measured.at(nm[i]).is_some()).collect();
        let pick = |values: &[f64]| common.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        let meter = Colorimeter::under(&pick(nm), self.viewing)?;
        let first_nm = nm[common[0]];
        let last_nm = nm[common[common.len() - 1]];
        let there = measured.colour(self.viewing, [first_nm, last_nm])?;
        let predicted = self.ink.spectrum(|layer| self.factor(layer, UNMOVED));
        let replicates: Vec<Vec<f64>> = predicted.replicates.iter().map(|r| pick(r)).collect();
        let here = meter.colour_with_error(&pick(&predicted.values), &replicates)?;
        let moved = |by: &dyn Fn(&LayerOnPaper) -> Shift| -> Vec<f64> {
            self.ink.layers().iter().map(|layer| self.factor(layer, by(layer))).collect()
        };
        let labs = self.uncertainty.moved(self.ink, |by| Ok(meter.colour(&pick(&moved(by)))?.lab))?;
        let from_here = |lab: &[f64; 3]| std::array::from_fn(|i| lab[i] - here.lab[i]);
        let mut shared: Vec<[f64; 3]> = labs.iter().map(from_here).collect();
        shared.extend(meter.beyond(&pick(&predicted.values), here.xyz));
        let all = 0..nm.len();
        for change in self.ink.input_changes(all, |layer| self.factor(layer, UNMOVED)) {
            let moved: Vec<f64> =
                predicted.values.iter().zip(&change).map(|(value, by)| value + by).collect();
            let there = meter.colour(&pick(&moved))?.lab;
            shared.push(std::array::from_fn(|i| FRAC_1_SQRT_2 * (there[i] - here.lab[i])));
        }
        let lab_covariance = self.uncertainty.widen_lab(here.lab_covariance, &shared);
        let lab = self.lab_of_emission(&meter, &common)?.unwrap_or(here.lab);
        Ok(distance(&Colour { lab, lab_covariance, ..here }, there.lab))
    }

    /// Lab of the prediction at wavelengths of the spectra without a gap, where the paper emits
    /// light under a lamp with lines, which is no part of factors.
    fn lab_of_emission(&self, meter: &Colorimeter, common: &[usize]) -> Result<Option<[f64; 3]>, InkError> {
        let (Some(&first), Some(&last)) = (common.first(), common.last()) else { return Ok(None) };
        let Some(weights) = self.ink.emission(meter, &(first..last + 1)) else { return Ok(None) };
        let factor = |layer: &LayerOnPaper| self.factor(layer, UNMOVED);
        let layers = &self.ink.layers()[first..=last];
        let emitted = emitted_parts(layers, &factor);
        let dark: Vec<f64> = layers.iter().zip(&emitted).map(|(layer, part)| factor(layer) - part).collect();
        let (dark, emitted) = (meter.xyz(&dark)?, weights.xyz(&emitted));
        Ok(Some(meter.colour_of(std::array::from_fn(|c| dark[c] + emitted[c])).lab))
    }
}

/// The paper of a study under the light of its instrument, or under its illuminant; `None` if it
/// does not fluoresce.
///
/// # Errors
/// An illuminant that is not known.
pub(super) fn in_light_of(study: &Study) -> Result<Option<Brightened>, ColourError> {
    let Judgement { viewing, condition, .. } = &study.judgement;
    Brightened::under(&study.paper, &study.wavelengths_nm, *condition, viewing)
}

/// Whether the light of a study is D65, as that of all numbers that name no other.
pub(super) fn is_in_daylight(study: &Study) -> bool {
    let Judgement { viewing, condition, .. } = &study.judgement;
    condition.is_none() && viewing.illuminant() == Viewing::default().illuminant()
}

/// The ink on its paper under the study's own light, where that is not D65 and the paper, which
/// fluoresces, shows other factors under it; `None` elsewhere.
///
/// # Errors
/// As [`InkOnPaper::new`].
pub fn in_own_light(study: &Study, ink: &InkOnPaper) -> Result<Option<InkOnPaper>, InkError> {
    let lit = in_light_of(study)?.filter(|_| !is_in_daylight(study));
    Ok(lit.map(|brightened| ink.clone().lit_by(&brightened)).transpose()?)
}

/// All numbers for ink makers.
///
/// # Errors
/// The wavelengths do not suffice for a colour.
pub(super) fn ink_maker(
    study: &Study,
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
    realisations: &[usize],
) -> Result<InkMaker, InkError> {
    let Judgement { viewing, target_lab, measured, condition } = &study.judgement;
    let relit = in_own_light(study, ink)?;
    let ink = relit.as_ref().unwrap_or(ink);
    let seen = Conditions::new(ink, study.output.mirrored_sky)?;
    let question = Question { ink, uncertainty, seen, viewing, sight: ink.sight(viewing)? };
    let print = question.over(|layer| *layer)?;
    let by = realisations.iter().copied().zip(print.deviations.iter().copied()).collect::<Vec<_>>();
    let (contrast_ratio, moved) = question.contrast_ratio()?;
    let (kubelka_munk, no_kubelka_munk) = coefficients::kubelka_munk(ink, uncertainty, study)?;
    Ok(InkMaker {
        conditions: condition
            .map_or(viewing.name(), |condition| format!("{}, {}", viewing.name(), condition.name())),
        natural_light: question.swatch(&|layer, by| question.seen.natural_light(layer, by))?,
        over_black: question.over(|layer| layer.over(BLACK))?,
        over_white: question.over(|layer| layer.over(WHITE))?,
        contrast_ratio,
        contrast_deviations: realisations.iter().copied().zip(moved).collect(),
        kubelka_munk,
        no_kubelka_munk,
        target: target_lab.map(|lab| target(&print.colour, &by, lab)),
        measured: measured.as_ref().map(|m| question.compare(m)),
        print,
    })
}

/// The difference to the target colour, and the contributions of the realisations: their
/// contributions to Lab along its gradient.
fn target(print: &Colour, by: &[(usize, [f64; 3])], lab: [f64; 3]) -> Target {
    let [gradient, _] = print.delta_e_2000_gradients(&exact(print, lab));
    let moved = |&(r, by): &(usize, [f64; 3])| (r, (0..3).map(|i| gradient[i] * by[i]).sum());
    Target { lab, delta_e_2000: distance(print, lab), deviations: by.iter().map(moved).collect() }
}

/// ΔE₀₀ to an exact colour.
pub fn distance(colour: &Colour, lab: [f64; 3]) -> Estimate {
    colour.delta_e_2000(&exact(colour, lab))
}

/// A colour without uncertainty, under the conditions of another.
fn exact(like: &Colour, lab: [f64; 3]) -> Colour {
    Colour { lab, lab_covariance: Some([[0.0; 3]; 3]), ..*like }
}
