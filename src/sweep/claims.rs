//! Conclusions as written, with the variants that they speak of.

use super::axes::Axis;
use super::expand::{Draft, check_where, matches};
use super::file::{ConclusionTable, Quantity, Where};
use crate::input::fault::{Fault, Faults};
use serde::{Deserialize, Serialize};

/// A checked conclusion about variants by their number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// What is measured of each variant.
    pub quantity: Quantity,
    /// The wavelength it is measured at, nm, where one is meant.
    pub wavelength_nm: Option<f64>,
    /// The wavelengths it is measured at, nm, where it speaks of a range.
    #[serde(default)]
    pub range_nm: Option<[f64; 2]>,
    /// Numbers of the variants that count positively.
    pub plus: Vec<usize>,
    /// Numbers of the variants that count negatively.
    pub minus: Vec<usize>,
    /// Least value that confirms it.
    pub at_least: Option<f64>,
    /// Most value that confirms it.
    pub at_most: Option<f64>,
    /// Places and numbers of the variants of a curve that the value is looked up on; empty where it counts itself.
    #[serde(default)]
    pub curve: Vec<(f64, usize)>,
}

/// Finds the variants that the conclusions speak of.
pub fn claims(
    tables: &[ConclusionTable],
    axes: &[Axis],
    drafts: &[Draft],
    faults: &mut Faults,
) -> Vec<Claim> {
    for (i, table) in tables.iter().enumerate() {
        if tables[..i].iter().any(|earlier| earlier.id == table.id) {
            let (field, found) = (format!("conclusion[{i}].id"), format!("{:?} twice", table.id));
            let remedy = "conclusions.csv and the page name them by it: give each its own";
            faults.push(Fault::new(field, found, "names that differ", remedy));
        }
    }
    let tables = tables.iter().enumerate();
    tables.map(|(i, table)| claim(&format!("conclusion[{i}]"), table, axes, drafts, faults)).collect()
}

fn claim(at: &str, table: &ConclusionTable, axes: &[Axis], drafts: &[Draft], faults: &mut Faults) -> Claim {
    let mut places = |key: &str, list: &[Where]| variants(&format!("{at}.{key}"), list, axes, drafts, faults);
    let (plus, minus) = (places("plus", &table.plus), places("minus", &table.minus));
    let among = places("among", &table.among);
    check(at, table, faults);
    Claim {
        id: table.id.clone(),
        statement: table.statement.clone(),
        quantity: table.quantity,
        wavelength_nm: table.wavelength_nm,
        range_nm: table.range_nm,
        plus,
        minus,
        at_least: table.at_least,
        at_most: table.at_most,
        curve: table.along.iter().copied().zip(among).collect(),
    }
}

/// Faults of a conclusion's own numbers: wavelengths, places of a curve, bounds.
fn check(at: &str, table: &ConclusionTable, faults: &mut Faults) {
    let spectral = matches!(table.quantity, Quantity::Transmittance | Quantity::Reflectance);
    let mut wrong = |key: &str, found: &str, allowed: &str| {
        faults.push(Fault::new(format!("{at}.{key}"), found, allowed, "see examples/paper-study-small.toml"));
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
        wrong(
            "along",
            &format!("{} places", table.along.len()),
            "a number for every variant in among, rising, 2 or more",
        );
    }
    if !table.along.is_empty() && (table.quantity == Quantity::DeltaE || table.range_nm.is_some()) {
        wrong("among", "a curve", "a curve of one quantity, at one wavelength");
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

/// A claim about light speaks of wavelengths that its variants are seen at: `wavelengths_nm` has those of each variant.
pub fn check_light(claims: &[Claim], wavelengths_nm: &[&[f64]], faults: &mut Faults) {
    for (i, claim) in claims.iter().enumerate() {
        let one = claim.wavelength_nm.map(|nm| [nm - 1e-6, nm + 1e-6]);
        let Some([from, to]) = claim.range_nm.or(one) else { continue };
        let dark = |v: &&usize| !wavelengths_nm[**v].iter().any(|nm| (from..=to).contains(nm));
        let mut named = claim.plus.iter().chain(&claim.minus).chain(claim.curve.iter().map(|(_, v)| v));
        let Some(&v) = named.find(dark) else {
            faults.0.extend(claim.range_nm.and_then(|range| uneven(claim, i, wavelengths_nm, range)));
            continue;
        };
        let (key, found) = match claim.wavelength_nm {
            Some(nm) => ("wavelength_nm", nm.to_string()),
            None => ("range_nm", format!("[{from}, {to}]")),
        };
        let listed: Vec<String> = wavelengths_nm[v].iter().map(f64::to_string).collect();
        let allowed = format!("wavelengths of the study, {} nm", listed.join(", "));
        let remedy = "name one of these, or add it to [light]";
        faults.push(Fault::new(format!("conclusion[{i}].{key}"), found, allowed, remedy));
    }
}

/// A range holds wavelength by wavelength, so that all variants must be seen at the same ones of it.
fn uneven(claim: &Claim, i: usize, wavelengths_nm: &[&[f64]], [from, to]: [f64; 2]) -> Option<Fault> {
    let of = |v: usize| -> Vec<f64> {
        wavelengths_nm[v].iter().copied().filter(|nm| (from..=to).contains(nm)).collect()
    };
    let mut all = claim.plus.iter().chain(&claim.minus).map(|&v| of(v));
    let first = all.next()?;
    let near = |a: &f64, b: &f64| (a - b).abs() < 1e-6;
    let same =
        |other: &Vec<f64>| other.len() == first.len() && other.iter().zip(&first).all(|(a, b)| near(a, b));
    let other = all.find(|other| !same(other))?;
    let [first, other] =
        [&first, &other].map(|nm| nm.iter().map(f64::to_string).collect::<Vec<_>>().join(", "));
    let (field, found) =
        (format!("conclusion[{i}].range_nm"), format!("{first} nm of one variant, {other} nm of another"));
    let remedy = "give them the same [light], or a range in which they agree";
    Some(Fault::new(field, found, "the same wavelengths of the range in all variants", remedy))
}

/// The variants that a list of conditions names, one each.
fn variants(field: &str, list: &[Where], axes: &[Axis], drafts: &[Draft], faults: &mut Faults) -> Vec<usize> {
    let one = |(k, condition)| one_variant(&format!("{field}[{k}]"), condition, axes, drafts, faults);
    list.iter().enumerate().filter_map(one).collect()
}

fn one_variant(
    field: &str,
    condition: &Where,
    axes: &[Axis],
    drafts: &[Draft],
    faults: &mut Faults,
) -> Option<usize> {
    check_where(field, condition, axes, faults);
    let fitting: Vec<usize> =
        (0..drafts.len()).filter(|&d| matches(condition, axes, &drafts[d].place)).collect();
    if let [one] = fitting[..] {
        return Some(one);
    }
    let found = format!("{} variants", fitting.len());
    faults.push(Fault::new(
        field,
        found,
        "exactly one variant",
        "name a value for every axis that has several",
    ));
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_needs_the_same_wavelengths_in_all_variants() {
        let claim = Claim {
            id: "1".into(),
            statement: String::new(),
            quantity: Quantity::Reflectance,
            wavelength_nm: None,
            range_nm: Some([500.0, 600.0]),
            plus: vec![0],
            minus: vec![1],
            at_least: Some(0.0),
            at_most: None,
            curve: Vec::new(),
        };
        let told = |a: &[f64], b: &[f64]| {
            let mut faults = Faults::default();
            check_light(std::slice::from_ref(&claim), &[a, b], &mut faults);
            faults.to_string()
        };
        assert_eq!(told(&[450.0, 500.0, 550.0], &[500.0, 550.0, 650.0]), "");
        let uneven = told(&[500.0, 550.0], &[500.0, 560.0]);
        assert!(
            uneven.contains("conclusion[0].range_nm: found 500, 550 nm of one variant, 500, 560 nm"),
            "{uneven}"
        );
        assert!(told(&[500.0, 550.0], &[500.0]).contains("the same wavelengths"));
    }
}
