use super::*;
use crate::appearance::colour::Colour;
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::ink_maker::Target;
use crate::sweep::definition::load::{Outline, Place};

/// A variant with all numbers, and noise in all digits.
fn finished(name: String, wavelengths_nm: &[f64], seed: u64) -> Outcome {
    let mut draws = crate::numerics::Draws::new(seed, 0);
    let mut number = || Estimate { value: draws.uniform(), standard_error: Some(0.01 * draws.uniform()) };
    let mut row = |polar_deg: f64, &wavelength_nm: &f64| PrintRow {
        wavelength_nm,
        polar_deg,
        reflectance: number(),
        transmittance: number(),
        natural_light: Some(number()),
        lit_at_45: Some(number()),
        deviations: Vec::new(),
    };
    let points = |polar_deg: f64| wavelengths_nm.iter().map(move |nm| (polar_deg, nm));
    let spectra: Vec<PrintRow> = points(0.0).chain(points(45.0)).map(|(deg, nm)| row(deg, nm)).collect();
    let values: Vec<f64> = spectra[..wavelengths_nm.len()].iter().map(|row| row.reflectance.value).collect();
    let colour = Colorimeter::new(wavelengths_nm).unwrap().colour(&values).unwrap();
    let covariance = Some([[0.1234567, 0.01, 0.0], [0.01, 0.2345678, 0.0], [0.0, 0.0, 0.3456789]]);
    let colour = Colour { lab_covariance: covariance, ..colour };
    let lab = [70.1, -5.2, 40.3];
    let deviations = Vec::new();
    let target = Target { lab, delta_e_2000: number(), deviations };
    let contrast = Some((number(), Vec::new()));
    let solves = Count { asked: 24, finished: 24 };
    let labels = vec![name.clone(), name.clone(), name.clone()];
    // colours that vary from angle to angle, like those of inks
    let cell = |x: usize, y: usize| [250 - 2 * x - y, 230 - x - 2 * y, 90 + x * y / 16].map(|c| c as u8);
    let picture = ScreenPicture {
        angles_deg: vec![0.0; 31],
        strip: (0..31).map(|y| cell(0, y)).collect(),
        square: (0..31).map(|y| (0..31).map(|x| cell(x, y)).collect()).collect(),
    };
    Outcome {
        numbers: Vec::new(),
        name,
        labels,
        solves,
        failures: 0,
        reason: None,
        realisations: 24,
        certain: false,
        colour: Some(colour),
        lab_deviations: Default::default(),
        contrast,
        aim: Some("L* 70.1, a* −5.2, b* 40.3 (D65, 2° observer)".into()),
        target: Some(target),
        print_hex: None,
        spectra,
        picture: Some(picture),
        medium: Vec::new(),
        hiding_thickness_um: None,
    }
}

/// The paper's study: 5 × 4 × 13 variants, 16 wavelengths at two angles, pictures of 31 × 31.
/// *Planted*: uncompressed pictures take 1 MB more; with the wavelengths of both angles the
/// curves would run back.
#[test]
fn a_page_of_260_variants_stays_below_1_megabyte() {
    let nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
    let axis = |name: &str, n: usize| AxisOutline {
        name: name.into(),
        labels: (0..n).map(|k| format!("{name} number {k}")).collect(),
        unit: String::new(),
    };
    let place = |i: usize| Place {
        name: format!("a_rather_long_name_of_a_variant_of_the_study-{i}"),
        place: vec![i / 52, i / 13 % 4, i % 13],
    };
    let outline = Outline {
        title: "The paper's study".into(),
        axes: vec![axis("ink", 5), axis("share", 4), axis("grains", 13)],
        sheet: Default::default(),
        reference: 0,
        reference_asked: false,
        claims: Vec::new(),
        variants: (0..260).map(place).collect(),
    };
    let all = (0..260).map(|i| finished(outline.variants[i].name.clone(), &nm, i as u64));
    let outcomes: Vec<Outcome> = all.collect();
    let sweep = Sweep { outline, variants: Vec::new(), texts: Vec::new(), inputs: Vec::new() };
    assert_eq!(wavelengths_nm(&outcomes), nm);
    let nearest = super::super::reported::nearest(&sweep.outline, &outcomes);
    let bytes = page(&sweep, &Reported { outcomes, conclusions: Vec::new(), nearest }, None).len();
    assert!((200_000..1_000_000).contains(&bytes), "{bytes} bytes");
}

#[test]
fn values_travel_to_a_twenty_thousandth() {
    let there = |x: f64| f64::from(counted(Some(x - LOWEST))) / STEPS + LOWEST;
    for x in [-0.05, 0.0, 0.123_456, 1.0, 1.3] {
        assert!((there(x) - x).abs() <= 0.5 / STEPS + 1e-12, "{x}");
    }
    assert_eq!((counted(None), counted(Some(f64::NAN))), (UNKNOWN, UNKNOWN));
}
