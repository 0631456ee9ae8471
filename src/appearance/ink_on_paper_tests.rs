//! Homogeneous inks (no solve) and synthetic ensembles.

use super::*;
use crate::appearance::paper::{Albedo, Coupling};
use crate::material::spectra::{Spectrum, molecular_mixture};
use crate::wave::Side;

/// A molecular mixture of a synthetic pigment in the papers' binder, 1 µm, on paper 0.9.
pub(crate) fn molecular_ink(pigment: &str, share: f64, coupling: Coupling) -> InkOnPaper {
    let wavelengths_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
    let rule = AngleRule::new(4, 60.0, coupling).unwrap();
    let spectrum = Spectrum::synthetic(pigment).unwrap();
    let layer = |nm: &f64| {
        let wavelength_um = nm / 1000.0;
        let eta = spectrum.index(wavelength_um).unwrap();
        let index = molecular_mixture(1.558.into(), &[(share, eta)]);
        vec![LayerOptics::homogeneous(&rule, Slab { index, thickness_um: 1.0, wavelength_um })]
    };
    let layers: Vec<_> = wavelengths_nm.iter().map(layer).collect();
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling };
    InkOnPaper::new(rule.clone(), &wavelengths_nm, &layers, &substrate).unwrap()
}

#[test]
fn a_yellow_ink_is_yellow_and_red_is_red() {
    for coupling in [Coupling::Gap, Coupling::OpticalContact { index: 1.558 }] {
        for (pigment, hues) in
            [("yellow", 80.0..110.0), ("red", 320.0..360.0), ("blue", 190.0..290.0), ("green", 100.0..160.0)]
        {
            let ink = molecular_ink(pigment, 0.3, coupling);
            let view = ink.rule().at(0.0).unwrap();
            let colour = ink.colour(|l| l.natural_light(&view, MirroredSky::Excluded)).unwrap();
            let (chroma, hue) = (colour.chroma().value, colour.hue_deg().value);
            println!("{pigment} {coupling:?}: Lab {:?} C* {chroma:.1} h {hue:.0}", colour.lab);
            assert!(chroma > 30.0 && hues.contains(&hue), "{pigment}: C* {chroma}, h {hue}");
        }
    }
}

#[test]
fn chroma_grows_with_concentration() {
    let chroma = |share| {
        let ink = molecular_ink("yellow", share, Coupling::Gap);
        let view = ink.rule().at(0.0).unwrap();
        ink.colour(|l| l.natural_light(&view, MirroredSky::Excluded)).unwrap().chroma().value
    };
    assert!(chroma(0.05) < chroma(0.15) && chroma(0.15) < chroma(0.3));
}

/// Realisations of a made-up layer: T and R_b scattered by `noise`.
fn noisy(rule: &AngleRule, draw: &mut impl FnMut() -> f64, noise: f64) -> LayerOptics {
    let points = rule.above.len();
    let t: Vec<f64> = (0..points).map(|_| 0.5 + noise * draw()).collect();
    let r: Vec<f64> = (0..points).map(|_| 0.2 + noise * draw()).collect();
    LayerOptics { specular: vec![0.1; points], ..LayerOptics::specular_only(vec![0.2; points], t, r) }
}

#[test]
fn jackknife_errors_of_the_layer_on_paper_are_calibrated() {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    let rule = AngleRule::new(3, 60.0, Coupling::Gap).unwrap();
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
    let mut rng = rand::rngs::ChaCha8Rng::seed_from_u64(11);
    let mut draw = || -> f64 { rng.sample(StandardNormal) };
    let exact = noisy(&rule, &mut draw, 0.0);
    let view = rule.at(40.0).unwrap();
    let light = |l: &[LayerOnPaper]| l[0].natural_light(&view, MirroredSky::Included);
    let truth = InkOnPaper::new(rule.clone(), &[550.0], &[vec![exact]], &substrate).unwrap().scalar(light);
    assert_eq!(truth.standard_error, None);
    let (repeats, n) = (1000, 8);
    let mut chi2 = 0.0;
    for _ in 0..repeats {
        let samples: Vec<_> = (0..n).map(|_| noisy(&rule, &mut draw, 0.02)).collect();
        let ink = InkOnPaper::new(rule.clone(), &[550.0], &[samples], &substrate).unwrap();
        let got = ink.scalar(light);
        chi2 += ((got.value - truth.value) / got.standard_error.unwrap()).powi(2);
    }
    // significance: t² with 7 degrees of freedom, mean 7/5, variance 7.84; 4σ
    let (mean, sigma) = (1.4 * f64::from(repeats), (7.84 * f64::from(repeats)).sqrt());
    assert!((chi2 - mean).abs() < 4.0 * sigma, "χ² {chi2}, expected {mean} ± {sigma}");
}

#[test]
fn colours_carry_a_covariance_from_two_realisations_on() {
    let rule = AngleRule::new(2, 60.0, Coupling::Gap).unwrap();
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
    let wavelengths_nm = [440.0, 550.0, 640.0];
    let layers: Vec<Vec<LayerOptics>> = (0..3)
        .map(|_| {
            [0.7, 0.6].map(|t| LayerOptics::specular_only(vec![0.1; 2], vec![t; 2], vec![0.1; 2])).to_vec()
        })
        .collect();
    let ink = InkOnPaper::new(rule.clone(), &wavelengths_nm, &layers, &substrate).unwrap();
    let view = ink.rule().at(0.0).unwrap();
    let colour = ink.colour(|l| PI * l.brdf(&view, &view)).unwrap();
    let [l, a, b] = colour.lab_standard_error().unwrap();
    assert!(l > 1.0 && a < 1e-9 && b < 1e-9, "a grey that varies in lightness only: {l} {a} {b}");
    let estimates = ink.spectrum(|l| l.transmittance(&view)).estimates();
    approx::assert_relative_eq!(estimates[0].value, 0.65, max_relative = 1e-13);
    approx::assert_relative_eq!(estimates[0].standard_error.unwrap(), 0.05, max_relative = 1e-12);
}

#[test]
fn ragged_input_is_refused() {
    let rule = AngleRule::new(2, 60.0, Coupling::Gap).unwrap();
    let layer = LayerOptics::specular_only(vec![0.1; 2], vec![0.7; 2], vec![0.1; 2]);
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
    let refused = |layers: &[Vec<LayerOptics>]| {
        InkOnPaper::new(rule.clone(), &[500.0, 600.0], layers, &substrate).unwrap_err().to_string()
    };
    assert!(refused(&[vec![layer.clone()]]).contains("layers: 1 entries"));
    assert!(refused(&[vec![layer.clone()], vec![]]).contains("realisations: 0 entries"));
    assert!(refused(&[vec![], vec![]]).contains("no realisations"));
    let contact = Substrate { coupling: Coupling::OpticalContact { index: 1.5 }, ..substrate.clone() };
    let error = InkOnPaper::new(rule.clone(), &[500.0], &[vec![layer]], &contact).unwrap_err();
    assert!(error.to_string().contains("another coupling"));
}

#[test]
fn far_fields_become_layer_optics_at_the_rules_angles() {
    use crate::appearance::bdf::tests::{LAMBDA_UM, PERIOD_UM, rng, speckle};
    let rule = AngleRule::new(2, 60.0, Coupling::Gap).unwrap();
    let solve = |seed, polar_deg, from| {
        let mut field = speckle(&mut rng(seed), 1e-3, 0.3);
        field.incidence.polar_deg = polar_deg;
        field.incidence.from = from;
        field
    };
    let above: Vec<FarField> = rule.above.iter().map(|n| solve(1, n.polar_deg, Side::Incident)).collect();
    let below: Vec<FarField> = rule.below.iter().map(|n| solve(2, n.polar_deg, Side::Exit)).collect();
    let layer = LayerOptics::from_far_fields(&rule, &above, Some(&below), None, 0.3).unwrap();
    assert_eq!(layer.reflectance_below[1], below[1].reflectance);
    assert_eq!(layer.specular[0], above[0].specular().reflected_efficiency);
    // f = 1e-3 cos θ L²/λ²; one speckle realisation over more than 64 orders, 4σ < 50 % (cos θ bends over the ring)
    let expected = 1e-3 * 60f64.to_radians().cos() * (PERIOD_UM / LAMBDA_UM).powi(2);
    assert!((layer.diffuse_brdf[[0, 1]] / expected - 1.0).abs() < 0.5);
    let refused = |above: &[FarField], below: Option<&[FarField]>| {
        LayerOptics::from_far_fields(&rule, above, below, None, 0.3).unwrap_err().to_string()
    };
    assert!(refused(&above[..1], None).contains("above: 1 entries"));
    assert!(refused(&[above[1].clone(), above[0].clone()], None).contains("rule's angle"));
    assert!(refused(&above, Some(&above)).contains("below"));
    let contact = AngleRule::new(2, 60.0, Coupling::OpticalContact { index: 1.5 }).unwrap();
    assert!(LayerOptics::from_far_fields(&contact, &above, None, None, 0.3).is_err());
}
