//! Composed layers of a sweep along its first axis: media, and weighted numbers of every thickness.

use super::outcome::Outcome;
use crate::draw::DrawResult;
use crate::draw::cell::{numbers, table, with_errors};
use crate::draw::chart::{Chart, Curve};
use crate::draw::page::{Picture, svg_data};
use crate::evaluate::manifest::composed::MediumRow;
use crate::evaluate::published::{ErrorParts, NumberNote, PublishedRow};
use crate::numerics::estimate::Estimate;
use crate::report::columns::heading;
use crate::sweep::definition::load::{AxisOutline, Sweep};

/// A coefficient of the medium that is drawn.
struct Drawn {
    name: &'static str,
    number: fn(&MediumRow) -> Option<ErrorParts>,
}

const DRAWN: [Drawn; 3] = [
    Drawn { name: "scattering_per_um", number: |row| row.medium.scattering_per_um },
    Drawn { name: "transport_path_um", number: |row| row.medium.transport_path_um },
    Drawn { name: "kubelka_munk_scattering_per_um", number: |row| row.medium.kubelka_munk_scattering_per_um },
];

/// `composed.csv`: one row for each composed layer and wavelength, with its place on the axes, the
/// coefficients, and what hides; `None` without such layers.
///
/// # Errors
/// A table that cannot be written.
pub(super) fn media_table(sweep: &Sweep, outcomes: &[Outcome]) -> csv::Result<Option<Vec<u8>>> {
    let axes = sweep.outline.axes.iter().map(AxisOutline::heading);
    let names = with_errors(MediumRow::names().into_iter().chain(["hiding_thickness_um"]));
    let mut all = Vec::new();
    for outcome in outcomes {
        for row in &outcome.medium {
            let of_medium = row.numbers().into_iter().map(|number| number.estimate);
            let estimates = of_medium.chain([outcome.hiding_thickness_um]);
            let mut line = [outcome.labels.clone(), vec![row.wavelength_nm.to_string()]].concat();
            line.extend(estimates.flat_map(numbers));
            all.push(line);
        }
    }
    if all.is_empty() {
        return Ok(None);
    }
    table(axes.chain(["wavelength_nm".to_owned()]).chain(names), all).map(Some)
}

/// `numbers.csv`: one row for each composed layer and thickness, with its place on the axes and the
/// weighted numbers; `None` without such numbers.
///
/// # Errors
/// A table that cannot be written.
pub(super) fn numbers_table(sweep: &Sweep, outcomes: &[Outcome]) -> csv::Result<Option<Vec<u8>>> {
    let axes = sweep.outline.axes.iter().map(AxisOutline::heading);
    let names = number_names(sweep);
    let mut all = Vec::new();
    for outcome in outcomes {
        for um in thicknesses(outcome) {
            let mut line = [outcome.labels.clone(), vec![um.to_string()]].concat();
            line.extend(names.iter().flat_map(|name| numbers(number_of(outcome, name, um))));
            all.push(line);
        }
    }
    if all.is_empty() {
        return Ok(None);
    }
    let columns = with_errors(names.iter().map(String::as_str));
    table(axes.chain(["thickness_um".to_owned()]).chain(columns), all).map(Some)
}

/// Names of the weighted numbers of all variants, each once.
pub(super) fn number_names(sweep: &Sweep) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for number in sweep.variants.iter().flat_map(|variant| &variant.study.numbers) {
        if !names.contains(&number.name) {
            names.push(number.name.clone());
        }
    }
    names
}

/// Thicknesses of which a composed layer has weighted numbers, µm.
fn thicknesses(outcome: &Outcome) -> Vec<f64> {
    let mut all: Vec<f64> = outcome.numbers.iter().filter_map(|note| note.thickness_um).collect();
    all.dedup();
    all
}

/// The weighted number of a composed layer of this thickness.
fn number_of(outcome: &Outcome, name: &str, thickness_um: f64) -> Option<Estimate> {
    let here = |note: &&NumberNote| note.name == name && note.thickness_um == Some(thickness_um);
    outcome.numbers.iter().find(here)?.estimate()
}

/// A number of the layers against the first axis, rising.
fn against(
    sweep: &Sweep,
    outcomes: &[Outcome],
    number: &dyn Fn(&Outcome) -> Option<Estimate>,
) -> Vec<(f64, Estimate)> {
    let abscissa = |v: usize| sweep.outline.axes.first()?.number(*sweep.outline.variants[v].place.first()?);
    let points = outcomes.iter().enumerate();
    let mut points: Vec<(f64, Estimate)> =
        points.filter_map(|(v, outcome)| Some((abscissa(v)?, number(outcome)?))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// Whether there are curves, each of several points.
fn is_drawn(curves: &[Curve]) -> bool {
    !curves.is_empty() && curves.iter().all(|curve| curve.points.len() > 1)
}

/// Coefficients, the hiding thickness and weighted numbers against the first axis, where that has
/// numbers.
pub(super) fn figures(sweep: &Sweep, outcomes: &[Outcome]) -> DrawResult<Vec<Picture>> {
    let first =
        outcomes.iter().find(|outcome| !outcome.medium.is_empty() || !thicknesses(outcome).is_empty());
    let Some((axis, first)) = sweep.outline.axes.first().zip(first) else {
        return Ok(Vec::new());
    };
    let mut charts = Vec::new();
    for Drawn { name, number } in DRAWN {
        let curve = |(w, row): (usize, &MediumRow)| {
            let of_layer = |outcome: &Outcome| Some(number(outcome.medium.get(w)?)?.estimate());
            Curve::measured(format!("{:.0} nm", row.wavelength_nm), against(sweep, outcomes, &of_layer))
        };
        charts.push((name.to_owned(), first.medium.iter().enumerate().map(curve).collect::<Vec<_>>()));
    }
    let hiding = against(sweep, outcomes, &|outcome| outcome.hiding_thickness_um);
    charts.push(("hiding_thickness_um".to_owned(), vec![Curve::measured("contrast ratio 0.98", hiding)]));
    for name in number_names(sweep) {
        let curve = |um: f64| {
            let of_layer = |outcome: &Outcome| number_of(outcome, &name, um);
            Curve::measured(format!("{um} µm"), against(sweep, outcomes, &of_layer))
        };
        charts.push((name.clone(), thicknesses(first).into_iter().map(curve).collect()));
    }
    let mut figures = Vec::new();
    for (name, curves) in charts.into_iter().filter(|(_, curves)| is_drawn(curves)) {
        let heading = heading(&name);
        let title = format!("{heading} against {}, with standard errors", axis.heading());
        let chart = Chart { from_zero: true, ..Chart::linear(&title, &axis.heading(), &heading, curves) };
        figures.push(Picture { data: svg_data(&chart.svg()?), caption: title });
    }
    Ok(figures)
}
