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
    let rising = table.along.iter().all(|x| x.is_finite()) && table.along.windows(2).all(|w| w[0] < w[1]);
    if table.along.len() != table.among.len() || !rising || table.along.len() == 1 {
        let allowed = "a number for every variant in among, rising, 2 or more";
        wrong("along", &format!("{} places", table.along.len()), allowed);
    }
    for (key, found, allowed) in contradictions(table) {
        wrong(key, found, allowed);
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
}

/// Keys that contradict each other: key, what was found, what is allowed.
fn contradictions(
    table: &ConclusionTable,
) -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    let (curve, ranged) = (!table.along.is_empty(), table.range_nm.is_some());
    let (delta_e, unbound) = (table.quantity == Quantity::DeltaE, table.at_least.or(table.at_most).is_none());
    let colours = (table.plus.len(), table.minus.len());
    let unowned = table.source.is_none();
    let (range, source) = ("a range of wavelengths, range_nm = [from, to]", "source = \"…\" beside it");
    let all = [
        (curve && (delta_e || ranged), "among", "a curve", "a curve of one quantity, at one wavelength"),
        (!ranged && table.over != Over::Every, "over", "no range_nm", range),
        (!ranged && table.absorbed_by.is_some(), "absorbed_by", "no range_nm", range),
        (table.absolute && curve, "absolute", "a curve", "sums and differences without a curve"),
        (unowned && table.quote.is_some(), "quote", "a quotation without a source", source),
        (unowned && table.translation.is_some(), "translation", "a quotation without a source", source),
        (unbound, "at_least", "nothing", "a bound: at_least, at_most or both"),
        (table.plus.is_empty(), "plus", "no variant", "one variant or more"),
        (
            delta_e && colours != (1, 1),
            "plus",
            "other numbers of colours",
            "one colour in plus and one in minus",
        ),
    ];
    all.into_iter().filter(|(there, ..)| *there).map(|(_, key, found, allowed)| (key, found, allowed))
}
