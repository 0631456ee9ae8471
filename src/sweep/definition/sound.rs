//! Validates an outline, wherever its file comes from: names must stay inside the folder; variants,
//! axes and labels must exist. The checksum detects accidental changes, this check deliberate ones.

use super::claims::Claim;
use super::expand::is_folder_name;
use super::file::Quantity;
use super::load::Outline;

/// Checks an outline before any of its names is used as a path and any of its numbers as an index.
///
/// # Errors
/// A message with the field, what was found and what is allowed.
pub fn check(outline: &Outline) -> Result<(), String> {
    let count = outline.variants.len();
    for (i, variant) in outline.variants.iter().enumerate() {
        let (name, place) = (&variant.name, &variant.place);
        if !is_folder_name(name) || outline.variants[..i].iter().any(|other| other.name == *name) {
            let allowed = "names that differ, of folders under variants, of letters, digits and . _ + -";
            return Err(format!("variants[{i}].name: found {name:?}; allowed: {allowed}"));
        }
        let labels = place.iter().zip(&outline.axes);
        if place.len() != outline.axes.len() || !labels.into_iter().all(|(&k, axis)| k < axis.labels.len()) {
            return Err(format!("variants[{i}].place: found {place:?}; allowed: a label of every axis"));
        }
    }
    if outline.reference >= count {
        let found = outline.reference;
        return Err(format!("reference: found {found}; allowed: whole numbers below {count}"));
    }
    match outline.claims.iter().position(|claim| !names_variants(claim, count)) {
        Some(i) => {
            Err(format!("claims[{i}]: found other variants; allowed: those of the sweep, of delta_e two"))
        }
        None => Ok(()),
    }
}

/// Whether a conclusion's variants exist, in the number that its quantity compares.
fn names_variants(claim: &Claim, count: usize) -> bool {
    let compared = (claim.plus.len(), claim.minus.len());
    let fits = if claim.table.quantity == Quantity::DeltaE { compared == (1, 1) } else { compared.0 > 0 };
    fits && claim.variants().all(|variant| variant < count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::definition::file::SheetTable;
    use crate::sweep::definition::load::{AxisOutline, Place};

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
        for name in ["..", ".", "", "../../x", "/absolute/x", "a/b", "a\\b", "C:x", "a\0b"] {
            let mut found = outline();
            found.variants[1].name = name.into();
            let told = check(&found).unwrap_err();
            assert!(told.starts_with("variants[1].name: found"), "{name:?}: {told}");
        }
        let mut twice = outline();
        twice.variants[1].name = "100".into();
        assert!(check(&twice).unwrap_err().contains("names that differ"));
    }

    #[test]
    fn numbers_are_those_of_something() {
        let mut found = outline();
        found.reference = 9;
        assert!(check(&found).unwrap_err().starts_with("reference: found 9"));
        let mut found = outline();
        found.variants[0].place = vec![6];
        assert!(check(&found).unwrap_err().starts_with("variants[0].place: found [6]"));
        let mut found = outline();
        found.variants[0].place = vec![0, 1];
        assert!(check(&found).unwrap_err().starts_with("variants[0].place: found [0, 1]"));
    }
}
