//! Files of a design: `design.json`, the best recipe as a study, and a page.

use super::recipe::{DesignTask, short};
use super::run::{DesignAnswer, DesignOutcome, Verified};
use crate::draw::page::{made_by, rendered};
use crate::report::publish::PublishResult;
use crate::store::folder::OutputFolder;
use minijinja::value::Serde;
use minijinja::{Value, context};

/// A recipe as a row of the page's tables.
fn row(hex: Option<&str>, values: &[f64], numbers: Vec<String>) -> Value {
    context!(hex => hex.map(str::to_owned), values => values.iter().map(|&x| short(x)).collect::<Vec<_>>(), numbers)
}

fn verified(run: &Verified) -> Value {
    let predicted = run.predicted.map_or(String::new(), |x| format!("{x:.2}"));
    let delta_e = run.delta_e_2000.in_words(2);
    let contrast = run.contrast_ratio.in_words(3);
    row(Some(&run.hex), &run.values, vec![delta_e, predicted, contrast, short(run.cost)])
}

fn answered(answer: &DesignAnswer) -> Value {
    let numbers = vec![format!("{:.2}", answer.delta_e_2000), format!("{:.3}", answer.contrast_ratio)];
    row(None, &answer.values, numbers)
}

/// The ranges of the valley in words, one for each variable.
pub fn ranges(task: &DesignTask, outcome: &DesignOutcome) -> Vec<String> {
    let named = task.variables.iter().zip(&outcome.valley_ranges);
    named.map(|(v, [low, high])| format!("{} {} … {}", v.name, short(*low), short(*high))).collect()
}

/// Writes all files.
///
/// # Errors
/// A file cannot be written.
pub fn publish(task: &DesignTask, outcome: &DesignOutcome, folder: &OutputFolder) -> PublishResult {
    let names: Vec<&str> = task.variables.iter().map(|v| v.name.as_str()).collect();
    let json = serde_json::json!({
        "title": task.title,
        "variables": names,
        "design": outcome,
        "version": env!("CARGO_PKG_VERSION"),
    });
    folder.write("design.json", &serde_json::to_vec_pretty(&json)?)?;
    let [l, a, b] = outcome.target;
    let page = context! {
        title => &task.title,
        met => outcome.met,
        verdict => &outcome.verdict,
        target => format!("L* {l:.2}, a* {a:.2}, b* {b:.2}"),
        variables => Serde(names),
        verified => outcome.verified.iter().map(verified).collect::<Vec<_>>(),
        valley => outcome.valley.iter().map(answered).collect::<Vec<_>>(),
        ranges => ranges(task, outcome),
        left_out => Serde(&outcome.left_out),
        note => format!(
            "The response surfaces are fitted to {} variants. Each variant left out in turn, they predict its colour with a median error of ΔE₀₀ {:.2}.",
            outcome.variants, outcome.surface_error
        ),
        program => made_by(),
    };
    folder.write("report.html", rendered(include_str!("design.html"), page)?.as_bytes())?;
    Ok(folder.complete()?)
}
