//! Content of a sweep's page.

use super::conclusions::Judged;
use super::curves;
use super::outcome::Outcome;
use super::reported::{Reported, shown};
use super::sheets::Sheet;
use super::target;
use crate::draw::OutputError;
use crate::draw::chart::{Chart, Curve};
use crate::evaluate::manifest::Count;
use crate::report::page::{Picture, hex, made_by, png_data, rendered, svg_data};
use crate::report::publish::PublishError;
use crate::report::scalar_error;
use crate::sweep::definition::load::{AxisOutline, Sweep};
use minijinja::value::Serde;
use minijinja::{Value, context};

/// Maximum number of figures with spectra.
const MOST_FIGURES: usize = 24;

/// The page as HTML; all text is escaped.
pub(crate) fn page(
    sweep: &Sweep,
    reported: &Reported,
    sheets: &[Sheet],
    drawn: &[Vec<u8>],
) -> Result<String, PublishError> {
    let (outline, outcomes) = (&sweep.outline, &reported.outcomes);
    let (complete, all) = (reported.complete(), sweep.variants.len());
    let pictures = sheets.iter().zip(drawn);
    let pictures = pictures.map(|(sheet, png)| Picture { data: png_data(png), caption: sheet.title.clone() });
    let pictures: Vec<Picture> = pictures.collect();
    let data = context! {
        title => &outline.title,
        summary => format!("{all} variants over {} axes.", outline.axes.len()),
        partial => (complete < all).then(|| partial(reported, complete, all)),
        scalar_error => scalar_error::line_of_many(sweep.variants.iter().map(|variant| &variant.study)),
        sheets => Serde(pictures),
        conclusions => conclusions(&reported.conclusions),
        nearest => Serde(target::nearest(outline, outcomes)),
        axes => Vec::from_iter(outline.axes.iter().map(AxisOutline::heading)),
        reference => &outcomes[outline.reference].name,
        variants => Vec::from_iter((0..all).map(|v| row(sweep, v, outcomes))),
        figures => Serde(figures(sweep, sheets, outcomes)?),
        program => made_by(),
    };
    Ok(rendered(include_str!("sweep.html"), data)?)
}

fn partial(reported: &Reported, complete: usize, all: usize) -> String {
    let unfinished = |o: &&Outcome| o.solves.finished < o.solves.asked;
    if reported.outcomes.iter().filter(unfinished).all(|outcome| outcome.reason.is_some()) {
        let without = reported.outcomes.iter().filter(unfinished).filter(|o| o.colour.is_none()).count();
        return format!(
            "{complete} of {all} variants are complete, {} lack some packings, and {without} have no results, \
             for the reasons in the table. --retry-failed retries them.",
            all - complete - without
        );
    }
    let failed = match reported.failures() {
        0 => String::new(),
        failures => format!(" {failures} failures are recorded; --retry-failed retries them."),
    };
    let solves =
        |count: fn(&Count) -> usize| reported.outcomes.iter().map(|o| count(&o.solves)).sum::<usize>();
    let (finished, asked) = (solves(|c| c.finished), solves(|c| c.asked));
    format!(
        "{complete} of {all} variants are finished, {finished} of {asked} solves.{failed} A running sweep updates this page \
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
        let own = quoted.then(|| "Our own questions".to_owned());
        let heading = source.map(|source| format!("What {source} says")).or(own);
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
    let (outcome, numbers) = (&outcomes[number], shown(sweep, number, outcomes));
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
fn figures(sweep: &Sweep, sheets: &[Sheet], outcomes: &[Outcome]) -> Result<Vec<Picture>, OutputError> {
    let mut figures = Vec::new();
    for sheet in sheets {
        for plot in curves::plots(sweep, sheet, outcomes) {
            figures.push(drawn(&plot));
        }
        for (name, row) in sheet.rows.iter().zip(&sheet.cells) {
            let words = [sheet.title.as_str(), &sheet.row_axis, name];
            let caption = words.into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" · ");
            figures.extend(figure((sweep, outcomes), &caption, &sheet.columns, row).transpose());
            if figures.len() >= MOST_FIGURES {
                return figures.into_iter().collect();
            }
        }
    }
    figures.into_iter().collect()
}

fn figure(
    (sweep, outcomes): (&Sweep, &[Outcome]),
    caption: &str,
    columns: &[String],
    row: &[Option<usize>],
) -> Result<Option<Picture>, OutputError> {
    let curve = |(name, v): (&String, &Option<usize>)| {
        let asked = &sweep.variants[(*v)?].study.wavelengths_nm;
        Some(transmittance(name, &outcomes[(*v)?])?.asked_at(asked))
    };
    let curves: Vec<Curve> = columns.iter().zip(row).filter_map(curve).take(curves::MOST_CURVES).collect();
    if curves.is_empty() {
        return Ok(None);
    }
    let chart = Chart::linear(caption, "wavelength, nm", "transmittance of the layer", curves);
    drawn(&Chart { from_zero: true, ..chart }).map(Some)
}

/// A variant's transmittance against wavelength; `None` without results.
fn transmittance(name: &str, outcome: &Outcome) -> Option<Curve> {
    let rows = outcome.at_first_angle();
    (!rows.is_empty()).then(|| Curve::measured(name, rows.iter().map(|r| (r.wavelength_nm, r.transmittance))))
}

fn drawn(plot: &Chart) -> Result<Picture, OutputError> {
    Ok(Picture { data: svg_data(&plot.svg()?), caption: plot.title.clone() })
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
