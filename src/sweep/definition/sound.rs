//! Validates an outline, wherever its file comes from: names must stay inside the folder; variants,
//! axes and labels must exist. The checksum detects accidental changes, this check deliberate ones.

use super::claims::{Claim, check_variants};
use super::expand::is_folder_name;
use super::file::Quantity;
use super::load::{Outline, Place, Variant};
use crate::input::fault::Faults;
use crate::input::study::Study;
use std::collections::HashSet;

/// Checks an outline before any of its names is used as a path and any of its numbers as an index.
///
/// # Errors
/// A message with the field, what was found and what is allowed.
pub fn check(outline: &Outline) -> Result<(), String> {
    let count = outline.variants.len();
    if count == 0 {
        return Err("variants: found none; allowed: one or more".into());
    }
    within("reference", outline.reference, count)?;
    let mut names = HashSet::new();
    for (i, place) in outline.variants.iter().enumerate() {
        check_place(&format!("variants[{i}]"), place, outline)?;
        if !names.insert(place.name.as_str()) {
            return Err(format!(
                "variants[{i}].name: found {:?} twice; allowed: names that differ",
                place.name
            ));
        }
    }
    let sheet = [("rows", &outline.sheet.rows), ("columns", &outline.sheet.columns)];
    for (key, name) in sheet.into_iter().filter_map(|(key, name)| Some((key, name.as_ref()?))) {
        if !outline.axes.iter().any(|axis| axis.name == *name) {
            return Err(format!("sheet.{key}: found {name:?}; allowed: the name of an axis"));
        }
    }
    let mut claims = outline.claims.iter().enumerate();
    claims.try_for_each(|(i, claim)| check_claim(&format!("claims[{i}]"), claim, count))
}

/// Checks that the variants have what the conclusions need: wavelengths, a target colour.
///
/// # Errors
/// As for [`check`].
pub fn check_wavelengths(claims: &[Claim], variants: &[Variant]) -> Result<(), String> {
    let studies: Vec<&Study> = variants.iter().map(|v| &v.study).collect();
    let mut faults = Faults::default();
    check_variants(claims, &studies, &mut faults);
    if faults.0.is_empty() { Ok(()) } else { Err(faults.to_string()) }
}

fn within(field: &str, found: usize, count: usize) -> Result<(), String> {
    if found < count {
        return Ok(());
    }
    Err(format!("{field}: found {found}; allowed: whole numbers below {count}"))
}

/// A variant's name must be a folder name, its position one label of every axis.
fn check_place(at: &str, place: &Place, outline: &Outline) -> Result<(), String> {
    if !is_folder_name(&place.name) {
        return Err(format!(
            "{at}.name: found {:?}; allowed: the name of a folder under variants, of letters, digits and . _ + -",
            place.name
        ));
    }
    if place.place.len() != outline.axes.len() {
        let (found, axes) = (place.place.len(), outline.axes.len());
        return Err(format!("{at}.place: found {found} numbers; allowed: one for each of the {axes} axes"));
    }
    let labels = outline.axes.iter().zip(&place.place);
    labels
        .enumerate()
        .try_for_each(|(a, (axis, &k))| within(&format!("{at}.place[{a}]"), k, axis.labels.len()))
}

/// A conclusion's variants must exist, in the number that its quantity compares.
fn check_claim(at: &str, claim: &Claim, count: usize) -> Result<(), String> {
    let curve: Vec<usize> = claim.curve.iter().map(|(_, variant)| *variant).collect();
    let absorbing: Vec<usize> = claim.absorbed_by.into_iter().collect();
    let lists =
        [("plus", &claim.plus), ("minus", &claim.minus), ("absorbed_by", &absorbing), ("curve", &curve)];
    for (key, list) in lists {
        list.iter().try_for_each(|&variant| within(&format!("{at}.{key}"), variant, count))?;
    }
    let compared = (claim.plus.len(), claim.minus.len());
    if claim.plus.is_empty() || claim.quantity == Quantity::DeltaE && compared != (1, 1) {
        return Err(format!(
            "{at}.plus: found {} variants; allowed: one or more, of delta_e one",
            claim.plus.len()
        ));
    }
    let rising = claim.curve.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if !rising || claim.curve.len() == 1 {
        return Err(format!("{at}.curve: found places that do not increase; allowed: two or more that do"));
    }
    if claim.at_least.is_none() && claim.at_most.is_none() {
        return Err(format!("{at}.at_least: found nothing; allowed: a bound, at_least, at_most or both"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::definition::file::SheetTable;
    use crate::sweep::definition::load::AxisOutline;

    fn outline() -> Outline {
        let place = |name: &str, k: usize| Place { name: name.into(), place: vec![k] };
        Outline {
            title: "Tiny".into(),
            axes: vec![AxisOutline {
                name: "size".into(),
                labels: vec!["100".into(), "200".into()],
                unit: String::new(),
            }],
            sheet: SheetTable::default(),
            reference: 0,
            reference_asked: false,
            claims: Vec::new(),
            variants: vec![place("100", 0), place("200", 1)],
        }
    }

    #[test]
    fn names_stay_inside_the_folder() {
        assert_eq!(check(&outline()), Ok(()));
        for name in ["..", ".", "", "../../x", "/tmp/x", "a/b", "a\\b", "C:x", "a\0b"] {
            let mut found = outline();
            found.variants[1].name = name.into();
            let told = check(&found).unwrap_err();
            assert!(told.starts_with("variants[1].name: found"), "{name:?}: {told}");
        }
        let mut twice = outline();
        twice.variants[1].name = "100".into();
        assert!(check(&twice).unwrap_err().contains("twice"));
    }

    #[test]
    fn numbers_are_those_of_something() {
        let mut found = outline();
        found.reference = 9;
        assert!(check(&found).unwrap_err().starts_with("reference: found 9"));
        let mut found = outline();
        found.variants[0].place = vec![6];
        assert!(check(&found).unwrap_err().starts_with("variants[0].place[0]: found 6"));
        let mut found = outline();
        found.variants[0].place = vec![0, 1];
        assert!(check(&found).unwrap_err().starts_with("variants[0].place: found 2"));
    }
}
