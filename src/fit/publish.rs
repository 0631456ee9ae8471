//! Files of a fit: `pigment.csv`, `fit.json` and a page; `pigment-other.csv` where a second
//! solution fits as well.

use super::law::rms;
use super::load::FitTask;
use super::run::{FitOutcome, FittedIndex, FittedNumber, FittedSpectrum, Forecast, OtherSolution, Trust};
use crate::draw::DrawResult;
use crate::draw::chart::{Chart, Curve, Style};
use crate::draw::page::{Picture, made_by, rendered, svg_data};
use crate::report::columns::FolderTables;
use crate::report::publish::PublishResult;
use crate::run::crew::processor_seconds;
use crate::store::folder::OutputFolder;
use minijinja::context;
use minijinja::value::Serde;
use std::fmt::Write;

/// Half of a 95 % interval in standard errors.
const HALF_95: f64 = 1.96;

/// The fit in one sentence; both solutions where there are two.
pub fn in_words(outcome: &FitOutcome) -> String {
    let FitOutcome { chi_squared, data, degrees_of_freedom, .. } = outcome;
    let verdict = match outcome.trust {
        Trust::Untested => ", too few for a verdict",
        Trust::Unconverged => "; no verdict: the fit has not converged",
        _ => "",
    };
    let is_outside = outcome.index.iter().any(|row| row.outside_search);
    let outside = if is_outside { "outside the range searched: " } else { "" };
    let index = index_in_words(&outcome.index);
    let unsure = outcome.trust != Trust::Contradicted && !outcome.n_is_determined;
    let unsure = if unsure { "n is not determined: " } else { "" };
    let other = outcome.other_solution.as_ref().map_or(String::new(), |other| {
        format!("; second solution: {}, χ² {:.0}", index_in_words(&other.index), other.chi_squared)
    });
    format!(
        "{unsure}{outside}{index}; χ² {chi_squared:.0} for {data} data and {degrees_of_freedom:.1} degrees of freedom{verdict}{other}"
    )
}

/// Range of n and κ with their errors.
fn index_in_words(index: &[FittedIndex]) -> String {
    let [n0, n1] = ends(index.iter().map(|row| row.n));
    let [k0, k1] = ends(index.iter().map(|row| row.kappa));
    let n_bar = bar(index.iter().filter_map(|row| row.n_error).collect(), 3);
    let kappa_bar = bar(index.iter().filter_map(|row| row.kappa_error).collect(), 4);
    format!("n {n0:.3} … {n1:.3} {n_bar}, κ {k0:.4} … {k1:.4} {kappa_bar}")
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
    let table = csv(task, &outcome.remarks, &outcome.index);
    written.write("pigment.csv", table.as_bytes(), about, &[])?;
    if let Some(other) = &outcome.other_solution {
        let said = "the second of two solutions that fit equally well; the first is pigment.csv".to_owned();
        let remarks: Vec<String> = std::iter::once(said).chain(outcome.remarks.iter().cloned()).collect();
        let about = "the second of two solutions that fit equally well, as pigment.csv has the first";
        written.write("pigment-other.csv", csv(task, &remarks, &other.index).as_bytes(), about, &[])?;
    }
    written.describe(&task.title)?;
    let json = serde_json::json!({
        "title": task.title,
        "pigment": task.coats[0].pigments[task.pigment].name,
        "prior": task.settings.prior,
        "noise": task.settings.noise,
        "fit": outcome,
        "processor_seconds": processor_seconds(),
        "version": env!("CARGO_PKG_VERSION"),
    });
    folder.write("fit.json", &serde_json::to_vec_pretty(&json)?)?;
    let page = context! {
        title => &task.title,
        summary => in_words(outcome),
        trust => Serde(outcome.trust),
        second => outcome.other_solution.is_some(),
        remarks => Serde(&outcome.remarks),
        figures => Serde(figures(task, outcome)?),
        numbers => Serde(outcome.numbers.iter().map(number_row).collect::<Vec<_>>()),
        forecasts => Serde(outcome.forecasts.iter().map(row).collect::<Vec<_>>()),
        program => made_by(),
    };
    folder.write("report.html", rendered(include_str!("fit.html"), page)?.as_bytes())?;
    Ok(folder.complete()?)
}

/// A table that any study takes as `index = { csv = "pigment.csv" }`.
fn csv(task: &FitTask, remarks: &[String], index: &[FittedIndex]) -> String {
    let mut text = format!("# {}: index fitted by {}\n", task.title.replace('\n', " "), made_by());
    for remark in remarks {
        let _ = writeln!(text, "# {remark}");
    }
    let errors = index.iter().all(|row| row.n_error.is_some());
    text += "wavelength_nm,n,kappa";
    text += if errors { ",n_error,kappa_error,correlation\n" } else { "\n" };
    for row in index {
        let _ = write!(text, "{},{:.6},{:.7}", row.wavelength_nm, row.n, row.kappa);
        if let (Some(n), Some(kappa), Some(correlation)) = (row.n_error, row.kappa_error, row.correlation) {
            let _ = write!(text, ",{n:.6},{kappa:.7},{correlation:.4}");
        }
        text.push('\n');
    }
    text
}

/// A number as the page shows it: measured, fitted, and their difference in standard deviations.
fn number_row(number: &FittedNumber) -> [String; 4] {
    let FittedNumber { name, measured, fitted, sigma } = number;
    // no −0
    let deviation = (10.0 * (measured - fitted) / sigma).round() / 10.0 + 0.0;
    [name.clone(), format!("{measured:.4}"), format!("{fitted:.4}"), format!("{deviation:+.1}")]
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
    let binder = nm.iter().zip(&task.binder().index).map(|(&nm, eta)| (nm, eta.re));
    let mut curves = Vec::new();
    let mut kappa = Vec::new();
    let one = OneSolution { name: "", index: &outcome.index };
    let other = outcome.other_solution.as_ref();
    let other = other.map(|other| OneSolution { name: " (second solution)", index: &other.index });
    for solution in std::iter::once(one).chain(other) {
        curves.push(solution.curve("n", |row| [row.n, row.n_error.unwrap_or(0.0)]));
        kappa.push(solution.curve("κ", |row| [row.kappa, row.kappa_error.unwrap_or(0.0)]));
    }
    curves.push(Curve::new("binder", Style::Guide, binder));
    let of_other = outcome.other_solution.iter().flat_map(|other: &OtherSolution| &other.spectra);
    let mut left: Vec<Curve> = outcome.spectra.iter().map(|spectrum| residuals(nm, spectrum, "")).collect();
    left.extend(of_other.map(|spectrum| residuals(nm, spectrum, " (second solution)")));
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

/// The index of one solution as it is drawn.
struct OneSolution<'a> {
    /// What follows the name of the quantity.
    name: &'a str,
    index: &'a [FittedIndex],
}

impl OneSolution<'_> {
    /// A quantity with its 95 % intervals, from value and standard error.
    fn curve(&self, quantity: &str, value_with_error: impl Fn(&FittedIndex) -> [f64; 2]) -> Curve {
        let rows = self.index.iter().map(|row| {
            let [value, error] = value_with_error(row);
            [row.wavelength_nm, value, HALF_95 * error]
        });
        Curve::with_bars(format!("{quantity}, 95 %{}", self.name), Style::Data, rows)
    }
}

/// Measured less fitted values, in standard deviations.
fn residuals(nm: &[f64], spectrum: &FittedSpectrum, solution: &str) -> Curve {
    let rows = spectrum.measured.iter().zip(&spectrum.fitted).zip(&spectrum.sigma);
    let points = nm.iter().zip(rows).map(|(&nm, ((m, f), sigma))| (nm, (m - f) / sigma));
    Curve::new(format!("{}{solution}", spectrum.name), Style::Data, points)
}

fn forecast_chart(nm: &[f64], forecast: &Forecast) -> Chart {
    let bars = forecast.values.iter().zip(&forecast.errors);
    let predicted = nm.iter().zip(bars).map(|(&nm, (&value, &error))| [nm, value, HALF_95 * error]);
    let mut curves = vec![Curve::with_bars("from the index, 95 %", Style::Data, predicted)];
    let line = |values: &Vec<f64>| nm.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
    curves.extend(forecast.measured.iter().map(|v| Curve::new("measured", Style::Points, line(v))));
    curves.extend(forecast.kubelka_munk.iter().map(|v| Curve::new("Kubelka–Munk", Style::Data, line(v))));
    Chart::linear(&forecast.name, "wavelength, nm", "reflectance factor", curves)
}
