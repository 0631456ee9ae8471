//! Content of a sweep's page.

use super::conclusions::Judged;
use super::curves;
use super::media;
use super::outcome::Outcome;
use super::reported::{Reported, shown};
use super::sheets::DrawnSheet;
use crate::draw::DrawResult;
use crate::draw::chart::{Chart, Curve};
use crate::draw::page::{Picture, hex, made_by, png_data, rendered, svg_data};
use crate::report::publish::PublishResult;
use crate::report::scalar_error;
use crate::sweep::definition::load::{AxisOutline, Sweep};
use minijinja::value::Serde;
use minijinja::{Value, context};

/// Maximum number of figures with spectra.
const MOST_FIGURES: usize = 24;

/// The page as HTML; all text is escaped.
pub(super) fn page(sweep: &Sweep, reported: &Reported, sheets: &[DrawnSheet]) -> PublishResult<String> {
    let outline = &sweep.outline;
    let outcomes = &reported.outcomes;
    let complete = reported.complete();
    let all = sweep.variants.len();
    let axes = outline.axes.len();
    let picture = |(sheet, png): &DrawnSheet| Picture { data: png_data(png), caption: sheet.title.clone() };
    let data = context! {
        title => &outline.title,
        summary => format!("{all} variants over {axes} {}.", if axes == 1 { "axis" } else { "axes" }),
        partial => (complete < all).then(|| partial(reported, complete, all)),
        scalar_error => scalar_error::line_of_many(sweep.variants.iter().map(|variant| &variant.study)),
        sheets => Serde(sheets.iter().map(picture).collect::<Vec<_>>()),
        conclusions => conclusions(&reported.conclusions),
        nearest => Serde(&reported.nearest),
        axes => Vec::from_iter(outline.axes.iter().map(AxisOutline::heading)),
        reference => &outcomes[outline.reference].name,
        variants => Vec::from_iter((0..all).map(|v| row(sweep, v, outcomes))),
        figures => Serde([figures(sweep, sheets, outcomes)?, media::figures(sweep, outcomes)?].concat()),
        program => made_by(),
    };
    Ok(rendered(include_str!("sweep.html"), data)?)
}

fn partial(reported: &Reported, complete: usize, all: usize) -> String {
    let unfinished: Vec<&Outcome> = reported.outcomes.iter().filter(|o| !o.is_complete()).collect();
    if unfinished.iter().all(|outcome| outcome.reason.is_some()) {
        let without = unfinished.iter().filter(|outcome| outcome.colour.is_none()).count();
        return format!(
            "{complete} of {all} variants are complete, {} lack some solves, and {without} have no results, \
             for the reasons in the table. --retry-failed retries them.",
            all - complete - without
        );
    }
    let failed = match reported.failures() {
        0 => String::new(),
        failures => format!(" {failures} failures are recorded; --retry-failed retries them."),
    };
    let finished: usize = reported.outcomes.iter().map(|o| o.solves.finished).sum();
    let planned: usize = reported.outcomes.iter().map(|o| o.solves.asked).sum();
    format!(
        "{complete} of {all} variants are finished, {finished} of {planned} solves.{failed} A running sweep updates this page \
         regularly; a stopped one resumes when it is run again."
    )
}

/// Groups conclusions by source; the sweep's own questions are the last group.
fn conclusions(all: &[Judged]) -> Vec<Value> {
    let mut sources: Vec<Option<&str>> = Vec::new();
    for source in all.iter().map(|judged| judged.table.source.as_deref()) {
        if !sources.contains(&source) {
            sources.push(source);
        }
    }
    sources.sort_by_key(Option::is_none);
    let quoted = sources.iter().any(Option::is_some);
    let mut groups = Vec::new();
    for source in sources {
        let own_questions = quoted.then(|| "Our own questions".to_owned());
        let heading = source.map(|source| format!("What {source} says")).or(own_questions);
        let rows = all.iter().filter(|judged| judged.table.source.as_deref() == source).map(conclusion);
        groups.push(context!(heading, rows => Vec::from_iter(rows)));
    }
    groups
}

fn conclusion(judged: &Judged) -> Value {
    let measured = judged.measured.map_or_else(|| "–".into(), |m| m.in_words(4));
    context!(measured, ..Value::from(Serde(judged)))
}

fn row(sweep: &Sweep, number: usize, outcomes: &[Outcome]) -> Value {
    let outcome = &outcomes[number];
    let numbers = shown(sweep, number, &outcomes[number], &outcomes[sweep.outline.reference]);
    let all = outcome.solves;
    let state = match (&outcome.reason, all.finished) {
        (Some(reason), _) => format!("{} failed: {reason}", outcome.failures),
        (None, 0) => "not computed".into(),
        (None, n) if n < all.asked => format!("{n} of {} solves", all.asked),
        _ => String::new(),
    };
    context! {
        labels => Serde(&outcome.labels),
        link => (all.finished > 0).then(|| format!("variants/{}/report.html", outcome.name)),
        hex => outcome.colour.map(|c| hex(c.srgb8)),
        numbers => (0..6).map(|i| numbers.map_or_else(String::new, |n| n[i].in_words(2))).collect::<Vec<_>>(),
        state,
    }
}

/// Curves against concentration and size; then spectra of the layer's transmittance: one figure per
/// row of each sheet, one curve per column.
fn figures(sweep: &Sweep, sheets: &[DrawnSheet], outcomes: &[Outcome]) -> DrawResult<Vec<Picture>> {
    let mut charts = Vec::new();
    'sheets: for (sheet, _) in sheets {
        charts.extend(curves::plots(sweep, sheet, outcomes));
        for (name, row) in sheet.rows.iter().zip(&sheet.cells) {
            let words = [sheet.title.as_str(), &sheet.row_axis, name];
            let caption = words.into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" · ");
            let of_row = sheet.columns.iter().zip(row);
            let curves = of_row.filter_map(|(name, v)| transmittance(name, sweep, outcomes, (*v)?));
            let curves: Vec<Curve> = curves.take(curves::MOST_CURVES).collect();
            if !curves.is_empty() {
                let chart = Chart::linear(&caption, "wavelength, nm", "transmittance of the layer", curves);
                charts.push(Chart { from_zero: true, ..chart });
            }
            if charts.len() >= MOST_FIGURES {
                break 'sheets;
            }
        }
    }
    let drawn = |chart: &Chart| Ok(Picture { data: svg_data(&chart.svg()?), caption: chart.title.clone() });
    charts.iter().map(drawn).collect()
}

/// A variant's transmittance against wavelength; `None` without results.
fn transmittance(name: &str, sweep: &Sweep, outcomes: &[Outcome], v: usize) -> Option<Curve> {
    let rows = outcomes[v].at_first_angle();
    let points = rows.iter().map(|r| (r.wavelength_nm, r.transmittance));
    let solved_nm = &sweep.variants[v].study.wavelengths_nm;
    (!rows.is_empty()).then(|| Curve::measured(name, points).asked_at(solved_nm))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// *Planted*: in the last of ten columns the reason would be only a few characters wide at 1280
    /// pixels.
    #[test]
    fn the_reason_of_a_failure_has_the_whole_width() {
        let row = context!(labels => ["yellow", "100"], state => "4 failed: no room for grain 7");
        let page = context!(axes => ["ink", "diameter, nm"], variants => [row]);
        let html = rendered(include_str!("sweep.html"), page).unwrap();
        assert!(html.contains("<td colspan=\"9\">4 failed: no room for grain 7</td>"), "{html}");
    }
}
