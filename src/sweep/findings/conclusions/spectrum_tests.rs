//! Tests of verdicts over a range of wavelengths.

use super::*;

fn every(parts: &[AtWavelength], range: [f64; 2]) -> (Verdict, Option<Estimate>, String) {
    one_by_one(parts, Over::Every, range).unwrap()
}

fn some(parts: &[AtWavelength], range: [f64; 2]) -> (Verdict, Option<Estimate>, String) {
    one_by_one(parts, Over::Some, range).unwrap()
}

fn part(nm: f64, margin: f64, verdict: Verdict) -> AtWavelength {
    let measured = Estimate { value: margin, standard_error: Some(0.1) };
    AtWavelength { nm, measured, verdict, together: verdict, margin }
}

#[test]
fn one_wavelength_refutes_what_others_confirm() {
    let parts = [part(500.0, 1.0, Verdict::Confirmed), part(520.0, -1.0, Verdict::Refuted)];
    let (verdict, measured, remark) = every(&parts, [500.0, 520.0]);
    assert_eq!(verdict, Verdict::Refuted);
    assert_eq!(measured.map(|m| m.value), Some(-1.0));
    assert!(remark.contains("refuted at 520 nm"), "{remark}");
    // the more distant value may be the less certain one
    let uncertain = AtWavelength { together: Verdict::Undecided, ..part(540.0, -2.0, Verdict::Undecided) };
    let measured = every(&[part(520.0, -1.0, Verdict::Refuted), uncertain], [520.0, 540.0]).1;
    assert_eq!(measured.map(|m| m.value), Some(-1.0));
    assert_eq!(every(&parts[..1], [500.0, 500.0]).0, Verdict::Confirmed);
    assert_eq!(every(&[part(500.0, 0.1, Verdict::Undecided)], [500.0, 500.0]).0, Verdict::Undecided);
    assert!(one_by_one(&[], Over::Every, [1.0, 2.0]).is_err());
}

/// *Planted*: judged as `every`, the first is refuted.
#[test]
fn one_wavelength_confirms_what_is_said_of_some() {
    let parts = [part(500.0, 1.0, Verdict::Confirmed), part(520.0, -1.0, Verdict::Refuted)];
    let (verdict, measured, remark) = some(&parts, [500.0, 520.0]);
    assert_eq!((verdict, measured.map(|m| m.value)), (Verdict::Confirmed, Some(1.0)));
    assert!(remark.contains("confirmed at 500 nm"), "{remark}");
    assert_eq!(some(&parts[1..], [520.0, 520.0]).0, Verdict::Refuted);
    // certain on its own, but not as one of many
    let lucky = AtWavelength { together: Verdict::Undecided, ..part(500.0, 0.21, Verdict::Confirmed) };
    assert_eq!(some(&[lucky, part(520.0, -1.0, Verdict::Refuted)], [500.0, 520.0]).0, Verdict::Undecided);
    assert!(one_by_one(&[], Over::Some, [1.0, 2.0]).is_err());
}

#[test]
fn what_absorbs_well_is_the_lower_half_of_the_transmittance() {
    // lower half between 0.3 and 0.9: up to 0.6
    let seen = [(400.0, 0.3), (450.0, 0.6), (500.0, 0.61), (550.0, 0.9)];
    assert_eq!(absorbed(&seen), [400.0, 450.0]);
}

/// *Planted*: if the grid errors were added as independent, the first error would be 0.2 / √2.
#[test]
fn grids_err_to_one_side_at_all_wavelengths_of_a_mean() {
    let number = |by: f64, error: f64| Linked {
        estimate: Estimate { value: 1.0, standard_error: Some(error) },
        deviations: [(0, by)].into(),
    };
    let error = |numbers: &[Linked]| mean(numbers).estimate.standard_error.unwrap();
    // rounding errors of a few additions
    approx::assert_relative_eq!(error(&[number(0.0, 0.2), number(0.0, 0.2)]), 0.2, max_relative = 1e-12);
    // the realisation moves the two wavelengths in opposite directions
    approx::assert_abs_diff_eq!(error(&[number(0.3, 0.3), number(-0.3, 0.3)]), 0.0, epsilon = 1e-12);
}

/// Of 2.5 % for one wavelength, each of two may use half.
#[test]
fn wavelengths_share_the_chance_of_a_mistake() {
    assert!((corrected(1) - QUANTILE).abs() < 1e-15);
    assert!((1.0 - corrected(2) - 0.5 * (1.0 - QUANTILE)).abs() < 1e-15);
}
