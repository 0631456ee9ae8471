//! Conclusions as written, with the variants that they speak of.

mod each;
mod light;
mod slips;

use super::axes::Axis;
use super::expand::{Draft, check_where, matches};
use super::file::{ConclusionTable, Over, Quantity, Where};
use crate::input::fault::{Fault, Faults};
pub use light::check_variants;
use serde::{Deserialize, Serialize};

/// Whose conclusion it is, in which words, and why it is tested so.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Words {
    /// Whose sentence it is; `None` for the sweep's own question.
    pub source: Option<String>,
    /// The source's own words.
    pub quote: Option<String>,
    /// The quote in English.
    pub translation: Option<String>,
    /// Why this inequality and these bounds.
    pub because: Option<String>,
}

/// A checked conclusion about variants by their number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// Whose sentence it is.
    #[serde(default)]
    pub words: Words,
    /// What is measured of each variant.
    pub quantity: Quantity,
    /// The wavelength it is measured at, nm, where one is meant.
    pub wavelength_nm: Option<f64>,
    /// The wavelengths it is measured at, nm, where it speaks of a range.
    #[serde(default)]
    pub range_nm: Option<[f64; 2]>,
    /// At which wavelengths of the range it is to hold.
    #[serde(default)]
    pub over: Over,
    /// Number of the variant that absorbs well what counts of the range.
    #[serde(default)]
    pub absorbed_by: Option<usize>,
    /// The size of the sum counts, whatever its sign.
    #[serde(default)]
    pub absolute: bool,
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
    let tables = each::expanded(tables, axes, faults);
    for (k, (i, table)) in tables.iter().enumerate() {
        if tables[..k].iter().any(|(_, earlier)| earlier.id == table.id) {
            let (field, found) = (format!("conclusion[{i}].id"), format!("{:?} twice", table.id));
            let remedy = "conclusions.csv and the page name them by it: give each its own";
            faults.push(Fault::new(field, found, "names that differ", remedy));
        }
    }
    tables.iter().map(|(i, table)| claim(&format!("conclusion[{i}]"), table, axes, drafts, faults)).collect()
}

fn claim(at: &str, table: &ConclusionTable, axes: &[Axis], drafts: &[Draft], faults: &mut Faults) -> Claim {
    let mut places = |key: &str, list: &[Where]| variants(&format!("{at}.{key}"), list, axes, drafts, faults);
    let (plus, minus) = (places("plus", &table.plus), places("minus", &table.minus));
    let among = places("among", &table.among);
    let absorbed_by = places("absorbed_by", table.absorbed_by.as_slice()).first().copied();
    slips::check(at, table, faults);
    Claim {
        id: table.id.clone(),
        statement: table.statement.clone(),
        words: words(table),
        quantity: table.quantity,
        wavelength_nm: table.wavelength_nm,
        range_nm: table.range_nm,
        over: table.over,
        absorbed_by,
        absolute: table.absolute,
        plus,
        minus,
        at_least: table.at_least,
        at_most: table.at_most,
        curve: table.along.iter().copied().zip(among).collect(),
    }
}

fn words(table: &ConclusionTable) -> Words {
    Words {
        source: table.source.clone(),
        quote: table.quote.clone(),
        translation: table.translation.clone(),
        because: table.because.clone(),
    }
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
impl Claim {
    /// C* of two variants, at least 0.
    pub(in crate::sweep) fn example() -> Self {
        Self {
            id: "1".into(),
            statement: String::new(),
            words: Words::default(),
            quantity: Quantity::Chroma,
            wavelength_nm: None,
            range_nm: None,
            over: Over::Every,
            absorbed_by: None,
            absolute: false,
            plus: vec![0],
            minus: vec![1],
            at_least: Some(0.0),
            at_most: None,
            curve: Vec::new(),
        }
    }
}
