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
use crate::appearance::picture::InkPicture;
use crate::draw::figure::Bitmap;
use crate::evaluate::manifest::{Count, SpectrumRow};
use crate::numerics::estimate::Estimate;
use crate::report::page::{STYLE, hex, made_by};
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
const SPECTRA: [(&str, &str, fn(&SpectrumRow) -> Option<Estimate>); 4] = [
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

fn spectra(rows: &[SpectrumRow], wavelengths_nm: &[f64]) -> String {
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

fn pixels(picture: &InkPicture) -> String {
    let side = picture.strip.len();
    // a picture without rows shows nothing
    let Ok(mut bitmap) = Bitmap::white(side + 1, side) else { return String::new() };
    for (y, colour) in picture.strip.iter().enumerate() {
        bitmap.fill([0, y], [1, 1], colour.srgb8);
    }
    for ((y, x), colour) in picture.square.indexed_iter() {
        bitmap.fill([x + 1, y], [1, 1], colour.srgb8);
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
    let (h, inner) = (xs[k + 1] - xs[k], [k > 0, k + 2 < xs.len()]);
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
mod tests {
    use super::*;
    use crate::appearance::colour::{Colorimeter, Colour};
    use crate::evaluate::ink_maker::Target;
    use crate::sweep::definition::load::{Outline, Place};
    use ndarray::Array2;

    /// A variant with all numbers, and noise in all digits.
    fn finished(name: String, wavelengths_nm: &[f64], seed: u64) -> Outcome {
        let mut draws = crate::numerics::Draws::new(seed, 0);
        let mut number = || Estimate { value: draws.uniform(), standard_error: Some(0.01 * draws.uniform()) };
        let mut row = |polar_deg: f64, &wavelength_nm: &f64| SpectrumRow {
            wavelength_nm,
            polar_deg,
            reflectance: number(),
            specular_reflectance: number(),
            transmittance: number(),
            specular_transmittance: number(),
            absorptance: number(),
            natural_light: Some(number()),
            lit_at_45: Some(number()),
            deviations: Vec::new(),
        };
        let at = |polar_deg: f64| wavelengths_nm.iter().map(move |nm| (polar_deg, nm));
        let spectra: Vec<SpectrumRow> = at(0.0).chain(at(45.0)).map(|(deg, nm)| row(deg, nm)).collect();
        let values: Vec<f64> =
            spectra[..wavelengths_nm.len()].iter().map(|row| row.reflectance.value).collect();
        let colour = Colorimeter::new(wavelengths_nm).unwrap().colour(&values).unwrap();
        let covariance = Some([[0.1234567, 0.01, 0.0], [0.01, 0.2345678, 0.0], [0.0, 0.0, 0.3456789]]);
        let colour = Colour { lab_covariance: covariance, ..colour };
        let (lab, deviations) = ([70.1, -5.2, 40.3], Vec::new());
        let target = Target { lab, delta_e_2000: number(), deviations };
        let contrast = Some((number(), Vec::new()));
        let solves = Count { asked: 24, finished: 24 };
        let labels = vec![name.clone(), name.clone(), name.clone()];
        // colours that vary from angle to angle, like those of inks
        let at = |x: usize, y: usize| {
            let srgb8 = [250 - 2 * x - y, 230 - x - 2 * y, 90 + x * y / 16].map(|c| c as u8);
            Colour { srgb8, ..colour }
        };
        let picture = InkPicture {
            angles_deg: vec![0.0; 31],
            strip: (0..31).map(|y| at(0, y)).collect(),
            square: Array2::from_shape_fn((31, 31), |(y, x)| at(x, y)),
        };
        Outcome {
            name,
            labels,
            solves,
            failures: 0,
            reason: None,
            realisations: 24,
            certain: false,
            colour: Some(colour),
            lab_deviations: Default::default(),
            contrast,
            aim: Some("L* 70.1, a* −5.2, b* 40.3 (D65, 2° observer)".into()),
            target: Some(target),
            print_hex: None,
            spectra,
            picture: Some(picture),
        }
    }

    /// The paper's study: 5 × 4 × 13 variants, 16 wavelengths at two angles, pictures of 31 × 31.
    /// *Planted*: uncompressed pictures take 1 MB more; with the wavelengths of both angles the
    /// curves would run back.
    #[test]
    fn a_page_of_260_variants_stays_below_1_megabyte() {
        let nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
        let axis = |name: &str, n: usize| AxisOutline {
            name: name.into(),
            labels: (0..n).map(|k| format!("{name} number {k}")).collect(),
            unit: String::new(),
        };
        let place = |i: usize| Place {
            name: format!("a_rather_long_name_of_a_variant_of_the_study-{i}"),
            place: vec![i / 52, i / 13 % 4, i % 13],
        };
        let outline = Outline {
            title: "The paper's study".into(),
            axes: vec![axis("ink", 5), axis("share", 4), axis("grains", 13)],
            sheet: Default::default(),
            reference: 0,
            reference_asked: false,
            claims: Vec::new(),
            variants: (0..260).map(place).collect(),
        };
        let all = (0..260).map(|i| finished(outline.variants[i].name.clone(), &nm, i as u64));
        let outcomes: Vec<Outcome> = all.collect();
        let sweep = Sweep { outline, variants: Vec::new(), inputs: Vec::new() };
        assert_eq!(wavelengths_nm(&outcomes), nm);
        let nearest = super::super::reported::nearest(&sweep.outline, &outcomes);
        let bytes = page(&sweep, &Reported { outcomes, conclusions: Vec::new(), nearest }).len();
        assert!((200_000..1_000_000).contains(&bytes), "{bytes} bytes");
    }

    #[test]
    fn values_travel_to_a_twenty_thousandth() {
        let there = |x: f64| f64::from(counted(Some(x - LOWEST))) / STEPS + LOWEST;
        for x in [-0.05, 0.0, 0.123_456, 1.0, 1.3] {
            assert!((there(x) - x).abs() <= 0.5 / STEPS + 1e-12, "{x}");
        }
        assert_eq!((counted(None), counted(Some(f64::NAN))), (UNKNOWN, UNKNOWN));
    }

    fn outline(labels: [&[&str]; 2]) -> Outline {
        let axis = |labels: &[&str]| AxisOutline {
            name: "size".into(),
            labels: labels.iter().map(|l| (*l).to_owned()).collect(),
            unit: String::new(),
        };
        let place = |i: usize, j: usize| Place { name: format!("{i}-{j}"), place: vec![i, j] };
        let inner = labels[1].len();
        Outline {
            title: String::new(),
            axes: labels.map(axis).to_vec(),
            sheet: Default::default(),
            reference: 0,
            reference_asked: false,
            claims: Vec::new(),
            variants: (0..labels[0].len() * inner).map(|v| place(v / inner, v % inner)).collect(),
        }
    }

    /// L* = 50 + x² at −2, …, 2, two times: without an inner x the cubic (at 0: slopes −1 and 1 at
    /// −1 and 1) and the parabolas (at −1 and 1) miss by 1/2, where lines miss by 1.
    /// *Planted*: without the bends this gives the errors of lines.
    #[test]
    fn leaving_one_out_of_a_parabola_misses_by_a_half() {
        let outline = outline([&["red", "blue"], &["-2 nm", "-1 nm", "0 nm", "1 nm", "2 nm"]]);
        let lab = |x: f64| [50.0 + x * x, 0.0, 0.0];
        let labs: Vec<_> = (0..10).map(|v| Some(lab(f64::from(v % 5) - 2.0))).collect();
        let axis = Continuous::new(&outline, &labs, 1).unwrap();
        let missed = |v: usize| labs[v].map(|[l, ..]| ciede2000([l + 0.5, 0.0, 0.0], [l, 0.0, 0.0]));
        for v in 0..10 {
            let expected = (1..4).contains(&(v % 5)).then(|| missed(v).unwrap());
            assert!((axis.left_out[v].unwrap_or(9.0) - expected.unwrap_or(9.0)).abs() < 1e-9, "{axis:?}");
        }
        assert!(axis.values == [-2.0, -1.0, 0.0, 1.0, 2.0] && !axis.logarithmic);
        assert!((axis.median - missed(1).unwrap()).abs() < 1e-9, "{axis:?}");
    }

    #[test]
    fn a_colour_linear_in_the_logarithm_is_interpolated_in_it() {
        let outline = outline([&["1"], &["800", "400", "200", "100"]]);
        let labs = [60.0, 50.0, 40.0, 30.0].map(|l| Some([l, 0.0, 0.0]));
        let axis = Continuous::new(&outline, &labs, 1).unwrap();
        assert!(axis.logarithmic && axis.median < 1e-9, "{axis:?}");
    }

    #[test]
    fn axes_with_two_values_words_or_gaps_stay_discrete() {
        let is_continuous = |labels: &[&str], gaps: usize| {
            let mut outline = outline([&["1", "2"], labels]);
            outline.variants.truncate(outline.variants.len() - gaps);
            Continuous::new(&outline, &vec![Some([50.0, 0.0, 0.0]); outline.variants.len()], 1).is_some()
        };
        assert!(is_continuous(&["1 nm", "2 nm", "4 nm"], 0));
        for labels in [&["1 nm", "2 nm"][..], &["1 nm", "2 µm", "4 µm"], &["1", "2", "all"], &["1", "3", "2"]]
        {
            assert!(!is_continuous(labels, 0), "{labels:?}");
        }
        assert!(!is_continuous(&["1 nm", "2 nm", "4 nm"], 1));
        let (three, unsolved) =
            (outline([&["1"], &["1", "2", "3"]]), [Some([50.0; 3]), None, Some([50.0; 3])]);
        assert!(Continuous::new(&three, &unsolved, 1).is_none());
    }

    #[test]
    fn weights_reproduce_lines_and_settings() {
        let xs = [1.0, 2.0, 5.0, 20.0];
        for (k, t) in [(0, 0.3), (1, 0.5), (2, 0.9), (2, 1.0)] {
            let weights = weights(&xs, k, t);
            let x: f64 = weights.iter().zip(xs).map(|(w, x)| w * x).sum();
            assert!((x - (xs[k] + t * (xs[k + 1] - xs[k]))).abs() < 1e-12, "{weights:?}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
        }
        assert_eq!(weights(&xs, 1, 0.0), [0.0, 1.0, 0.0, 0.0]);
    }
}
