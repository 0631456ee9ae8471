//! The interactive page of a sweep: sliders for its axes; for the selected variant its swatch,
//! spectra, numbers with errors and picture. Between solved settings that are numbers it shows
//! variants that are evaluated from the same solves, where these suffice, and interpolates
//! elsewhere, with the leave-one-out error. One file, no network.
//!
//! Spectra are stored as 16-bit multiples of 1/20 000, pictures as PNG and numbers to a millionth,
//! so that 260 variants take less than 1 MB; `sweep.csv` has all digits.

use super::between::{BetweenVariant, VariantsBetween};
use super::continuous::{Continuous, numbers};
use super::outcome::Outcome;
use super::reported::{Reported, shown, target_numbers};
use crate::appearance::picture::ScreenPicture;
use crate::draw::figure::Bitmap;
use crate::draw::page::{STYLE, hex, made_by};
use crate::evaluate::manifest::Count;
use crate::evaluate::manifest::main_numbers::PrintRow;
use crate::numerics::estimate::Estimate;
use crate::sweep::definition::load::{AxisOutline, Sweep};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Steps per unit of a spectrum; the largest value is 3.2767 − 0.1.
const STEPS: f64 = 20_000.0;
/// Offset of the steps: values may be slightly negative.
const LOWEST: f64 = -0.1;
/// Steps per unit of the numbers: no error is shown with more decimals.
const NUMBERS: f64 = 1e6;
/// Code of an unknown value or error.
const UNKNOWN: u16 = u16::MAX;

/// Names, units and values of the spectra, in order.
const SPECTRA: [(&str, &str, fn(&PrintRow) -> Option<Estimate>); 4] = [
    ("under a uniform sky", "share of a perfect white", |row| row.natural_light),
    ("lit at 45°, seen at 0°", "share of a perfect white", |row| row.lit_at_45),
    ("transmittance of the layer", "share of the light", |row| Some(row.transmittance)),
    ("reflectance of the layer", "share of the light", |row| Some(row.reflectance)),
];

/// The page as HTML.
pub(super) fn page(sweep: &Sweep, reported: &Reported, between: Option<&VariantsBetween>) -> String {
    let Reported { outcomes, nearest, .. } = reported;
    let outline = &sweep.outline;
    let wavelengths_nm = wavelengths_nm(outcomes);
    let labs: Vec<Option<[f64; 3]>> = outcomes.iter().map(|o| o.colour.map(|c| c.lab)).collect();
    let axis = |(a, axis): (usize, &AxisOutline)| {
        let steps = between.and_then(|between| between.steps.get(a)).map_or(1, |&steps| steps);
        json!({
            "name": axis.heading(),
            "labels": axis.labels,
            "values": numbers(axis),
            "steps": steps,
            "between": if steps > 1 { None } else { Continuous::new(outline, &labs, a) },
        })
    };
    let solved = (0..outcomes.len()).map(|v| variant(sweep, outcomes, v, &wavelengths_nm));
    let between = between.iter().flat_map(|between| &between.variants);
    let evaluated = between.map(|between| evaluated(sweep, outcomes, between, &wavelengths_nm));
    let variants: Vec<Value> = solved.chain(evaluated).collect();
    let data = json!({
        "title": outline.title,
        "program": made_by(),
        "reference": outcomes[outline.reference].name,
        "target": nearest.as_ref().map(|near| json!({ "colour": near.target, "nearest": near.summary })),
        "axes": Vec::from_iter(outline.axes.iter().enumerate().map(axis)),
        "spectra": SPECTRA.map(|(name, ..)| name),
        "units": SPECTRA.map(|(_, unit, _)| unit),
        "steps": STEPS,
        "lowest": LOWEST,
        "variants": variants,
        "wavelengths_nm": wavelengths_nm,
    });
    // "</script" would end the script element, "<!--<script>" hide its end
    let data = data.to_string().replace('<', "\\u003c");
    include_str!("explore.html").replace("/*style*/", STYLE).replace("/*data*/null", &data)
}

/// Wavelengths of the variant that has the most, nm.
fn wavelengths_nm(outcomes: &[Outcome]) -> Vec<f64> {
    let longest = outcomes.iter().map(Outcome::at_first_angle).max_by_key(|rows| rows.len());
    longest.unwrap_or(&[]).iter().map(|row| row.wavelength_nm).collect()
}

/// A solved variant with its picture, a PNG in base64: the first column is the strip, the rest the
/// square.
fn variant(sweep: &Sweep, outcomes: &[Outcome], number: usize, wavelengths_nm: &[f64]) -> Value {
    let outcome = &outcomes[number];
    let mut all = tabulated(sweep, outcomes, (number, outcome), wavelengths_nm);
    all["place"] = json!(sweep.outline.variants[number].place);
    all["angles"] = json!(outcome.picture.as_ref().map_or(0, |p| p.strip.len()));
    all["picture"] = json!(outcome.picture.as_ref().map_or_else(String::new, pixels));
    all
}

/// A variant between others; the page shows the picture of the nearest.
fn evaluated(sweep: &Sweep, outcomes: &[Outcome], between: &BetweenVariant, wavelengths_nm: &[f64]) -> Value {
    let mut all = tabulated(sweep, outcomes, (between.nearest, &between.outcome), wavelengths_nm);
    all["place"] = json!(between.place);
    all["nearest"] = json!(between.nearest);
    all
}

/// The numbers of an outcome with the inks of a variant: `numbers` are \[value, standard error\] of
/// L*, a*, b*, C*, h, ΔE₀₀, with a target also ΔE₀₀ to it and the contrast ratio; `spectra` holds
/// u16 in base64, of every spectrum all values, then all errors.
fn tabulated(
    sweep: &Sweep,
    outcomes: &[Outcome],
    (number, outcome): (usize, &Outcome),
    wavelengths_nm: &[f64],
) -> Value {
    let reference = &outcomes[sweep.outline.reference];
    let to_target = target_numbers(outcome).map(|e| e.map_or([None; 2], in_numbers));
    let to_target = to_target.into_iter().filter(|_| outcome.aim.is_some());
    let numbers =
        shown(sweep, number, outcome, reference).map(|all| all.into_iter().map(in_numbers).chain(to_target));
    let Count { finished, asked } = outcome.solves;
    let missing = if finished < asked { format!("{finished} of {asked} solves") } else { String::new() };
    json!({
        "name": outcome.name,
        "hex": outcome.colour.map(|c| hex(c.srgb8)),
        "numbers": numbers.map(Vec::from_iter),
        "realisations": outcome.realisations,
        "state": outcome.reason.as_ref().unwrap_or(&missing),
        "spectra": spectra(&outcome.spectra, wavelengths_nm),
    })
}

/// Value and standard error, rounded; none where not finite.
fn in_numbers(e: Estimate) -> [Option<f64>; 2] {
    [Some(e.value), e.standard_error]
        .map(|x| Some((x? * NUMBERS).round() / NUMBERS).filter(|x| x.is_finite()))
}

fn spectra(rows: &[PrintRow], wavelengths_nm: &[f64]) -> String {
    let mut bytes = Vec::new();
    for (.., kind) in SPECTRA {
        let estimates: Vec<Option<Estimate>> = wavelengths_nm
            .iter()
            .map(|&nm| rows.iter().find(|row| (row.wavelength_nm - nm).abs() < 1e-6).and_then(kind))
            .collect();
        let values = estimates.iter().map(|e| e.map(|e| e.value - LOWEST));
        let errors = estimates.iter().map(|e| e.and_then(|e| e.standard_error));
        values.chain(errors).for_each(|x| bytes.extend(counted(x).to_le_bytes()));
    }
    STANDARD.encode(bytes)
}

fn counted(value: Option<f64>) -> u16 {
    let Some(v) = value.filter(|v| v.is_finite()) else { return UNKNOWN };
    (v * STEPS).round().clamp(0.0, f64::from(UNKNOWN - 1)) as u16
}

fn pixels(picture: &ScreenPicture) -> String {
    let side = picture.strip.len();
    // a picture without rows shows nothing
    let Ok(mut bitmap) = Bitmap::white(side + 1, side) else { return String::new() };
    for (y, &colour) in picture.strip.iter().enumerate() {
        bitmap.fill([0, y], [1, 1], colour);
    }
    for (y, colours) in picture.square.iter().enumerate() {
        for (x, &colour) in colours.iter().enumerate() {
            bitmap.fill([x + 1, y], [1, 1], colour);
        }
    }
    bitmap.png(&[]).map_or_else(|_| String::new(), |png| STANDARD.encode(png))
}

#[cfg(test)]
#[path = "explore_tests.rs"]
mod tests;
