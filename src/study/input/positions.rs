//! Positions of spheres in other programs' files: CSV, LAMMPS dumps and extended XYZ.

use super::file::{LengthUnit, MicrostructureTable, SizeColumn};
use crate::ink::Sphere;
use crate::numerics::files;
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

/// All cuts in a file: one in CSV, one per frame otherwise. Dumps and XYZ files leave to `table`
/// the unit of all lengths, and whether the column of sizes holds radii or diameters.
///
/// # Errors
/// In words: what is missing or wrong, with its line.
pub fn read_positions(path: &Path, table: &MicrostructureTable) -> Result<Vec<Positions>, String> {
    let text = files::read_text(path, files::TABLE).map_err(|e| e.to_string())?;
    let first = text.trim_start();
    if first.starts_with("ITEM:") {
        return frames(&text, dump_frame, table);
    }
    match first.lines().next().map(|line| line.trim().parse::<usize>()) {
        Some(Ok(_)) => frames(&text, xyz_frame, table),
        _ => Ok(vec![from_csv(&text)?]),
    }
}

fn from_csv(text: &str) -> Result<Positions, String> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let names: Vec<String> = reader.headers().map_err(|e| e.to_string())?.iter().map(str::to_owned).collect();
    let [x, y, z] = [with_unit(&names, "x")?, with_unit(&names, "y")?, with_unit(&names, "z")?];
    let sizes = ["radius", "diameter"].map(|n| [format!("{n}_um"), format!("{n}_nm")]);
    let radius = match sizes.map(|own| own.iter().any(|name| names.contains(name))) {
        [true, false] => with_unit(&names, "radius")?,
        [false, true] => with_unit(&names, "diameter").map(|(column, um)| (column, 0.5 * um))?,
        [true, true] => return Err("both a radius and a diameter".into()),
        _ => return Err("no column radius_um or diameter_um (or _nm)".into()),
    };
    let [pigment, grain] = ["pigment", "grain"].map(|name| names.iter().position(|n| n == name));
    let table = PositionColumns { lengths: [x, y, z, radius], pigment, grain };
    let mut positions = Positions::default();
    for (i, record) in reader.records().enumerate() {
        let record = record.map_err(|e| e.to_string())?;
        let words: Vec<&str> = record.iter().collect();
        table.read(&words, i + 2, &mut positions)?;
    }
    Ok(positions)
}

/// The column of a length and its unit in µm.
fn with_unit(names: &[String], name: &str) -> Result<(usize, f64), String> {
    let units = [(format!("{name}_um"), 1.0), (format!("{name}_nm"), 1e-3)];
    let of = |n: &String| units.iter().find(|(own, _)| own == n).map(|(_, um)| *um);
    let found: Vec<(usize, f64)> = names.iter().enumerate().filter_map(|(i, n)| Some((i, of(n)?))).collect();
    match found[..] {
        [one] => Ok(one),
        [] => Err(format!("no column {name}_um or {name}_nm; a header names the columns with their unit")),
        _ => Err(format!("{} columns for {name}: keep one {name}_um or {name}_nm", found.len())),
    }
}

/// Where the numbers of a row are.
struct PositionColumns {
    /// Columns of x, y, z and the radius, with their factors to µm.
    lengths: [(usize, f64); 4],
    pigment: Option<usize>,
    grain: Option<usize>,
}

impl PositionColumns {
    fn read(&self, words: &[&str], line: usize, into: &mut Positions) -> Result<(), String> {
        let length = |(column, um): (usize, f64)| {
            let word = words.get(column).copied().unwrap_or_default();
            let finite = word.parse::<f64>().ok().filter(|v| v.is_finite()).map(|value| value * um);
            finite.ok_or_else(|| format!("line {line}: {word:?} where a number is needed"))
        };
        let [x, y, z, radius] = self.lengths.map(length);
        let (center_um, radius_um) = ([x?, y?, z?], radius?);
        if radius_um <= 0.0 {
            return Err(format!("line {line}: a sphere of radius {radius_um} µm"));
        }
        into.spheres.push(Sphere { center_um, radius_um });
        let word = |column: usize| words.get(column).map(|w| (*w).to_owned());
        into.pigments.extend(self.pigment.and_then(word));
        into.grains.extend(self.grain.and_then(word));
        Ok(())
    }

    /// The columns of a dump or of XYZ by their names, with the units that the study gives.
    fn named(names: &[&str], axes: [&[&str]; 3], meaning: &MicrostructureTable) -> Result<Self, String> {
        let find = |all: &[&str]| names.iter().position(|n| all.contains(n));
        let no_unit = "its lengths have no unit: add unit = \"um\" or \"nm\" beside spheres";
        let um = meaning.unit.ok_or(no_unit)?.um();
        let size = find(&["radius", "diameter"]).ok_or("no column radius or diameter")?;
        let unstated = "its sizes may be radii or diameters: add size = \"radius\" or \"diameter\"";
        let factor = if meaning.size.ok_or(unstated)? == SizeColumn::Radius { 1.0 } else { 0.5 };
        let [x, y, z] = axes.map(|all| find(all).ok_or_else(|| format!("no column {}", all[0])));
        let (pigment, grain) = (find(&["type", "species"]), find(&["mol", "grain"]));
        Ok(Self { lengths: [(x?, um), (y?, um), (z?, um), (size, um * factor)], pigment, grain })
    }
}

/// Lines with their numbers.
type NumberedLines<'a> = std::iter::Peekable<std::iter::Enumerate<std::str::Lines<'a>>>;
/// Reads one cut; its box is in the file's unit.
type CutReader = fn(&mut NumberedLines, &MicrostructureTable) -> Result<Positions, String>;

fn frames(text: &str, frame: CutReader, meaning: &MicrostructureTable) -> Result<Vec<Positions>, String> {
    let mut lines = text.lines().enumerate().peekable();
    let um = meaning.unit.map_or(1.0, LengthUnit::um);
    let mut all = Vec::new();
    while lines.peek().is_some() {
        let cut = frame(&mut lines, meaning)?;
        let box_um = cut.box_um.map(|b| b.map(|range| range.map(|x| x * um)));
        all.push(Positions { counted_from: 1, box_um, ..cut });
        while lines.next_if(|(_, line)| line.trim().is_empty()).is_some() {}
    }
    Ok(all)
}

fn next<'a>(lines: &mut NumberedLines<'a>, what: &str) -> Result<(usize, &'a str), String> {
    lines.next().ok_or_else(|| format!("it ends before {what}"))
}

fn dump_frame(lines: &mut NumberedLines, meaning: &MicrostructureTable) -> Result<Positions, String> {
    let (mut count, mut bounds) = (0, None);
    loop {
        let (i, line) = next(lines, "ITEM: ATOMS")?;
        let item =
            line.trim().strip_prefix("ITEM:").ok_or_else(|| format!("line {}: no ITEM:", i + 1))?.trim();
        if item == "NUMBER OF ATOMS" {
            let (i, line) = next(lines, "the number of atoms")?;
            count = line.trim().parse().map_err(|_| format!("line {}: no number of atoms", i + 1))?;
        } else if item.starts_with("BOX BOUNDS") {
            bounds = Some([bound(lines)?, bound(lines)?, bound(lines)?]);
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let names: Vec<&str> = names.split_whitespace().collect();
            let table = PositionColumns::named(&names, [&["x", "xu"], &["y", "yu"], &["z", "zu"]], meaning)?;
            return Ok(Positions { box_um: bounds, ..rows(lines, count, &table)? });
        } else {
            next(lines, "the value of an item")?;
        }
    }
}

fn bound(lines: &mut NumberedLines) -> Result<[f64; 2], String> {
    let (i, line) = next(lines, "the box")?;
    match line.split_whitespace().filter_map(|w| w.parse().ok()).collect::<Vec<f64>>()[..] {
        [low, high] => Ok([low, high]),
        _ => Err(format!("line {}: an upright box has two numbers per axis, not {line:?}", i + 1)),
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

fn xyz_frame(lines: &mut NumberedLines, meaning: &MicrostructureTable) -> Result<Positions, String> {
    let (i, line) = next(lines, "the number of spheres")?;
    let count = line.trim().parse().map_err(|_| format!("line {}: no number of spheres", i + 1))?;
    let (i, comment) = next(lines, "the line of properties")?;
    let wrong = |what: &str| format!("line {}: {what}", i + 1);
    let keys = quoted_keys(comment);
    let properties = keys.get("Properties").ok_or_else(|| wrong("no Properties=…"))?;
    let mut names: Vec<&str> = Vec::new();
    for part in properties.split(':').collect::<Vec<&str>>().chunks_exact(3) {
        let width: usize = part[2].parse().map_err(|_| wrong("Properties are name:type:columns"))?;
        names.extend(std::iter::repeat_n(part[0], width));
    }
    let place = names.iter().position(|n| *n == "pos").ok_or_else(|| wrong("no property pos"))?;
    names.iter_mut().skip(place).take(3).zip(["x", "y", "z"]).for_each(|(name, axis)| *name = axis);
    let positions = rows(lines, count, &PositionColumns::named(&names, [&["x"], &["y"], &["z"]], meaning)?)?;
    let box_um = keys.get("Lattice").map(|text| lattice(text)).transpose().map_err(|e| wrong(&e))?;
    Ok(Positions { box_um, ..positions })
}

/// An upright box at the origin from nine numbers.
fn lattice(text: &str) -> Result<[[f64; 2]; 3], String> {
    match text.split_whitespace().filter_map(|w| w.parse().ok()).collect::<Vec<f64>>()[..] {
        [x, a, b, c, y, d, e, f, z] if [a, b, c, d, e, f] == [0.0; 6] => Ok([x, y, z].map(|l| [0.0, l])),
        _ => Err(format!("Lattice {text:?} is no upright box")),
    }
}

/// `key=value` and `key="several words"`.
fn quoted_keys(comment: &str) -> HashMap<String, String> {
    let mut keys = HashMap::new();
    let mut rest = comment.trim();
    while let Some((key, after)) = rest.split_once('=') {
        let (value, next) = match after.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => after.split_once(char::is_whitespace).unwrap_or((after, "")),
        };
        keys.insert(key.trim().to_owned(), value.to_owned());
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

    #[test]
    fn what_a_file_leaves_open_is_asked_for() {
        let xyz = xyz_twice();
        for (text, meaning, says) in [
            (xyz.as_str(), MicrostructureTable { unit: None, ..in_nm() }, "no unit"),
            (xyz.as_str(), MicrostructureTable { size: None, ..in_nm() }, "radii or diameters"),
            ("x,y,z,r\n1,2,3,4\n", in_nm(), "no column x_um or x_nm"),
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
