//! Contact sheets: two axes as rows and columns, one sheet for each combination of the others.

use super::outcome::Outcome;
use crate::appearance::picture::InkPicture;
use crate::draw::contact_sheet::ContactSheet;
use crate::sweep::definition::load::Outline;

/// A contact sheet of variants by number, `None` where one is left out; its title names the values
/// of the axes that it does not show.
pub(crate) type Sheet = ContactSheet<Option<usize>>;

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
    let asked = [&outline.sheet.rows, &outline.sheet.columns];
    let [mut row, column] =
        asked.map(|name| outline.axes.iter().position(|axis| Some(&axis.name) == name.as_ref()));
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

/// One side of a sheet: its axis, and the values that variants on the sheet have there.
struct SheetSide {
    axis: Option<usize>,
    used: Vec<usize>,
}

impl SheetSide {
    fn new(outline: &Outline, axis: Option<usize>, on_sheet: &[usize]) -> Self {
        let mut side = Self { axis, used: Vec::new() };
        side.used = on_sheet.iter().map(|&v| side.at(outline, v)).collect();
        side.used.sort_unstable();
        side.used.dedup();
        side
    }

    /// Value of a variant.
    fn at(&self, outline: &Outline, variant: usize) -> usize {
        self.axis.map_or(0, |a| outline.variants[variant].place[a])
    }

    fn name(&self, outline: &Outline) -> String {
        self.axis.map_or_else(String::new, |a| outline.axes[a].plain_name().to_owned())
    }

    fn captions(&self, outline: &Outline) -> Vec<String> {
        let axis = self.axis.map(|a| &outline.axes[a]);
        self.used.iter().map(|&k| axis.map_or_else(String::new, |axis| axis.caption(k))).collect()
    }
}

fn sheet(outline: &Outline, shown: [Option<usize>; 2], other: &[usize]) -> Sheet {
    let all = 0..outline.variants.len();
    let on_sheet: Vec<usize> =
        all.filter(|&v| others_of(&outline.variants[v].place, shown) == other).collect();
    let [rows, columns] = shown.map(|axis| SheetSide::new(outline, axis, &on_sheet));
    let mut cells = vec![vec![None; columns.used.len()]; rows.used.len()];
    for &v in on_sheet.iter().rev() {
        let [r, c] = [&rows, &columns].map(|side| side.used.iter().position(|&k| k == side.at(outline, v)));
        if let (Some(r), Some(c)) = (r, c) {
            cells[r][c] = Some(v);
        }
    }
    let hidden = (0..outline.axes.len()).filter(|&a| !shown.contains(&Some(a)));
    Sheet {
        title: hidden.map(|a| outline.axes[a].named(other[a])).collect::<Vec<_>>().join(", "),
        row_axis: rows.name(outline),
        column_axis: columns.name(outline),
        cells,
        rows: rows.captions(outline),
        columns: columns.captions(outline),
    }
}

/// A sheet with its pictures, or with the reasons why they are missing.
pub(crate) fn contact_sheet(
    sheet: &Sheet,
    title: &str,
    pictures: &[Option<InkPicture>],
    outcomes: &[Outcome],
) -> ContactSheet {
    let title = if sheet.title.is_empty() { title.to_owned() } else { format!("{title}: {}", sheet.title) };
    sheet.map(title, |v| {
        let picture = v.and_then(|v| pictures[v].clone());
        picture.ok_or_else(|| why_blank(v.map(|v| &outcomes[v])))
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
