//! Inequalities as text.

use super::{Claim, Outcome, Quantity};
use crate::sweep::definition::file::Over;

/// The inequality of a conclusion, such as "C*(a) − C*(b) ≥ 5".
pub(super) fn inequality(claim: &Claim, outcomes: &[Outcome]) -> String {
    let at = match (claim.table.wavelength_nm, claim.table.range_nm) {
        (Some(nm), _) => format!("{nm:.0}"),
        (None, Some([from, to])) => format!("{from:.0}–{to:.0}"),
        (None, None) => String::new(),
    };
    let symbol = match claim.table.quantity {
        Quantity::Chroma => "C*".to_owned(),
        Quantity::Lightness => "L*".to_owned(),
        Quantity::Hue => "h".to_owned(),
        Quantity::Transmittance => format!("T{at}"),
        Quantity::Reflectance => format!("R{at}"),
        Quantity::ContrastRatio => "contrast ratio".to_owned(),
        Quantity::DeltaEToTarget => "ΔE₀₀ to the target".to_owned(),
        Quantity::DeltaE => {
            let name = |v: &[usize]| v.first().map_or_else(String::new, |&v| outcomes[v].labels.join(", "));
            return bounded(claim, &format!("ΔE₀₀({}; {})", name(&claim.plus), name(&claim.minus)));
        }
    };
    let term = |v: &usize| format!("{symbol}({})", outcomes[*v].labels.join(", "));
    let plus: Vec<String> = claim.plus.iter().map(term).collect();
    let minus: String = claim.minus.iter().map(|v| format!(" − {}", term(v))).collect();
    let sum = format!("{}{minus}", plus.join(" + "));
    let sum = if claim.table.absolute { format!("|{sum}|") } else { sum };
    let what = if claim.among.is_empty() { sum } else { format!("place with the same {sum}") };
    bounded(claim, &what) + &wavelengths(claim, outcomes)
}

fn bounded(claim: &Claim, what: &str) -> String {
    let bound = |x: f64| x.to_string().replace('-', "−");
    match (claim.table.at_least, claim.table.at_most) {
        (Some(low), Some(high)) => format!("{} ≤ {what} ≤ {}", bound(low), bound(high)),
        (Some(low), None) => format!("{what} ≥ {}", bound(low)),
        (_, high) => format!("{what} ≤ {}", bound(high.unwrap_or(f64::INFINITY))),
    }
}

/// Describes the selected wavelengths; empty if the whole range counts.
fn wavelengths(claim: &Claim, outcomes: &[Outcome]) -> String {
    let over = match claim.table.over {
        Over::Every => "",
        Over::Some => ", at some wavelength",
        Over::Mean => ", on the mean",
    };
    let absorbed = claim.absorbed_by.map(|v| outcomes[v].labels.join(", "));
    let absorbed = absorbed.map(|name| format!(", where {name} absorbs well (lower half of its T)"));
    format!("{over}{}", absorbed.unwrap_or_default())
}
