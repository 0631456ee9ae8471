//! Contact sheets: two axes as rows and columns, one sheet for each combination of the others.

use super::outcome::Outcome;
use crate::appearance::picture::InkPicture;
use crate::draw::contact_sheet::ContactSheet;
use crate::sweep::definition::load::Outline;

/// A sheet with its variants as \[row\]\[column\].
pub(crate) struct Sheet {
    /// Captions of the axes that the sheet does not show.
    pub caption: String,
    pub row_axis: String,
    pub rows: Vec<String>,
    pub column_axis: String,
    pub columns: Vec<String>,
    pub variants: Vec<Vec<Option<usize>>>,
}

/// All sheets of a sweep that contain a variant.
pub(crate) fn sheets(outline: &Outline) -> Vec<Sheet> {
    let (row, column) = shown_axes(outline);
    let mut others: Vec<Vec<usize>> = Vec::new();
    for variant in &outline.variants {
        let other = others_of(&variant.place, row, column);
        if !others.contains(&other) {
            others.push(other);
        }
    }
    others.into_iter().map(|other| sheet(outline, row, column, &other)).collect()
}

/// The axes of rows and columns: as requested, otherwise the first two unused ones.
fn shown_axes(outline: &Outline) -> (Option<usize>, Option<usize>) {
    let named = |name: &Option<String>| outline.axes.iter().position(|a| Some(&a.name) == name.as_ref());
    let (mut row, mut column) = (named(&outline.sheet.rows), named(&outline.sheet.columns));
    let free = |taken: Option<usize>| (0..outline.axes.len()).find(|&a| Some(a) != taken);
    if outline.axes.len() > 1 {
        row = row.or_else(|| free(column));
    }
    column = column.filter(|_| column != row).or_else(|| free(row));
    (row, column)
}

/// The position with rows and columns set to 0.
fn others_of(place: &[usize], row: Option<usize>, column: Option<usize>) -> Vec<usize> {
    let shown = |a: usize| Some(a) == row || Some(a) == column;
    place.iter().enumerate().map(|(a, &k)| if shown(a) { 0 } else { k }).collect()
}

fn sheet(outline: &Outline, row: Option<usize>, column: Option<usize>, other: &[usize]) -> Sheet {
    let here = |v: &usize| others_of(&outline.variants[*v].place, row, column) == other;
    let on_sheet: Vec<usize> = (0..outline.variants.len()).filter(here).collect();
    let at = |v: usize, axis: Option<usize>| axis.map_or(0, |a| outline.variants[v].place[a]);
    // values without a variant on this sheet are left out
    let used = |axis: Option<usize>| distinct(on_sheet.iter().map(|&v| at(v, axis)).collect());
    let (rows, columns) = (used(row), used(column));
    let find = |r: usize, c: usize| on_sheet.iter().copied().find(|&v| at(v, row) == r && at(v, column) == c);
    let names = |axis: Option<usize>, used: &[usize]| -> Vec<String> {
        used.iter().map(|&k| axis.map_or_else(String::new, |a| outline.axes[a].caption(k))).collect()
    };
    let axis_name =
        |axis: Option<usize>| axis.map_or_else(String::new, |a| outline.axes[a].plain_name().to_owned());
    let shown = |a: usize| Some(a) == row || Some(a) == column;
    let captions = (0..outline.axes.len()).filter(|&a| !shown(a)).map(|a| outline.axes[a].named(other[a]));
    Sheet {
        caption: captions.collect::<Vec<_>>().join(", "),
        row_axis: axis_name(row),
        column_axis: axis_name(column),
        variants: rows.iter().map(|&r| columns.iter().map(|&c| find(r, c)).collect()).collect(),
        rows: names(row, &rows),
        columns: names(column, &columns),
    }
}

/// Distinct values in increasing order.
fn distinct(mut values: Vec<usize>) -> Vec<usize> {
    values.sort_unstable();
    values.dedup();
    values
}

impl Sheet {
    /// Lays out a sheet with its pictures, or with the reasons why they are missing.
    pub fn contact_sheet(
        &self,
        title: &str,
        pictures: &[Option<InkPicture>],
        outcomes: &[Outcome],
    ) -> ContactSheet {
        let title =
            if self.caption.is_empty() { title.to_owned() } else { format!("{title}: {}", self.caption) };
        let reason = |v: &Option<usize>| why_blank(v.map(|v| &outcomes[v]));
        let picture = |v: &Option<usize>| v.and_then(|v| pictures[v].clone());
        ContactSheet {
            title,
            row_axis: self.row_axis.clone(),
            rows: self.rows.clone(),
            column_axis: self.column_axis.clone(),
            columns: self.columns.clone(),
            blanks: self.variants.iter().map(|row| row.iter().map(reason).collect()).collect(),
            pictures: self.variants.iter().map(|row| row.iter().map(picture).collect()).collect(),
        }
    }
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
