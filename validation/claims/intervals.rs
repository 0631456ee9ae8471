//! Printed intervals hold the truth as often as they say: a small study, many times over, against one large one.

mod small;

use crate::claim::{Bound, Claim, Findings, Level, Reason, Table};
use crate::studies::{apart_from_the_grid, estimate};
use rayon::prelude::*;
use serde_json::{Value, json};
use small::{Known, Shift, Small};
use std::path::Path;

pub const CLAIM: Claim = Claim {
    id: "24-intervals",
    statement: "95 % intervals of a small study hold the truth of L*, a*, b*, R, T, natural light and 45:0 in ninety to ninety-nine cases of a hundred; the grid's part of them holds what a grid twice as fine changes.",
    because: "The truth has 20 times the area in cells of 4.8 µm, 24 strata of directions and wavelengths 5 nm apart (validation/data/intervals.toml); only the seed differs between the small studies. First all stand on one grid, and the bars go without the grid's part. Then the bars are those that are printed, and the truth is moved to twice the points and planes, by what that changes in studies of the same packings.",
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
    fn of(results: &Value, truth: &Value, known: &Known) -> Self {
        let apart = |([x, dx], [y, dy]): (&[f64; 2], &[f64; 2])| (x - y) / dx.hypot(*dy);
        let own = Known::of(results, truth);
        Self {
            colours: own.colours.iter().zip(&known.colours).map(apart).collect(),
            spectra: own.spectra.iter().zip(&known.spectra).map(apart).collect(),
            factor: results["certainty"]["coverage_factor_95"].as_f64().expect("several realisations"),
        }
    }
}

/// Both kinds of quantities by name.
const KINDS: [(&str, Pick); 2] =
    [("L*, a*, b*", |d| &d.colours), ("R, T, natural light and 45:0 over the spectrum", |d| &d.spectra)];

/// Share of a kind's deviations that bars `width` times as wide hold.
fn covered(all: &[Deviations], of: Pick, width: f64) -> f64 {
    let inside = |d: &Deviations| of(d).iter().filter(|z| z.abs() <= width * d.factor).count();
    let count: usize = all.iter().map(|d| of(d).len()).sum();
    all.iter().map(inside).sum::<usize>() as f64 / count as f64
}

fn measure(level: Level, findings: &mut Findings) {
    let truth: Value = serde_json::from_str(include_str!("../data/intervals.json")).expect("JSON");
    let (seeds, finer) = level.pick((4, 2), (40, 8));
    let studies: Vec<Small> = (0..seeds).into_par_iter().map(|seed| Small::run(1001 + seed, 1.0)).collect();
    let shift = |seed: u64| Shift::of(&studies[seed as usize], &Small::run(1001 + seed, 2.0), &truth);
    let shifts: Vec<Shift> = (0..finer).into_par_iter().map(shift).collect();
    let known = Known::of_truth(&truth);
    let deviations = |results: fn(&Small) -> &Value, known: &Known| -> Vec<Deviations> {
        studies.iter().map(|small| Deviations::of(results(small), &truth, known)).collect()
    };
    let all = deviations(|small| &small.apart, &known);
    chance(level, &all, findings);
    let changes: Vec<Vec<f64>> = shifts.iter().map(|shift| shift.change.clone()).collect();
    printed(level, &deviations(|small| &small.printed, &known.moved(&changes)), &shifts, findings);
    findings.tables.push(table(&all, &truth));
}

/// Four studies say little; forty leave two per cent to chance, as what one study says of its colours belongs together.
fn bounds(level: Level) -> [f64; 2] {
    level.pick([0.75, 1.0], [0.90, 0.99])
}

/// On the truth's own grid, with bars apart from the grid's part.
fn chance(level: Level, all: &[Deviations], findings: &mut Findings) {
    let bound = bounds(level);
    let because = "95 % are meant; the range leaves what chance does to this many studies";
    for (name, of) in KINDS {
        let what = format!("share of 95 % intervals that hold the truth: {name}");
        findings.check(what, covered(all, of, 1.0), Bound::Within(bound), Reason::Significance, because);
    }
    if level == Level::Full {
        let what = "the same of both with bars half as wide, which would be noticed".to_string();
        let narrow = KINDS.map(|(_, of)| covered(all, of, 0.5)).into_iter().fold(0.0, f64::max);
        let because = "the power of the test above";
        findings.check(what, narrow, Bound::AtMost(bound[0]), Reason::Significance, because);
    }
}

/// As printed, against the truth on twice the points and planes; and the grid's part of the bars by itself.
fn printed(level: Level, all: &[Deviations], shifts: &[Shift], findings: &mut Findings) {
    let because = "the grid's part is the largest at the probes, so the bars may hold more than 95 %";
    for (name, of) in KINDS {
        let what =
            format!("share of printed intervals that hold the truth on twice the points and planes: {name}");
        let least = Bound::AtLeast(bounds(level)[0]);
        findings.check(what, covered(all, of, 1.0), least, Reason::Significance, because);
    }
    let count: usize = shifts.iter().map(|shift| shift.change.len()).sum();
    let held = |width: f64| shifts.iter().map(|shift| shift.held(width)).sum::<usize>() as f64 / count as f64;
    let what =
        "share of changes by twice the points and planes that the grid's part of the bars holds".to_string();
    let because = "95 % are meant; claims 8 and 15 judge the errors of single amplitudes";
    findings.check(what, held(1.0), Bound::AtLeast(0.95), Reason::Promise, because);
    if level == Level::Full {
        let what = "the same with a twentieth of that part, which would be noticed".to_string();
        findings.check(what, held(0.05), Bound::AtMost(0.95), Reason::Promise, "the power of the test above");
    }
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
