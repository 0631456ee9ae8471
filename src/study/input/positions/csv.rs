//! Spheres in CSV: a header names the columns and their units.

use super::columns::{LengthColumn, PositionColumns};
use super::{Positions, is_passed_over};
use crate::input::file::{LengthUnit, MicrostructureTable, SizeColumn};
use std::borrow::Cow;

/// The spheres of one cut.
///
/// # Errors
/// In words: what is missing or wrong, with its line.
pub(super) fn from_csv(text: &str, meaning: &MicrostructureTable) -> Result<Positions, String> {
    let mut rows = text.lines().enumerate().filter(|(_, line)| !is_passed_over(line)).peekable();
    let (above, first) = *rows.peek().ok_or("it has no header and no rows")?;
    let without_header = first.split([';', ',', '\t', ' ']).all(|word| word.is_empty() || is_number(word));
    // programs for arrays write the header as a remark
    let remarked = text.lines().take(above).filter(|line| !line.trim().is_empty()).last();
    let remarked =
        remarked.filter(|_| without_header).map(|line| line.trim_start().trim_start_matches('#').trim());
    if remarked.is_none() {
        rows.next();
    }
    let header = remarked.unwrap_or(first);
    let words = split(header, separator(header))?;
    let names: Vec<ColumnName> = words.iter().map(|word| ColumnName::new(word)).collect();
    let table = PositionColumns::of_csv(&names, meaning)?;
    let separator = match remarked {
        Some(_) => separator(rows.peek().map_or(header, |(_, line)| line)),
        None => separator(header),
    };
    let mut positions = Positions::default();
    for (i, line) in rows {
        let words = split(line, separator).map_err(|e| format!("line {}: {e}", i + 1))?;
        table.read(&words, i + 1, &mut positions)?;
    }
    Ok(positions)
}

/// What separates the words of a line: a semicolon, a comma, a tab, or else blanks.
fn separator(line: &str) -> char {
    [';', ',', '\t'].into_iter().find(|c| line.contains(*c)).unwrap_or(' ')
}

fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}

/// The words of one line of CSV. Numbers between semicolons may have decimal commas.
fn split(line: &str, separator: char) -> Result<Vec<Cow<'_, str>>, String> {
    if separator == ' ' {
        return Ok(line.split_whitespace().map(Cow::Borrowed).collect());
    }
    if !line.contains('"') {
        let words = line.split(separator).map(str::trim);
        return Ok(words.map(|word| if separator == ';' { with_point(word) } else { word.into() }).collect());
    }
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .has_headers(false)
        .delimiter(separator as u8)
        .from_reader(line.as_bytes());
    let record = reader.records().next().transpose().map_err(|e| e.to_string())?.unwrap_or_default();
    Ok(record.iter().map(|word| Cow::Owned(with_point(word).into_owned())).collect())
}

/// A number with a decimal comma as one with a point; other words as they are.
fn with_point(word: &str) -> Cow<'_, str> {
    let point = word.replacen(',', ".", 1);
    if point != word && is_number(&point) { Cow::Owned(point) } else { Cow::Borrowed(word) }
}

/// The units that a column may name, with their length in µm.
const UNITS: [(&str, LengthUnit); 4] =
    [("um", LengthUnit::Um), ("nm", LengthUnit::Nm), ("mm", LengthUnit::Mm), ("m", LengthUnit::M)];

/// A column's name in parts: `x_um`, `X (µm)` and `x [um]` are all x in µm.
struct ColumnName {
    name: String,
    unit: Option<LengthUnit>,
}

impl ColumnName {
    fn new(words: &str) -> Self {
        let plain = words.to_lowercase().replace(['µ', 'μ'], "u");
        let parts: Vec<&str> =
            plain.split(|c: char| !c.is_alphanumeric()).filter(|p| !p.is_empty()).collect();
        let unit_of = |part: &str| UNITS.iter().find(|(unit, _)| *unit == part).map(|(_, unit)| *unit);
        match parts[..] {
            [name, unit] if unit_of(unit).is_some() => Self { name: name.to_owned(), unit: unit_of(unit) },
            _ => Self { name: plain.trim().to_owned(), unit: None },
        }
    }
}

impl PositionColumns {
    /// The columns of CSV by their names, which hold the units, or leave them to the study.
    fn of_csv(names: &[ColumnName], meaning: &MicrostructureTable) -> Result<Self, String> {
        let length = |known: &[&str]| -> Result<Option<LengthColumn>, String> {
            let unit_of = |i: usize| names[i].unit.or(meaning.unit);
            let is_known = |i: &usize| known.contains(&names[*i].name.as_str()) && unit_of(*i).is_some();
            let columns: Vec<usize> = (0..names.len()).filter(is_known).collect();
            match columns[..] {
                [] => Ok(None),
                [column] => Ok(unit_of(column).map(|unit| LengthColumn::new(column, unit.um()))),
                _ => {
                    let name = known[0];
                    Err(format!("{} columns for {name}: keep one {name}_um or {name}_nm", columns.len()))
                }
            }
        };
        let axis = |name: &str| {
            let is_bare = names.iter().any(|n| n.name == name);
            let hint = if is_bare { "; or add unit = \"um\" beside spheres" } else { "" };
            let absent =
                format!("no column {name}_um or {name}_nm; a header names the columns with their unit{hint}");
            length(&[name])?.ok_or(absent)
        };
        let center = [axis("x")?, axis("y")?, axis("z")?];
        let radius = length(&["radius", "r"])?;
        let diameter = length(&["diameter", "d"])?;
        let (column, named) = match (radius, diameter) {
            (Some(_), Some(_)) => return Err("both a radius and a diameter".into()),
            (None, None) => return Err("no column radius_um or diameter_um (or _nm)".into()),
            (Some(column), None) => (column, SizeColumn::Radius),
            (None, Some(column)) => (column, SizeColumn::Diameter),
        };
        // the study says what a column holds that has no unit of its own
        let stated = meaning.size.filter(|_| names[column.column].unit.is_none());
        let radius = match stated.unwrap_or(named) {
            SizeColumn::Radius => column,
            SizeColumn::Diameter => LengthColumn { factor_um: 0.5 * column.factor_um, ..column },
        };
        let find = |name: &str| names.iter().position(|n| n.name == name);
        Ok(Self {
            count: names.len(),
            center,
            radius,
            pigment: find("pigment"),
            grain: find("grain"),
            zero_is_alone: false,
        })
    }
}
