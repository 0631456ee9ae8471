//! Weighted numbers in words and as a table.

use crate::draw::cell::{numbers, table, text, with_errors};
use crate::evaluate::published::NumberNote;
use crate::numerics::estimate::Estimate;
use crate::report::columns::NamedTable;
use serde::Serialize;

/// A weighted number on a page.
#[derive(Debug, Serialize)]
pub(super) struct NumberLine {
    name: String,
    value: String,
    about: String,
}

/// Significant digits of an error.
const DIGITS: i32 = 2;
/// Smaller errors are rounding, and are not shown.
const CERTAIN: f64 = 1e-7;
/// Decimals of a number whose error is unknown or nothing.
const USUAL_DECIMALS: usize = 4;

/// A number with as many decimals as its error has.
fn value(note: &NumberNote) -> String {
    let Some(estimate) = note.estimate() else { return "withheld".to_owned() };
    let error = estimate.standard_error.filter(|error| *error > CERTAIN);
    let decimals = error.map_or(USUAL_DECIMALS as i32, |error| DIGITS - 1 - error.log10().floor() as i32);
    Estimate { standard_error: error, ..estimate }.in_words(decimals.clamp(0, 6) as usize)
}

/// The name, with the thickness of a composed layer.
fn name(note: &NumberNote) -> String {
    note.thickness_um.map_or_else(|| note.name.clone(), |um| format!("{um} µm, {}", note.name))
}

/// The main numbers in a line each.
pub(super) fn in_words(notes: &[NumberNote]) -> Vec<String> {
    notes.iter().map(|note| format!("{} {}", name(note), value(note))).collect()
}

/// The lines of a page, with what the errors are made of.
pub(super) fn lines(notes: &[NumberNote]) -> Vec<NumberLine> {
    let line = |note: &NumberNote| NumberLine {
        name: name(note),
        value: value(note),
        about: format!("{}; {}", note.about, parts(note)),
    };
    notes.iter().map(line).collect()
}

/// The parts of an error that are there.
fn parts(note: &NumberNote) -> String {
    if note.standard_error.is_none() {
        return "its error is unknown".to_owned();
    }
    let parts = note.parts;
    let all = [
        ("chance", parts.chance),
        ("composing", parts.model),
        ("grid", parts.grid),
        ("directions", parts.directions),
        ("wavelengths", parts.wavelengths),
        ("tables of indices", parts.inputs),
    ];
    let named: Vec<String> = all
        .into_iter()
        .filter(|(_, part)| *part > 0.0)
        .map(|(name, part)| format!("{name} {part:.1e}"))
        .collect();
    match named.as_slice() {
        [] => "without an error".to_owned(),
        named => format!("parts of its error: {}", named.join(", ")),
    }
}

/// `numbers.csv`; none without numbers.
pub(super) fn numbers_table(notes: &[NumberNote]) -> csv::Result<Option<NamedTable>> {
    if notes.is_empty() {
        return Ok(None);
    }
    let header = ["name", "thickness_um", "about"].map(str::to_owned).into_iter();
    let rows = notes.iter().map(|note| {
        let thickness_um = note.thickness_um.map_or_else(String::new, |um| um.to_string());
        ([text(&note.name), thickness_um, text(&note.about)], numbers(note.estimate()))
    });
    let bytes = table(header.chain(with_errors(["value"])), rows)?;
    Ok(Some(("numbers.csv", bytes, "weighted numbers of the spectra")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::published::NumberParts;

    #[test]
    fn numbers_have_the_digits_of_their_errors() {
        let note = |value, error| NumberNote {
            name: "solar reflectance".to_owned(),
            thickness_um: Some(20.0),
            value,
            standard_error: error,
            parts: NumberParts { chance: 0.003, ..NumberParts::default() },
            deviations: Vec::new(),
            about: "mean".to_owned(),
        };
        let notes = [note(Some(0.81234), Some(0.0034)), note(Some(43.21), Some(0.6)), note(None, None)];
        let words = in_words(&notes);
        assert_eq!(words[0], "20 µm, solar reflectance 0.8123 ± 0.0034");
        assert_eq!(words[1], "20 µm, solar reflectance 43.21 ± 0.60");
        assert_eq!(words[2], "20 µm, solar reflectance withheld");
        assert!(lines(&notes)[0].about.ends_with("parts of its error: chance 3.0e-3"));
        let (_, bytes, _) = numbers_table(&notes).unwrap().unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert_eq!(text.lines().next().unwrap(), "name,thickness_um,about,value,value_standard_error");
        assert_eq!(text.lines().last().unwrap(), "solar reflectance,20,mean,,");
        assert!(numbers_table(&[]).unwrap().is_none());
    }
}
