use super::*;
use crate::appearance::weighted::NumberTransform;
use crate::evaluate::summed::{Residuals, sum_wavelengths_nm};
use crate::input::study::WantedWeights;

fn wanted(transform: NumberTransform, over: Option<SeenLight>, weights: &str) -> WantedNumber {
    WantedNumber {
        name: "number".to_owned(),
        weights: WantedWeights::Named(weights.to_owned()),
        range_nm: [100.0, 10_000.0],
        of: SeenLight::ScatteredTransmittance,
        over,
        transform,
    }
}

/// Steps of 1 %, from the first to the last wavelength.
#[test]
fn wavelengths_of_sums_reach_both_ends() {
    let nm = sum_wavelengths_nm([300.0, 2500.0], |_| 1e3);
    assert!(nm[0] == 300.0 && nm[nm.len() - 1] == 2500.0 && nm.len() > 200);
    assert!(nm.windows(2).all(|pair| pair[1] / pair[0] < 1.0101 && pair[1] > pair[0]));
    assert_eq!(sum_wavelengths_nm([550.0, 550.0], |_| 1e3), [550.0, 550.0]);
}

/// A quarter of the light is scattered: a haze of 0.25, a density of log 4, and X, Y, Z of a grey
/// have no tint. *Planted*: the second spectrum weighted with X and not with Y.
#[test]
fn numbers_are_made_of_their_spectra() {
    let nm: Vec<f64> = (0..41).map(|k| 380.0 + 10.0 * f64::from(k)).collect();
    let slope: Vec<f64> = nm.iter().map(|nm| 1e-3 * nm).collect();
    let quarter: Vec<f64> = slope.iter().map(|x| 0.25 * x).collect();
    let haze = wanted(NumberTransform::Mean, Some(SeenLight::Transmittance), "C/2");
    let asked = AskedNumber::new(&haze, &nm).unwrap();
    assert!((asked.of(&[&quarter, &slope]) - 0.25).abs() < 1e-12);
    let density = wanted(NumberTransform::Density, None, "status_t_red");
    assert!((AskedNumber::new(&density, &nm).unwrap().of(&[&[0.25; 41]]) - 4.0_f64.log10()).abs() < 1e-12);
    let tint = wanted(NumberTransform::Tint, None, "D65/10");
    assert!(AskedNumber::new(&tint, &nm).unwrap().of(&[&[0.5; 41]]).abs() < 1e-10);
}

/// A fit that misses what lies between its functions: the sum with the residuals is that of the
/// samples, with each realisation left out as well. *Planted*: the residuals of the one left out
/// counted.
#[test]
fn residuals_take_a_sum_back_to_its_samples() {
    let nm: Vec<Vec<f64>> =
        (0..3).map(|r| (0..10).map(|j| 405.0 + 10.0 * j as f64 + r as f64).collect()).collect();
    let residual = |left_out: Option<usize>, r: usize, j: usize| {
        let own = 0.01 * (r as f64 + 1.0) * if j.is_multiple_of(2) { 1.0 } else { 0.5 };
        own + left_out.map_or(0.0, |k| 1e-3 * k as f64)
    };
    let residuals = Residuals::new(nm, 100.0, 3, &residual);
    let sums = residuals.sums(&|from, to| (to - from) / 100.0);
    assert_eq!(sums.len(), 4);
    // strata of a tenth each: means of 0.75 · 0.01 (r + 1)
    assert!((sums[0] - 0.75 * 0.02).abs() < 1e-12, "{sums:?}");
    assert!((sums[1] - 0.75 * 0.025).abs() < 1e-12, "{sums:?}");
    assert!((sums[3] - (0.75 * 0.015 + 2e-3)).abs() < 1e-12, "{sums:?}");
}
