//! Files of a fit: `pigment.csv`, `fit.json` and a page.

use super::load::FitTask;
use super::run::{FitOutcome, FittedSpectrum, Forecast};
use crate::draw::OutputError;
use crate::draw::chart::{Chart, Curve, Style};
use crate::report::page::{Picture, made_by, rendered, svg_data};
use crate::store::folder::{FolderError, OutputFolder};
use minijinja::value::Serde;
use serde::Serialize;
use std::fmt::Write;
use thiserror::Error;

/// Half of a 95 % interval in standard errors.
const HALF_95: f64 = 1.96;

/// Why files of a fit cannot be written.
#[derive(Debug, Error)]
pub enum FitOutputError {
    /// The folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A chart.
    #[error(transparent)]
    Chart(#[from] OutputError),
    /// The page's template does not fit its data.
    #[error("the page cannot be made: {0}")]
    Page(#[from] minijinja::Error),
    /// Numbers that are not finite.
    #[error("fit.json cannot be made: {0}")]
    Json(#[from] serde_json::Error),
}

/// Contents of the page.
#[derive(Serialize)]
struct FitPage<'a> {
    title: &'a str,
    summary: String,
    trust: String,
    remarks: &'a [String],
    figures: Vec<Picture>,
    forecasts: Vec<[String; 5]>,
    program: String,
}

/// The fit in one sentence.
pub fn in_words(outcome: &FitOutcome) -> String {
    let rms = |of: fn(&super::run::FittedIndex) -> Option<f64>| {
        let all: Vec<f64> = outcome.index.iter().filter_map(of).collect();
        (!all.is_empty()).then(|| (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt())
    };
    let range = |of: fn(&super::run::FittedIndex) -> f64| {
        let all = outcome.index.iter().map(of);
        [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
    };
    let ([n0, n1], [k0, k1]) = (range(|row| row.n), range(|row| row.kappa));
    let bar = |error: Option<f64>, digits: usize| {
        error.map_or("no error stated".into(), |e| {
            format!("± {e:.digits$} (1 standard error, root mean square)")
        })
    };
    format!(
        "n {n0:.3} … {n1:.3} {}, κ {k0:.4} … {k1:.4} {}; χ² {:.0} for {} data",
        if outcome.n_is_determined { bar(rms(|row| row.n_error), 3) } else { "— not determined".into() },
        bar(rms(|row| row.kappa_error), 4),
        outcome.chi_squared,
        outcome.data,
    )
}

/// Writes all files.
///
/// # Errors
/// A file cannot be written, or a chart not be drawn.
pub fn publish(task: &FitTask, outcome: &FitOutcome, folder: &OutputFolder) -> Result<(), FitOutputError> {
    folder.write("pigment.csv", csv(task, outcome).as_bytes())?;
    let json = serde_json::json!({
        "title": task.title,
        "pigment": task.coats[0].pigments[task.pigment].name,
        "prior": task.settings.prior,
        "noise": task.settings.noise,
        "fit": outcome,
        "version": env!("CARGO_PKG_VERSION"),
    });
    folder.write("fit.json", &serde_json::to_vec_pretty(&json)?)?;
    let page = FitPage {
        title: &task.title,
        summary: in_words(outcome),
        trust: format!("{:?}", outcome.trust).to_lowercase(),
        remarks: &outcome.remarks,
        figures: figures(task, outcome)?,
        forecasts: outcome.forecasts.iter().map(row).collect(),
        program: made_by(),
    };
    folder.write("report.html", rendered(include_str!("fit.html"), Serde(&page))?.as_bytes())?;
    Ok(folder.complete()?)
}

/// A table that any study takes as `index = { csv = "pigment.csv" }`.
fn csv(task: &FitTask, outcome: &FitOutcome) -> String {
    let mut text = format!("# {}: index fitted by {}\n", task.title.replace('\n', " "), made_by());
    for remark in &outcome.remarks {
        let _ = writeln!(text, "# {remark}");
    }
    let errors = outcome.index.iter().all(|row| row.n_error.is_some());
    text += "wavelength_nm,n,kappa";
    text += if errors { ",n_error,kappa_error,correlation\n" } else { "\n" };
    for row in &outcome.index {
        let _ = write!(text, "{},{:.6},{:.7}", row.wavelength_nm, row.n, row.kappa);
        if let (Some(n), Some(kappa), Some(correlation)) = (row.n_error, row.kappa_error, row.correlation) {
            let _ = write!(text, ",{n:.6},{kappa:.7},{correlation:.4}");
        }
        text.push('\n');
    }
    text
}

fn row(forecast: &Forecast) -> [String; 5] {
    let shown = |x: Option<f64>| x.map_or("—".into(), |x| format!("{x:.2}"));
    let apart = |km: &Vec<f64>| {
        let squares = km.iter().zip(&forecast.values).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / km.len() as f64).sqrt()
    };
    let rms = forecast.kubelka_munk.as_ref().map(apart).filter(|x| x.is_finite());
    let error = forecast.errors.iter().map(|e| e * e).sum::<f64>() / forecast.errors.len().max(1) as f64;
    [
        forecast.name.clone(),
        format!("{:.4}", error.sqrt()),
        rms.map_or("—".into(), |x| format!("{x:.4}")),
        shown(forecast.delta_e_2000),
        shown(forecast.delta_e_2000_kubelka_munk),
    ]
}

fn figures(task: &FitTask, outcome: &FitOutcome) -> Result<Vec<Picture>, OutputError> {
    let nm = task.wavelengths_nm();
    let bar = |error: Option<f64>| HALF_95 * error.unwrap_or(0.0);
    let n = outcome.index.iter().map(|row| [row.wavelength_nm, row.n, bar(row.n_error)]);
    let kappa = outcome.index.iter().map(|row| [row.wavelength_nm, row.kappa, bar(row.kappa_error)]);
    let binder = nm.iter().zip(&task.coats[0].layer.binder.index).map(|(&nm, eta)| (nm, eta.re));
    let curves =
        vec![Curve::with_bars("n, 95 %", Style::Data, n), Curve::new("binder", Style::Guide, binder)];
    let axis = "wavelength, nm";
    let mut charts = vec![
        (Chart::linear("Refractive index", axis, "n", curves), "n with 95 % intervals"),
        (
            Chart::linear("Absorption", axis, "κ", vec![Curve::with_bars("κ, 95 %", Style::Data, kappa)]),
            "κ with 95 % intervals",
        ),
    ];
    let left = |spectrum: &FittedSpectrum| {
        let rows = spectrum.measured.iter().zip(&spectrum.fitted).zip(&spectrum.sigma);
        let points = nm.iter().zip(rows).map(|(&nm, ((m, f), sigma))| (nm, (m - f) / sigma));
        Curve::new(spectrum.name.clone(), Style::Data, points)
    };
    let left = outcome.spectra.iter().map(left).collect();
    charts.push((
        Chart::linear("Measured less fitted", axis, "standard deviations", left),
        "Measured less fitted, in standard deviations of noise, ensemble and grid",
    ));
    for forecast in &outcome.forecasts {
        charts.push((forecast_chart(nm, forecast), "A layer predicted from the fitted index"));
    }
    let picture = |(chart, caption): &(Chart, &str)| {
        Ok(Picture { data: svg_data(&chart.svg()?), caption: (*caption).to_owned() })
    };
    charts.iter().map(picture).collect()
}

fn forecast_chart(nm: &[f64], forecast: &Forecast) -> Chart {
    let bars = forecast.values.iter().zip(&forecast.errors);
    let own = nm.iter().zip(bars).map(|(&nm, (&value, &error))| [nm, value, HALF_95 * error]);
    let mut curves = vec![Curve::with_bars("from the index, 95 %", Style::Data, own)];
    let line = |values: &Vec<f64>| nm.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
    let measured = forecast.measured.iter().map(|v| Curve::new("measured", Style::Points, line(v)));
    curves.extend(measured);
    let munk = forecast.kubelka_munk.iter();
    curves.extend(munk.map(|v| Curve::new("Kubelka–Munk", Style::Data, line(v))));
    Chart::linear(&forecast.name, "wavelength, nm", "reflectance factor", curves)
}
