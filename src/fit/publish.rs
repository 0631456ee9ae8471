//! Files of a fit: `pigment.csv`, `fit.json` and a page.

use super::law::rms;
use super::load::FitTask;
use super::run::{FitOutcome, FittedSpectrum, Forecast};
use crate::draw::DrawResult;
use crate::draw::chart::{Chart, Curve, Style};
use crate::report::columns::FolderTables;
use crate::report::page::{Picture, made_by, rendered, svg_data};
use crate::report::publish::PublishResult;
use crate::store::folder::OutputFolder;
use minijinja::context;
use minijinja::value::Serde;
use std::fmt::Write;

/// Half of a 95 % interval in standard errors.
const HALF_95: f64 = 1.96;

/// The fit in one sentence.
pub fn in_words(outcome: &FitOutcome) -> String {
    let rows = || outcome.index.iter();
    let ([n0, n1], [k0, k1]) = (ends(rows().map(|row| row.n)), ends(rows().map(|row| row.kappa)));
    let n_bar = bar(rows().filter_map(|row| row.n_error).collect(), 3);
    let kappa_bar = bar(rows().filter_map(|row| row.kappa_error).collect(), 4);
    let n_bar = if outcome.n_is_determined { n_bar } else { "— not determined".into() };
    let FitOutcome { chi_squared, data, .. } = outcome;
    format!(
        "n {n0:.3} … {n1:.3} {n_bar}, κ {k0:.4} … {k1:.4} {kappa_bar}; χ² {chi_squared:.0} for {data} data"
    )
}

/// Smallest and largest of some numbers.
fn ends(all: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
}

fn bar(errors: Vec<f64>, digits: usize) -> String {
    if errors.is_empty() {
        return "no error stated".into();
    }
    format!("± {:.digits$} (1 standard error, root mean square)", rms(errors))
}

/// Writes all files.
///
/// # Errors
/// A file cannot be written, or a chart not be drawn.
pub fn publish(task: &FitTask, outcome: &FitOutcome, folder: &OutputFolder) -> PublishResult {
    let mut written = FolderTables::new(folder);
    let about =
        "the pigment's refractive index with its errors; a study takes the table as index = { csv = … }";
    written.write("pigment.csv", csv(task, outcome).as_bytes(), about, &[])?;
    written.describe(&task.title)?;
    let json = serde_json::json!({
        "title": task.title,
        "pigment": task.coats[0].pigments[task.pigment].name,
        "prior": task.settings.prior,
        "noise": task.settings.noise,
        "fit": outcome,
        "version": env!("CARGO_PKG_VERSION"),
    });
    folder.write("fit.json", &serde_json::to_vec_pretty(&json)?)?;
    let page = context! {
        title => &task.title,
        summary => in_words(outcome),
        trust => Serde(outcome.trust),
        remarks => Serde(&outcome.remarks),
        figures => Serde(figures(task, outcome)?),
        forecasts => Serde(outcome.forecasts.iter().map(row).collect::<Vec<_>>()),
        program => made_by(),
    };
    folder.write("report.html", rendered(include_str!("fit.html"), page)?.as_bytes())?;
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
    let apart = forecast.kubelka_munk.as_ref();
    let apart = apart.map(|km| rms(km.iter().zip(&forecast.values).map(|(a, b)| a - b)));
    [
        forecast.name.clone(),
        format!("{:.4}", rms(forecast.errors.iter().copied())),
        shown(apart.filter(|x| x.is_finite()), 4),
        shown(forecast.delta_e_2000, 2),
        shown(forecast.delta_e_2000_kubelka_munk, 2),
    ]
}

fn shown(number: Option<f64>, digits: usize) -> String {
    number.map_or("—".into(), |x| format!("{x:.digits$}"))
}

fn figures(task: &FitTask, outcome: &FitOutcome) -> DrawResult<Vec<Picture>> {
    let nm = task.wavelengths_nm();
    let rows = || outcome.index.iter();
    let n = rows().map(|row| [row.wavelength_nm, row.n, HALF_95 * row.n_error.unwrap_or(0.0)]);
    let kappa = rows().map(|row| [row.wavelength_nm, row.kappa, HALF_95 * row.kappa_error.unwrap_or(0.0)]);
    let binder = nm.iter().zip(&task.coats[0].layer.binder.index).map(|(&nm, eta)| (nm, eta.re));
    let curves =
        vec![Curve::with_bars("n, 95 %", Style::Data, n), Curve::new("binder", Style::Guide, binder)];
    let kappa = vec![Curve::with_bars("κ, 95 %", Style::Data, kappa)];
    let left = outcome.spectra.iter().map(|spectrum| residuals(nm, spectrum)).collect();
    let axis = "wavelength, nm";
    let mut pictures = vec![
        picture(&Chart::linear("Refractive index", axis, "n", curves), "n with 95 % intervals")?,
        picture(&Chart::linear("Absorption", axis, "κ", kappa), "κ with 95 % intervals")?,
        picture(
            &Chart::linear("Measured less fitted", axis, "standard deviations", left),
            "Measured less fitted, in standard deviations of noise, ensemble and grid",
        )?,
    ];
    for forecast in &outcome.forecasts {
        pictures.push(picture(&forecast_chart(nm, forecast), "A layer predicted from the fitted index")?);
    }
    Ok(pictures)
}

fn picture(chart: &Chart, caption: &str) -> DrawResult<Picture> {
    Ok(Picture { data: svg_data(&chart.svg()?), caption: caption.to_owned() })
}

/// Measured less fitted values, in standard deviations.
fn residuals(nm: &[f64], spectrum: &FittedSpectrum) -> Curve {
    let rows = spectrum.measured.iter().zip(&spectrum.fitted).zip(&spectrum.sigma);
    let points = nm.iter().zip(rows).map(|(&nm, ((m, f), sigma))| (nm, (m - f) / sigma));
    Curve::new(spectrum.name.clone(), Style::Data, points)
}

fn forecast_chart(nm: &[f64], forecast: &Forecast) -> Chart {
    let bars = forecast.values.iter().zip(&forecast.errors);
    let own = nm.iter().zip(bars).map(|(&nm, (&value, &error))| [nm, value, HALF_95 * error]);
    let mut curves = vec![Curve::with_bars("from the index, 95 %", Style::Data, own)];
    let line = |values: &Vec<f64>| nm.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
    curves.extend(forecast.measured.iter().map(|v| Curve::new("measured", Style::Points, line(v))));
    curves.extend(forecast.kubelka_munk.iter().map(|v| Curve::new("Kubelka–Munk", Style::Data, line(v))));
    Chart::linear(&forecast.name, "wavelength, nm", "reflectance factor", curves)
}
