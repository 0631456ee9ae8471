//! Checked conclusions, with the variants they refer to.

mod each;
mod light;
mod slips;

use super::axes::Axis;
use super::expand::{Draft, check_where, matches};
use super::file::{ConclusionTable, Over, Quantity, Where};
use crate::input::fault::Faults;
pub use light::check_variants;
use serde::{Deserialize, Serialize};

/// Source, wording and justification of a conclusion.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Words {
    /// Source of the statement; `None` for a question of the sweep's own.
    pub source: Option<String>,
    /// The wording of the source.
    pub quote: Option<String>,
    /// The quote in English.
    pub translation: Option<String>,
    /// Why this inequality and these bounds were chosen.
    pub because: Option<String>,
}

/// A checked conclusion; variants are given by number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// Source, wording and justification.
    #[serde(default)]
    pub words: Words,
    /// Quantity measured on each variant.
    pub quantity: Quantity,
    /// Wavelength of the measurement, nm, for a single one.
    pub wavelength_nm: Option<f64>,
    /// Wavelengths of the measurement, nm, for a range.
    #[serde(default)]
    pub range_nm: Option<[f64; 2]>,
    /// How the wavelengths of the range are combined.
    #[serde(default)]
    pub over: Over,
    /// Variant whose absorption selects the wavelengths of the range.
    #[serde(default)]
    pub absorbed_by: Option<usize>,
    /// Whether to compare the absolute value of the sum.
    #[serde(default)]
    pub absolute: bool,
    /// Variants that are added.
    pub plus: Vec<usize>,
    /// Variants that are subtracted.
    pub minus: Vec<usize>,
    /// Smallest value that confirms the conclusion.
    pub at_least: Option<f64>,
    /// Largest value that confirms the conclusion.
    pub at_most: Option<f64>,
    /// Abscissas and variants of the curve on which the value is looked up; empty if the value
    /// itself is compared.
    #[serde(default)]
    pub curve: Vec<(f64, usize)>,
}

impl Claim {
    /// All variants that it names.
    pub fn variants(&self) -> impl Iterator<Item = usize> {
        let listed = self.plus.iter().chain(&self.minus).chain(&self.absorbed_by).copied();
        listed.chain(self.curve.iter().map(|(_, variant)| *variant))
    }
}

/// Resolves the variants that the conclusions refer to.
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
            faults.add(field, found, "names that differ", remedy);
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

/// Resolves a list of conditions, each of which must select exactly one variant.
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
    faults.add(field, found, "exactly one variant", "name a value for every axis that has several");
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
