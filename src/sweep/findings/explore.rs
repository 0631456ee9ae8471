//! The interactive page of a sweep: sliders for its axes; for the selected variant its swatch,
//! spectra, numbers with errors and picture. Between solved settings that are numbers it
//! interpolates, with the leave-one-out error. One file, no network.
//!
//! Spectra are stored as 16-bit multiples of 1/20 000, pictures as PNG and numbers to a millionth,
//! so that 260 variants take less than 1 MB; `sweep.csv` has all digits.
//!
//! Interpolation between the solved settings of an axis, for the sliders of the explorer, with the
//! leave-one-out error of the colour. `explore.html` has the same [`weights`] in JavaScript.

use super::outcome::Outcome;
use super::reported::{Reported, shown, target_numbers};
use crate::appearance::colour::ciede2000;
use crate::appearance::picture::ScreenPicture;
use crate::draw::figure::Bitmap;
use crate::draw::page::{STYLE, hex, made_by};
use crate::evaluate::manifest::Count;
use crate::evaluate::manifest::main_numbers::PrintRow;
use crate::numerics::estimate::Estimate;
use crate::sweep::definition::load::{AxisOutline, Outline, Sweep};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

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
pub fn page(sweep: &Sweep, Reported { outcomes, nearest, .. }: &Reported) -> String {
    let outline = &sweep.outline;
    let wavelengths_nm = wavelengths_nm(outcomes);
    let labs: Vec<Option<[f64; 3]>> = outcomes.iter().map(|o| o.colour.map(|c| c.lab)).collect();
    let axis = |(a, axis): (usize, &AxisOutline)| {
        let between = Continuous::new(outline, &labs, a);
        json!({ "name": axis.heading(), "labels": axis.labels, "between": between })
    };
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
        "variants": Vec::from_iter((0..outcomes.len()).map(|v| variant(sweep, outcomes, v, &wavelengths_nm))),
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

/// A variant: `numbers` are \[value, standard error\] of L*, a*, b*, C*, h, ΔE₀₀, with a target
/// also ΔE₀₀ to it and the contrast ratio; `spectra` holds u16 in base64, of every spectrum all
/// values, then all errors; the first column of `picture`, a PNG in base64, is the strip, the rest
/// the square.
fn variant(sweep: &Sweep, outcomes: &[Outcome], number: usize, wavelengths_nm: &[f64]) -> Value {
    let outcome = &outcomes[number];
    let to_target = target_numbers(outcome).map(|e| e.map_or([None; 2], in_numbers));
    let to_target = to_target.into_iter().filter(|_| outcome.aim.is_some());
    let numbers = shown(sweep, number, outcomes).map(|all| all.into_iter().map(in_numbers).chain(to_target));
    let Count { finished, asked } = outcome.solves;
    let missing = if finished < asked { format!("{finished} of {asked} solves") } else { String::new() };
    json!({
        "name": outcome.name,
        "place": sweep.outline.variants[number].place,
        "hex": outcome.colour.map(|c| hex(c.srgb8)),
        "numbers": numbers.map(Vec::from_iter),
        "realisations": outcome.realisations,
        "state": outcome.reason.as_ref().unwrap_or(&missing),
        "spectra": spectra(&outcome.spectra, wavelengths_nm),
        "angles": outcome.picture.as_ref().map_or(0, |p| p.strip.len()),
        "picture": outcome.picture.as_ref().map_or_else(String::new, pixels),
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

/// Fewest settings to interpolate between: an inner one must be left out.
const FEWEST: usize = 3;

/// An axis whose settings are numbers, all with results.
#[derive(Debug, Serialize)]
pub(super) struct Continuous {
    /// Numbers of the settings, rising or falling.
    pub values: Vec<f64>,
    /// Whether their logarithms are interpolated instead, because the median is smaller.
    pub logarithmic: bool,
    /// Median of all leave-one-out errors, ΔE₀₀.
    pub median: f64,
    /// ΔE₀₀ between each variant's colour and that interpolated from the others along the axis;
    /// `None` for the first and last setting.
    pub left_out: Vec<Option<f64>>,
}

impl Continuous {
    /// Axis `a`, with L*, a*, b* of every variant; `None` if it has fewer than three numbers or one
    /// of its variants has no colour.
    pub fn new(outline: &Outline, labs: &[Option<[f64; 3]>], a: usize) -> Option<Self> {
        let values = numbers(&outline.axes[a])?;
        let lines = lines(outline, a)?;
        let labs = labs.iter().copied().collect::<Option<Vec<_>>>()?;
        let logarithms = values[0].min(values[values.len() - 1]) > 0.0;
        let judged = [false, true].into_iter().filter(|&log| logarithms || !log).filter_map(|logarithmic| {
            let xs: Vec<f64> = values.iter().map(|&x| if logarithmic { x.ln() } else { x }).collect();
            let left_out = left_out(&xs, &lines, &labs);
            Some(Self { values: values.clone(), logarithmic, median: median(&left_out)?, left_out })
        });
        judged.min_by(|one, other| one.median.total_cmp(&other.median))
    }
}

/// The numbers of an axis if all labels are numbers with one unit, in order.
fn numbers(axis: &AxisOutline) -> Option<Vec<f64>> {
    let values: Vec<f64> = (0..axis.labels.len()).map(|k| axis.number(k)).collect::<Option<_>>()?;
    let one_unit =
        axis.labels.windows(2).all(|l| l[0].split_whitespace().nth(1) == l[1].split_whitespace().nth(1));
    let in_order = values.is_sorted_by(|x, y| x < y) || values.is_sorted_by(|x, y| x > y);
    (one_unit && in_order && values.len() >= FEWEST).then_some(values)
}

/// The variants along an axis, for every combination of the other settings; `None` if some are
/// missing.
fn lines(outline: &Outline, a: usize) -> Option<Vec<Vec<usize>>> {
    let settings = outline.axes[a].labels.len();
    let mut lines: BTreeMap<Vec<usize>, Vec<Option<usize>>> = BTreeMap::new();
    for (v, variant) in outline.variants.iter().enumerate() {
        let mut others = variant.place.clone();
        let k = others.remove(a);
        lines.entry(others).or_insert_with(|| vec![None; settings])[k] = Some(v);
    }
    lines.into_values().map(|line| line.into_iter().collect()).collect()
}

/// Leave-one-out errors of all variants, ΔE₀₀.
fn left_out(xs: &[f64], lines: &[Vec<usize>], labs: &[[f64; 3]]) -> Vec<Option<f64>> {
    let mut errors = vec![None; labs.len()];
    for k in 1..xs.len() - 1 {
        let mut others = xs.to_vec();
        let x = others.remove(k);
        let weights = weights(&others, k - 1, (x - xs[k - 1]) / (xs[k + 1] - xs[k - 1]));
        for line in lines {
            let near = line.iter().filter(|&&v| v != line[k]).zip(&weights);
            let lab = near.fold([0.0; 3], |sum, (&v, w)| std::array::from_fn(|i| sum[i] + w * labs[v][i]));
            errors[line[k]] = Some(ciede2000(lab, labs[line[k]]));
        }
    }
    errors
}

fn median(errors: &[Option<f64>]) -> Option<f64> {
    let mut all: Vec<f64> = errors.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied()
}

/// Weights of values at `xs` for the point `t` = 0…1 between `xs[k]` and `xs[k + 1]`: the cubic
/// whose slope at an inner `x` is that of the chord through both neighbours, so that uneven
/// distances cause no large overshoot; at an end the parabola, with two values the line.
fn weights(xs: &[f64], k: usize, t: f64) -> Vec<f64> {
    let h = xs[k + 1] - xs[k];
    let inner = [k > 0, k + 2 < xs.len()];
    let (here, there) = (h * t * (1.0 - t).powi(2), -h * t * t * (1.0 - t));
    // by how much the slopes at both ends differ from that of the line
    let bends = match inner {
        [true, true] => [here, there],
        [true, false] => [here - there, 0.0],
        [false, true] => [0.0, there - here],
        [false, false] => [0.0; 2],
    };
    let mut weights = vec![0.0; xs.len()];
    (weights[k], weights[k + 1]) = (1.0 - t, t);
    for (bend, [i, j]) in bends.into_iter().zip([[k.saturating_sub(1), k + 1], [k, k + 2]]) {
        if bend != 0.0 {
            let chord = bend / (xs[j] - xs[i]);
            weights[j] += chord;
            weights[i] -= chord;
            weights[k + 1] -= bend / h;
            weights[k] += bend / h;
        }
    }
    weights
}

#[cfg(test)]
#[path = "explore_tests.rs"]
mod tests;
