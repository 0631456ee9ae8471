//! Positions of spheres in other programs' files: CSV, LAMMPS dumps and extended XYZ.
//!
//! A file is recognised by its first line that is neither blank nor a remark (`#`). Every row must
//! have as many values as the file names columns: a missing one would shift all that follow.

use super::file::{LengthUnit, MicrostructureTable, SizeColumn};
use crate::ink::Sphere;
use crate::ink::packing::sizes::MOST_GRAINS;
use crate::numerics::files;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// Spheres of one cut through a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Positions {
    /// The spheres, lengths in µm.
    pub spheres: Vec<Sphere>,
    /// Pigment of every sphere as the file calls it; empty if it does not.
    pub pigments: Vec<String>,
    /// The first number where pigments are numbers: 0 in CSV, as in the program's own files, else
    /// 1.
    pub counted_from: usize,
    /// Grain of every sphere; empty if every sphere is one.
    pub grains: Vec<String>,
    /// Lowest and highest x, y, z of the box, if the file has one, µm.
    pub box_um: Option<[[f64; 2]; 3]>,
}

/// All cuts in a file: one in CSV, one per frame otherwise. Files whose columns name no unit leave
/// to `table` the unit of all lengths, and whether the column of sizes holds radii or diameters.
///
/// # Errors
/// In words: what is missing or wrong, with its line.
pub fn read_positions(path: &Path, table: &MicrostructureTable) -> Result<Vec<Positions>, String> {
    let text = files::read_text(path, files::CASE).map_err(|e| e.to_string())?;
    let first = text.lines().map(str::trim).find(|line| !is_passed_over(line)).unwrap_or_default();
    if first.starts_with("ITEM:") {
        frames(&text, dump_frame, table)
    } else if first.parse::<usize>().is_ok() {
        frames(&text, xyz_frame, table)
    } else {
        Ok(vec![from_csv(&text, table)?])
    }
}

/// Whether a line holds no data: it is blank or a remark.
fn is_passed_over(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with('#')
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
        let unit_of = |part: &str| UNITS.iter().find(|(own, _)| *own == part).map(|(_, unit)| *unit);
        match parts[..] {
            [name, unit] if unit_of(unit).is_some() => Self { name: name.to_owned(), unit: unit_of(unit) },
            _ => Self { name: plain.trim().to_owned(), unit: None },
        }
    }
}

fn from_csv(text: &str, meaning: &MicrostructureTable) -> Result<Positions, String> {
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

/// A column of lengths: µm = `offset_um` + `factor_um` × value.
#[derive(Clone, Copy)]
struct LengthColumn {
    column: usize,
    factor_um: f64,
    offset_um: f64,
}

impl LengthColumn {
    fn new(column: usize, factor_um: f64) -> Self {
        Self { column, factor_um, offset_um: 0.0 }
    }

    fn read(&self, words: &[impl AsRef<str>], line: usize) -> Result<f64, String> {
        let word = words[self.column].as_ref();
        let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| format!("line {line}: {word:?} where a number is needed"))?;
        Ok(self.offset_um + self.factor_um * value)
    }
}

/// Where the numbers of a row are.
struct PositionColumns {
    /// Number of columns that the file names.
    count: usize,
    /// Columns of x, y and z.
    center: [LengthColumn; 3],
    radius: LengthColumn,
    pigment: Option<usize>,
    grain: Option<usize>,
    /// Whether grain 0 means none, as molecule 0 of a dump does.
    zero_is_alone: bool,
}

const NO_UNIT: &str = "its lengths have no unit: add unit = \"um\", \"nm\", \"mm\" or \"m\" beside spheres";
const NO_SIZE: &str = "its sizes may be radii or diameters: add size = \"radius\" or \"diameter\"";

impl PositionColumns {
    /// The values of a row, whose number must be that of the columns.
    fn read(&self, words: &[impl AsRef<str>], line: usize, into: &mut Positions) -> Result<(), String> {
        if words.len() != self.count {
            return Err(format!(
                "line {line}: {} values where {} columns are named",
                words.len(),
                self.count
            ));
        }
        let [x, y, z] = self.center;
        let center_um = [x.read(words, line)?, y.read(words, line)?, z.read(words, line)?];
        let radius_um = self.radius.read(words, line)?;
        if radius_um <= 0.0 {
            return Err(format!("line {line}: a sphere of radius {radius_um} µm"));
        }
        if into.spheres.len() >= MOST_GRAINS {
            return Err(format!("line {line}: more than {MOST_GRAINS} spheres in one cut"));
        }
        into.spheres.push(Sphere { center_um, radius_um });
        let word = |column: usize| words[column].as_ref().to_owned();
        into.pigments.extend(self.pigment.map(word));
        let alone =
            |grain: String| if self.zero_is_alone && grain == "0" { format!("line {line}") } else { grain };
        into.grains.extend(self.grain.map(word).map(alone));
        Ok(())
    }

    /// The columns of CSV by their names, which hold the units, or leave them to the study.
    fn of_csv(names: &[ColumnName], meaning: &MicrostructureTable) -> Result<Self, String> {
        let length = |known: &[&str]| -> Result<Option<LengthColumn>, String> {
            let own =
                |n: &ColumnName| known.contains(&n.name.as_str()) && (n.unit.or(meaning.unit)).is_some();
            let found: Vec<usize> = (0..names.len()).filter(|&i| own(&names[i])).collect();
            let unit = found.first().and_then(|&i| names[i].unit.or(meaning.unit));
            match found[..] {
                [] => Ok(None),
                [column] => Ok(unit.map(|unit| LengthColumn::new(column, unit.um()))),
                _ => {
                    let (count, name) = (found.len(), known[0]);
                    Err(format!("{count} columns for {name}: keep one {name}_um or {name}_nm"))
                }
            }
        };
        let axis = |name: &str| {
            let bare = names.iter().any(|n| n.name == name);
            let hint = if bare { "; or add unit = \"um\" beside spheres" } else { "" };
            let absent =
                format!("no column {name}_um or {name}_nm; a header names the columns with their unit{hint}");
            length(&[name])?.ok_or(absent)
        };
        let center = [axis("x")?, axis("y")?, axis("z")?];
        let (radius, diameter) = (length(&["radius", "r"])?, length(&["diameter", "d"])?);
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
        let (pigment, grain) = (find("pigment"), find("grain"));
        Ok(Self { count: names.len(), center, radius, pigment, grain, zero_is_alone: false })
    }

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

/// Lowest and highest x, y, z of a box, in the unit of its file.
type Bounds = [[f64; 2]; 3];
/// Lines with their numbers.
type NumberedLines<'a> = std::iter::Peekable<std::iter::Enumerate<std::str::Lines<'a>>>;
/// Reads one cut; its box is in the file's unit.
type CutReader = fn(&mut NumberedLines, &MicrostructureTable) -> Result<Positions, String>;

fn frames(text: &str, frame: CutReader, meaning: &MicrostructureTable) -> Result<Vec<Positions>, String> {
    let mut lines = text.lines().enumerate().peekable();
    let um = meaning.unit.map_or(1.0, LengthUnit::um);
    let (mut all, mut spheres) = (Vec::new(), 0);
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

fn dump_frame(lines: &mut NumberedLines, meaning: &MicrostructureTable) -> Result<Positions, String> {
    let (mut count, mut bounds) = (None, None);
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

/// Numbers apart from each other by blanks or commas, perhaps within brackets; `None` if one is
/// none.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split(|c: char| c.is_whitespace() || ",[]{}()".contains(c)).filter(|w| !w.is_empty());
    words.map(|word| word.parse::<f64>().ok().filter(|number| number.is_finite())).collect()
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

fn rows(lines: &mut NumberedLines, count: usize, table: &PositionColumns) -> Result<Positions, String> {
    let mut positions = Positions::default();
    for _ in 0..count {
        let (i, line) = next(lines, "the last of its spheres")?;
        table.read(&line.split_whitespace().collect::<Vec<_>>(), i + 1, &mut positions)?;
    }
    Ok(positions)
}

/// More columns than any program writes.
const MOST_COLUMNS: usize = 1000;

fn xyz_frame(lines: &mut NumberedLines, meaning: &MicrostructureTable) -> Result<Positions, String> {
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
    let at = match origin {
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
            Ok([[at[0], at[0] + x], [at[1], at[1] + y], [at[2], at[2] + z]])
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

#[cfg(test)]
mod tests {
    use super::*;

    fn in_nm() -> MicrostructureTable {
        let (unit, size) = (Some(LengthUnit::Nm), Some(SizeColumn::Diameter));
        MicrostructureTable { unit, size, ..Default::default() }
    }

    fn read(text: &str, meaning: &MicrostructureTable) -> Result<Vec<Positions>, String> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), text).expect("written");
        read_positions(file.path(), meaning)
    }

    /// Two spheres in three formats.
    #[test]
    fn three_formats_are_one() {
        let csv = "pigment,x_nm,y_um,z_um,diameter_nm\n1,100,0.2,0.3,80\n2,400,0.2,0.3,60\n";
        let atoms = "ITEM: ATOMS id type x y z radius\n1 1 100 200 300 80\n2 2 400 200 300 60\n";
        let dump = format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n0 500\n0 600\n0 700\n{atoms}"
        );
        let xyz = "2\nLattice=\"500 0 0 0 600 0 0 0 700\" Properties=species:S:1:pos:R:3:radius:R:1\n\
                   1 100 200 300 80\n2 400 200 300 60\n";
        let [csv, dump, xyz] = [(csv, Default::default()), (&dump, in_nm()), (xyz, in_nm())]
            .map(|(text, meaning)| read(text, &meaning).unwrap().remove(0));
        assert_eq!(dump, xyz);
        assert_eq!((&csv.spheres, &csv.pigments), (&dump.spheres, &dump.pigments));
        assert_eq!(csv.spheres[0].radius_um, 0.04);
        assert_eq!(dump.box_um.unwrap()[2].map(|x| (1e9 * x).round()), [0.0, 7e8]);
        assert_eq!(read(&xyz_twice(), &in_nm()).unwrap().len(), 2);
    }

    fn xyz_twice() -> String {
        "1\nProperties=species:S:1:pos:R:3:radius:R:1\n1 1 2 3 4\n".repeat(2)
    }

    /// One cell as programs write it. *Planted*: an origin or a corner that is ignored.
    #[test]
    fn variants_of_a_format_are_one() {
        let um = || MicrostructureTable {
            unit: Some(LengthUnit::Um),
            size: Some(SizeColumn::Radius),
            ..Default::default()
        };
        let expected = [[0.5, 1.5, 0.25, 0.125], [1.0, 0.5, 0.75, 0.25]];
        let dump = |head: &str, names: &str, rows: &str| {
            format!(
                "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS{head}\nITEM: ATOMS {names}\n{rows}"
            )
        };
        let upright = " pp pp ff\n0 2\n-1 3\n-1 1";
        let csv = [
            "# of a program\n\nx_um,y_um,z_um,radius_um\n0.5,1.5,0.25,0.125\n\n# half\n1,0.5,0.75,0.25\n"
                .to_owned(),
            "# x_um y_um z_um radius_um\n0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n".to_owned(),
            "X (µm);Y [um];z/µm;Diameter (mm)\r\n0,5;1,5;0,25;0,00025\r\n1;0,5;0,75;0,0005\r\n".to_owned(),
            "x\ty\tz\tradius\n0.5\t1.5\t0.25\t0.125\n1\t0.5\t0.75\t0.25\n".to_owned(),
            "\"x_m\",\"y_um\",z_um,d_nm\n5e-7,1.5,0.25,250\n1e-6,0.5,0.75,500\n".to_owned(),
        ];
        let dumps = [
            dump(upright, "id type x y z radius", "1 1 0.5 1.5 0.25 0.125\n2 1 1 0.5 0.75 0.25\n"),
            dump(upright, "type xu yu zu radius", "1 0.5 1.5 0.25 0.125\n\n# two\n1 1 0.5 0.75 0.25\n"),
            dump(upright, "xs ys zs radius", "0.25 0.625 0.625 0.125\n0.5 0.375 0.875 0.25\n"),
            dump(upright, "radius xsu ysu zsu", "0.125 0.25 0.625 0.625\n0.25 0.5 0.375 0.875\n"),
            dump(
                " xy xz yz pp pp ff\n0 2 0\n-1 3 0\n-1 1 0",
                "x y z radius",
                "0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n",
            ),
            "# first\n".to_owned() + &dump(upright, "x y z Radius", "0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n"),
        ];
        let xyz = [
            "2\nLattice=\"2 0 0 0 4 0 0 0 2\" Origin=\"0 -1 -1\" Properties=pos:R:3:radius:R:1 pbc=\"T T F\"\n\
             0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n",
            "\n2\nframe properties=species:S:1:pos:R:3:radius:R:1 origin=[0,-1,-1] lattice={2 0 0 0 4 0 0 0 2}\n\
             A 0.5 1.5 0.25 0.125\n# second\nA 1 0.5 0.75 0.25\n\n",
        ]
        .map(str::to_owned);
        for (text, has_box) in
            csv.iter().map(|t| (t, false)).chain(dumps.iter().chain(&xyz).map(|t| (t, true)))
        {
            let cut = read(text, &um()).unwrap_or_else(|e| panic!("{text}: {e}")).remove(0);
            let found =
                cut.spheres.iter().map(|s| [s.center_um[0], s.center_um[1], s.center_um[2], s.radius_um]);
            for (found, expected) in found.zip(expected) {
                // identity: rounding of units and of shares
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{text}: {found:?}");
            }
            assert_eq!(cut.box_um, has_box.then_some([[0.0, 2.0], [-1.0, 3.0], [-1.0, 1.0]]), "{text}");
            assert_eq!(cut.spheres.len(), 2, "{text}");
        }
    }

    /// *Planted*: a row that lacks a value would shift the pigments of all that follow.
    #[test]
    fn rows_without_a_value_are_refused_with_their_line() {
        let dump = |names: &str, rows: &str| {
            format!(
                "ITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n0 9\n0 9\n0 9\nITEM: ATOMS {names}\n{rows}"
            )
        };
        let bounds = |line: &str| {
            let other = format!("ITEM: BOX BOUNDS pp pp ff\n{line}\n");
            dump("x y z radius", "1 2 3 4\n1 2 3 4\n").replace("ITEM: BOX BOUNDS pp pp ff\n0 9\n", &other)
        };
        for (text, says) in [
            (dump("x y z radius type", "1 2 3 4 1\n1 2 3 4\n"), "line 9: 4 values where 5 columns"),
            (dump("x y z radius type", "1 2 3 4 1\n1 2 3 4 1 7\n"), "line 9: 6 values where 5 columns"),
            (dump("x y z radius", "1 2 3 4\nITEM: TIMESTEP\n"), "line 9: 2 values"),
            (dump("x y z radius", "1 2 3 4\n1 2 3 4\n1 2 3 4\n"), "line 10: \"1 2 3 4\" where an ITEM"),
            (bounds("0 9 1"), "line 4: an upright box"),
            (bounds("9 0"), "line 4: an upright box"),
            (bounds("0 a"), "line 4: an upright box"),
            ("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs radius\n0 0 0 1\n".to_owned(), "without a box"),
            ("ITEM: ATOMS x y z radius\n0 0 0 1\n".to_owned(), "no NUMBER OF ATOMS"),
            (xyz_twice().replace("1 1 2 3 4", "1 1 2 3"), "line 3: 4 values where 5 columns"),
            (xyz_twice() + "1 1 2 3 4\n", "line 7: \"1 1 2 3 4\" where the number"),
            ("1\nProperties=species:S:1000000000000:pos:R:3\n1 2\n".to_owned(), "at most 1000 columns"),
            ("1\nProperties=species:S:1:pos:R:3:radius\n1 2\n".to_owned(), "not \"radius\""),
            ("1\nLattice=\"2 0 0 0 2 0 0 0 1 a\" Properties=pos:R:3\n1 2\n".to_owned(), "no upright box"),
            ("1\nLattice=\"2 0 0 0 2 0 0 0 1\" Origin=\"1 2\" Properties=pos:R:3\n1\n".to_owned(), "Origin"),
            ("x_um,y_um,z_um,radius_um,pigment\n1,2,3,1,a\n1,2,3,1\n".to_owned(), "line 3: 4 values where 5"),
            ("x_um,y_um,z_um,radius_um\n1,2,3,1\n1,2,3,1,a\n".to_owned(), "line 3: 5 values where 4"),
            ("x,y,z,radius\n1,2,3,1\n".to_owned(), "no column radius_um"),
        ] {
            let meaning = if says.contains("radius_um") { Default::default() } else { in_nm() };
            let error = read(&text, &meaning).unwrap_err();
            assert!(error.contains(says) || error.contains("add unit"), "{text}: {error}");
        }
        // molecule 0 of a dump is none
        let apart = read(&dump("mol x y z radius", "0 1 2 3 1\n0 5 2 3 1\n"), &in_nm()).unwrap().remove(0);
        assert_ne!(apart.grains[0], apart.grains[1]);
    }

    #[test]
    fn what_a_file_leaves_open_is_asked_for() {
        let xyz = xyz_twice();
        for (text, meaning, says) in [
            (xyz.as_str(), MicrostructureTable { unit: None, ..in_nm() }, "no unit"),
            (xyz.as_str(), MicrostructureTable { size: None, ..in_nm() }, "radii or diameters"),
            ("x,y,z,r\n1,2,3,4\n", Default::default(), "no column x_um or x_nm"),
            ("x_um,y_um,z_um\n1,2,3\n", in_nm(), "radius_um or diameter_um"),
            ("x_um,x_um,y_um,z_um,radius_um\n1,1,2,3,1\n", in_nm(), "2 columns for x"),
            ("x_um,x_nm,y_um,z_um,radius_um\n1,1,2,3,1\n", in_nm(), "2 columns for x"),
            ("x_um,y_um,z_um,radius_um,radius_nm\n1,2,3,1,1\n", in_nm(), "2 columns for radius"),
            ("x_um,y_um,z_um,radius_um\n1,2,a,1\n", in_nm(), "line 2: \"a\""),
            ("x_um,y_um,z_um,radius_um\n1,2,3,0\n", in_nm(), "line 2: a sphere of radius 0"),
            ("3\nProperties=species:S:1:pos:R:3:radius:R:1\n1 1 2 3 4\n", in_nm(), "ends before the last"),
        ] {
            let error = read(text, &meaning).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
    }
}
