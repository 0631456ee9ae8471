//! The printed intervals hold the truth as often as they say.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::{done, estimate, row};
use inkwave::numerics::estimate::coverage_factor_95;
use serde_json::Value;

pub const CLAIM: Claim = Claim {
    id: "19-coverage",
    statement: "95 % intervals of L*, a*, b*, R, T, natural light and 45°:0° of a small study hold the value of a 21 times larger one in 90–99 % of cases.",
    because: "Every realisation is an unbiased sample of cell, directions and wavelengths, so the jackknife over realisations holds all of them; grid and residual are added.",
    file: file!(),
    measure,
};

/// Values with standard errors of the large study; its file and script lie beside it.
const TRUTH: &str = include_str!("../data/coverage_truth.json");
const STUDY: &str = include_str!("../data/coverage-truth.toml");
/// Packings of a small study.
const REALISATIONS: usize = 6;
const SPECTRA: [&str; 4] = ["reflectance", "transmittance", "natural_light", "lit_at_45"];

/// The small study: smaller cells, fewer directions, wavelengths and packings.
fn small(seed: usize) -> Value {
    let small = [
        ("period_um = 4.8", "period_um = 1.2".to_owned()),
        ("per_realisation = 20", "per_realisation = 6".to_owned()),
        ("count = 12", "count = 4".to_owned()),
        ("realisations = 8", format!("realisations = {REALISATIONS}")),
        ("seed = 1000", format!("seed = {seed}")),
    ];
    let text = small.iter().fold(STUDY.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the truth's study has {from}");
        text.replace(from, to)
    });
    done(&text).results
}

/// Difference small − truth, the small study's standard error, and the truth's.
type Difference = [f64; 3];

/// All quantities of one study.
fn differences(small: &Value, truth: &Value) -> Vec<Difference> {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let mut all = Vec::new();
    for colour in small["colours"].as_array().expect("colours") {
        let name = colour["conditions"].as_str().expect("a name");
        for i in 0..3 {
            let (own, error) = (number(&colour["lab"][i]), number(&colour["lab_standard_error"][i]));
            let [want, its] = [0, 1].map(|k| number(&truth["colours"][name][k][i]));
            all.push([own - want, error, its]);
        }
    }
    for line in truth["spectra"].as_array().expect("spectra") {
        let own = row(small, number(&line["wavelength_nm"]), 0.0);
        for key in SPECTRA {
            let ([value, error], [want, its]) = (estimate(&own[key]), [0, 1].map(|k| number(&line[key][k])));
            all.push([value - want, error, its]);
        }
    }
    all
}

fn measure(level: Level, findings: &mut Findings) {
    let truth: Value = serde_json::from_str(TRUTH).expect("JSON");
    let factor = coverage_factor_95(REALISATIONS - 1).expect("several packings");
    let seeds = level.pick(4, 24);
    let all: Vec<Vec<Difference>> = (1..=seeds).map(|seed| differences(&small(seed), &truth)).collect();
    let flat = || all.iter().flatten();
    let held = |scale: f64| {
        flat().filter(|[apart, own, its]| apart.abs() <= scale * factor * own.hypot(*its)).count() as f64 / flat().count() as f64
    };
    let because = "95 % by construction; quantities of one study go together, so that the share of few studies scatters";
    findings.check("share of intervals that hold the truth", held(1.0), Bound::Within(level.pick([0.75, 1.0], [0.9, 0.99])), Reason::Significance, because);
    let because = "the power of the count: bars a third as long do not hold it";
    findings.check("share held by a third of the bar", held(1.0 / 3.0), Bound::AtMost(0.8), Reason::Significance, because);
    let count = all[0].len();
    let mean = |k: usize| {
        let samples = || all.iter().map(|study| study[k][0]);
        let mean = samples().sum::<f64>() / seeds as f64;
        let own = all.iter().map(|study| study[k][1].powi(2)).sum::<f64>().sqrt() / seeds as f64;
        mean.abs() / own.hypot(all[0][k][2])
    };
    let worst = (0..count).map(mean).fold(0.0, f64::max);
    let because = "means over all seeds against the truth and its own error: a bias would stand out; the worst of some 30";
    findings.check("largest mean difference, in errors", worst, Bound::AtMost(4.5), Reason::Significance, because);
}
