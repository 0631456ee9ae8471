//! Sweeps of composed layers: every layer in its own folder, and what changes along the first axis,
//! such as the crowding of a pigment against its share.

use super::publish::{axis_columns, number_columns, number_names};
use crate::draw::cell::{numbers, table, with_errors};
use crate::draw::chart::{Chart, Curve};
use crate::draw::page::Figure;
use crate::evaluate::composed::manifest::{ComposedManifest, MediumRow};
use crate::evaluate::manifest::Status;
use crate::evaluate::published::{ErrorParts, NumberNote, PublishedRow};
use crate::numerics::estimate::Estimate;
use crate::report::columns::FolderTables;
use crate::report::composed::{heading, lines, publish as publish_layer};
use crate::report::page::on_study;
use crate::report::publish::PublishResult;
use crate::run::Stores;
use crate::run::watch::RunWatch;
use crate::store::folder::OutputFolder;
use crate::sweep::definition::folder::VARIANTS;
use crate::sweep::definition::load::{AxisOutline, Sweep};
use crate::work::alone::stored_portions;
use crate::work::variant::Variant;
use minijinja::context;
use minijinja::value::Serde;
use std::path::PathBuf;

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

/// A layer of the sweep, by the number of its variant.
type LayerDone<'a> = (usize, ComposedManifest<'a>);

/// What is published of a sweep.
#[derive(Clone, Debug)]
pub struct PublishedLayers {
    /// Path of the page.
    pub page: PathBuf,
    /// Number of layers of which every solve has a result.
    pub complete: usize,
}

/// Whether any variant is a composed layer.
pub fn is_composed(sweep: &Sweep) -> bool {
    sweep.variants.iter().any(|variant| variant.study.composed().is_some())
}

/// Writes what the store has of the layers: each layer in its folder, and the page of all. A layer
/// of which some slab has no complete realisation is left out; the watch hears why.
///
/// # Errors
/// Files that cannot be written, a store that cannot be read.
pub fn publish(sweep: &Sweep, folder: &OutputFolder, watch: &dyn RunWatch) -> PublishResult<PublishedLayers> {
    let stores = Stores::open(folder)?;
    let mut done = Vec::new();
    for (k, Variant { name, study }) in sweep.variants.iter().enumerate() {
        watch.stage(&format!("{name}: evaluating the layer"));
        let of_variant = folder.inside(&format!("{VARIANTS}/{name}"))?;
        match publish_layer(study, &stored_portions(study, &stores), &of_variant) {
            Ok(layer) => done.push((k, layer)),
            Err(reason) => watch.stage(&format!("{name}: {reason}")),
        }
    }
    let page = write_page(sweep, &done, folder)?;
    let complete = done.iter().filter(|(_, layer)| layer.origin.status == Status::Complete).count();
    if complete == sweep.variants.len() {
        folder.complete()?;
    }
    Ok(PublishedLayers { page, complete })
}

/// Writes `composed.csv` and the page; returns the page's path.
fn write_page(sweep: &Sweep, done: &[LayerDone], folder: &OutputFolder) -> PublishResult<PathBuf> {
    let mut written = FolderTables::new(folder);
    let axes = axis_columns(sweep, AxisOutline::heading);
    written.write(
        "composed.csv",
        &rows(sweep, done)?,
        "what the packed media of the variants are to light",
        &axes,
    )?;
    if !number_names(sweep).is_empty() {
        let about = "weighted numbers of the variants";
        let columns = [axis_columns(sweep, AxisOutline::heading), number_columns(sweep)].concat();
        written.write("sweep.csv", &number_rows(sweep, done)?, about, &columns)?;
    }
    written.describe(&sweep.outline.title)?;
    let line = |(k, layer): &LayerDone| {
        let name = &sweep.variants[*k].name;
        lines(layer).into_iter().map(|line| [name.clone(), line]).collect::<Vec<_>>()
    };
    let page = context! {
        title => &sweep.outline.title,
        summary => format!("{} composed layers; each has a page of its own under variants.", done.len()),
        figures => Serde(figures(sweep, done)?),
        layers => Serde(done.iter().flat_map(line).collect::<Vec<_>>()),
        limits => ["Bars are those of the layers: chance, grid, and the error of composing."],
    };
    folder.write("report.html", on_study("{% extends \"page.html\" %}", page)?.as_bytes())?;
    Ok(folder.path().join("report.html"))
}

/// One row for each layer and wavelength: its place on the axes, the coefficients, what hides.
fn rows(sweep: &Sweep, done: &[LayerDone]) -> csv::Result<Vec<u8>> {
    let axes = sweep.outline.axes.iter().map(|axis| axis.heading());
    let names = with_errors(MediumRow::names().into_iter().chain(["hiding_thickness_um"]));
    let mut all = Vec::new();
    for (k, layer) in done {
        let place = &sweep.outline.variants[*k].place;
        let labels: Vec<String> =
            sweep.outline.axes.iter().zip(place).map(|(axis, &at)| axis.labels[at].clone()).collect();
        for row in &layer.medium {
            let hiding = layer.hiding_thickness_um.map(|j| j.estimate());
            let estimates = row.numbers().into_iter().map(|number| number.estimate).chain([hiding]);
            let mut line = [labels.clone(), vec![row.wavelength_nm.to_string()]].concat();
            line.extend(estimates.flat_map(numbers));
            all.push(line);
        }
    }
    table(axes.chain(["wavelength_nm".to_owned()]).chain(names), all)
}

/// One row for each layer and thickness: its place on the axes, and the weighted numbers.
fn number_rows(sweep: &Sweep, done: &[LayerDone]) -> csv::Result<Vec<u8>> {
    let axes = sweep.outline.axes.iter().map(|axis| axis.heading());
    let names = number_names(sweep);
    let mut all = Vec::new();
    for (k, layer) in done {
        let place = &sweep.outline.variants[*k].place;
        let labels: Vec<String> =
            sweep.outline.axes.iter().zip(place).map(|(axis, &at)| axis.labels[at].clone()).collect();
        for &um in &layer.composed.thicknesses_um {
            let of = |name: &String| {
                let here = |note: &&NumberNote| note.name == *name && note.thickness_um == Some(um);
                layer.numbers.iter().find(here)?.estimate()
            };
            let mut line = [labels.clone(), vec![um.to_string()]].concat();
            line.extend(names.iter().map(of).flat_map(numbers));
            all.push(line);
        }
    }
    let columns = with_errors(names.iter().map(String::as_str));
    table(axes.chain(["thickness_um".to_owned()]).chain(columns), all)
}

/// A number of the layers against the first axis, rising.
fn against(
    sweep: &Sweep,
    done: &[LayerDone],
    number: &dyn Fn(&ComposedManifest) -> Option<Estimate>,
) -> Vec<(f64, Estimate)> {
    let abscissa = |k: usize| sweep.outline.axes.first()?.number(*sweep.outline.variants[k].place.first()?);
    let mut points: Vec<(f64, Estimate)> =
        done.iter().filter_map(|(k, layer)| Some((abscissa(*k)?, number(layer)?))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// Coefficients and the hiding thickness against the first axis, where that has numbers.
fn figures(sweep: &Sweep, done: &[LayerDone]) -> PublishResult<Vec<Figure>> {
    let Some((axis, (_, first))) = sweep.outline.axes.first().zip(done.first()) else {
        return Ok(Vec::new());
    };
    let mut charts = Vec::new();
    for Drawn { name, number } in DRAWN {
        let curve = |(w, row): (usize, &MediumRow)| {
            let of_layer = |layer: &ComposedManifest| Some(number(layer.medium.get(w)?)?.estimate());
            Curve::measured(format!("{:.0} nm", row.wavelength_nm), against(sweep, done, &of_layer))
        };
        charts.push((name.to_owned(), first.medium.iter().enumerate().map(curve).collect::<Vec<_>>()));
    }
    let hiding = against(sweep, done, &|layer| Some(layer.hiding_thickness_um?.estimate()));
    charts.push(("hiding_thickness_um".to_owned(), vec![Curve::measured("contrast ratio 0.98", hiding)]));
    for name in number_names(sweep) {
        let mut curves = Vec::new();
        for um in &first.composed.thicknesses_um {
            let of_layer = |layer: &ComposedManifest| {
                let here = |note: &&NumberNote| note.name == name && note.thickness_um == Some(*um);
                layer.numbers.iter().find(here)?.estimate()
            };
            curves.push(Curve::measured(format!("{um} µm"), against(sweep, done, &of_layer)));
        }
        charts.push((name, curves));
    }
    let mut figures = Vec::new();
    for (name, curves) in charts.into_iter().filter(|(_, curves)| curves.iter().all(|c| c.points.len() > 1)) {
        let heading = heading(&name);
        let chart = Chart { from_zero: true, ..Chart::linear("", &axis.heading(), &heading, curves) };
        let caption = format!("{heading} against {}, with standard errors.", axis.heading());
        figures.push(Figure::new(&heading, &chart, caption)?);
    }
    Ok(figures)
}
