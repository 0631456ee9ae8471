//! What the keywords of a CGATS file say of how its samples were measured.

use crate::input::measured::MeasuredCondition;
use crate::input::measured::fields::Declared;
use crate::input::measured::quantity::other_quantity;
use crate::input::measured::sample::StatedViewing;
use crate::input::measured::words::{self, MeasuredKind};
use crate::material::text_table::number;

/// Keywords whose text says nothing of how was measured: names, dates, and the print itself.
const SILENT: [&str; 14] = [
    "ORIGINATOR",
    "DESCRIPTOR",
    "CREATED",
    "MANUFACTURER",
    "MANUFACTURE",
    "MATERIAL",
    "SERIAL",
    "PROD_DATE",
    "PRINT_CONDITIONS",
    "TARGET_TYPE",
    "STUDY_HASH",
    "SPECTRA_NOTE",
    "LAB_NOTE",
    "KEYWORD",
];

/// What the keywords declare for all samples of a table.
pub(super) fn declared(header: &[(String, String)]) -> Declared {
    let mut all = Declared::default();
    let mut viewing = StatedViewing::default();
    let mut said = StatedViewing::default();
    let mut conditions = Vec::new();
    let add = |list: &mut Vec<String>, names: Vec<String>| {
        for name in names {
            if !list.iter().any(|known| known.eq_ignore_ascii_case(&name)) {
                list.push(name);
            }
        }
    };
    // the keywords of ProfileMaker that begin with LGO describe inks and the chart
    let tells = |keyword: &str| !SILENT.contains(&keyword) && !keyword.starts_with("LGO");
    for (keyword, value) in header.iter().filter(|(keyword, _)| tells(keyword)) {
        let lower = value.to_lowercase();
        let is_about =
            |word: &str| keyword.contains(word) || lower.trim_start().starts_with(&word.to_lowercase());
        if keyword == "SPECTRAL_NORM" || keyword == "SPEC_SCALE" {
            all.white = number(value, true).filter(|white| white.is_finite() && *white > 0.0);
        } else if all.white.is_none() && (keyword.contains("SPECTRAL") || keyword.contains("REFLECTANCE")) {
            all.white = white_in_words(&lower);
        }
        if [
            "MEAS_TYPE",
            "MEASUREMENT_TYPE",
            "MEASUREMENT_MODE",
            "MEASUREMENT_SOURCE",
            "MEASUREMENT_GEOMETRY",
            "DEVICE_CLASS",
        ]
        .contains(&keyword.as_str())
        {
            all.kind =
                MeasuredKind::of(value).filter(|kind| *kind != MeasuredKind::Reflectance).unwrap_or(all.kind);
        }
        let says_quantity = ["UNIT", "TYPE", "QUANTITY", "MODE", "ORDINATE", "DATA", "FORMAT"]
            .iter()
            .any(|word| keyword.contains(word));
        if says_quantity
            && (keyword.contains("SPECTR") || keyword.contains("MEAS") || keyword.starts_with('Y'))
        {
            all.kind = other_quantity(value).unwrap_or(all.kind);
        }
        if is_about("ILLUMINA") && !keyword.contains("MEASUREMENT_SOURCE") && !lower.contains('=') {
            add(&mut viewing.illuminants, words::stated_illuminant(value).into_iter().collect());
        } else if is_about("OBSERVER") && !lower.contains('=') {
            add(&mut viewing.observers, words::stated_observer(value).into_iter().collect());
        } else {
            add(&mut said.illuminants, words::illuminants(value));
            add(&mut said.observers, words::observers(value));
        }
        for condition in words::conditions(value) {
            if !conditions.contains(&condition) {
                conditions.push(condition);
            }
        }
        if keyword == "FILTER" && lower.starts_with("polari") {
            conditions.push(MeasuredCondition::M3);
        }
        for geometry in words::geometries(value) {
            if !all.geometries.contains(&geometry) {
                all.geometries.push(geometry);
            }
        }
    }
    // one sphere said in several ways is one
    let spheres =
        |geometry: &words::MeasuredGeometry| matches!(geometry, words::MeasuredGeometry::Sphere(Some(_)));
    if all.geometries.iter().any(spheres) {
        all.geometries.retain(|geometry| *geometry != words::MeasuredGeometry::Sphere(None));
    }
    all.condition = if let [one] = conditions[..] { Some(one) } else { None };
    // keywords of their own go before words elsewhere
    let first_of = |keyword: Vec<String>, said: Vec<String>| if keyword.is_empty() { said } else { keyword };
    all.viewing = StatedViewing {
        illuminants: first_of(viewing.illuminants, said.illuminants),
        observers: first_of(viewing.observers, said.observers),
    };
    all
}

/// The white that a keyword on reflectances states in words.
fn white_in_words(lower: &str) -> Option<f64> {
    if lower.contains('%') || lower.contains("percent") {
        return Some(100.0);
    }
    (lower.contains("factor")
        || lower.contains("decimal")
        || lower.contains("0-1")
        || lower.contains("0 to 1"))
    .then_some(1.0)
}
