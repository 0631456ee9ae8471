//! Layers composed of slabs against layers solved at once, and what they may not lose.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::{composed, done, estimate};
use serde_json::Value;

pub const CLAIM: Claim = Claim {
    id: "26-composed",
    statement: "A layer composed of slabs is the layer solved at once, within both error bars, and it loses no light at 100 µm: clear grains have R + T = 1, 1/T grows evenly with the thickness, and on a perfect white all light comes back.",
    because: "Flux matrices are reciprocal and conserve energy column by column; the surfaces are solved together with the outermost slabs.",
    file: file!(),
    measure,
};

/// Angles that both ways report, degrees, with the name of the composed number's end.
const ANGLES: [(f64, &str); 2] = [(0.0, "normal"), (45.0, "45")];
/// Largest distance in standard errors: four comparisons exceed it by chance in 1 % of all runs at eight realisations, with
/// Student's law of as many degrees of freedom as there are realisations.
const FARTHEST: f64 = 4.5;

fn layer(thickness: &str, rest: &str, level: Level) -> String {
    format!(
        "[layer]\nthickness_um = {thickness}\nperiod_um = 1.0\nbinder.index = 1.5\n{rest}\n\
         [[pigment]]\nname = 'grains'\ndiameter_nm = 250\nvolume_fraction = 0.15\nshare = 'scale_sizes'\nindex = 2.0\n\
         [paper]\nalbedo = 1.0\n[light]\nwavelengths_nm = [550]\n[run]\nrealisations = {}\n\
         [resolution]\naccuracy = 3e-2\n",
        level.pick(8, 24)
    )
}

fn measure(level: Level, findings: &mut Findings) {
    let stack = composed(&layer("[2, 50, 75, 100]", "composed = { slab_um = 1.0 }", level));
    let rows = stack["spectra"].as_array().cloned().unwrap_or_default();
    let value = |row: &Value, name: &str| estimate(&row[name])[0];
    for row in &rows {
        let um = &row["thickness_um"];
        for light in ["normal", "45", "diffuse"] {
            let sum =
                value(row, &format!("reflectance_{light}")) + value(row, &format!("transmittance_{light}"));
            let because = "columns are scaled to R + T = 1 − A, and composing loses nothing: rounding of some hundred products";
            findings.identity(format!("R + T − 1 of {um} µm, {light}"), (sum - 1.0).abs(), 1e-7, because);
        }
        let because = "the furnace, through a layer that transmits little: rounding over T";
        let lost = (value(row, "natural_light") - 1.0).abs();
        findings.identity(format!("light lost on white paper, {um} µm"), lost, 1e-6, because);
    }
    let through: Vec<f64> = rows.iter().map(|row| 1.0 / value(row, "transmittance_diffuse")).collect();
    if let [_, a, b, c] = through[..] {
        let because = "clear grains: 1/T of diffuse light grows by the same for every slab; rounding of some hundred products";
        findings.identity(
            "1/T from 50 to 75 µm less that from 75 to 100 µm, relative",
            ((c - b) / (b - a) - 1.0).abs(),
            1e-5,
            because,
        );
    }
    let whole = done(&format!("{}[angles]\ncount = 3\n", layer("2", "", level)));
    let solved = whole.results["spectra"].as_array().cloned().unwrap_or_default();
    for (deg, name) in ANGLES {
        let own = solved.iter().find(|row| row["polar_deg"].as_f64() == Some(deg));
        for lobe in ["reflectance", "transmittance"] {
            let [a, a_error] = estimate(&rows[0][format!("{lobe}_{name}")]);
            let [b, b_error] = own.map_or([f64::NAN; 2], |row| estimate(&row[lobe]));
            findings.check(
                format!("{lobe} of 2 µm at {deg}°: composed less solved at once, in standard errors"),
                (a - b) / a_error.hypot(b_error),
                Bound::AtMost(FARTHEST),
                Reason::Significance,
                "four comparisons of few realisations",
            );
        }
    }
}
