//! Against `validation/data/colour.json` (plain sums; white, Lab and sRGB of 12 spectra on two
//! grids).

use super::*;
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("../../../validation/data/colour.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

/// Spectra of the reference file, from the formulas printed there.
fn spectrum(name: &str, l: f64) -> f64 {
    let gauss = |c: f64, s: f64| (-((l - c) / s).powi(2) / 2.0).exp();
    let step = |c: f64, s: f64| 1.0 / (1.0 + (-(l - c) / s).exp());
    match name {
        "flat_0.9" => 0.9,
        "perfect_white" => 1.0,
        "yellow_edge" => 0.05 + 0.85 * step(510.0, 12.0),
        "red_edge" => 0.04 + 0.80 * step(600.0, 10.0),
        "cyan_notch" => 0.88 * (1.0 - 0.92 * gauss(640.0, 55.0)),
        "magenta_notch" => 0.88 * (1.0 - 0.90 * gauss(545.0, 38.0)),
        "green_band" => 0.05 + 0.60 * gauss(525.0, 30.0),
        "beer_blue" => 0.9 * (-3.0 * gauss(610.0, 50.0) - 0.4 * gauss(700.0, 30.0)).exp(),
        "two_band_purple" => 0.05 + 0.5 * gauss(440.0, 25.0) + 0.7 * step(650.0, 8.0),
        "fringes_gray" => 0.45 + 0.2 * (std::f64::consts::TAU * 2.0 * 1.558 * 1000.0 / l).cos(),
        "saturated_out_of_gamut" => 0.98 * gauss(505.0, 12.0),
        "dark_film" => 0.02 + 0.03 * gauss(460.0, 20.0),
        other => panic!("no formula for {other}"),
    }
}

fn uniform(first: f64, last: f64, step: f64) -> Vec<f64> {
    (0..=((last - first) / step).round() as usize).map(|i| first + step * i as f64).collect()
}

fn colour_on(grid: &[f64], name: &str) -> Colour {
    let values: Vec<f64> = grid.iter().map(|&l| spectrum(name, l)).collect();
    Colorimeter::new(grid).unwrap().colour(&values).unwrap()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn both_reference_grids_are_reproduced() {
    let json = reference();
    for (key, grid) in [("g380_780_5", uniform(380., 780., 5.)), ("g400_700_10", uniform(400., 700., 10.))] {
        for case in json["spectra"].as_array().unwrap() {
            let name = case["name"].as_str().unwrap();
            let want = &case[key];
            let got = colour_on(&grid, name);
            // The tables are the same numbers, so only the file's 12 printed digits remain: 5e-10
            // of XYZ ≤ 109, and Lab, RGB from the same sums. Observed: XYZ 1.2e-10, Lab 3.4e-10,
            // RGB 5e-12, sRGB 5e-13.
            let xyz = largest_difference(&got.xyz, &numbers(&want["XYZ"]));
            let lab = largest_difference(&got.lab, &numbers(&want["Lab"]));
            let rgb = largest_difference(&got.linear_rgb, &numbers(&want["rgb_linear_whitenorm"]));
            let srgb = largest_difference(&got.srgb, &numbers(&want["srgb_whitenorm"]));
            assert!(xyz < 5e-10 && lab < 1e-9, "{key} {name}: XYZ off by {xyz:e}, Lab by {lab:e}");
            assert!(rgb < 2e-11 && srgb < 2e-12, "{key} {name}: RGB off by {rgb:e}, sRGB by {srgb:e}");
            assert_eq!(got.srgb8.map(f64::from).to_vec(), numbers(&want["srgb8_whitenorm"]), "{key} {name}");
            assert_eq!(!got.out_of_gamut, want["in_gamut"].as_bool().unwrap(), "{key} {name}");
        }
    }
}

#[test]
fn white_is_exactly_255_on_any_grid() {
    let grids =
        [uniform(400., 700., 20.), uniform(405., 690., 28.5), vec![420., 455., 500., 560., 600., 650.]];
    for grid in grids {
        let white = Colorimeter::new(&grid).unwrap().colour(&vec![1.0; grid.len()]).unwrap();
        assert_eq!((white.srgb8, white.out_of_gamut), ([255; 3], false));
        assert!(largest_difference(&white.lab, &[100.0, 0.0, 0.0]) < 1e-12);
    }
}

#[test]
fn coarse_grids_keep_the_colour() {
    let json = reference();
    // Resolution: about twice the largest ΔE observed. A band of σ = 12 nm is lost by such grids
    // and omitted.
    for (step, bound) in [(20.0, 1.0), (300.0 / 11.0, 2.5), (300.0 / 7.0, 12.0)] {
        let grid = uniform(400., 700., step);
        for case in json["spectra"].as_array().unwrap() {
            let name = case["name"].as_str().unwrap();
            let fine = colour_on(&uniform(400., 700., 5.), name);
            let delta = distance(colour_on(&grid, name).lab, fine.lab);
            println!("{} points, {name}: ΔE*ab {delta:.3}", grid.len());
            let narrow = name == "saturated_out_of_gamut";
            assert!(narrow || delta < bound, "{step} nm, {name}: ΔE {delta}");
        }
    }
}

#[test]
fn chroma_hue_and_differences_carry_first_order_errors() {
    let grid = uniform(400., 700., 10.);
    let meter = Colorimeter::new(&grid).unwrap();
    let values: Vec<f64> = grid.iter().map(|&l| spectrum("yellow_edge", l)).collect();
    let scaled = |s: f64| values.iter().map(|v| v * s).collect::<Vec<_>>();
    let replicates: Vec<_> = [0.999, 1.001].map(scaled).into();
    let colour = meter.colour_with_error(&values, &replicates).unwrap();
    let plain = meter.colour(&values).unwrap();
    assert_eq!((plain.chroma().standard_error, plain.delta_e_2000(&colour).standard_error), (None, None));
    // two replicates ±δ have jackknife variance δ²; chroma is a smooth function of the common scale
    let chroma_of = |s: f64| meter.colour(&scaled(s)).unwrap().chroma().value;
    let expected = (chroma_of(1.001) - chroma_of(0.999)) / 2.0;
    approx::assert_relative_eq!(colour.chroma().standard_error.unwrap(), expected, max_relative = 1e-3);
    assert!((colour.hue_deg().value - 94.6).abs() < 0.1 && colour.hue_deg().standard_error.unwrap() < 0.01);
    let other = meter.colour_with_error(&scaled(0.8), &replicates).unwrap();
    let old = distance(colour.lab, other.lab);
    let new = colour.delta_e_2000(&other);
    assert!(old > new.value && new.standard_error.unwrap() > 0.0);
    let noise = colour.delta_e_noise(&other);
    assert!(noise.unwrap() < old);
    assert_eq!(colour.delta_e_2000(&colour).standard_error, colour.delta_e_noise(&colour));
}

#[test]
fn unusable_grids_and_values_are_refused() {
    let refused = |grid: &[f64]| Colorimeter::new(grid).unwrap_err().to_string();
    assert!(refused(&[450.0, 550.0]).contains("2 entries"));
    assert!(refused(&[360.0, 500.0, 600.0]).contains("wavelengths_nm[0] = 360"));
    assert!(refused(&[450.0, 600.0, 550.0]).contains("wavelengths_nm[2] = 550"));
    assert!(refused(&[450.0, f64::NAN, 550.0]).contains("NaN"));
    assert!(refused(&[600.0, 620.0, 640.0]).contains("leave white"));
    let meter = Colorimeter::new(&[440.0, 550.0, 640.0]).unwrap();
    assert!(meter.colour(&[1.0; 2]).is_err());
    assert!(meter.colour(&[1.0, f64::NAN, 1.0]).unwrap_err().to_string().contains("at 550 nm = NaN"));
}

#[test]
fn ciede2000_meets_published_pairs() {
    // Sharma, Wu & Dalal (2005), pairs 1, 17 and 25: four decimals
    let colour = |lab| Colour { lab, ..colour_on(&uniform(400., 700., 10.), "perfect_white") };
    for (p, q, delta) in [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
    ] {
        approx::assert_abs_diff_eq!(colour(p).delta_e_2000(&colour(q)).value, delta, epsilon = 5e-5);
    }
}

/// At a* = 30, b* = 40 the hue changes by (−0.016, 0.012) rad a unit: 4·0.016² + 0.012² −
/// 2·0.016·0.012 = 0.028².
#[test]
fn the_error_of_the_hue_knows_the_correlation() {
    let lab_covariance = Some([[0.0; 3], [0.0, 4.0, 1.0], [0.0, 1.0, 1.0]]);
    let white = colour_on(&uniform(400., 700., 10.), "perfect_white");
    let colour = Colour { lab: [50.0, 30.0, 40.0], lab_covariance, ..white };
    let error = colour.hue_deg().standard_error.unwrap().to_radians();
    assert!((error - 0.028).abs() < 1e-12, "{error}");
}
