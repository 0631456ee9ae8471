//! Spectra → XYZ, Lab and sRGB against plain sums.

use crate::claim::{Claim, Findings, Level};
use inkwave::appearance::tristimulus::Colorimeter;
use serde_json::Value;
use std::f64::consts::TAU;

pub const CLAIM: Claim = Claim {
    id: "14-colour",
    statement: "Reflectance spectra have the colours of the tables, and a perfect white is exactly white on any wavelengths.",
    because: "CIE 1931 2° and D65 summed plainly by an independent script (data/colour.json); white is the normalisation (CIE 15).",
    file: file!(),
    measure,
};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// The reference's spectra, by the formulas printed there.
fn spectrum(name: &str, l: f64) -> f64 {
    let bell = |centre: f64, width: f64| (-((l - centre) / width).powi(2) / 2.0).exp();
    let step = |centre: f64, width: f64| 1.0 / (1.0 + (-(l - centre) / width).exp());
    match name {
        "flat_0.9" => 0.9,
        "perfect_white" => 1.0,
        "yellow_edge" => 0.05 + 0.85 * step(510.0, 12.0),
        "red_edge" => 0.04 + 0.80 * step(600.0, 10.0),
        "cyan_notch" => 0.88 * (1.0 - 0.92 * bell(640.0, 55.0)),
        "magenta_notch" => 0.88 * (1.0 - 0.90 * bell(545.0, 38.0)),
        "green_band" => 0.05 + 0.60 * bell(525.0, 30.0),
        "beer_blue" => 0.9 * (-3.0 * bell(610.0, 50.0) - 0.4 * bell(700.0, 30.0)).exp(),
        "two_band_purple" => 0.05 + 0.5 * bell(440.0, 25.0) + 0.7 * step(650.0, 8.0),
        "fringes_gray" => 0.45 + 0.2 * (TAU * 2.0 * 1.558 * 1000.0 / l).cos(),
        "saturated_out_of_gamut" => 0.98 * bell(505.0, 12.0),
        "dark_film" => 0.02 + 0.03 * bell(460.0, 20.0),
        other => panic!("no formula for {other}"),
    }
}

fn wavelengths(first: f64, last: f64, step: f64) -> Vec<f64> {
    (0..=((last - first) / step).round() as usize).map(|i| first + step * i as f64).collect()
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

fn measure(_: Level, findings: &mut Findings) {
    let file: Value = serde_json::from_str(include_str!("../data/colour.json")).expect("JSON");
    let mut xyz = 0.0f64;
    let mut lab = 0.0f64;
    let mut rgb = 0.0f64;
    let mut bytes = 0.0f64;
    for (key, grid) in
        [("g380_780_5", wavelengths(380., 780., 5.)), ("g400_700_10", wavelengths(400., 700., 10.))]
    {
        let meter = Colorimeter::new(&grid).expect("a grid");
        for case in file["spectra"].as_array().expect("spectra") {
            let name = case["name"].as_str().expect("a name");
            let values: Vec<f64> = grid.iter().map(|&l| spectrum(name, l)).collect();
            let got = meter.colour(&values).expect("a colour");
            let want = &case[key];
            xyz = xyz.max(largest(&got.xyz, &numbers(&want["XYZ"])));
            lab = lab.max(largest(&got.lab, &numbers(&want["Lab"])));
            rgb = rgb.max(largest(&got.srgb, &numbers(&want["srgb_whitenorm"])));
            bytes = bytes.max(largest(&got.srgb8.map(f64::from), &numbers(&want["srgb8_whitenorm"])));
        }
    }
    findings.identity("XYZ", xyz, 5e-10, "12 printed digits of values up to 109");
    findings.identity("Lab", lab, 1e-9, "the same digits through a cube root");
    findings.identity("sRGB, 0–1", rgb, 2e-12, "12 printed digits");
    findings.identity("sRGB, 8 bits", bytes, 0.5, "whole numbers");
    let grids = [
        wavelengths(400., 700., 20.),
        wavelengths(405., 690., 28.5),
        vec![420., 455., 500., 560., 600., 650.],
    ];
    let white = grids.iter().map(|grid| {
        let white = Colorimeter::new(grid).expect("a grid").colour(&vec![1.0; grid.len()]).expect("white");
        largest(&white.lab, &[100.0, 0.0, 0.0]).max(largest(&white.srgb8.map(f64::from), &[255.0; 3]))
    });
    findings.identity(
        "white on uneven grids",
        white.fold(0.0, f64::max),
        1e-12,
        "white is the normalisation",
    );
}
