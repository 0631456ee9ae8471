//! What an ink maker asks: hiding power, Kubelka–Munk coefficients, colours under her own light, the difference to her own
//! measurement or to a target. All from the stored solves, with jackknife errors.

use super::ink::{InkError, InkOnPaper};
use super::on_paper::{LayerOnPaper, PolarAngle};
use crate::appearance::colour::{Colorimeter, Colour};
use crate::appearance::kubelka_munk::KubelkaMunk;
use crate::appearance::paper::{Coupling, PRINT_DEG};
use crate::input::measured::MeasuredSpectrum;
use crate::input::study::{Judgement, Study};
use crate::numerics::estimate::Estimate;
use serde::Serialize;
use std::f64::consts::PI;

/// Albedo of the black backing of a draw-down card.
pub const BLACK: f64 = 0.0;
/// Albedo of its white one (ISO 6504-3: Y of 80).
pub const WHITE: f64 = 0.8;

/// All that an ink maker asks; colours at 45:0 under the study's own conditions, summed from its spectra.
#[derive(Clone, Debug, Serialize)]
pub struct InkMaker {
    /// Light, observer and rule of summation.
    pub conditions: String,
    /// The ink on its paper.
    pub print: Swatch,
    /// The ink over black.
    pub over_black: Swatch,
    /// The ink over white.
    pub over_white: Swatch,
    /// Y over black divided by Y over white, 0–1: 1 hides everything (ISO 6504-3).
    pub contrast_ratio: Estimate,
    /// K and S at every wavelength; none in optical contact, where the two sides of the layer differ.
    pub kubelka_munk: Vec<KubelkaMunkRow>,
    /// Difference to the target colour.
    pub target: Option<Target>,
    /// Difference to a measured spectrum.
    pub measured: Option<Comparison>,
}

/// A colour with what a screen shows of it.
#[derive(Clone, Debug, Serialize)]
pub struct Swatch {
    /// `#rrggbb`, adapted to the light.
    pub hex: String,
    /// Standard errors of L*, a*, b*.
    pub lab_standard_error: Option<[f64; 3]>,
    /// The colour.
    #[serde(flatten)]
    pub colour: Colour,
}

/// Kubelka–Munk coefficients at one wavelength.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct KubelkaMunkRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// K, 1/µm.
    pub absorption_per_um: Estimate,
    /// S, 1/µm.
    pub scattering_per_um: Estimate,
}

/// How far the print is from a wanted colour.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Target {
    /// L*, a*, b* wanted.
    pub lab: [f64; 3],
    /// CIEDE2000; its error is that of the prediction.
    pub delta_e_2000: Estimate,
}

/// A measured spectrum beside the prediction.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The file.
    pub source: String,
    /// CIEDE2000 between both spectra on the wavelengths they share; its error is that of the prediction.
    pub delta_e_2000: Option<Estimate>,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// The study's wavelengths inside the measurement.
    pub rows: Vec<ComparedRow>,
}

/// One wavelength of a comparison, reflectance factors at 45:0.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ComparedRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// What was measured.
    pub measured: f64,
    /// What is predicted.
    pub predicted: Estimate,
}

/// Lit at 45°, seen along the normal: π times the BRDF.
struct Geometry {
    light: PolarAngle,
    view: PolarAngle,
}

impl Geometry {
    fn factor(&self, layer: &LayerOnPaper) -> f64 {
        PI * layer.brdf(&self.light, &self.view)
    }
}

/// Everything at once.
///
/// # Errors
/// Wavelengths that cannot carry a colour.
pub fn ink_maker(study: &Study, ink: &InkOnPaper) -> Result<InkMaker, InkError> {
    let Judgement { viewing, target_lab, measured } = &study.judgement;
    let geometry = Geometry { light: ink.at(PRINT_DEG)?, view: ink.at(0.0)? };
    let meter = Colorimeter::under(ink.wavelengths_nm(), viewing)?;
    let over = |albedo: f64| swatch(ink, &meter, &|layer| geometry.factor(&layer.over(albedo)));
    let luminance = |layers: &[LayerOnPaper], albedo: f64| {
        let values: Vec<f64> = layers.iter().map(|layer| geometry.factor(&layer.over(albedo))).collect();
        // as many values as wavelengths; a value that is no number stays one
        meter.xyz(&values).map_or(f64::NAN, |xyz| xyz[1])
    };
    let print = swatch(ink, &meter, &|layer| geometry.factor(layer))?;
    Ok(InkMaker {
        conditions: viewing.name(),
        over_black: over(BLACK)?,
        over_white: over(WHITE)?,
        contrast_ratio: ink.scalar(|layers| luminance(layers, BLACK) / luminance(layers, WHITE)),
        kubelka_munk: match study.paper.coupling {
            Coupling::Gap => kubelka_munk(ink, study.layer.thickness_um),
            Coupling::OpticalContact { .. } => Vec::new(),
        },
        target: target_lab.map(|lab| Target { lab, delta_e_2000: distance(&print.colour, lab) }),
        measured: measured.as_ref().map(|m| compare(ink, &geometry, study, m)),
        print,
    })
}

fn swatch(
    ink: &InkOnPaper,
    meter: &Colorimeter,
    of: &dyn Fn(&LayerOnPaper) -> f64,
) -> Result<Swatch, InkError> {
    let spectrum = ink.spectrum(of);
    let colour = meter.colour_with_error(&spectrum.values, &spectrum.replicates)?;
    let [r, g, b] = colour.srgb8;
    let hex = format!("#{r:02x}{g:02x}{b:02x}");
    Ok(Swatch { hex, lab_standard_error: colour.lab_standard_error(), colour })
}

/// K and S from the diffuse fluxes that the paper exchanges with the layer: R̄ and T̄ of the layer alone.
fn kubelka_munk(ink: &InkOnPaper, thickness_um: f64) -> Vec<KubelkaMunkRow> {
    let of = |layer: &LayerOnPaper| {
        KubelkaMunk::from_layer(layer.mean_reflectance_exit(), layer.mean_transmittance(), thickness_um)
    };
    let part =
        |get: fn(KubelkaMunk) -> f64| ink.spectrum(|layer| of(layer).map_or(f64::NAN, get)).estimates();
    let (k, s) = (part(|km| km.absorption_per_um), part(|km| km.scattering_per_um));
    let rows = ink.wavelengths_nm().iter().zip(k.into_iter().zip(s));
    let row = |(&wavelength_nm, (absorption_per_um, scattering_per_um)): (&f64, (Estimate, Estimate))| {
        KubelkaMunkRow { wavelength_nm, absorption_per_um, scattering_per_um }
    };
    rows.map(row).filter(|row| row.absorption_per_um.value.is_finite()).collect()
}

/// ΔE₀₀ to a colour that is exact.
fn distance(colour: &Colour, lab: [f64; 3]) -> Estimate {
    colour.delta_e_2000(&Colour { lab, lab_covariance: Some([[0.0; 3]; 3]), ..*colour })
}

fn compare(ink: &InkOnPaper, geometry: &Geometry, study: &Study, measured: &MeasuredSpectrum) -> Comparison {
    let predicted = ink.spectrum(|layer| geometry.factor(layer));
    let (estimates, nm) = (predicted.estimates(), ink.wavelengths_nm());
    let shared: Vec<usize> = (0..nm.len()).filter(|&i| measured.at(nm[i]).is_some()).collect();
    let row = |&i: &usize| {
        let (wavelength_nm, predicted) = (nm[i], estimates[i]);
        Some(ComparedRow { wavelength_nm, measured: measured.at(wavelength_nm)?, predicted })
    };
    let rows: Vec<ComparedRow> = shared.iter().filter_map(row).collect();
    let square: f64 = rows.iter().map(|r| (r.measured - r.predicted.value).powi(2)).sum();
    let pick = |values: &[f64]| shared.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    let difference = || -> Result<Estimate, InkError> {
        let meter = Colorimeter::under(&pick(nm), &study.judgement.viewing)?;
        let replicates: Vec<Vec<f64>> = predicted.replicates.iter().map(|r| pick(r)).collect();
        let here = meter.colour_with_error(&pick(&predicted.values), &replicates)?;
        let there = meter.colour(&rows.iter().map(|r| r.measured).collect::<Vec<_>>())?;
        Ok(distance(&here, there.lab))
    };
    Comparison {
        source: measured.source.clone(),
        // too few shared wavelengths carry no colour; the residuals stand all the same
        delta_e_2000: difference().ok(),
        rms: (square / rows.len().max(1) as f64).sqrt(),
        rows,
    }
}
