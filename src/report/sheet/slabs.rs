//! What the page of a composed layer has beside others: curves against thickness and depth, and the
//! coefficients of the medium.

use super::figures::shown_nm;
use super::layers::called;
use super::words::{words, words_of};
use crate::draw::DrawResult;
use crate::draw::chart::{Chart, Curve, Style};
use crate::draw::page::Figure;
use crate::evaluate::manifest::composed::{ComposedColours, ComposedRow, SlabNotes};
use crate::evaluate::manifest::{ComposedResults, Manifest};
use crate::evaluate::published::{ErrorParts, PublishedRow};
use crate::input::study::{Study, WantedNumber};
use crate::numerics::estimate::Estimate;
use crate::report::columns::heading;
use minijinja::value::Serde;
use minijinja::{Value, context};
use serde::Serialize;

fn lab(judged: Option<[ErrorParts; 3]>) -> String {
    let Some(judged) = judged else { return "no colour".to_owned() };
    let [l, a, b] = judged.map(|part| words(&part, 2));
    format!("L* {l}, a* {a}, b* {b}")
}

/// The main results in a line each.
pub(super) fn lines(manifest: &Manifest, composed: &ComposedResults) -> Vec<String> {
    let mut lines = Vec::new();
    for c in composed.colours {
        let seen = lab(c.natural_light);
        let ratio = words_of(c.contrast_ratio, 3);
        let um = start(manifest, c.thickness_um, ": ");
        lines.push(format!("{um}{seen} under natural light, contrast ratio {ratio}"));
    }
    if lines.is_empty() {
        lines.extend(composed.rows.iter().map(|row| spectral_line(manifest, row)));
    }
    lines.extend(composed.slabs.hiding_thickness_um.map(|um| format!("hides at {} µm", words(&um, 1))));
    lines
}

/// What a line begins with, where there are several thicknesses or a single layer.
fn start(manifest: &Manifest, thickness_um: f64, end: &str) -> String {
    let name = called(manifest, thickness_um);
    if name.is_empty() { name } else { name + end }
}

fn spectral_line(manifest: &Manifest, row: &ComposedRow) -> String {
    let um = start(manifest, row.thickness_um, ", ");
    let nm = row.wavelength_nm;
    let r = words_of(row.layer.reflectance_normal, 4);
    let t = words_of(row.layer.transmittance_normal, 4);
    let diffuse_r = words_of(row.layer.reflectance_diffuse, 4);
    let diffuse_t = words_of(row.layer.transmittance_diffuse, 4);
    format!("{um}{nm} nm: at 0° R {r}, T {t}; diffuse light R {diffuse_r}, T {diffuse_t}")
}

/// What the page shows beside the manifest.
pub(super) fn page(manifest: &Manifest, composed: &ComposedResults) -> Value {
    context! {
        patches => Serde(patches(manifest, composed.colours)),
        shown_medium => Serde(shown_medium(manifest.study, composed.slabs)),
        largest => Serde(largest_parts(composed.rows)),
    }
}

/// Names and colours of the patches of every thickness.
fn patches(manifest: &Manifest, colours: &[ComposedColours]) -> Vec<(String, String)> {
    let patch = |layer: &ComposedColours| {
        Some((start(manifest, layer.thickness_um, " ") + "on the paper", layer.hex.clone()?))
    };
    colours.iter().filter_map(patch).collect()
}

/// Curves against thickness and depth, and spectra.
pub(super) fn figures(manifest: &Manifest, composed: &ComposedResults) -> DrawResult<Vec<Figure>> {
    let study = manifest.study;
    let slabs = composed.slabs;
    let mut all = vec![
        ("The light's way", depth_chart(slabs), DEPTH),
        ("On the paper", spectra_chart(manifest, composed), SPECTRA),
    ];
    // a stack has the thicknesses requested, often one
    if !slabs.curve.is_empty() {
        all.insert(0, ("Against thickness", shares_chart(study, slabs), SHARES));
    }
    if !slabs.curve_colours.is_empty() {
        all.insert(1, ("Hiding", hiding_chart(slabs), HIDING));
        all.insert(2, ("Colour", colour_chart(slabs), COLOUR));
    }
    if !slabs.curve_numbers.is_empty() {
        all.push(("Weighted numbers", numbers_chart(study, slabs), NUMBERS));
    }
    all.into_iter().map(|(heading, chart, caption)| Figure::new(heading, &chart, caption)).collect()
}

const NUMBERS: &str = "Weighted numbers of the study against the thickness, with standard errors.";
const SHARES: &str = "Diffuse light reflected (R) and transmitted (T) by the layer without paper, against its \
    thickness. Error bars are standard errors, the model's part included.";
const DEPTH: &str = "Fluxes towards the paper and back in the layer on its paper, lit at 0°, as shares of the \
    incident light. Where their difference falls, light is absorbed. Without interference between the layers' \
    faces, and without error bars.";
const SPECTRA: &str = "Light that reaches the eye along the normal under natural light, as a share of that of a \
    perfect white, for every thickness asked for.";
const HIDING: &str = "Contrast ratio (Y over black by Y over white, 45:0) and L*/100 on the paper under natural \
    light, against the thickness. 0.98 counts as hiding.";

const COLOUR: &str = "Colour on the paper under natural light, seen along the normal, against the thickness.";

fn against_thickness(y_label: &str, curves: Vec<Curve>) -> Chart {
    let chart = Chart::linear("", "thickness, µm", y_label, curves);
    Chart { log: [true, false], y_range: Some([0.0, 1.0]), ..chart }
}

fn shares_chart(study: &Study, slabs: &SlabNotes) -> Chart {
    let curve = |nm: f64, name: &str, share: fn(&ComposedRow) -> Option<ErrorParts>| {
        let rows = slabs.curve.iter().filter(move |row| row.wavelength_nm == nm);
        let points = rows.filter_map(|row| Some((row.thickness_um, share(row)?.estimate())));
        Curve::measured(format!("{name}, {nm:.0} nm"), points)
    };
    let mut curves = Vec::new();
    for nm in shown_nm(&study.wavelengths_nm) {
        curves.push(curve(nm, "R", |row| row.layer.reflectance_diffuse));
        curves.push(curve(nm, "T", |row| row.layer.transmittance_diffuse));
    }
    against_thickness("share of the light", curves)
}

/// A number of the colours against the thickness, over `by`.
fn colour_curve(
    slabs: &SlabNotes,
    name: &str,
    number: fn(&ComposedColours) -> Option<ErrorParts>,
    by: f64,
) -> Curve {
    let points = slabs.curve_colours.iter().filter_map(|c| Some((c.thickness_um, number(c)?)));
    let points = points.map(|(um, judged)| [um, judged.value / by, judged.standard_error / by]);
    Curve::with_bars(name, Style::Data, points)
}

fn hiding_chart(slabs: &SlabNotes) -> Chart {
    let curves = vec![
        colour_curve(slabs, "contrast ratio", |c| c.contrast_ratio, 1.0),
        colour_curve(slabs, "L*/100 on the paper", |c| Some(c.natural_light?[0]), 100.0),
        colour_curve(slabs, "L*/100 over black", |c| Some(c.over_black?[0]), 100.0),
    ];
    against_thickness("contrast ratio, L*/100", curves)
}

fn colour_chart(slabs: &SlabNotes) -> Chart {
    let curves = vec![
        colour_curve(slabs, "L*", |c| Some(c.natural_light?[0]), 1.0),
        colour_curve(slabs, "a*", |c| Some(c.natural_light?[1]), 1.0),
        colour_curve(slabs, "b*", |c| Some(c.natural_light?[2]), 1.0),
    ];
    Chart { y_range: None, ..against_thickness("L*, a*, b*", curves) }
}

fn numbers_chart(study: &Study, slabs: &SlabNotes) -> Chart {
    let curve = |wanted: &WantedNumber| {
        let notes = slabs.curve_numbers.iter().filter(|note| note.name == wanted.name);
        Curve::measured(
            wanted.name.as_str(),
            notes.filter_map(|note| Some((note.thickness_um?, note.estimate()?))),
        )
    };
    let curves = study.numbers.iter().map(curve).collect();
    Chart { y_range: None, ..against_thickness("number", curves) }
}

fn depth_chart(slabs: &SlabNotes) -> Chart {
    let curve = |name: &str, number: fn([f64; 2]) -> f64| {
        let points = slabs.depth.iter().map(|row| (row.depth_um, number([row.down, row.up])));
        Curve::new(format!("{name}, {:.0} nm", slabs.depth_nm), Style::Data, points)
    };
    let curves = vec![curve("down", |[d, _]| d), curve("up", |[_, u]| u), curve("net", |[d, u]| d - u)];
    Chart { from_zero: true, ..Chart::linear("", "depth, µm", "flux, share of the incident light", curves) }
}

fn spectra_chart(manifest: &Manifest, composed: &ComposedResults) -> Chart {
    let mut curves = Vec::new();
    for um in &composed.slabs.composed.thicknesses_um {
        let rows = composed.rows_of(*um);
        let points = rows.filter_map(|row| Some((row.wavelength_nm, row.layer.natural_light?.estimate())));
        let name = called(manifest, *um);
        let name = if name.is_empty() { "all layers".to_owned() } else { name };
        curves.push(Curve::measured(name, points));
    }
    let chart = Chart::linear("", "wavelength, nm", "share of a perfect white", curves);
    Chart { y_range: Some([0.0, 1.0]), ..chart }
}

/// Coefficients of the medium at a few wavelengths.
fn shown_medium(study: &Study, slabs: &SlabNotes) -> Vec<(String, Estimate)> {
    let shown = shown_nm(&study.wavelengths_nm);
    let mut rows = Vec::new();
    for row in slabs.medium.iter().filter(|row| shown.contains(&row.wavelength_nm)) {
        for number in row.numbers() {
            let Some(estimate) = number.estimate else { continue };
            let name = heading(number.name);
            rows.push((format!("{name}, {:.0} nm", row.wavelength_nm), estimate));
        }
    }
    rows
}

/// Largest parts of the bars of R and T.
#[derive(Default, Serialize)]
struct LargestParts {
    chance: f64,
    model: f64,
    grid: f64,
    directions: f64,
    inputs: f64,
}

fn largest_parts(rows: &[ComposedRow]) -> LargestParts {
    let mut largest = LargestParts::default();
    for ComposedRow { layer, .. } in rows {
        let totals = [
            layer.reflectance_normal,
            layer.transmittance_normal,
            layer.reflectance_45,
            layer.transmittance_45,
            layer.reflectance_diffuse,
            layer.transmittance_diffuse,
        ];
        for parts in totals.into_iter().flatten() {
            largest.chance = largest.chance.max(parts.chance);
            largest.model = largest.model.max(parts.model);
            largest.grid = largest.grid.max(parts.grid);
            largest.directions = largest.directions.max(parts.directions);
            largest.inputs = largest.inputs.max(parts.inputs);
        }
    }
    largest
}
