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
    let bytes = page(&sweep, &Reported { outcomes, conclusions: Vec::new(), nearest }).len();
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

fn outline(labels: [&[&str]; 2]) -> Outline {
    let axis = |labels: &[&str]| AxisOutline {
        name: "size".into(),
        labels: labels.iter().map(|l| (*l).to_owned()).collect(),
        unit: String::new(),
    };
    let place = |i: usize, j: usize| Place { name: format!("{i}-{j}"), place: vec![i, j] };
    let inner = labels[1].len();
    Outline {
        title: String::new(),
        axes: labels.map(axis).to_vec(),
        sheet: Default::default(),
        reference: 0,
        reference_asked: false,
        claims: Vec::new(),
        variants: (0..labels[0].len() * inner).map(|v| place(v / inner, v % inner)).collect(),
    }
}

/// L* = 50 + x² at −2, …, 2, two times: without an inner x the cubic (at 0: slopes −1 and 1 at
/// −1 and 1) and the parabolas (at −1 and 1) miss by 1/2, where lines miss by 1.
/// *Planted*: without the bends this gives the errors of lines.
#[test]
fn leaving_one_out_of_a_parabola_misses_by_a_half() {
    let outline = outline([&["red", "blue"], &["-2 nm", "-1 nm", "0 nm", "1 nm", "2 nm"]]);
    let lab = |x: f64| [50.0 + x * x, 0.0, 0.0];
    let labs: Vec<_> = (0..10).map(|v| Some(lab(f64::from(v % 5) - 2.0))).collect();
    let axis = Continuous::new(&outline, &labs, 1).unwrap();
    let missed = |v: usize| labs[v].map(|[l, ..]| ciede2000([l + 0.5, 0.0, 0.0], [l, 0.0, 0.0]));
    for v in 0..10 {
        let expected = (1..4).contains(&(v % 5)).then(|| missed(v).unwrap());
        assert!((axis.left_out[v].unwrap_or(9.0) - expected.unwrap_or(9.0)).abs() < 1e-9, "{axis:?}");
    }
    assert!(axis.values == [-2.0, -1.0, 0.0, 1.0, 2.0] && !axis.logarithmic);
    assert!((axis.median - missed(1).unwrap()).abs() < 1e-9, "{axis:?}");
}

#[test]
fn a_colour_linear_in_the_logarithm_is_interpolated_in_it() {
    let outline = outline([&["1"], &["800", "400", "200", "100"]]);
    let labs = [60.0, 50.0, 40.0, 30.0].map(|l| Some([l, 0.0, 0.0]));
    let axis = Continuous::new(&outline, &labs, 1).unwrap();
    assert!(axis.logarithmic && axis.median < 1e-9, "{axis:?}");
}

#[test]
fn axes_with_two_values_words_or_gaps_stay_discrete() {
    let is_continuous = |labels: &[&str], gaps: usize| {
        let mut outline = outline([&["1", "2"], labels]);
        outline.variants.truncate(outline.variants.len() - gaps);
        Continuous::new(&outline, &vec![Some([50.0, 0.0, 0.0]); outline.variants.len()], 1).is_some()
    };
    assert!(is_continuous(&["1 nm", "2 nm", "4 nm"], 0));
    for labels in [&["1 nm", "2 nm"][..], &["1 nm", "2 µm", "4 µm"], &["1", "2", "all"], &["1", "3", "2"]] {
        assert!(!is_continuous(labels, 0), "{labels:?}");
    }
    assert!(!is_continuous(&["1 nm", "2 nm", "4 nm"], 1));
    let three = outline([&["1"], &["1", "2", "3"]]);
    let unsolved = [Some([50.0; 3]), None, Some([50.0; 3])];
    assert!(Continuous::new(&three, &unsolved, 1).is_none());
}

#[test]
fn weights_reproduce_lines_and_settings() {
    let xs = [1.0, 2.0, 5.0, 20.0];
    for (k, t) in [(0, 0.3), (1, 0.5), (2, 0.9), (2, 1.0)] {
        let weights = weights(&xs, k, t);
        let x: f64 = weights.iter().zip(xs).map(|(w, x)| w * x).sum();
        assert!((x - (xs[k] + t * (xs[k + 1] - xs[k]))).abs() < 1e-12, "{weights:?}");
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
    }
    assert_eq!(weights(&xs, 1, 0.0), [0.0, 1.0, 0.0, 0.0]);
}
