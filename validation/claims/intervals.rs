//! Printed intervals hold the truth as often as they say: a small study, many times over, against one large one.

use crate::claim::{Bound, Claim, Findings, Level, Reason, Table};
use crate::studies::{apart_from_the_grid, estimate, row};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

pub const CLAIM: Claim = Claim {
    id: "24-intervals",
    statement: "95 % intervals of a small study, apart from the grid's part, hold the truth of L*, a*, b*, R, T, natural light and 45:0 in ninety to ninety-nine cases of a hundred.",
    because: "The truth has 20 times the area in cells of 4.8 µm, 24 strata of directions and wavelengths 5 nm apart (validation/data/intervals.toml), on the same grid; only the seed differs between the small studies. The grid's part is judged by claims 8 and 15.",
    file: file!(),
    measure,
};

/// Quantities of a row of the spectra.
const SPECTRA: [&str; 4] = ["reflectance", "transmittance", "natural_light", "lit_at_45"];

const TRUTH: &str = include_str!("../data/intervals.toml");

/// What the claim needs of the truth, from the folder of its finished run.
pub fn truth(folder: &Path) -> Value {
    let results = apart_from_the_grid(TRUTH, folder);
    assert_eq!(results["status"], "complete", "the truth is not complete");
    let kept = |row: &Value| {
        let mut known = json!({ "wavelength_nm": row["wavelength_nm"] });
        SPECTRA.iter().for_each(|key| known[*key] = json!(estimate(&row[*key])));
        known
    };
    let rows = results["spectra"].as_array().expect("spectra").iter();
    let colour = |c: &Value| json!({ "conditions": c["conditions"], "lab": c["lab"], "standard_error": c["lab_standard_error"] });
    json!({
        "doc": "Made by `nightly --truth` from a finished run of intervals.toml; values with standard errors, the grid's part left out.",
        "study_hash": results["study_hash"],
        "method_version": results["method_version"],
        "solves": results["solves"],
        "colours": results["colours"].as_array().expect("colours").iter().map(colour).collect::<Vec<_>>(),
        "spectra": rows.filter(|row| row["polar_deg"] == 0.0).map(kept).collect::<Vec<_>>(),
    })
}

fn small(seed: u64) -> Value {
    let folder = tempfile::tempdir().expect("a temporary folder");
    apart_from_the_grid(&small_study(seed), &folder.path().join("out"))
}

/// The truth's ink in a few cells of 1.2 µm.
fn small_study(seed: u64) -> String {
    let mut study: toml::Table = TRUTH.parse().expect("a study file");
    let changes: [(&str, &str, toml::Value); 5] = [
        ("layer", "period_um", 1.2.into()),
        ("light", "per_realisation", 8.into()),
        ("angles", "count", 5.into()),
        ("run", "realisations", 4.into()),
        ("run", "seed", i64::try_from(seed).expect("a small seed").into()),
    ];
    for (table, key, value) in changes {
        let table = study[table].as_table_mut().expect("a table of the study");
        table.insert(key.into(), value).expect("a key that the truth has too");
    }
    study.to_string()
}

/// What a study says of the quantities that the truth has: deviations in standard errors, colours and spectra apart.
struct Deviations {
    colours: Vec<f64>,
    spectra: Vec<f64>,
    /// Factor on the standard errors that gives 95 % intervals.
    factor: f64,
}

/// Some of a study's deviations.
type Pick = fn(&Deviations) -> &[f64];

impl Deviations {
    fn of(results: &Value, truth: &Value) -> Self {
        let apart = |[x, dx]: [f64; 2], [y, dy]: [f64; 2]| (x - y) / dx.hypot(dy);
        let array = |value: &'static str| truth[value].as_array().expect("an array of the truth");
        let pair = |value: &Value| [0, 1].map(|i| value[i].as_f64().expect("a value and its error"));
        let colour = |known: &Value| -> Vec<f64> {
            let own = results["colours"].as_array().expect("colours");
            let own =
                own.iter().find(|c| c["conditions"] == known["conditions"]).expect("the same conditions");
            let at = |c: &Value, error: &str, i: usize| {
                [&c["lab"][i], &c[error][i]].map(|x| x.as_f64().expect("a number"))
            };
            (0..3).map(|i| apart(at(own, "lab_standard_error", i), at(known, "standard_error", i))).collect()
        };
        let spectrum = |known: &Value| -> Vec<f64> {
            let own = row(results, known["wavelength_nm"].as_f64().expect("a wavelength"), 0.0);
            SPECTRA.map(|key| apart(estimate(&own[key]), pair(&known[key]))).to_vec()
        };
        Self {
            colours: array("colours").iter().flat_map(colour).collect(),
            spectra: array("spectra").iter().flat_map(spectrum).collect(),
            factor: results["certainty"]["coverage_factor_95"].as_f64().expect("several realisations"),
        }
    }
}

fn measure(level: Level, findings: &mut Findings) {
    let truth: Value = serde_json::from_str(include_str!("../data/intervals.json")).expect("JSON");
    let seeds = level.pick(4, 40);
    let all: Vec<Deviations> =
        (0..seeds).into_par_iter().map(|seed| Deviations::of(&small(1001 + seed), &truth)).collect();
    let covered = |of: Pick, width: f64| {
        let inside = |d: &Deviations| of(d).iter().filter(|z| z.abs() <= width * d.factor).count();
        let count: usize = all.iter().map(|d| of(d).len()).sum();
        all.iter().map(inside).sum::<usize>() as f64 / count as f64
    };
    // Four studies say little; forty leave two per cent to chance, as what one study says of its colours belongs together.
    let bound = level.pick([0.75, 1.0], [0.90, 0.99]);
    let because = "95 % are meant; the range leaves what chance does to this many studies";
    let kinds: [(&str, Pick); 2] =
        [("L*, a*, b*", |d| &d.colours), ("R, T, natural light and 45:0 over the spectrum", |d| &d.spectra)];
    for (name, of) in kinds {
        let what = format!("share of 95 % intervals that hold the truth: {name}");
        findings.check(what, covered(of, 1.0), Bound::Within(bound), Reason::Significance, because);
    }
    if level == Level::Full {
        let what = "the same of both with bars half as wide, which would be noticed".to_string();
        let narrow = kinds.map(|(_, of)| covered(of, 0.5)).into_iter().fold(0.0, f64::max);
        findings.check(
            what,
            narrow,
            Bound::AtMost(bound[0]),
            Reason::Significance,
            "the power of the test above",
        );
    }
    findings.tables.push(table(&all, &truth));
}

/// Root mean square deviation of each colour's coordinate, in standard errors.
fn table(all: &[Deviations], truth: &Value) -> Table {
    let conditions = truth["colours"]
        .as_array()
        .expect("colours")
        .iter()
        .map(|c| c["conditions"].as_str().expect("words"));
    let rms = |i: usize| {
        let squares: f64 = all.iter().map(|d| d.colours[i].powi(2)).sum();
        format!("{:.2}", (squares / all.len() as f64).sqrt())
    };
    let cells =
        |(i, name): (usize, &str)| [name.to_string(), rms(3 * i), rms(3 * i + 1), rms(3 * i + 2)].to_vec();
    Table {
        title: format!(
            "Root mean square deviation from the truth over {} studies, in standard errors",
            all.len()
        ),
        columns: ["conditions", "L*", "a*", "b*"].map(String::from).to_vec(),
        rows: conditions.enumerate().map(cells).collect(),
    }
}
