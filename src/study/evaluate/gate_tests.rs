use super::*;
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::manifest::SpectrumReplicates;
use crate::evaluate::uncertainty::Budget;

fn estimate(value: f64, error: f64) -> Estimate {
    Estimate { value, standard_error: Some(error) }
}

/// Numbers from coarse grids, beside those of accurate studies.
#[test]
fn factors_and_ratios_that_cannot_be_are_withheld() {
    for (value, error, word) in [
        (-16.0, 615.0, "too large"),
        (-0.099, 0.006, "below 0"),
        (f64::NAN, 0.1, "not determined"),
        (0.4, f64::NAN, "not determined"),
        (8.3, 0.08, "above 2"),
        (4.3, 0.3, "above 2"),
    ] {
        let reason = impossible_factor(estimate(value, error)).unwrap();
        assert!(reason.contains(word), "{reason}");
        assert!(impossible_share(estimate(value, error)).is_some());
    }
    assert!(impossible_share(estimate(1.2, 0.05)).unwrap().contains("above 1"));
    for (value, error) in [(0.0, 1e-6), (-0.001, 1e-3), (-0.004, 0.005), (1.3, 0.02), (0.7, 0.2)] {
        assert_eq!(impossible_factor(estimate(value, error)), None);
    }
    assert_eq!(impossible_share(estimate(1.01, 0.02)), None);
    assert_eq!(impossible_share(Estimate::unknown_error(-0.01)), None);
}

#[test]
fn colours_that_cannot_be_are_withheld() {
    let grid: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    let meter = Colorimeter::new(&grid).unwrap();
    let grey = |value: f64| meter.colour(&[value; 31]).unwrap();
    let small = Some([0.3; 3]);
    for (value, error, word) in [
        (-16.0, Some([30.0; 3]), "X = "),
        (-0.01, small, "below 0"),
        (1.1, small, "lighter than white"),
        (1.2, None, "lighter than white"),
        (0.5, Some([4.0, 80.0, 3.0]), "is not meaningful"),
        (0.5, Some([f64::NAN; 3]), "not a number"),
    ] {
        let reason = impossible_colour(&grey(value), error, Brightest::White).unwrap();
        assert!(reason.contains(word), "{reason}");
    }
    for (value, error) in [(0.0, small), (1.0, small), (1.005, small), (0.5, Some([20.0; 3])), (0.9, None)] {
        assert_eq!(impossible_colour(&grey(value), error, Brightest::White), None, "{value}");
    }
    // lit from one direction a white behind a face may read 1.05
    for (value, error) in [(1.05, small), (1.1, small), (1.2, None)] {
        assert_eq!(impossible_colour(&grey(value), error, Brightest::AboveWhite), None, "{value}");
    }
    let reason = impossible_colour(&grey(1.4), small, Brightest::AboveWhite).unwrap();
    assert!(reason.contains("lighter than 1.2 times white"), "{reason}");
}

/// On plain paper a print under a uniform sky is no lighter than white; on paper that fluoresces,
/// and lit from one side, it may be. *Planted*: one bound for all of them.
#[test]
fn prints_may_be_lighter_than_white_from_one_side_alone() {
    let grid: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    let colour = Colorimeter::new(&grid).unwrap().colour(&[1.05; 31]).unwrap();
    let note = |conditions: &str| ColourNote {
        conditions: conditions.into(),
        chroma: estimate(0.0, 0.1),
        hue_deg: estimate(0.0, 0.1),
        lab_standard_error: Some([0.1; 3]),
        delta_e_2000_95: None,
        budget: Budget::default(),
        deviations: Vec::new(),
        colour,
    };
    let notes = || vec![note(NATURAL_LIGHT), note(LIT_AT_45)];
    let (kept, withheld) = colours(notes(), false);
    assert!(kept.len() == 1 && kept[0].conditions == LIT_AT_45, "{kept:?}");
    assert!(withheld.len() == 1 && withheld[0].number == colour_under(NATURAL_LIGHT), "{withheld:?}");
    let (kept, withheld) = colours(notes(), true);
    assert!(kept.len() == 2 && withheld.is_empty(), "{withheld:?}");
}

/// A spline through few wavelengths may dip below 0, which is acceptable. What is far outside is
/// left unchanged, and refused.
#[test]
fn totals_keep_within_0_and_1_and_their_errors_include_the_overshoot() {
    assert_eq!(bounded(estimate(-0.04, 0.03)), estimate(0.0, 0.05));
    assert_eq!(bounded(estimate(0.3, 0.03)), estimate(0.3, 0.03));
    assert_eq!(bounded(Estimate::unknown_error(1.02)), Estimate::unknown_error(1.0));
    assert_eq!(bounded(estimate(-0.2, 0.03)), estimate(-0.2, 0.03));
    assert!(bounded(estimate(f64::NAN, 0.03)).value.is_nan());
}

#[test]
fn quantities_with_a_unit_are_above_0() {
    for (quantity, value, error, word) in [
        (Quantity::Size, -0.1, 0.01, "below 0"),
        (Quantity::Positive, 2.0, 3.0, "no more than its error"),
        (Quantity::Positive, 0.0, 0.0, "no more than its error"),
        (Quantity::Size, f64::INFINITY, 0.0, "not determined"),
        (Quantity::Cosine, 1.3, 0.1, "beyond"),
        (Quantity::Share, 1.1, 0.05, "above 1"),
        (Quantity::Factor, 4.3, 0.3, "above 2"),
    ] {
        let reason = impossible(quantity, estimate(value, error)).unwrap();
        assert!(reason.contains(word), "{quantity:?}: {reason}");
    }
    for (quantity, value, error) in [
        (Quantity::Size, -0.02, 0.01),
        (Quantity::Size, -1e-9, 0.0),
        (Quantity::Positive, 2.0, 1.0),
        (Quantity::Cosine, -0.9, 0.2),
        (Quantity::Factor, 1.3, 0.02),
    ] {
        assert_eq!(impossible(quantity, estimate(value, error)), None, "{quantity:?} {value}");
    }
}

/// A spectrum whose colour cannot be is not published either; single impossible numbers of others
/// are left out alone. *Planted*: a gate without an upper end.
#[test]
fn a_spectrum_goes_with_its_colour() {
    let row = |lit: f64| SpectrumRow {
        wavelength_nm: 550.0,
        polar_deg: 0.0,
        reflectance: estimate(0.1, 0.01),
        specular_reflectance: estimate(0.1, 0.01),
        transmittance: estimate(0.9, 0.01),
        specular_transmittance: estimate(0.9, 0.01),
        coherent_transmittance: None,
        absorptance: estimate(0.0, 0.01),
        natural_light: Some(estimate(0.8, 0.01)),
        lit_at_45: Some(estimate(lit, 0.08)),
        sphere_at_8: None,
        sphere_at_8_excluded: None,
        diffuse_normal: None,
        transmittance_diffuse: None,
        absorptance_behind: None,
        deviations: Vec::new(),
        replicates: SpectrumReplicates::default(),
    };
    let mut rows = [row(1.4), row(8.3)];
    let reasons = spectra(&mut rows, &[]);
    assert!(reasons.len() == 1 && reasons[0].reason.contains("1 of its wavelengths"), "{reasons:?}");
    assert!(rows[0].lit_at_45.is_some() && rows[1].lit_at_45.is_none());
    let colour = Withheld { number: colour_under(LIT_AT_45), reason: "lighter than white".into() };
    let mut rows = [row(1.4), row(1.5)];
    spectra(&mut rows, &[colour]);
    assert!(rows.iter().all(|row| row.lit_at_45.is_none() && row.natural_light.is_some()));
    let mut rows = [row(1.4)];
    rows[0].sphere_at_8 = Some(estimate(5.0, 0.1));
    rows[0].diffuse_normal = Some(estimate(1.1, 0.1));
    rows[0].transmittance_diffuse = Some(estimate(1.4, 0.1));
    let reasons = spectra(&mut rows, &[]);
    let withheld: Vec<&str> = reasons.iter().map(|withheld| withheld.number.as_str()).collect();
    assert_eq!(withheld, ["reflectance factor d:8", "transmittance of diffuse light"]);
    assert!(rows[0].sphere_at_8.is_none() && rows[0].diffuse_normal.is_some());
}
