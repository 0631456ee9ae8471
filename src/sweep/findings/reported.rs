//! Summary of a sweep's report, with the variants ranked by their distance to the target colour.

use super::conclusions::{Judged, QUANTILE, student};
use super::outcome::{Outcome, lab};
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::numerics::estimate::Linked;
use crate::sweep::definition::load::{Outline, Sweep};
use serde::Serialize;

/// Summary of a report.
#[derive(Clone, Debug)]
pub struct Reported {
    /// The outcome of each variant.
    pub outcomes: Vec<Outcome>,
    /// The conclusions with their verdicts.
    pub conclusions: Vec<Judged>,
    /// The variants nearest to the target colour; `None` without a target.
    pub nearest: Option<Nearest>,
}

impl Reported {
    /// Number of variants in which every solve is finished.
    pub fn complete(&self) -> usize {
        self.outcomes.iter().filter(|o| o.is_complete()).count()
    }

    /// Number of failures, over all variants.
    pub fn failures(&self) -> usize {
        self.outcomes.iter().map(|o| o.failures).sum()
    }
}

/// The numbers of an outcome for a page, with the inks of variant `number`: ΔE₀₀ to a reference of
/// another ink is left out, unless the file names the reference.
pub(super) fn shown(
    sweep: &Sweep,
    number: usize,
    outcome: &Outcome,
    reference: &Outcome,
) -> Option<[Estimate; 6]> {
    let outline = &sweep.outline;
    let mut numbers = numbers(outcome, reference)?;
    let inks_of = |v: usize| Some(inks(&sweep.variants.get(v)?.study));
    if !outline.reference_asked && inks_of(number) != inks_of(outline.reference) {
        numbers[5] = Estimate::unknown_error(f64::NAN);
    }
    Some(numbers)
}

/// Names of a study's pigments.
pub(super) fn inks(study: &Study) -> Vec<&str> {
    let grains = study.pigments.iter().map(|p| p.name.as_str());
    let mut names: Vec<&str> = grains.chain(study.dissolved.iter().map(|d| d.name.as_str())).collect();
    names.sort_unstable();
    names
}

/// L*, a*, b*, C*, h and ΔE₀₀ to the reference; `None` without a colour.
pub(super) fn numbers(outcome: &Outcome, reference: &Outcome) -> Option<[Estimate; 6]> {
    let colour = outcome.colour.as_ref()?;
    let difference = match outcome.difference(reference) {
        // the difference to itself is zero, without an error
        Some(_) if outcome.name == reference.name => Estimate::unknown_error(0.0),
        difference => difference.map_or(Estimate::unknown_error(f64::NAN), |d| d.estimate),
    };
    Some([lab(colour, 0), lab(colour, 1), lab(colour, 2), colour.chroma(), colour.hue_deg(), difference])
}

/// Maximum number of variants in the page's table.
const MOST_ROWS: usize = 12;

/// The variants nearest to a target colour.
#[derive(Clone, Debug, Serialize)]
pub struct Nearest {
    /// The target colour with its conditions.
    pub target: String,
    /// Names the nearest variant, and how many cannot be distinguished from it.
    pub summary: String,
    /// The nearest variants, in order.
    pub rows: Vec<NearRow>,
}

/// One of the variants nearest to a target colour.
#[derive(Clone, Debug, Serialize)]
pub struct NearRow {
    /// Labels of the variant on the axes.
    pub labels: Vec<String>,
    /// The variant's own page.
    pub link: String,
    /// `#rrggbb` of the print.
    pub hex: Option<String>,
    /// ΔE₀₀ with its 95 % interval.
    pub delta_e: String,
    /// Contrast ratio (Y over black divided by Y over white) with its 95 % interval.
    pub contrast_ratio: String,
    /// Whether it can be distinguished from the nearest.
    pub verdict: String,
}

/// A variant with its distance to the target.
struct Near {
    variant: usize,
    /// ΔE₀₀ to its target.
    distance: Estimate,
    /// How much farther it is than the nearest variant; half of the 95 % interval is its error, and
    /// none if that is unknown.
    farther: Estimate,
}

impl Near {
    /// Whether the difference to the nearest variant is within its 95 % interval; `None` if
    /// unknown.
    fn is_tied(&self) -> Option<bool> {
        Some(self.farther.value <= self.farther.standard_error?)
    }
}

/// Columns of `sweep.csv` for target colours; empty without a target.
pub(super) fn target_columns(outcomes: &[Outcome]) -> &'static [&'static str] {
    let has_target = outcomes.iter().any(|outcome| outcome.aim.is_some());
    if has_target { &["delta_e_2000_to_target", "contrast_ratio"] } else { &[] }
}

/// Values of these columns, as in the variant's own `results.json`.
pub(super) fn target_numbers(outcome: &Outcome) -> [Option<Estimate>; 2] {
    let target = outcome.target.as_ref();
    let contrast = target.and(outcome.contrast.as_ref());
    [target.map(|target| target.delta_e_2000), contrast.map(|(ratio, _)| *ratio)]
}

/// The nearest variants; `None` without a target.
pub(super) fn nearest(outline: &Outline, outcomes: &[Outcome]) -> Option<Nearest> {
    let aims: Vec<&String> = outcomes.iter().filter_map(|outcome| outcome.aim.as_ref()).collect();
    let first = *aims.first()?;
    let target = if aims.iter().all(|other| *other == first) { first } else { "each variant's own" };
    let order = in_order(outcomes);
    let rows = order.iter().enumerate().take(MOST_ROWS);
    Some(Nearest {
        target: target.to_owned(),
        summary: order.first().map_or_else(String::new, |best| {
            summary(&outcomes[best.variant], &order, aims.len()) + &at_the_edge(outline, best.variant)
        }),
        rows: rows.map(|(rank, near)| row(rank, near, outcomes)).collect(),
    })
}

/// The nearest variant, and how many of all that have a target cannot be told from it.
fn summary(best: &Outcome, order: &[Near], all: usize) -> String {
    let others = |tied: Option<bool>| order.iter().skip(1).filter(|near| near.is_tied() == tied).count();
    let tied = others(Some(true));
    let unknown = others(None);
    let known = order.len();
    let mut text = format!("{} is nearest.", best.name);
    match tied {
        0 if unknown == 0 && known > 1 => text += " All others are farther with 95 % confidence.",
        0 => {}
        1 => text += " One other cannot be distinguished from it.",
        n => text += &format!(" {n} others cannot be distinguished from it."),
    }
    if unknown > 0 {
        text += &format!(" Of {unknown} that is unknown: two or more realisations are needed.");
    }
    if known < all {
        text += &format!(" {} have no colour yet.", all - known);
    }
    text
}

/// Warns if a variant has the smallest or largest number of an axis, because there may be a nearer
/// one beyond.
fn at_the_edge(outline: &Outline, variant: usize) -> String {
    let place = &outline.variants[variant].place;
    let edges: Vec<String> = (0..place.len()).filter_map(|a| edge(outline, a, place[a])).collect();
    if edges.is_empty() {
        return String::new();
    }
    format!(" It lies at the edge of the sweep ({}): there may be a nearer one beyond.", edges.join(", "))
}

/// Describes whether a label has the smallest or largest number of an axis.
fn edge(outline: &Outline, a: usize, k: usize) -> Option<String> {
    let axis = &outline.axes[a];
    let here = axis.number(k)?;
    let numbers = || outline.variants.iter().filter_map(|v| axis.number(v.place[a]));
    let below = numbers().any(|x| x < here);
    let above = numbers().any(|x| x > here);
    let which = if below { "largest" } else { "smallest" };
    (below != above).then(|| format!("{} is the {which}", axis.named(k)))
}

/// All variants with a distance to their target, the nearest first.
fn in_order(outcomes: &[Outcome]) -> Vec<Near> {
    let mut all: Vec<(usize, Linked)> =
        outcomes.iter().enumerate().filter_map(|(v, outcome)| Some((v, outcome.to_target()?))).collect();
    all.retain(|(_, to_target)| to_target.estimate.value.is_finite());
    all.sort_by(|a, b| a.1.estimate.value.total_cmp(&b.1.estimate.value));
    let Some((best, least)) = all.first() else { return Vec::new() };
    // common realisations move both distances alike
    let near = |(variant, to_target): &(usize, Linked)| {
        let farther = Linked::sum([(1.0, to_target), (-1.0, least)]).estimate;
        let farther = with_interval(farther, &[&outcomes[*best], &outcomes[*variant]]);
        Near { variant: *variant, distance: to_target.estimate, farther }
    };
    all.iter().map(near).collect()
}

/// The estimate with half of its 95 % interval as the error, for the smallest number of
/// realisations.
fn with_interval(estimate: Estimate, outcomes: &[&Outcome]) -> Estimate {
    let behind = outcomes.iter().filter(|o| !o.certain).map(|o| o.realisations);
    let factor = student(behind.min().unwrap_or(0), QUANTILE);
    Estimate { standard_error: estimate.standard_error.map(|s| factor * s), ..estimate }
}

fn row(rank: usize, near: &Near, outcomes: &[Outcome]) -> NearRow {
    let outcome = &outcomes[near.variant];
    let in_words = |e: Estimate| with_interval(e, &[outcome]).in_words(2);
    NearRow {
        labels: outcome.labels.clone(),
        link: format!("variants/{}/report.html", outcome.name),
        hex: outcome.print_hex.clone(),
        delta_e: in_words(near.distance),
        contrast_ratio: target_numbers(outcome)[1].map_or_else(String::new, in_words),
        verdict: match (rank, near.is_tied()) {
            (0, _) => "nearest".into(),
            (_, Some(true)) => "cannot be distinguished from it".into(),
            (_, Some(false)) => format!("farther by {}", near.farther.in_words(2)),
            (_, None) => "unknown".into(),
        },
    }
}

#[cfg(test)]
#[path = "reported_tests.rs"]
mod tests;
