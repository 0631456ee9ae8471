//! The scatter of many seeds against the printed errors: a kind of the claim that needs no truth.

use super::{CHANCE, SPREAD};
use crate::claim::{Bound, Findings, Reason};
use crate::studies::{apart_from_the_grid, side_by_side};
use serde_json::Value;

/// A red ink in optical contact.
const STUDY: &str = include_str!("../../data/intervals-red.toml");
/// Seeds of each number of directions.
const SEEDS: i64 = 96;
/// Numbers of directions: the usual one, and one fewer, whose strata are half as wide again.
const COUNTS: [i64; 2] = [5, 4];

/// Scatter of L*, a*, b* over their printed errors without the grid's part, for the colours of a
/// study under two lights.
pub fn seeds(findings: &mut Findings) {
    for count in COUNTS {
        let all: Vec<Value> = side_by_side(SEEDS as usize, |seed| study(count, 1 + seed as i64));
        for (place, light) in ["natural light", "45:0"].into_iter().enumerate() {
            for (i, axis) in ["L*", "a*", "b*"].into_iter().enumerate() {
                let number = |key: &str, results: &Value| {
                    results["colours"][place][key][i].as_f64().expect("a number")
                };
                let values: Vec<f64> = all.iter().map(|results| number("lab", results)).collect();
                let errors: Vec<f64> =
                    all.iter().map(|results| number("lab_standard_error", results)).collect();
                let ratio = scatter(&values) / root_mean_square(&errors);
                let error = ratio / (2.0 * SEEDS as f64).sqrt();
                let what = format!(
                    "red, {count} directions, {SEEDS} seeds: scatter over printed error of {axis}, {light}"
                );
                let because = "0.85 to 1.1 are promised; the range adds 2.6 standard errors of the scatter of normal deviations";
                let bound = Bound::Within([SPREAD[0] - CHANCE * error, SPREAD[1] + CHANCE * error]);
                findings.check(what, ratio, bound, Reason::Significance, because);
            }
        }
    }
}

fn study(count: i64, seed: i64) -> Value {
    let mut study: toml::Table = STUDY.parse().expect("a study file");
    for (table, key, value) in [("angles", "count", count), ("run", "seed", seed)] {
        study[table].as_table_mut().expect("a table of the study").insert(key.into(), value.into());
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let results = apart_from_the_grid(&study.to_string(), &folder.path().join("out"));
    assert_eq!(results["colours"][0]["conditions"], "natural light");
    results
}

fn scatter(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}
