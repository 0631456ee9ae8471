//! Checks that the variants have what their conclusions need: wavelengths, and a target colour
//! where the distance to it is compared.

use super::Claim;
use crate::input::fault::{Fault, Faults};
use crate::input::study::Study;
use crate::sweep::definition::file::Quantity;

/// Reports conclusions that their variants cannot answer.
pub fn check_variants(claims: &[Claim], studies: &[&Study], faults: &mut Faults) {
    let light: Vec<&[f64]> = studies.iter().map(|study| study.wavelengths_nm.as_slice()).collect();
    check_light(claims, &light, faults);
    for claim in claims.iter().filter(|claim| claim.table.quantity == Quantity::DeltaEToTarget) {
        if claim.variants().any(|v| studies[v].judgement.target_lab.is_none()) {
            let found =
                format!("{:?} in {:?}, of a variant without a target", "delta_e_to_target", claim.table.id);
            let remedy = "set base.colour.target_lab = [L, a, b]";
            faults.add("conclusion.quantity", found, "variants with a target colour", remedy);
        }
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
        let (quantity, range_nm) = (Quantity::Reflectance, Some([500.0, 600.0]));
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
