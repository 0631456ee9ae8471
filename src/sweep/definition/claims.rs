//! Checked conclusions, with the variants they refer to: repeated for every value of an axis, their
//! keys checked, and whether the variants have what they need: wavelengths, and a target colour
//! where the distance to it is compared.

use super::axes::{Axis, names};
use super::expand::{Draft, check_where, matches};
use super::file::{ConclusionTable, MeasuredQuantity, Over, SweepFile, Where};
use crate::input::fault::{Fault, Faults};
use crate::input::study::Study;
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
    let tables = expanded(file, axes, faults);
    for (k, (i, table)) in tables.iter().enumerate() {
        let others = tables[..k].iter().map(|(_, earlier)| earlier.id.as_str());
        faults.name(format!("conclusion[{i}].id"), &table.id, others, "conclusion");
    }
    tables.iter().map(|(i, table)| claim(&format!("conclusion[{i}]"), table, axes, drafts, faults)).collect()
}

fn claim(
    field: &str,
    table: &ConclusionTable,
    axes: &[Axis],
    drafts: &[Draft],
    faults: &mut Faults,
) -> Claim {
    let mut places =
        |key: &str, list: &[Where]| variants(&format!("{field}.{key}"), list, axes, drafts, faults);
    let plus = places("plus", &table.plus);
    let minus = places("minus", &table.minus);
    let among = places("among", &table.among);
    let absorbed_by = places("absorbed_by", table.absorbed_by.as_slice()).first().copied();
    check(field, table, faults);
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

/// All conclusions, each with the index of the table that defines it.
pub fn expanded(file: &SweepFile, axes: &[Axis], faults: &mut Faults) -> Vec<(usize, ConclusionTable)> {
    let mut all = Vec::new();
    for (i, table) in file.conclusion.iter().enumerate() {
        let Some(name) = &table.each else {
            all.push((i, table.clone()));
            continue;
        };
        match axes.iter().find(|axis| axis.name == *name) {
            Some(axis) => all.extend(axis.settings.iter().map(|s| (i, of_label(table, name, &s.label)))),
            None => {
                let field = format!("conclusion[{i}].each");
                let allowed = format!("one of {}", names(axes));
                faults.add(field, format!("{name:?}"), allowed, "name one of the axes");
            }
        }
    }
    all
}

/// The conclusion for one label; conditions that name the axis are left unchanged.
fn of_label(table: &ConclusionTable, axis: &str, label: &str) -> ConclusionTable {
    let mut one = table.clone();
    one.id = format!("{label}: {}", table.id);
    let lists = [&mut one.plus, &mut one.minus, &mut one.among];
    for condition in lists.into_iter().flatten().chain(&mut one.absorbed_by) {
        condition.entry(axis.to_owned()).or_insert_with(|| label.into());
    }
    one
}

/// Reports errors in a conclusion's numbers: wavelengths, abscissas of a curve, bounds.
fn check(field: &str, table: &ConclusionTable, faults: &mut Faults) {
    let spectral = matches!(table.quantity, MeasuredQuantity::Transmittance | MeasuredQuantity::Reflectance);
    let mut wrong = |key: &str, found: &str, allowed: &str| {
        faults.add(format!("{field}.{key}"), found, allowed, "see examples/paper-study-small.toml");
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
    for [key, found, allowed] in contradictions(table) {
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
fn contradictions(table: &ConclusionTable) -> impl Iterator<Item = [&'static str; 3]> {
    let curve = !table.along.is_empty();
    let ranged = table.range_nm.is_some();
    let delta_e = table.quantity == MeasuredQuantity::DeltaE;
    let unbound = table.at_least.or(table.at_most).is_none();
    let colours = (table.plus.len(), table.minus.len());
    let unowned = table.source.is_none();
    let of_number = table.quantity == MeasuredQuantity::Number;
    let number = "the name of a [[number]] of the study, with quantity = \"number\" and only there";
    let one_each = "one colour in plus and one in minus";
    let range = "a range of wavelengths, range_nm = [from, to]";
    let source = "source = \"…\" beside it";
    let all = [
        (curve && (delta_e || ranged), "among", "a curve", "a curve of one quantity, at one wavelength"),
        (!ranged && table.over != Over::Every, "over", "no range_nm", range),
        (!ranged && table.absorbed_by.is_some(), "absorbed_by", "no range_nm", range),
        (table.absolute && curve, "absolute", "a curve", "sums and differences without a curve"),
        (unowned && table.quote.is_some(), "quote", "a quotation without a source", source),
        (unowned && table.translation.is_some(), "translation", "a quotation without a source", source),
        (of_number && table.number.is_none(), "number", "nothing", number),
        (!of_number && table.number.is_some(), "number", "a name", number),
        (unbound, "at_least", "nothing", "a bound: at_least, at_most or both"),
        (table.plus.is_empty(), "plus", "no variant", "one variant or more"),
        (delta_e && colours != (1, 1), "plus", "other numbers of colours", one_each),
    ];
    all.into_iter().filter(|(there, ..)| *there).map(|(_, key, found, allowed)| [key, found, allowed])
}

/// Reports conclusions that their variants cannot answer.
pub fn check_variants(claims: &[Claim], studies: &[&Study], faults: &mut Faults) {
    let light: Vec<&[f64]> = studies.iter().map(|study| study.wavelengths_nm.as_slice()).collect();
    check_light(claims, &light, faults);
    check_numbers(claims, studies, faults);
    for claim in claims.iter().filter(|claim| claim.table.quantity == MeasuredQuantity::DeltaEToTarget) {
        if claim.variants().any(|v| studies[v].judgement.target_lab.is_none()) {
            let found =
                format!("{:?} in {:?}, of a variant without a target", "delta_e_to_target", claim.table.id);
            let remedy = "set base.colour.target_lab = [L, a, b]";
            faults.add("conclusion.quantity", found, "variants with a target colour", remedy);
        }
    }
}

/// Checks that the variants have the weighted numbers that conclusions name.
fn check_numbers(claims: &[Claim], studies: &[&Study], faults: &mut Faults) {
    for (i, claim) in claims.iter().enumerate() {
        let Some(name) = &claim.table.number else { continue };
        let lacks = |v: &usize| !studies[*v].numbers.iter().any(|number| number.name == *name);
        let Some(v) = claim.variants().find(lacks) else { continue };
        let known: Vec<&str> = studies[v].numbers.iter().map(|number| number.name.as_str()).collect();
        let allowed = match known.as_slice() {
            [] => "the name of a [[number]]; a variant has none".to_owned(),
            known => format!("one of {}", known.join(", ")),
        };
        let remedy = "name one of these, or add a [[base.number]]";
        faults.add(format!("conclusion[{i}].number"), format!("{name:?}"), allowed, remedy);
    }
}

/// Checks that the wavelengths of a conclusion are computed; `wavelengths_nm` lists those of each
/// variant.
fn check_light(claims: &[Claim], wavelengths_nm: &[&[f64]], faults: &mut Faults) {
    for (i, claim) in claims.iter().enumerate() {
        let one = claim.table.wavelength_nm.map(|nm| [nm - 1e-6, nm + 1e-6]);
        let Some([from, to]) = claim.table.range_nm.or(one) else { continue };
        let Some(v) =
            claim.variants().find(|v| !wavelengths_nm[*v].iter().any(|nm| (from..=to).contains(nm)))
        else {
            faults.0.extend(claim.table.range_nm.and_then(|range| uneven(claim, i, wavelengths_nm, range)));
            continue;
        };
        let (key, found) = match claim.table.wavelength_nm {
            Some(nm) => ("wavelength_nm", nm.to_string()),
            None => ("range_nm", format!("[{from}, {to}]")),
        };
        let listed: Vec<String> = wavelengths_nm[v].iter().map(f64::to_string).collect();
        let allowed = format!("wavelengths of the study, {} nm", listed.join(", "));
        let remedy = "name one of these, or add it to [light]";
        faults.add(format!("conclusion[{i}].{key}"), found, allowed, remedy);
    }
}

/// Finds a variant with other wavelengths in the range: ranges are compared wavelength by
/// wavelength.
fn uneven(claim: &Claim, i: usize, wavelengths_nm: &[&[f64]], [from, to]: [f64; 2]) -> Option<Fault> {
    let mut all = claim.variants().map(|v| {
        let inside = wavelengths_nm[v].iter().filter(|nm| (from..=to).contains(*nm));
        inside.map(|nm| format!("{}", (nm * 1e6).round() / 1e6)).collect::<Vec<_>>().join(", ")
    });
    let first = all.next()?;
    let other = all.find(|other| *other != first)?;
    let field = format!("conclusion[{i}].range_nm");
    let found = format!("{first} nm of one variant, {other} nm of another");
    let remedy = "give them the same [light], or a range in which they agree";
    Some(Fault::new(field, found, "the same wavelengths of the range in all variants", remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_needs_the_same_wavelengths_in_all_variants() {
        let quantity = MeasuredQuantity::Reflectance;
        let range_nm = Some([500.0, 600.0]);
        let mut claim = Claim::example();
        (claim.table.quantity, claim.table.range_nm) = (quantity, range_nm);
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
