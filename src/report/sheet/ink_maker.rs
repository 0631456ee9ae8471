//! The page's plots for ink makers.

use crate::draw::OutputError;
use crate::draw::chart::{Chart, Curve};
use crate::evaluate::ink_maker::{ComparedRow, InkMaker, MeasuredComparison};
use crate::evaluate::manifest::Manifest;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::report::page::Figure;

/// Plots of K and S, and of a measurement with its residuals.
pub(crate) fn figures(manifest: &Manifest<&Study>) -> Result<Vec<Figure>, OutputError> {
    let Some(maker) = &manifest.ink_maker else { return Ok(Vec::new()) };
    let mut figures = Vec::new();
    if !maker.kubelka_munk.is_empty() {
        figures.push(kubelka_munk(maker, manifest)?);
    }
    if let Some(measured) = &maker.measured {
        figures.extend(compared(measured)?);
    }
    Ok(figures)
}

fn figure(heading: &str, y_label: &str, curves: Vec<Curve>, caption: String) -> Result<Figure, OutputError> {
    let plot = Chart { from_zero: true, ..Chart::linear("", "wavelength, nm", y_label, curves) };
    Figure::new(heading, &plot, caption)
}

fn kubelka_munk(maker: &InkMaker, manifest: &Manifest<&Study>) -> Result<Figure, OutputError> {
    let certainty = &manifest.certainty;
    let asked: Vec<f64> = manifest.spectra.iter().map(|row| row.wavelength_nm).collect();
    let factor = certainty.coverage_factor_95;
    let wide = |e: Estimate| Estimate {
        standard_error: e.standard_error.map(|error| error * factor.unwrap_or(1.0)),
        ..e
    };
    let rows = || maker.kubelka_munk.iter();
    let absorption = rows().map(|row| (row.wavelength_nm, wide(row.absorption_per_um)));
    let scattering = rows().map(|row| (row.wavelength_nm, wide(row.scattering_per_um)));
    let series = vec![
        Curve::measured("absorption K", absorption).asked_at(&asked),
        Curve::measured("scattering S", scattering).asked_at(&asked),
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

fn compared(measured: &MeasuredComparison) -> Result<Vec<Figure>, OutputError> {
    let of = |value: &dyn Fn(&ComparedRow) -> Estimate| {
        measured.rows.iter().map(|row| (row.wavelength_nm, value(row))).collect::<Vec<_>>()
    };
    let both = vec![
        Curve::measured("predicted", of(&|row| row.predicted)),
        Curve::measured("measured", of(&|row| Estimate { value: row.measured, standard_error: None })),
    ];
    let residual = of(&|row| Estimate { value: row.measured - row.predicted.value, ..row.predicted });
    let residual = vec![Curve::measured("measured less predicted", residual)];
    let caption = format!("At 45:0; measured: {}, linear between its rows.", measured.source);
    Ok(vec![
        figure("Measured and predicted", "share of a perfect white", both, caption.clone())?,
        figure(
            "Residual",
            "measured less predicted",
            residual,
            format!("{caption} Error bars are those of the prediction."),
        )?,
    ])
}
