//! Checks the keys of a conclusion.

use crate::input::fault::Faults;
use crate::sweep::definition::file::{ConclusionTable, Over, Quantity};

/// Reports errors in a conclusion's numbers: wavelengths, abscissas of a curve, bounds.
pub(super) fn check(at: &str, table: &ConclusionTable, faults: &mut Faults) {
    let spectral = matches!(table.quantity, Quantity::Transmittance | Quantity::Reflectance);
    let mut wrong = |key: &str, found: &str, allowed: &str| {
        faults.add(format!("{at}.{key}"), found, allowed, "see examples/paper-study-small.toml");
    };
    match (spectral, table.wavelength_nm, table.range_nm) {
        (true, None, None) => {
            wrong("wavelength_nm", "nothing", "one of the study's wavelengths, or range_nm = [from, to]");
        }
        (true, Some(_), Some(_)) => wrong("range_nm", "both", "either wavelength_nm or range_nm"),
        (false, _, Some(_)) => {
            wrong("range_nm", "a range", "a range for transmittance and reflectance alone")
        }
        (false, Some(_), None) => {
            wrong("wavelength_nm", "a wavelength", "a wavelength for transmittance and reflectance alone");
        }
        (true, None, Some([from, to])) if !(from.is_finite() && to.is_finite() && from <= to) => {
            wrong("range_nm", &format!("[{from}, {to}]"), "the shortest wavelength and the longest");
        }
        _ => {}
    }
    let curve = !table.along.is_empty();
    let rising = table.along.iter().all(|x| x.is_finite()) && table.along.windows(2).all(|w| w[0] < w[1]);
    if table.along.len() != table.among.len() || !rising || table.along.len() == 1 {
        let allowed = "a number for every variant in among, rising, 2 or more";
        wrong("along", &format!("{} places", table.along.len()), allowed);
    }
    if curve && (table.quantity == Quantity::DeltaE || table.range_nm.is_some()) {
        wrong("among", "a curve", "a curve of one quantity, at one wavelength");
    }
    if let Some(key) = range_slip(table) {
        wrong(key, "no range_nm", "a range of wavelengths, range_nm = [from, to]");
    }
    if table.absolute && curve {
        wrong("absolute", "a curve", "sums and differences without a curve");
    }
    if let Some(key) = unowned(table) {
        wrong(key, "a quotation without a source", "source = \"…\" beside it");
    }
    if table.at_least.is_none() && table.at_most.is_none() {
        wrong("at_least", "nothing", "a bound: at_least, at_most or both");
    }
    for (key, bound) in [("at_least", table.at_least), ("at_most", table.at_most)] {
        if let Some(bound) = bound.filter(|bound| !bound.is_finite()) {
            wrong(key, &bound.to_string(), "a finite number");
        }
    }
    if let (Some(low), Some(high)) = (table.at_least, table.at_most)
        && low > high
    {
        wrong("at_most", &format!("{high}, below at_least = {low}"), "a number from at_least on");
    }
    if table.plus.is_empty() {
        wrong("plus", "no variant", "one variant or more");
    }
    if table.quantity == Quantity::DeltaE && (table.plus.len(), table.minus.len()) != (1, 1) {
        wrong("plus", "other numbers of colours", "one colour in plus and one in minus");
    }
}

/// A key that has no meaning without a range.
fn range_slip(table: &ConclusionTable) -> Option<&'static str> {
    match table.range_nm {
        Some(_) => None,
        None if table.over != Over::Every => Some("over"),
        None => table.absorbed_by.as_ref().map(|_| "absorbed_by"),
    }
}

/// A quote without a source.
fn unowned(table: &ConclusionTable) -> Option<&'static str> {
    match table.source {
        Some(_) => None,
        None if table.quote.is_some() => Some("quote"),
        None => table.translation.as_ref().map(|_| "translation"),
    }
}
