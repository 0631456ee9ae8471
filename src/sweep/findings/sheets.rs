//! Contact sheets: two axes as rows and columns, one sheet for each combination of the others.

use super::outcome::Outcome;
use crate::draw::contact_sheet::ContactSheet;
use crate::sweep::definition::load::{AxisOutline, Outline, Place};
use std::collections::{BTreeMap, BTreeSet};

/// A contact sheet of variants by number, `None` where one is left out; its title names the values
/// of the axes that it does not show.
pub(crate) type Sheet = ContactSheet<Option<usize>>;

/// A sheet, and its pictures as PNG.
pub(super) type DrawnSheet = (Sheet, Vec<u8>);

/// All sheets of a sweep that contain a variant.
pub(crate) fn sheets(outline: &Outline) -> Vec<Sheet> {
    let shown = shown_axes(outline);
    let mut others: Vec<Vec<usize>> = Vec::new();
    for variant in &outline.variants {
        let other = others_of(&variant.place, shown);
        if !others.contains(&other) {
            others.push(other);
        }
    }
    others.into_iter().map(|other| sheet(outline, shown, &other)).collect()
}

/// The axes of rows and columns: as requested, otherwise the first two unused ones.
fn shown_axes(outline: &Outline) -> [Option<usize>; 2] {
    let requested = [&outline.sheet.rows, &outline.sheet.columns];
    let [mut row, column] =
        requested.map(|name| outline.axes.iter().position(|axis| Some(&axis.name) == name.as_ref()));
    let all = 0..outline.axes.len();
    if all.len() > 1 {
        row = row.or_else(|| all.clone().find(|&a| Some(a) != column));
    }
    [row, column.filter(|_| column != row).or_else(|| all.clone().find(|&a| Some(a) != row))]
}

/// The position with rows and columns set to 0.
fn others_of(place: &[usize], shown: [Option<usize>; 2]) -> Vec<usize> {
    place.iter().enumerate().map(|(a, &k)| if shown.contains(&Some(a)) { 0 } else { k }).collect()
}

/// A sheet whose rows and columns are the values that its variants have on the shown axes.
fn sheet(outline: &Outline, shown: [Option<usize>; 2], other: &[usize]) -> Sheet {
    let on_sheet = outline.variants.iter().enumerate().filter(|(_, v)| others_of(&v.place, shown) == other);
    // the first of several variants at one place is shown
    let mut numbers: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for (v, Place { place, .. }) in on_sheet {
        numbers.entry(shown.map(|axis| axis.map_or(0, |a| place[a]))).or_insert(v);
    }
    let rows = BTreeSet::from_iter(numbers.keys().map(|[row, _]| *row));
    let columns = BTreeSet::from_iter(numbers.keys().map(|[_, column]| *column));
    let cells = rows.iter().map(|&r| columns.iter().map(|&c| numbers.get(&[r, c]).copied()).collect());
    let [row_axis, column_axis] = shown.map(|axis| axis.map(|a| &outline.axes[a]));
    let name = |axis: Option<&AxisOutline>| axis.map_or_else(String::new, |a| a.plain_name().to_owned());
    let caption = |axis: Option<&AxisOutline>, k| axis.map_or_else(String::new, |axis| axis.caption(k));
    let hidden = (0..outline.axes.len()).filter(|&a| !shown.contains(&Some(a)));
    Sheet {
        title: hidden.map(|a| outline.axes[a].named(other[a])).collect::<Vec<_>>().join(", "),
        row_axis: name(row_axis),
        column_axis: name(column_axis),
        cells: cells.collect(),
        rows: rows.iter().map(|&k| caption(row_axis, k)).collect(),
        columns: columns.iter().map(|&k| caption(column_axis, k)).collect(),
    }
}

/// A sheet with its pictures, or with the reasons why they are missing.
pub(crate) fn contact_sheet(sheet: &Sheet, title: &str, outcomes: &[Outcome]) -> ContactSheet {
    let title = if sheet.title.is_empty() { title.to_owned() } else { format!("{title}: {}", sheet.title) };
    sheet.map(title, |v| {
        let outcome = v.map(|v| &outcomes[v]);
        outcome.and_then(|o| o.picture.clone()).ok_or_else(|| why_blank(outcome))
    })
}

/// Why there is no picture at a place of the sheet.
fn why_blank(outcome: Option<&Outcome>) -> String {
    match outcome {
        None => "left out of the sweep".into(),
        Some(o) if o.failures > 0 && o.colour.is_none() => format!("{} failed", o.failures),
        Some(o) if o.solves.finished == 0 => "not solved yet".into(),
        Some(o) if o.realisations == 0 => format!("{} of {} solves", o.solves.finished, o.solves.asked),
        Some(_) => "no paper at these angles".into(),
    }
}
