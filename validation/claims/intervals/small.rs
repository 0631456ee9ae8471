//! The small studies of the claim: what they are, what they know, what a finer grid changes in them.

use super::SPECTRA;
use crate::studies::{estimate, row, with_and_without_the_grid};
use inkwave::numerics::estimate::Estimate;
use serde_json::Value;
use std::fmt;

/// A small study as it is printed, and with bars that hold everything but the grid's part.
pub struct Small {
    pub printed: Value,
    pub apart: Value,
}

/// How many cells a small study has.
#[derive(Clone, Copy, Debug)]
pub enum Cells {
    Fixed(u32),
    /// As many as this target of ΔE₀₀ takes, at most 64.
    Until(f64),
}

impl fmt::Display for Cells {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Fixed(count) => write!(f, "{count} cells"),
            Self::Until(target) => write!(f, "cells until ΔE₀₀ ± {target}"),
        }
    }
}

impl Small {
    /// A study of the truth's ink with this number of wavelengths in every cell.
    pub fn run(truth: &str, cells: Cells, wavelengths: i64, seed: u64, finer: f64) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let study = small_study(truth, cells, wavelengths, seed, finer);
        let [printed, apart] = with_and_without_the_grid(&study, &folder.path().join("out"));
        Self { printed, apart }
    }
}

/// The truth's ink in a few cells of 1.6 µm, on a grid `finer` times as fine as the truth's.
fn small_study(truth: &str, cells: Cells, wavelengths: i64, seed: u64, finer: f64) -> String {
    let mut study: toml::Table = truth.parse().expect("a study file");
    let per_um = |key: &str| study["resolution"][key].as_integer().expect("points or planes") as f64;
    let points = finer * per_um("points_per_um");
    let planes = finer * per_um("planes_per_um");
    let (most, target) = match cells {
        Cells::Fixed(count) => (count, None),
        Cells::Until(target) => (64, Some(target)),
    };
    if let Some(target) = target {
        study["run"].as_table_mut().expect("a table").insert("target_delta_e".into(), target.into());
    }
    let changes: [(&str, &str, toml::Value); 7] = [
        ("layer", "period_um", 1.6.into()),
        ("light", "per_realisation", wavelengths.into()),
        ("angles", "count", 5.into()),
        ("run", "realisations", i64::from(most).into()),
        ("run", "seed", i64::try_from(seed).expect("a small seed").into()),
        ("resolution", "points_per_um", points.into()),
        ("resolution", "planes_per_um", planes.into()),
    ];
    for (table, key, value) in changes {
        let table = study[table].as_table_mut().expect("a table of the study");
        table.insert(key.into(), value).expect("a key that the truth has too");
    }
    study.to_string()
}

/// Values with their standard errors: colours, and R, T, natural light and 45:0 over the spectrum.
#[derive(Clone)]
pub struct Known {
    pub colours: Vec<[f64; 2]>,
    pub spectra: Vec<[f64; 2]>,
}

impl Known {
    fn all(&self) -> impl Iterator<Item = &[f64; 2]> {
        self.colours.iter().chain(&self.spectra)
    }

    /// What the claim keeps of the truth.
    pub fn of_truth(truth: &Value) -> Self {
        let array = |value: &'static str| truth[value].as_array().expect("an array of the truth").iter();
        let pair = |value: &Value| [0, 1].map(|i| value[i].as_f64().expect("a value and its error"));
        let spectrum = |row: &Value| -> Vec<[f64; 2]> {
            SPECTRA.iter().filter_map(|key| row.get(*key)).map(pair).collect()
        };
        Self {
            colours: array("colours").flat_map(|c| lab(c, "standard_error")).collect(),
            spectra: array("spectra").flat_map(spectrum).collect(),
        }
    }

    /// The same of a study's results.
    pub fn of(results: &Value, truth: &Value) -> Self {
        let array = |value: &'static str| truth[value].as_array().expect("an array of the truth").iter();
        let colours = results["colours"].as_array().expect("colours");
        let colour = |known: &Value| {
            let same = colours.iter().find(|c| c["conditions"] == known["conditions"]);
            lab(same.expect("the same conditions"), "lab_standard_error")
        };
        let spectrum = |known: &Value| -> Vec<[f64; 2]> {
            let nm = known["wavelength_nm"].as_f64().expect("a number");
            let deg = known["polar_deg"].as_f64().expect("a number");
            let row = row(results, nm, deg);
            SPECTRA.iter().filter(|key| known.get(**key).is_some()).map(|key| estimate(&row[*key])).collect()
        };
        Self {
            colours: array("colours").flat_map(colour).collect(),
            spectra: array("spectra").flat_map(spectrum).collect(),
        }
    }

    /// Moved by the mean of some shifts, with its standard error.
    pub fn moved(&self, shifts: &[Vec<f64>]) -> Self {
        let mut moved = self.clone();
        for (i, [value, error]) in moved.colours.iter_mut().chain(&mut moved.spectra).enumerate() {
            let samples: Vec<f64> = shifts.iter().map(|shift| shift[i]).collect();
            let mean = Estimate::of_mean(&samples);
            *value += mean.value;
            *error = error.hypot(mean.standard_error.unwrap_or(0.0));
        }
        moved
    }
}

fn lab(colour: &Value, error: &str) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|i| [&colour["lab"][i], &colour[error][i]].map(|x| x.as_f64().expect("a number")))
}

/// What twice the points and planes change in one study's numbers, and the grid's part of their bars.
pub struct Shift {
    pub change: Vec<f64>,
    part: Vec<f64>,
}

impl Shift {
    pub fn of(small: &Small, finer: &Small, truth: &Value) -> Self {
        let printed = Known::of(&small.printed, truth);
        let apart = Known::of(&small.apart, truth);
        let finer = Known::of(&finer.apart, truth);
        let part =
            |([_, whole], [_, rest]): (&[f64; 2], &[f64; 2])| (whole * whole - rest * rest).max(0.0).sqrt();
        Self {
            change: finer.all().zip(printed.all()).map(|([fine, _], [own, _])| fine - own).collect(),
            part: printed.all().zip(apart.all()).map(part).collect(),
        }
    }

    /// Share of the changes that are within 1.96 of the parts times `width`.
    pub fn held(&self, width: f64) -> f64 {
        let pairs = self.change.iter().zip(&self.part);
        let held = pairs.filter(|(change, part)| change.abs() <= 1.96 * width * **part).count();
        held as f64 / self.change.len() as f64
    }
}
