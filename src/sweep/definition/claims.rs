//! Checked conclusions, with the variants they refer to.

mod each;
mod light;
mod slips;

use super::axes::Axis;
use super::expand::{Draft, check_where, matches};
use super::file::{ConclusionTable, SweepFile, Where};
use crate::input::fault::Faults;
pub use light::check_variants;
use serde::{Deserialize, Serialize};

/// A checked conclusion with the numbers of its variants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// The conclusion as written.
    pub table: ConclusionTable,
    /// Variant whose absorption selects the wavelengths of the range.
    pub absorbed_by: Option<usize>,
    /// Variants that are added.
    pub plus: Vec<usize>,
    /// Variants that are subtracted.
    pub minus: Vec<usize>,
    /// Variants of the curve on which the value is looked up, at the abscissas `along`; empty if
    /// the value itself is compared.
    pub among: Vec<usize>,
}

impl Claim {
    /// All variants that it names.
    pub fn variants(&self) -> impl Iterator<Item = usize> {
        let listed = self.plus.iter().chain(&self.minus).chain(&self.absorbed_by).copied();
        listed.chain(self.among.iter().copied())
    }

    /// Abscissas and variants of the curve.
    pub fn curve(&self) -> impl Iterator<Item = (f64, usize)> {
        self.table.along.iter().copied().zip(self.among.iter().copied())
    }
}

/// Resolves the variants that the conclusions refer to.
pub fn claims(file: &SweepFile, axes: &[Axis], drafts: &[Draft], faults: &mut Faults) -> Vec<Claim> {
    let tables = each::expanded(file, axes, faults);
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
    Claim { table: table.clone(), absorbed_by, plus, minus, among }
}

/// Resolves a list of conditions, each of which must select exactly one variant.
fn variants(field: &str, list: &[Where], axes: &[Axis], drafts: &[Draft], faults: &mut Faults) -> Vec<usize> {
    let mut chosen = Vec::new();
    for (k, condition) in list.iter().enumerate() {
        let field = format!("{field}[{k}]");
        check_where(&field, condition, axes, faults);
        let fitting: Vec<usize> =
            (0..drafts.len()).filter(|&d| matches(condition, axes, &drafts[d].place)).collect();
        if fitting.len() != 1 {
            let remedy = "name a value for every axis that has several";
            faults.add(field, format!("{} variants", fitting.len()), "exactly one variant", remedy);
            continue;
        }
        chosen.extend(fitting);
    }
    chosen
}

#[cfg(test)]
impl Claim {
    /// C* of two variants, at least 0.
    pub(in crate::sweep) fn example() -> Self {
        let table = "id = '1'\nstatement = ''\nquantity = 'chroma'\nplus = []\nat_least = 0.0";
        let table = toml::from_str(table).expect("a conclusion");
        Self { table, absorbed_by: None, plus: vec![0], minus: vec![1], among: Vec::new() }
    }
}
