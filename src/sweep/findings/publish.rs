//! Writes a sweep's results from its store, at any time: the page of every variant, the table,
//! contact sheets, conclusions.

use super::between::VariantsBetween;
use super::conclusions::{Judged, judge};
use super::kept::KeptPages;
use super::media::{media_table, number_names, numbers_table};
use super::outcome::Outcome;
use super::reported::{Reported, nearest, numbers, target_columns, target_numbers};
use super::sheets::{contact_sheet, sheets};
use super::{explore, page};
use crate::draw::cell;
use crate::draw::picture::PictureStyle;
use crate::evaluate::evaluated::{EvaluateError, Evaluated};
use crate::evaluate::manifest::Count;
use crate::report::columns::{Column, FolderTables};
use crate::report::publish::{PublishError, PublishResult, publish as publish_study};
use crate::run::Stores;
use crate::store::folder::OutputFolder;
use crate::sweep::definition::folder::VARIANTS;
use crate::sweep::definition::load::{AxisOutline, Sweep};
use crate::work::alone::stored;
use crate::work::rounds::refused;

/// Rows and columns of a picture on a contact sheet.
const SHEET_ANGLES: usize = 31;
const SHEET_STYLE: PictureStyle = PictureStyle { side_px: 124, strip_px: 32, gap_px: 4, labels: false };

/// Writes all available results; removes the partial mark once all variants are finished.
///
/// # Errors
/// Files cannot be written, or records do not match.
pub fn publish(sweep: &Sweep, folder: &OutputFolder) -> PublishResult<Reported> {
    Publisher::new(sweep).publish(folder)
}

/// Writes the results of a sweep repeatedly while it runs; finished variants are evaluated once.
#[derive(Debug)]
pub struct Publisher<'a> {
    sweep: &'a Sweep,
    outcomes: Vec<Outcome>,
    /// What is between finished variants, once all are.
    between: Option<VariantsBetween>,
}

impl<'a> Publisher<'a> {
    /// Starts without results.
    pub fn new(sweep: &'a Sweep) -> Self {
        let outcomes = (0..sweep.variants.len()).map(|number| Outcome::nothing(sweep, number));
        Self { sweep, outcomes: outcomes.collect(), between: None }
    }

    /// Writes all results available now. An existing page is kept until the new one replaces it.
    ///
    /// # Errors
    /// As for [`publish`].
    pub fn publish(&mut self, folder: &OutputFolder) -> PublishResult<Reported> {
        folder.mark_partial()?;
        let stores = Stores::open(folder)?;
        let pages = KeptPages::new(&stores);
        for (number, outcome) in self.outcomes.iter_mut().enumerate().filter(|(_, o)| !o.is_complete()) {
            let variant = &self.sweep.variants[number];
            let of_variant = folder.inside(&format!("{VARIANTS}/{}", variant.name))?;
            let unchanged = pages.unchanged(variant, &of_variant, outcome);
            if let Some(unchanged) = unchanged {
                *outcome = unchanged;
                continue;
            }
            *outcome = published(self.sweep, number, &stores, &of_variant)?;
            pages.keep(variant, &of_variant, outcome)?;
        }
        if self.between.is_none() && self.outcomes.iter().all(Outcome::is_complete) {
            self.between = Some(VariantsBetween::new(self.sweep, folder, &stores));
        }
        report(self.sweep, folder, self.outcomes.clone(), self.between.as_ref())
    }
}

/// Writes the contact sheets, tables and pages of the whole sweep.
fn report(
    sweep: &Sweep,
    folder: &OutputFolder,
    outcomes: Vec<Outcome>,
    between: Option<&VariantsBetween>,
) -> PublishResult<Reported> {
    let conclusions = sweep.outline.claims.iter().map(|claim| judge(claim, &outcomes)).collect();
    let nearest = nearest(&sweep.outline, &outcomes);
    let reported = Reported { outcomes, conclusions, nearest };
    let sheets = sheets(&sweep.outline);
    let count = sheets.len();
    let mut drawn = Vec::new();
    for (i, sheet) in sheets.into_iter().enumerate() {
        let pictures = contact_sheet(&sheet, &sweep.outline.title, &reported.outcomes);
        let png = pictures.render(&SHEET_STYLE)?.png(&[("Title", pictures.title.as_str())])?;
        folder.write(&sheet_name(i, count), &png)?;
        drawn.push((sheet, png));
    }
    let mut written = FolderTables::new(folder);
    let axes = axis_columns(sweep, |axis| cell::text(&axis.name));
    let columns = [axes, number_columns(sweep)].concat();
    written.write("sweep.csv", &table(sweep, &reported.outcomes)?, "the variants of the sweep", &columns)?;
    let axes = || axis_columns(sweep, AxisOutline::heading);
    if let Some(media) = media_table(sweep, &reported.outcomes)? {
        let about = "what the packed media of the composed layers are to light";
        written.write("composed.csv", &media, about, &axes())?;
    }
    if let Some(numbers) = numbers_table(sweep, &reported.outcomes)? {
        let about = "weighted numbers of composed layers of every thickness";
        written.write("numbers.csv", &numbers, about, &[axes(), number_columns(sweep)].concat())?;
    }
    let conclusions = conclusions_table(&reported.conclusions)?;
    written.write("conclusions.csv", &conclusions, "claims about the sweep, judged", &[])?;
    written.describe(&sweep.outline.title)?;
    folder.write("explore.html", explore::page(sweep, &reported, between).as_bytes())?;
    folder.write("report.html", page::page(sweep, &reported, &drawn)?.as_bytes())?;
    if reported.complete() == sweep.variants.len() {
        folder.complete()?;
    }
    Ok(reported)
}

/// `contact-sheet.png`, numbered from 1 if there are several.
fn sheet_name(i: usize, count: usize) -> String {
    if count == 1 { "contact-sheet.png".into() } else { format!("contact-sheet-{}.png", i + 1) }
}

/// Evaluates a variant and writes its page to its folder.
fn published(
    sweep: &Sweep,
    number: usize,
    stores: &Stores,
    of_variant: &OutputFolder,
) -> PublishResult<Outcome> {
    let study = &sweep.variants[number].study;
    let nothing = Outcome::nothing(sweep, number);
    let Some(solved) = stored(study, stores) else {
        let refused = refused(study, stores, study.realisations);
        let reason = refused.first().map(|first| first.reason.clone());
        return Ok(Outcome { failures: refused.len(), reason, ..nothing });
    };
    let solves = Count { finished: solved.finished(), ..nothing.solves };
    let evaluated = match Evaluated::new(study, &solved) {
        // slabs that are not solved yet, or that failed
        Err(EvaluateError::Slabs(reason)) => {
            let is_open = solves.finished < solves.asked && solved.failures() == 0;
            let failures = if is_open { 0 } else { solved.failures().max(1) };
            return Ok(Outcome { solves, failures, reason: (!is_open).then_some(reason), ..nothing });
        }
        evaluated => evaluated?,
    };
    let manifest = &evaluated.manifest;
    match publish_study(&evaluated, of_variant) {
        // a variant without a result does not hold back the others
        Err(none @ (PublishError::Unphysical(_) | PublishError::NoRoom(_))) => {
            let solves = Count { finished: manifest.solves.finished, ..nothing.solves };
            let failures = 1 + manifest.failures.len();
            Ok(Outcome { solves, failures, reason: Some(none.to_string()), ..nothing })
        }
        published => {
            published?;
            let step = study.angles.picture_max_deg / (SHEET_ANGLES - 1) as f64;
            let angles: Vec<f64> = (0..SHEET_ANGLES).map(|i| i as f64 * step).collect();
            let picture = evaluated.picture(&angles).ok().flatten().map(|picture| picture.on_screen());
            Ok(Outcome { picture, ..nothing.with(manifest) })
        }
    }
}

/// The columns of a sweep's axes, which the user has named.
fn axis_columns(sweep: &Sweep, heading: impl Fn(&AxisOutline) -> String) -> Vec<Column> {
    let column = |axis: &AxisOutline| Column {
        name: heading(axis),
        kind: "string",
        unit: axis.unit.clone(),
        about: "setting of the variant on this axis of the sweep".to_owned(),
    };
    sweep.outline.axes.iter().map(column).collect()
}

/// The columns of weighted numbers, which the user has named.
fn number_columns(sweep: &Sweep) -> Vec<Column> {
    let column = |name: String| Column {
        about: format!("weighted number {name} of the variant"),
        name,
        kind: "number",
        unit: String::new(),
    };
    number_names(sweep).into_iter().map(column).collect()
}

const NUMBERS: [&str; 6] = ["L", "a", "b", "C", "h_deg", "delta_e_2000"];

/// `sweep.csv`, with one row per variant; columns for targets are last and only present if there
/// are targets.
fn table(sweep: &Sweep, outcomes: &[Outcome]) -> csv::Result<Vec<u8>> {
    let axes = sweep.outline.axes.iter().map(|axis| cell::text(&axis.name));
    let counts = ["solves", "solves_finished", "failures", "realisations"].map(str::to_owned);
    let aims = target_columns(outcomes);
    let weighted = number_names(sweep);
    let names = NUMBERS.into_iter().chain(aims.iter().copied()).chain(weighted.iter().map(String::as_str));
    let columns = cell::with_errors(names);
    let header = std::iter::once("variant".into()).chain(axes).chain(counts).chain(columns);
    let row = |outcome: &Outcome| {
        let of_weighted = weighted.iter().map(|name| Some(outcome.weighted(name)?.estimate));
        let named = outcome_row(outcome, &outcomes[sweep.outline.reference], aims.len());
        Vec::from_iter(named.chain(of_weighted.flat_map(cell::numbers)))
    };
    cell::table(header, outcomes.iter().map(row))
}

/// A variant's names, counts and numbers, with the first `aims` of its target's numbers.
fn outcome_row(o: &Outcome, reference: &Outcome, aims: usize) -> impl Iterator<Item = String> {
    let all = o.solves;
    let counts = [all.asked, all.finished, o.failures, o.realisations].map(|n| n.to_string());
    let numbers = numbers(o, reference);
    let of_aims = target_numbers(o).into_iter().take(aims);
    let estimates = (0..NUMBERS.len()).map(move |i| numbers.map(|n| n[i])).chain(of_aims);
    let names = std::iter::once(&o.name).chain(&o.labels).map(|words| cell::text(words));
    names.chain(counts).chain(estimates.flat_map(cell::numbers))
}

/// `conclusions.csv`.
fn conclusions_table(conclusions: &[Judged]) -> csv::Result<Vec<u8>> {
    let judged = ["id", "statement", "inequality", "measured", "standard_error", "verdict", "remark"];
    let words = ["source", "quote", "translation", "because"];
    cell::table(judged.into_iter().chain(words), conclusions.iter().map(|c| Vec::from_iter(judged_row(c))))
}

fn judged_row(c: &Judged) -> impl Iterator<Item = String> {
    let [value, error] = cell::numbers(c.measured);
    let id = cell::text(&c.table.id);
    let statement = cell::text(&c.table.statement);
    let inequality = cell::text(&c.inequality);
    let verdict = c.verdict.name().to_owned();
    let words = [&c.table.source, &c.table.quote, &c.table.translation, &c.table.because];
    let words = words.map(|words| cell::text(words.as_deref().unwrap_or_default()));
    [id, statement, inequality, value, error, verdict, cell::text(&c.remark)].into_iter().chain(words)
}
