//! Printed intervals hold the truth as often as they say: a small study, many times over, against one large one.

mod seeds;
mod small;

use crate::claim::{Bound, Claim, Findings, Level, Reason, Table};
use crate::studies::{apart_from_the_grid, estimate, side_by_side};
use inkwave::numerics::estimate::Estimate;
use serde_json::{Value, json};
use small::{Cells, Known, Shift, Small};
use std::path::Path;

pub const CLAIM: Claim = Claim {
    id: "24-intervals",
    statement: "95 % intervals of small studies of three inks hold the truth of L*, a*, b*, R and T at 0° and 45°, natural light and 45:0 in 93 to 97 cases of a hundred, with 8, 16 and 40 cells and where a target ends the study; the grid's part of them holds what a grid twice as fine changes.",
    because: "The truths have 24 to 40 cells of 4.8 or 3.2 µm (validation/data/intervals*.toml); only the seed differs between the small studies. First all stand on one grid, and the bars go without the grid's part. Then the bars are those that are printed, and the truth is moved to twice the points and planes, by what that changes in studies of the same packings.",
    file: file!(),
    measure,
};

/// Quantities of a row of the spectra; those of light from all sides stand in the row of 0°.
const SPECTRA: [&str; 4] = ["reflectance", "transmittance", "natural_light", "lit_at_45"];

/// Coverage that is promised of 95 % intervals.
const PROMISED: [f64; 2] = [0.93, 0.97];
/// Root mean square of deviations over their standard errors that is promised.
const SPREAD: [f64; 2] = [0.85, 1.1];
/// Standard errors by which a sample may miss what is promised: one in a hundred does.
const CHANCE: f64 = 2.6;
/// ΔE₀₀ at which the stopping rule ends, between 16 and 40 cells.
const TARGET: f64 = 0.6;

/// Angles of the spectra that are kept, degrees.
const ANGLES: [f64; 2] = [0.0, 45.0];

/// An ink whose truth is known.
pub struct Ink {
    /// File name of the truth's study without its ending, and what is kept of its run.
    pub name: &'static str,
    study: &'static str,
    known: &'static str,
    /// Small studies of each kind, and how many of them say what a finer grid changes.
    kinds: &'static [(Cells, u64, u64)],
}

/// A yellow ink; a blue one with larger grains; clear grains, whose T is skew: resonances of single cells lower it.
const INKS: [Ink; 3] = [
    Ink {
        name: "intervals",
        study: include_str!("../data/intervals.toml"),
        known: include_str!("../data/intervals.json"),
        kinds: &[
            (Cells::Fixed(8), 120, 8),
            (Cells::Fixed(16), 60, 4),
            (Cells::Fixed(40), 40, 2),
            (Cells::Until(TARGET), 60, 6),
        ],
    },
    Ink {
        name: "intervals-blue",
        study: include_str!("../data/intervals-blue.toml"),
        known: include_str!("../data/intervals-blue.json"),
        kinds: &[(Cells::Fixed(8), 120, 4), (Cells::Until(TARGET), 96, 6)],
    },
    Ink {
        name: "intervals-clear",
        study: include_str!("../data/intervals-clear.toml"),
        known: include_str!("../data/intervals-clear.json"),
        kinds: &[(Cells::Fixed(8), 180, 4), (Cells::Fixed(16), 120, 2)],
    },
];

/// What the claim needs of a truth, from the folder of its finished run, which has its study's name.
pub fn truth(folder: &Path) -> Value {
    let named = |ink: &&Ink| folder.file_name().is_some_and(|name| name == ink.name);
    let ink = INKS.iter().find(named).expect("a folder with the name of a truth's study");
    let results = apart_from_the_grid(ink.study, folder);
    assert_eq!(results["status"], "complete", "the truth is not complete");
    let kept = |row: &Value| {
        let mut known = json!({ "wavelength_nm": row["wavelength_nm"], "polar_deg": row["polar_deg"] });
        for key in SPECTRA {
            let pair = estimate(&row[key]);
            if pair.iter().all(|x| x.is_finite()) {
                known[key] = json!(pair);
            }
        }
        known
    };
    let rows = results["spectra"].as_array().expect("spectra").iter();
    let polar = |row: &Value| row["polar_deg"].as_f64().expect("an angle");
    let wanted = |row: &&Value| ANGLES.iter().any(|deg| (polar(row) - deg).abs() < 1e-6);
    let colour = |c: &Value| json!({ "conditions": c["conditions"], "lab": c["lab"], "standard_error": c["lab_standard_error"] });
    json!({
        "doc": "Made by `nightly --truth` from a finished run of the study; values with standard errors, the grid's part left out.",
        "study_hash": results["study_hash"],
        "method_version": results["method_version"],
        "solves": results["solves"],
        "colours": results["colours"].as_array().expect("colours").iter().map(colour).collect::<Vec<_>>(),
        "spectra": rows.filter(wanted).map(kept).collect::<Vec<_>>(),
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

/// Share of a kind's deviations that bars `width` times as wide hold, with its error by the studies.
fn covered(all: &[Deviations], of: Pick, width: f64) -> Estimate {
    let share = |d: &Deviations| {
        of(d).iter().filter(|z| z.abs() <= width * d.factor).count() as f64 / of(d).len() as f64
    };
    Estimate::of_mean(&all.iter().map(share).collect::<Vec<_>>())
}

/// Root mean square of a kind's deviations in units of the bars' 95 % over 1.96, with its error by the studies.
fn spread(all: &[Deviations], of: Pick) -> [f64; 2] {
    let square = |d: &Deviations| {
        of(d).iter().map(|z| (1.96 * z / d.factor).powi(2)).sum::<f64>() / of(d).len() as f64
    };
    let mean = Estimate::of_mean(&all.iter().map(square).collect::<Vec<_>>());
    let rms = mean.value.sqrt();
    [rms, 0.5 * mean.standard_error.unwrap_or(0.0) / rms]
}

fn measure(level: Level, findings: &mut Findings) {
    for ink in &INKS[..level.pick(1, INKS.len())] {
        let truth: Value = serde_json::from_str(ink.known).expect("JSON");
        let quick = [(Cells::Fixed(8), 4, 2)];
        for &kind in level.pick(&quick[..], ink.kinds) {
            small_studies(level, (ink, &truth), kind, findings);
        }
    }
    if level == Level::Full {
        seeds::seeds(findings);
    }
}

/// Small studies of one kind, and of the finer grid as many as say what it changes.
fn small_studies(
    level: Level,
    (ink, truth): (&Ink, &Value),
    (cells, seeds, finer): (Cells, u64, u64),
    findings: &mut Findings,
) {
    let wavelengths = level.pick(4, 8);
    let run = |seed, factor| Small::run(ink.study, cells, wavelengths, 1001 + seed, factor);
    let studies: Vec<Small> = side_by_side(seeds as usize, |seed| run(seed as u64, 1.0));
    let shift = |seed: usize| Shift::of(&studies[seed], &run(seed as u64, 2.0), truth);
    let shifts: Vec<Shift> = side_by_side(finer as usize, shift);
    let known = Known::of_truth(truth);
    let deviations = |results: fn(&Small) -> &Value, known: &Known| -> Vec<Deviations> {
        studies.iter().map(|small| Deviations::of(results(small), truth, known)).collect()
    };
    let kind =
        format!("{}, {cells}", ink.name.trim_start_matches("intervals-").replace("intervals", "yellow"));
    let all = deviations(|small| &small.apart, &known);
    chance(level, &kind, &all, findings);
    let changes: Vec<Vec<f64>> = shifts.iter().map(|shift| shift.change.clone()).collect();
    let printed_all = deviations(|small| &small.printed, &known.moved(&changes));
    printed(level, &kind, &printed_all, &shifts, findings);
    findings.tables.push(table(&kind, &all, truth));
}

/// What is promised, widened by what chance does to the share of a number of studies: 2.6 of its standard errors, one in a
/// hundred. A share near one says little of its own error, which is at least that of two independent numbers a study.
/// Four studies are too few for that.
fn bounds(level: Level, share: &Estimate, studies: usize) -> [f64; 2] {
    let least = (PROMISED[1] * (1.0 - PROMISED[1]) / (2.0 * studies as f64)).sqrt();
    let chance = CHANCE * share.standard_error.unwrap_or(0.0).max(least);
    level.pick([0.75, 1.0], [PROMISED[0] - chance, PROMISED[1] + chance])
}

/// On the truth's own grid, with bars apart from the grid's part.
fn chance(level: Level, kind: &str, all: &[Deviations], findings: &mut Findings) {
    let because = "93 to 97 % are promised; the range adds 2.6 standard errors of the share, by the studies it comes from";
    for (name, of) in KINDS {
        let share = covered(all, of, 1.0);
        let what = format!("{kind}: share of 95 % intervals that hold the truth: {name}");
        findings.check(
            what,
            share.value,
            Bound::Within(bounds(level, &share, all.len())),
            Reason::Significance,
            because,
        );
        if level == Level::Full {
            let what = format!("{kind}: root mean square deviation over its law's: {name}");
            let because = "0.85 to 1.1 are promised, Student's law scaled to the normal one by its 95 % factor; the range adds 2.6 standard errors of the sample, by the studies";
            let [rms, error] = spread(all, of);
            let bound = Bound::Within([SPREAD[0] - CHANCE * error, SPREAD[1] + CHANCE * error]);
            findings.check(what, rms, bound, Reason::Significance, because);
        }
    }
    if level == Level::Full {
        let what = format!("{kind}: how many of the four tests above would notice bars two thirds as wide");
        let narrow = |(_, of): &(&str, Pick)| {
            let share = covered(all, *of, 2.0 / 3.0);
            let [rms, error] = spread(all, *of).map(|x| 1.5 * x);
            let tests = [share.value < bounds(level, &share, all.len())[0], rms - CHANCE * error > SPREAD[1]];
            tests.into_iter().filter(|notices| *notices).count()
        };
        let noticed: usize = KINDS.iter().map(narrow).sum();
        findings.check(what, noticed as f64, Bound::AtLeast(1.0), Reason::Significance, "their power");
    }
}

/// As printed, against the truth on twice the points and planes; and the grid's part of the bars by itself.
fn printed(level: Level, kind: &str, all: &[Deviations], shifts: &[Shift], findings: &mut Findings) {
    let because = "the grid's part is the largest at the probes, so the bars may hold more than 95 %";
    for (name, of) in KINDS {
        let share = covered(all, of, 1.0);
        let what = format!(
            "{kind}: share of printed intervals that hold the truth on twice the points and planes: {name}"
        );
        let least = Bound::AtLeast(bounds(level, &share, all.len())[0]);
        findings.check(what, share.value, least, Reason::Significance, because);
    }
    let held =
        |width: f64| Estimate::of_mean(&shifts.iter().map(|shift| shift.held(width)).collect::<Vec<_>>());
    let what = format!(
        "{kind}: share of changes by twice the points and planes that the grid's part of the bars holds"
    );
    let because = "95 % are meant, less 2.6 standard errors by the studies; claims 8 and 15 judge the errors of single amplitudes";
    let share = held(1.0);
    let least = Bound::AtLeast(0.95 - CHANCE * share.standard_error.unwrap_or(0.0));
    findings.check(what, share.value, least, Reason::Significance, because);
    if level == Level::Full {
        let what =
            format!("{kind}: share of those changes that a twentieth of that part holds, which is noticed");
        findings.check(
            what,
            held(0.05).value,
            Bound::AtMost(0.95),
            Reason::Promise,
            "the power of the test above",
        );
    }
}

/// Root mean square deviation of each colour's coordinate, in standard errors.
fn table(kind: &str, all: &[Deviations], truth: &Value) -> Table {
    let conditions = truth["colours"]
        .as_array()
        .expect("colours")
        .iter()
        .map(|c| c["conditions"].as_str().expect("words"));
    let rms = |i: usize| {
        let squares: f64 = all.iter().map(|d| d.colours[i].powi(2)).sum();
        format!("{:.2}", (squares / all.len() as f64).sqrt())
    };
    let row =
        |(i, name): (usize, &str)| [name.to_string(), rms(3 * i), rms(3 * i + 1), rms(3 * i + 2)].to_vec();
    Table {
        title: format!(
            "{kind}: root mean square deviation from the truth over {} studies, in standard errors",
            all.len()
        ),
        columns: ["conditions", "L*", "a*", "b*"].map(String::from).to_vec(),
        rows: conditions.enumerate().map(row).collect(),
    }
}
