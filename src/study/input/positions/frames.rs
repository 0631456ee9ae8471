//! Spheres in frames, one after the other in a file: LAMMPS dumps and extended XYZ.

use super::columns::{LengthColumn, PositionColumns};
use super::{Positions, is_passed_over};
use crate::ink::packing::sizes::MOST_GRAINS;
use crate::input::file::{LengthUnit, MicrostructureTable, SizeColumn};
use std::collections::HashMap;

/// Lowest and highest x, y, z of a box, in the unit of its file.
type Bounds = [[f64; 2]; 3];
/// Lines with their numbers.
pub(super) type NumberedLines<'a> = std::iter::Peekable<std::iter::Enumerate<std::str::Lines<'a>>>;
/// Reads one cut; its box is in the file's unit.
pub(super) type CutReader = fn(&mut NumberedLines, &MicrostructureTable) -> Result<Positions, String>;

/// All cuts of a text.
///
/// # Errors
/// In words: what is missing or wrong, with its line.
pub(super) fn frames(
    text: &str,
    frame: CutReader,
    meaning: &MicrostructureTable,
) -> Result<Vec<Positions>, String> {
    let mut lines = text.lines().enumerate().peekable();
    let um = meaning.unit.map_or(1.0, LengthUnit::um);
    let mut all = Vec::new();
    let mut spheres = 0;
    pass_over(&mut lines);
    while lines.peek().is_some() {
        let cut = frame(&mut lines, meaning)?;
        spheres += cut.spheres.len();
        if spheres > MOST_GRAINS {
            return Err(format!("more than {MOST_GRAINS} spheres in its frames: keep fewer of them"));
        }
        let box_um = cut.box_um.map(|b| b.map(|range| range.map(|x| x * um)));
        all.push(Positions { counted_from: 1, box_um, ..cut });
        pass_over(&mut lines);
    }
    Ok(all)
}

/// Passes over blank lines and remarks.
fn pass_over(lines: &mut NumberedLines) {
    while lines.next_if(|(_, line)| is_passed_over(line)).is_some() {}
}

/// The next line that is neither blank nor a remark.
fn next<'a>(lines: &mut NumberedLines<'a>, what: &str) -> Result<(usize, &'a str), String> {
    pass_over(lines);
    lines.next().ok_or_else(|| format!("it ends before {what}"))
}

/// The next `count` rows.
fn rows(lines: &mut NumberedLines, count: usize, table: &PositionColumns) -> Result<Positions, String> {
    let mut positions = Positions::default();
    for _ in 0..count {
        let (i, line) = next(lines, "the last of its spheres")?;
        table.read(&line.split_whitespace().collect::<Vec<_>>(), i + 1, &mut positions)?;
    }
    Ok(positions)
}

/// One frame of a LAMMPS dump.
pub(super) fn dump_frame(
    lines: &mut NumberedLines,
    meaning: &MicrostructureTable,
) -> Result<Positions, String> {
    let mut count = None;
    let mut bounds = None;
    loop {
        let (i, line) = next(lines, "ITEM: ATOMS")?;
        let no_item = || format!("line {}: {line:?} where an ITEM: is needed", i + 1);
        let item = line.trim().strip_prefix("ITEM:").ok_or_else(no_item)?.trim();
        if item == "NUMBER OF ATOMS" {
            let (i, line) = next(lines, "the number of atoms")?;
            let number = line.trim().parse::<usize>();
            count = Some(number.map_err(|_| format!("line {}: no number of atoms", i + 1))?);
        } else if item.starts_with("BOX BOUNDS") {
            bounds = Some([bound(lines)?, bound(lines)?, bound(lines)?]);
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let count = count.ok_or_else(|| format!("line {}: no NUMBER OF ATOMS before ATOMS", i + 1))?;
            let names: Vec<&str> = names.split_whitespace().collect();
            let table = PositionColumns::named(&names, bounds, meaning)?;
            return Ok(Positions { box_um: bounds, ..rows(lines, count, &table)? });
        } else {
            next(lines, "the value of an item")?;
        }
    }
}

/// Lowest and highest coordinate of an upright box along one axis.
fn bound(lines: &mut NumberedLines) -> Result<[f64; 2], String> {
    let (i, line) = next(lines, "the box")?;
    match numbers(line).as_deref() {
        Some(&([low, high] | [low, high, 0.0])) if low < high => Ok([low, high]),
        _ => Err(format!(
            "line {}: an upright box has two numbers per axis, the lower one first, and no tilt; not {line:?}",
            i + 1
        )),
    }
}

/// Numbers apart from each other by blanks or commas, perhaps within brackets; `None` if one is
/// none.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split(|c: char| c.is_whitespace() || ",[]{}()".contains(c)).filter(|w| !w.is_empty());
    words.map(|word| word.parse::<f64>().ok().filter(|number| number.is_finite())).collect()
}

/// More columns than any program writes.
const MOST_COLUMNS: usize = 1000;

/// One frame of extended XYZ.
pub(super) fn xyz_frame(
    lines: &mut NumberedLines,
    meaning: &MicrostructureTable,
) -> Result<Positions, String> {
    let (i, line) = next(lines, "the number of spheres")?;
    let not_a_number =
        || format!("line {}: {line:?} where the number of spheres of a frame is needed", i + 1);
    let count = line.trim().parse::<usize>().map_err(|_| not_a_number())?;
    // the line of properties may begin with anything
    let (i, comment) = lines.next().ok_or("it ends before the line of properties")?;
    let wrong = |what: &str| format!("line {}: {what}", i + 1);
    let keys = quoted_keys(comment);
    let bounds = keys.get("lattice").map(|text| lattice(text, keys.get("origin"))).transpose();
    let bounds = bounds.map_err(|e| wrong(&e))?;
    let properties = keys.get("properties").ok_or_else(|| wrong("no Properties=…"))?;
    let names = property_columns(properties).map_err(|e| wrong(&e))?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let positions = rows(lines, count, &PositionColumns::named(&names, bounds, meaning)?)?;
    Ok(Positions { box_um: bounds, ..positions })
}

/// The name of every column: `pos:R:3` is x, y and z.
fn property_columns(properties: &str) -> Result<Vec<String>, String> {
    let parts: Vec<&str> = properties.split(':').collect();
    let mut names: Vec<String> = Vec::new();
    for part in parts.chunks(3) {
        let width = part.get(2).and_then(|width| width.parse::<usize>().ok());
        let width = width.filter(|width| *width <= MOST_COLUMNS - names.len().min(MOST_COLUMNS));
        let malformed = || {
            format!(
                "Properties are name:type:columns, at most {MOST_COLUMNS} columns in all; not {:?}",
                part.join(":")
            )
        };
        let width = width.ok_or_else(malformed)?;
        if part[0].eq_ignore_ascii_case("pos") {
            if width != 3 {
                return Err(format!("pos has {width} columns, not 3"));
            }
            names.extend(["x", "y", "z"].map(str::to_owned));
        } else {
            names.extend(std::iter::repeat_n(part[0].to_owned(), width));
        }
    }
    if names.iter().any(|name| name == "x") { Ok(names) } else { Err("no property pos".into()) }
}

/// An upright box from nine numbers, with its lowest corner at the origin or elsewhere.
fn lattice(text: &str, origin: Option<&String>) -> Result<Bounds, String> {
    let [x0, y0, z0] = match origin {
        None => [0.0; 3],
        Some(text) => match numbers(text).as_deref() {
            Some(&[x, y, z]) => [x, y, z],
            _ => return Err(format!("Origin {text:?} is not three numbers")),
        },
    };
    match numbers(text).as_deref() {
        Some(&[x, a, b, c, y, d, e, f, z])
            if [a, b, c, d, e, f] == [0.0; 6] && [x, y, z].iter().all(|side| *side > 0.0) =>
        {
            Ok([[x0, x0 + x], [y0, y0 + y], [z0, z0 + z]])
        }
        _ => Err(format!("Lattice {text:?} is no upright box with sides above 0")),
    }
}

/// `key=value` and `key="several words"`; keys in lower case.
fn quoted_keys(comment: &str) -> HashMap<String, String> {
    let mut keys = HashMap::new();
    let mut rest = comment.trim();
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let ends = [('"', '"'), ('\'', '\''), ('{', '}'), ('[', ']')];
        let (value, next) = match ends.iter().find(|(open, _)| after.starts_with(*open)) {
            Some((_, close)) => after[1..].split_once(*close).unwrap_or((&after[1..], "")),
            None => after.split_once(char::is_whitespace).unwrap_or((after, "")),
        };
        // words without a value may stand before a key
        let key = key.split_whitespace().last().unwrap_or_default().to_lowercase();
        keys.insert(key, value.to_owned());
        rest = next.trim_start();
    }
    keys
}

const NO_UNIT: &str = "its lengths have no unit: add unit = \"um\", \"nm\", \"mm\" or \"m\" beside spheres";
const NO_SIZE: &str = "its sizes may be radii or diameters: add size = \"radius\" or \"diameter\"";

impl PositionColumns {
    /// The columns of a dump or of XYZ by their names, with the units that the study gives; the box
    /// (in the file's unit) is what scaled coordinates are shares of.
    fn named(names: &[&str], bounds: Option<Bounds>, meaning: &MicrostructureTable) -> Result<Self, String> {
        let lower: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
        let find = |name: &str| lower.iter().position(|n| n == name);
        let um = meaning.unit.ok_or(NO_UNIT)?.um();
        let size = find("radius").or_else(|| find("diameter")).ok_or("no column radius or diameter")?;
        let factor = if meaning.size.ok_or(NO_SIZE)? == SizeColumn::Radius { 1.0 } else { 0.5 };
        let axis = |i: usize| {
            let name = ["x", "y", "z"][i];
            // as they are, or not wrapped into the box; then the same as shares of the box
            let plain = find(name).or_else(|| find(&format!("{name}u")));
            let scaled = || find(&format!("{name}s")).or_else(|| find(&format!("{name}su")));
            if let Some(column) = plain {
                return Ok(LengthColumn::new(column, um));
            }
            let column = scaled().ok_or_else(|| format!("no column {name}, {name}u, {name}s or {name}su"))?;
            let [low, high] = bounds.ok_or("scaled coordinates without a box before them")?[i];
            Ok::<_, String>(LengthColumn { column, factor_um: um * (high - low), offset_um: um * low })
        };
        let center = [axis(0)?, axis(1)?, axis(2)?];
        let molecule = find("mol").or_else(|| find("molecule"));
        Ok(Self {
            count: names.len(),
            center,
            radius: LengthColumn::new(size, um * factor),
            pigment: find("type").or_else(|| find("species")),
            grain: molecule.or_else(|| find("grain")),
            zero_is_alone: molecule.is_some(),
        })
    }
}
