//! Earlier nights: one line per claim and night, and what tonight's margins are against them.

use crate::claim::Level;
use crate::manifest::Manifest;
use crate::{Judged, Measured};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::path::Path;

/// One claim on one night.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Night {
    pub date: String,
    pub commit: String,
    pub level: Level,
    pub claim: String,
    pub holds: bool,
    /// The measurement with the smallest margin.
    pub measurement: String,
    pub measured: f64,
    pub margin: f64,
    pub seconds: f64,
}

/// Nights that tonight is compared with.
const RECENT: usize = 7;
/// A margin below this share of its recent median is shrinking.
const SHRUNK: f64 = 0.67;

/// Earlier nights of that level; none when there is no file yet.
pub fn read(path: &Path, level: Level) -> Result<Vec<Night>, Box<dyn Error>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let nights: Result<Vec<Night>, csv::Error> = csv::Reader::from_path(path)?.deserialize().collect();
    let nights = nights.map_err(|e| format!("{}: {e}; mend or move the file", path.display()))?;
    Ok(nights.into_iter().filter(|n| n.level == level).collect())
}

/// Adds tonight; the file is replaced whole.
pub fn append(path: &Path, manifest: &Manifest, judged: &[Judged]) -> Result<(), Box<dyn Error>> {
    let mut bytes = if path.exists() { std::fs::read(path)? } else { Vec::new() };
    let mut writer = csv::WriterBuilder::new().has_headers(bytes.is_empty()).from_writer(Vec::new());
    for j in judged {
        writer.serialize(night(manifest, &j.measured))?;
    }
    bytes.extend(writer.into_inner()?);
    Ok(inkwave::store::safely::write(path, &bytes)?)
}

fn night(manifest: &Manifest, measured: &Measured) -> Night {
    let tightest = measured.findings.tightest();
    Night {
        date: manifest.date.clone(),
        commit: manifest.commit.clone(),
        level: manifest.level,
        claim: measured.id.clone(),
        holds: measured.holds(),
        measurement: tightest
            .map_or_else(|| measured.failure.clone().unwrap_or_default(), |c| c.what.clone()),
        measured: tightest.map_or(0.0, |c| c.measured),
        margin: measured.margin(),
        seconds: measured.seconds,
    }
}

/// Tonight's margin against the median of recent nights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trend {
    First,
    Steady(f64),
    Shrinking(f64),
    Growing(f64),
}

/// Margins of a claim on earlier nights, oldest first.
pub fn margins(nights: &[Night], claim: &str) -> Vec<f64> {
    nights.iter().filter(|n| n.claim == claim).map(|n| n.margin).collect()
}

pub fn trend(earlier: &[f64], margin: f64) -> Trend {
    let mut recent = earlier[earlier.len().saturating_sub(RECENT)..].to_vec();
    recent.sort_by(f64::total_cmp);
    let Some(&median) = recent.get(recent.len() / 2).filter(|m| **m > 0.0) else { return Trend::First };
    match margin / median {
        ratio if ratio < SHRUNK => Trend::Shrinking(ratio),
        ratio if ratio > 1.0 / SHRUNK => Trend::Growing(ratio),
        ratio => Trend::Steady(ratio),
    }
}
