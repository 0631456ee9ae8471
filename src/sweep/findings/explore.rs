//! The interactive page of a sweep: sliders for its axes; for the selected variant its swatch,
//! spectra, numbers with errors and picture. Between solved settings that are numbers it
//! interpolates, with the leave-one-out error. One file, no network.
//!
//! Spectra are stored as 16-bit multiples of 1/20 000, pictures as PNG and numbers to a millionth,
//! so that 260 variants take less than 1 MB; `sweep.csv` has all digits.

use super::between::Continuous;
use super::outcome::Outcome;
use super::reported::{Reported, shown, target_numbers};
use crate::appearance::picture::InkPicture;
use crate::draw::figure::Bitmap;
use crate::evaluate::manifest::{Count, SpectrumRow};
use crate::numerics::estimate::Estimate;
use crate::report::page::{STYLE, hex, made_by};
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
    value
        .filter(|v| v.is_finite())
        .map_or(UNKNOWN, |v| (v * STEPS).round().clamp(0.0, f64::from(UNKNOWN - 1)) as u16)
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
}
