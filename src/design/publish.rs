//! Files of a design: `design.json`, the best recipe as a study, and a page.

use super::recipe::{DesignTask, short};
use super::run::{DesignAnswer, DesignOutcome, Verified};
use crate::report::page::{made_by, rendered};
use crate::store::folder::{FolderError, OutputFolder};
use minijinja::value::Serde;
use serde::Serialize;
use thiserror::Error;

/// Why files of a design cannot be written.
#[derive(Debug, Error)]
pub enum DesignOutputError {
    /// The folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The page's template does not fit its data.
    #[error("the page cannot be made: {0}")]
    Page(#[from] minijinja::Error),
    /// Numbers that are not finite.
    #[error("design.json cannot be made: {0}")]
    Json(#[from] serde_json::Error),
}

#[derive(Serialize)]
struct DesignPage<'a> {
    title: &'a str,
    met: bool,
    verdict: &'a str,
    target: String,
    variables: Vec<&'a str>,
    verified: Vec<DesignRow>,
    valley: Vec<DesignRow>,
    ranges: Vec<String>,
    note: String,
    program: String,
}

#[derive(Serialize)]
struct DesignRow {
    hex: Option<String>,
    values: Vec<String>,
    numbers: Vec<String>,
}

impl DesignRow {
    fn verified(run: &Verified) -> Self {
        let predicted = run.predicted.map_or(String::new(), |x| format!("{x:.2}"));
        Self {
            hex: Some(run.hex.clone()),
            values: run.values.iter().map(|&x| short(x)).collect(),
            numbers: vec![
                run.delta_e_2000.in_words(2),
                predicted,
                run.contrast_ratio.in_words(3),
                short(run.cost),
            ],
        }
    }

    fn answered(answer: &DesignAnswer) -> Self {
        Self {
            hex: None,
            values: answer.values.iter().map(|&x| short(x)).collect(),
            numbers: vec![format!("{:.2}", answer.delta_e_2000), format!("{:.3}", answer.contrast_ratio)],
        }
    }
}

/// The ranges of the valley in words, one for each variable.
pub fn ranges(task: &DesignTask, outcome: &DesignOutcome) -> Vec<String> {
    let part = |(variable, [low, high]): (&super::recipe::Variable, &[f64; 2])| {
        format!("{} {} … {}", variable.name, short(*low), short(*high))
    };
    task.variables.iter().zip(&outcome.valley_ranges).map(part).collect()
}

/// Writes all files.
///
/// # Errors
/// A file cannot be written.
pub fn publish(
    task: &DesignTask,
    outcome: &DesignOutcome,
    folder: &OutputFolder,
) -> Result<(), DesignOutputError> {
    let names: Vec<&str> = task.variables.iter().map(|v| v.name.as_str()).collect();
    let json = serde_json::json!({
        "title": task.title,
        "variables": names,
        "design": outcome,
        "version": env!("CARGO_PKG_VERSION"),
    });
    folder.write("design.json", &serde_json::to_vec_pretty(&json)?)?;
    let [l, a, b] = outcome.target;
    let page = DesignPage {
        title: &task.title,
        met: outcome.met,
        verdict: &outcome.verdict,
        target: format!("L* {l:.2}, a* {a:.2}, b* {b:.2}"),
        variables: names,
        verified: outcome.verified.iter().map(DesignRow::verified).collect(),
        valley: outcome.valley.iter().map(DesignRow::answered).collect(),
        ranges: ranges(task, outcome),
        note: format!(
            "Response surfaces rest on {} variants; without a variant they miss its colour by ΔE₀₀ {:.2} (median).",
            outcome.variants, outcome.surface_error
        ),
        program: made_by(),
    };
    folder.write("report.html", rendered(include_str!("design.html"), Serde(&page))?.as_bytes())?;
    Ok(folder.complete()?)
}
