//! Numbers of the page in words.

use crate::evaluate::published::ErrorParts;
use crate::numerics::estimate::Estimate;

/// Smaller errors are rounding, and are not shown.
const CERTAIN: f64 = 1e-6;

/// A number with its error.
pub(super) fn words(judged: &ErrorParts, decimals: usize) -> String {
    let certain = judged.standard_error < CERTAIN;
    let estimate = if certain { Estimate::unknown_error(judged.value) } else { judged.estimate() };
    estimate.in_words(decimals)
}

/// A number that may be withheld.
pub(super) fn words_of(judged: Option<ErrorParts>, decimals: usize) -> String {
    judged.map_or_else(|| "withheld".to_owned(), |judged| words(&judged, decimals))
}

/// L*, a*, b* without their names.
pub(super) fn lab_of(judged: Option<[ErrorParts; 3]>) -> String {
    let Some(judged) = judged else { return "–".to_owned() };
    judged.map(|part| words(&part, 2)).join(", ")
}
