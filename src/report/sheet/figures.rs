//! The page's plots, those for ink makers among them.

use crate::draw::DrawResult;
use crate::draw::chart::{Chart, Curve};
use crate::draw::page::Figure;
use crate::evaluate::ink_maker::{ComparedRow, InkMaker, MeasuredComparison};
use crate::evaluate::manifest::{Manifest, SpectrumRow, WholeResults};
use crate::evaluate::seen::Seen;
use crate::evaluate::summary::{LIT_AT_45, NATURAL_LIGHT};
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use std::f64::consts::PI;

/// Wavelengths of the BRDF curves, nm: the nearest ones of the study are shown.
const SHOWN_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// Viewing angles of the BRDF curves.
const BRDF_STEP_DEG: f64 = 5.0;
/// Light of the BRDF curves.
const LIGHT_DEG: f64 = 45.0;

/// All plots that the finished solves allow.
pub(super) fn figures(manifest: &Manifest, rows: &[SpectrumRow], seen: &Seen) -> DrawResult<Vec<Figure>> {
    let study = manifest.study;
    let all =
        [seen_spectra(study, rows), layer_spectra(study, rows), other_angles(study, rows), brdf(study, seen)];
    all.into_iter().flatten().map(|(heading, plot, caption)| Figure::new(heading, &plot, caption)).collect()
}

/// Label of the axis of spectra.
pub(super) const WAVELENGTH: &str = "wavelength, nm";

/// A heading, its plot and its caption; nothing where there is nothing to show.
pub(super) type Drawing = Option<(&'static str, Chart, String)>;

/// A spectrum, broken where a wavelength of the study has no value.
fn spectrum(
    (study, rows): (&Study, &[SpectrumRow]),
    name: &str,
    of: impl Fn(&SpectrumRow) -> Option<Estimate>,
) -> Curve {
    let points = rows.iter().filter_map(|row| Some((row.wavelength_nm, of(row)?)));
    Curve::measured(name, points).asked_at(&study.wavelengths_nm)
}

/// Shares of the light or of a perfect white, unless there is none.
pub(super) fn shares(x_label: &str, y_label: &str, mut curves: Vec<Curve>) -> Option<Chart> {
    curves.retain(Curve::has_points);
    let chart = Chart::linear("", x_label, y_label, curves);
    (!chart.curves.is_empty()).then_some(Chart { y_range: Some([0.0, 1.0]), ..chart })
}

fn seen_spectra(study: &Study, rows: &[SpectrumRow]) -> Drawing {
    let curves = vec![
        spectrum((study, rows), NATURAL_LIGHT, |row| row.natural_light),
        spectrum((study, rows), LIT_AT_45, |row| row.lit_at_45),
    ];
    let caption = format!(
        "Light that the ink on its paper sends to the eye, as a share of that of a perfect white: under {NATURAL_LIGHT} and at \
         {LIT_AT_45} (π × BRDF). Error bars are standard errors: the spread over realisations, and the grid."
    );
    Some(("The ink on its paper", shares(WAVELENGTH, "share of a perfect white", curves)?, caption))
}

fn layer_spectra(study: &Study, rows: &[SpectrumRow]) -> Drawing {
    let angle = rows.first()?.polar_deg;
    let rows = &at_angle(rows, angle);
    let curves = vec![
        spectrum((study, rows), "reflected", |row| Some(row.reflectance)),
        spectrum((study, rows), "reflected, specular", |row| Some(row.specular_reflectance)),
        spectrum((study, rows), "transmitted", |row| Some(row.transmittance)),
        spectrum((study, rows), "transmitted, specular", |row| Some(row.specular_transmittance)),
        spectrum((study, rows), "transmitted, coherent", |row| row.coherent_transmittance),
        spectrum((study, rows), "absorbed", |row| Some(row.absorptance)),
    ];
    let caption = format!(
        "The layer alone, without paper, lit at {angle:.0}°: shares of the light reflected, transmitted and absorbed, \
         which add up to 1 within their errors. “Specular” is the cells' order that goes on as a mirror image or straight \
         through, the diffuse light of its direction included (mean |t|²); “coherent” is that without the diffuse light \
         (|mean t|²), as a print of any size has it. Estimated apart from the whole, they may exceed it within the errors."
    );
    Some(("The layer alone", shares(WAVELENGTH, "share of the light", curves)?, caption))
}

/// Most curves of one kind in the plot of every angle.
const MOST_CURVES: usize = 6;

/// R and T at all angles solved: against wavelength for a few of them, against the angle for many.
fn other_angles(study: &Study, rows: &[SpectrumRow]) -> Drawing {
    let mut angles: Vec<f64> = rows.iter().map(|row| row.polar_deg).collect();
    angles.dedup();
    if angles.len() < 2 {
        return None;
    }
    let caption =
        "The layer alone at every angle solved: shares of the light reflected (R) and transmitted (T).";
    let plot = if angles.len() <= MOST_CURVES {
        let mut curves = Vec::new();
        for deg in angles {
            let here = &at_angle(rows, deg);
            curves.push(spectrum((study, here), &format!("R, {deg:.0}°"), |row| Some(row.reflectance)));
            curves.push(spectrum((study, here), &format!("T, {deg:.0}°"), |row| Some(row.transmittance)));
        }
        shares(WAVELENGTH, "share of the light", curves)?
    } else {
        let solved: Vec<f64> = at_angle(rows, angles[0]).iter().map(|row| row.wavelength_nm).collect();
        let curves = shown_nm(&solved).into_iter().flat_map(|nm| against_angle(study, rows, nm)).collect();
        shares("angle of incidence, °", "share of the light", curves)?
    };
    Some(("Every angle solved", plot, caption.to_owned()))
}

/// R and T at one wavelength against the angle of incidence.
fn against_angle(study: &Study, rows: &[SpectrumRow], nm: f64) -> [Curve; 2] {
    let rows: Vec<&SpectrumRow> = rows.iter().filter(|row| row.wavelength_nm == nm).collect();
    let numbers: [(&str, fn(&SpectrumRow) -> Estimate); 2] =
        [("R", |row| row.reflectance), ("T", |row| row.transmittance)];
    numbers.map(|(name, of)| {
        let points = rows.iter().map(|row| (row.polar_deg, of(row)));
        Curve::measured(format!("{name}, {nm:.0} nm"), points).asked_at(&study.angles.exact_deg)
    })
}

pub(super) fn at_angle(rows: &[SpectrumRow], polar_deg: f64) -> Vec<SpectrumRow> {
    rows.iter().filter(|row| row.polar_deg == polar_deg).cloned().collect()
}

fn brdf(study: &Study, seen: &Seen) -> Drawing {
    let ink = seen.ink.as_ref().ok()?;
    let light = ink.at(LIGHT_DEG.min(study.angles.picture_max_deg)).ok()?;
    let steps = (study.angles.picture_max_deg / BRDF_STEP_DEG).floor() as usize;
    let degrees: Vec<f64> = (0..=steps).map(|i| i as f64 * BRDF_STEP_DEG).collect();
    let views: Vec<_> = degrees.iter().map(|&deg| ink.at(deg)).collect::<Result<_, _>>().ok()?;
    let spectra: Vec<Vec<Estimate>> =
        views.iter().map(|view| ink.spectrum(|layer| PI * layer.brdf(&light, view)).estimates()).collect();
    let mut curves = Vec::new();
    for nm in shown_nm(&study.wavelengths_nm) {
        let w = study.wavelengths_nm.iter().position(|solved| *solved == nm)?;
        let points = degrees.iter().zip(&spectra).map(|(&deg, spectrum)| (deg, spectrum[w]));
        curves.push(Curve::measured(format!("{nm:.0} nm"), points));
    }
    let caption = format!(
        "π × diffuse BRDF of the ink on its paper, lit at {:.0}°, mean over the azimuth, against the viewing angle. A \
         matt white would be 1 everywhere.",
        light.polar_deg
    );
    let plot = Chart { from_zero: true, ..Chart::linear("", "viewing angle, °", "π × BRDF", curves) };
    Some(("How it changes with the viewing angle", plot, caption))
}

/// The study's wavelengths nearest to the shown ones, without repeats.
pub(super) fn shown_nm(wavelengths_nm: &[f64]) -> Vec<f64> {
    let mut all: Vec<f64> = SHOWN_NM.iter().filter_map(|&nm| nearest(wavelengths_nm, nm)).collect();
    all.dedup();
    all
}

fn nearest(wavelengths_nm: &[f64], target: f64) -> Option<f64> {
    wavelengths_nm.iter().copied().min_by(|a, b| (a - target).abs().total_cmp(&(b - target).abs()))
}

/// Plots of K and S, and of a measurement with its residuals.
pub(super) fn of_ink_makers(maker: &InkMaker, whole: &WholeResults) -> DrawResult<Vec<Figure>> {
    let mut figures = Vec::new();
    if !maker.kubelka_munk.is_empty() {
        figures.push(kubelka_munk(maker, whole)?);
    }
    if let Some(measured) = &maker.measured {
        figures.extend(compared(measured)?);
    }
    Ok(figures)
}

fn figure(heading: &str, y_label: &str, curves: Vec<Curve>, caption: String) -> DrawResult<Figure> {
    let plot = Chart { from_zero: true, ..Chart::linear("", "wavelength, nm", y_label, curves) };
    Figure::new(heading, &plot, caption)
}

fn kubelka_munk(maker: &InkMaker, whole: &WholeResults) -> DrawResult<Figure> {
    let certainty = &whole.ensemble.certainty;
    let solved_nm: Vec<f64> = whole.rows.iter().map(|row| row.wavelength_nm).collect();
    let factor = certainty.coverage_factor_95;
    let wider = factor.unwrap_or(1.0);
    let wide = |e: Estimate| Estimate { standard_error: e.standard_error.map(|error| error * wider), ..e };
    let rows = || maker.kubelka_munk.iter();
    let absorption = rows().map(|row| (row.wavelength_nm, wide(row.absorption_per_um)));
    let scattering = rows().map(|row| (row.wavelength_nm, wide(row.scattering_per_um)));
    let series = vec![
        Curve::measured("absorption K", absorption).asked_at(&solved_nm),
        Curve::measured("scattering S", scattering).asked_at(&solved_nm),
    ];
    let bars = match factor {
        Some(factor) => {
            let degrees = certainty.degrees_of_freedom;
            format!("95 % intervals: {factor:.2} standard errors (Student's t, {degrees} degrees of freedom)")
        }
        None => "standard errors".to_owned(),
    };
    let caption = format!(
        "Kubelka–Munk coefficients of the layer without its faces, from its diffuse reflectance and transmittance, at the \
         wavelengths at which hardly any light goes straight through: the reflections at both plane faces are removed \
         (Saunderson 1942). Error bars are {bars}; where that of K, which is never negative, reaches 0, K is compatible with 0."
    );
    figure("Kubelka–Munk coefficients", "1/µm", series, caption)
}

fn compared(measured: &MeasuredComparison) -> DrawResult<Vec<Figure>> {
    let points = |value: &dyn Fn(&ComparedRow) -> Estimate| {
        measured.rows.iter().map(|row| (row.wavelength_nm, value(row))).collect::<Vec<_>>()
    };
    let both = vec![
        Curve::measured("predicted", points(&|row| row.predicted)),
        Curve::measured("measured", points(&|row| Estimate { value: row.measured, standard_error: None })),
    ];
    let residual = points(&|row| Estimate { value: row.measured - row.predicted.value, ..row.predicted });
    let residual = vec![Curve::measured("measured less predicted", residual)];
    let caption = format!("At 45:0; measured: {}, linear between its rows.", measured.source);
    let of_residual = format!("{caption} Error bars are those of the prediction.");
    Ok(vec![
        figure("Measured and predicted", "share of a perfect white", both, caption)?,
        figure("Residual", "measured less predicted", residual, of_residual)?,
    ])
}
