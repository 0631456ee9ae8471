//! Reading of refractiveindex.info's YAML files.

use super::{DataSource, Dispersion};
use crate::material::usable::{FileRow, Usable, usable};
use crate::numerics::files::{self, FileError};
use serde::{Deserialize, Deserializer};
use serde_norway::Value;
use std::path::Path;

/// Largest depth of nested brackets, including those in comments.
const MOST_OPEN: usize = 200;

/// What a record states about itself, without markup; empty where it says nothing.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct RecordText {
    /// The publications.
    #[serde(rename = "REFERENCES", deserialize_with = "plain")]
    pub reference: String,
    /// What was measured and how.
    #[serde(rename = "COMMENTS", deserialize_with = "plain")]
    pub comment: String,
}

/// Text without tags, on one line.
fn plain<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let html = String::deserialize(from)?;
    let outside = html.split('<').enumerate().map(|(i, part)| match part.split_once('>') {
        Some((_, rest)) if i > 0 => rest,
        _ => part,
    });
    Ok(outside.collect::<String>().split_whitespace().collect::<Vec<_>>().join(" "))
}

#[derive(Deserialize)]
struct DispersionRecord {
    #[serde(rename = "DATA")]
    data: Vec<DataEntry>,
}

#[derive(Deserialize)]
struct DataEntry {
    #[serde(rename = "type")]
    kind: String,
    data: Option<String>,
    #[serde(alias = "range")]
    wavelength_range: Option<Value>,
    coefficients: Option<Value>,
}

impl Dispersion {
    /// Reads a record's YAML file.
    ///
    /// # Errors
    /// The file cannot be read, is not a record, or holds numbers that give no index.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let name = path.display().to_string();
        let text = files::read_text(path, files::RECORD).map_err(|error| FileError::new(&name, error))?;
        let expected = "expected a record of refractiveindex.info with DATA: - type: tabulated nk, n, k or formula 1 to 9";
        Self::parse(&name, &text)
            .map_err(|reason| FileError::new(&name, format_args!("{reason}; {expected}")))
    }

    pub(in crate::material) fn parse(name: &str, text: &str) -> Result<Self, String> {
        if let Some(depth) = too_deep(text) {
            return Err(format!("{depth} brackets are open at once; a record has a few"));
        }
        let record: DispersionRecord = serde_norway::from_str(text).map_err(in_words)?;
        let mut found =
            Self { name: name.to_owned(), n: None, kappa: None, unusable: Vec::new(), joined: Vec::new() };
        for entry in &record.data {
            found.take(entry)?;
        }
        let either = found.n.is_some() || found.kappa.is_some();
        either.then_some(found).ok_or_else(|| "it has neither n nor k".into())
    }

    fn take(&mut self, entry: &DataEntry) -> Result<(), String> {
        let words: Vec<&str> = entry.kind.split_whitespace().collect();
        match words.as_slice() {
            ["tabulated", "nk"] => {
                let rows = self.sound_rows(entry, 2)?;
                put(&mut self.n, column(&rows, 1), "n")?;
                put(&mut self.kappa, column(&rows, 2), "k")
            }
            ["tabulated", "n"] => {
                let rows = self.sound_rows(entry, 1)?;
                put(&mut self.n, column(&rows, 1), "n")
            }
            ["tabulated", "k"] => {
                let rows = self.sound_rows(entry, 1)?;
                put(&mut self.kappa, column(&rows, 1), "k")
            }
            ["formula", number] => put(&mut self.n, formula(entry, number)?, "n"),
            _ => Err(format!("type {:?} is not known", entry.kind)),
        }
    }

    /// The sound rows of a table: λ in µm and `columns` numbers. Where there is none is remembered.
    fn sound_rows(&mut self, entry: &DataEntry, columns: usize) -> Result<Vec<Vec<f64>>, String> {
        let lines = entry.data.as_deref().unwrap_or("").lines().filter(|line| !line.trim().is_empty());
        let rows = lines.map(|line| {
            let first = line.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
            let nm = first.filter(|um| um.is_finite() && *um > 0.0).map(|um| 1e3 * um);
            let values = numbers(line, columns + 1).map(|mut row| {
                row.truncate(columns + 1);
                row
            });
            FileRow { nm, values }
        });
        let Usable { rows, gaps, first_fault } = usable(rows.collect());
        self.unusable.extend(gaps);
        if rows.is_empty() {
            return Err(first_fault.unwrap_or_else(|| format!("type {:?} has no data", entry.kind)));
        }
        Ok(rows.into_iter().map(|(_, row)| row).collect())
    }
}

/// The nesting depth if it exceeds the limit: the parser's time grows with its square.
fn too_deep(text: &str) -> Option<usize> {
    let mut open = 0usize;
    for byte in text.bytes() {
        match byte {
            b'[' | b'{' => open += 1,
            b']' | b'}' => open = open.saturating_sub(1),
            _ => {}
        }
        if open > MOST_OPEN {
            return Some(open);
        }
    }
    None
}

fn put(place: &mut Option<DataSource>, source: DataSource, part: &str) -> Result<(), String> {
    place.replace(source).map_or(Ok(()), |_| Err(format!("it has {part} twice; keep one of them")))
}

/// λ in µm with one of the columns.
fn column(rows: &[Vec<f64>], column: usize) -> DataSource {
    DataSource::Table(rows.iter().map(|row| [row[0], row[column]]).collect())
}

fn formula(entry: &DataEntry, number: &str) -> Result<DataSource, String> {
    let number = number.parse().ok().filter(|n| (1..=9).contains(n));
    let number = number.ok_or_else(|| format!("type {:?}: allowed are formula 1 to 9", entry.kind))?;
    let text = |value: &Option<Value>| match value {
        Some(Value::String(text)) => text.clone(),
        Some(Value::Number(number)) => number.to_string(),
        _ => String::new(),
    };
    let range = numbers(&text(&entry.wavelength_range), 2)?;
    if range[0] >= range[1] {
        return Err(format!("wavelength_range does not increase: {} to {} µm", range[0], range[1]));
    }
    let coefficients = numbers(&text(&entry.coefficients), 1)?;
    let count = coefficients.len();
    let (possible, allowed) = match number {
        1 | 2 | 3 | 5 | 6 => (count % 2 == 1, "an odd number: one, and pairs"),
        4 => (count >= 9 && count % 2 == 1, "9, and further pairs"),
        7 => ((3..=6).contains(&count), "3 to 6"),
        8 => (count == 4, "4"),
        _ => (count == 6, "6"),
    };
    if !possible {
        return Err(format!(
            "formula {number} has {count} coefficients where it needs {allowed}: the record is incomplete, and no index follows from it"
        ));
    }
    Ok(DataSource::Formula { number, range_um: [range[0], range[1]], coefficients })
}

/// At least `least` finite numbers.
fn numbers(text: &str, least: usize) -> Result<Vec<f64>, String> {
    let parse = |word: &str| {
        let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
        number.ok_or_else(|| format!("found {word:?} where a number is needed"))
    };
    let numbers = text.split_whitespace().map(parse).collect::<Result<Vec<f64>, String>>()?;
    if numbers.len() < least {
        return Err(format!("found {text:?} where {least} numbers are needed"));
    }
    Ok(numbers)
}

/// The message of the YAML parser, which names a type of this program.
fn in_words(error: serde_norway::Error) -> String {
    error.to_string().replace("struct DispersionRecord", "a record of refractiveindex.info")
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/data/refractive_index_info");

    /// All formulas and tables against another reader of the same database.
    #[test]
    fn records_give_what_the_databases_own_reader_gives() {
        let text = std::fs::read_to_string(format!("{FOLDER}/values.json")).unwrap();
        let values: serde_json::Value = serde_json::from_str(&text).unwrap();
        let materials = values["materials"].as_array().unwrap();
        let mut compared = 0;
        for material in materials {
            let file = material["file"].as_str().unwrap();
            let dispersion = Dispersion::read(Path::new(&format!("{FOLDER}/{file}"))).unwrap();
            for row in material["rows"].as_array().unwrap() {
                let eta = dispersion.index(row[0].as_f64().unwrap());
                for (have, want) in [(eta.re, row[1].as_f64()), (eta.im, row[2].as_f64())] {
                    let Some(want) = want else { continue };
                    // the same formula in another order of operations
                    assert!((have - want).abs() <= 1e-12 * want.abs().max(1.0), "{file}: {have} {want}");
                    compared += 1;
                }
            }
        }
        assert!(materials.len() >= 16 && compared > 100, "{compared}");
    }

    /// Rows that are not used block nothing; where they are used, the reason is given.
    #[test]
    fn faults_of_other_rows_do_not_block_a_record() {
        let rows = "0.40 1.50 0.1\n        0.70 1.56 0.1\n        1.20 1.56\n        4.90 1.6 0.1\n        4.90 1.7 0.1\n";
        let text = format!("DATA:\n  - type: tabulated nk\n    data: |\n        {rows}");
        let record = Dispersion::parse("x.yml", &text).unwrap();
        assert!((record.index(0.55).re - 1.53).abs() < 1e-12);
        assert_eq!(record.unusable([400.0, 700.0]), None);
        assert!(record.unusable([400.0, 800.0]).unwrap().reason.contains("3 numbers are needed"));
        assert!(record.unusable([4800.0, 4900.0]).unwrap().reason.contains("numbers are needed"));
        let falling =
            "DATA:\n  - type: tabulated n\n    data: |\n        0.6 1.6\n        0.5 1.5\n        0.4 1.4\n";
        assert!((Dispersion::parse("x.yml", falling).unwrap().index(0.45).re - 1.45).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_record_is_refused_with_its_reason() {
        let reason = |text: &str| Dispersion::parse("x.yml", text).unwrap_err();
        assert!(reason("DATA:\n  - type: formula 12\n    coefficients: 1\n").contains("formula 1 to 9"));
        assert!(reason("DATA:\n  - type: tabulated n\n    data: |\n        0.5 x\n").contains("\"x\""));
        assert!(reason("DATA: []\n").contains("neither"));
        assert!(reason("REFERENCES: me\n").contains("DATA"));
        assert!(reason(&"[".repeat(200_000)).contains("brackets are open at once"));
        // half a pair of coefficients, and a formula without its last
        let formula = |number: u8, count: usize| {
            let all = vec!["0.1"; count].join(" ");
            let text = format!(
                "DATA:\n  - type: formula {number}\n    wavelength_range: 0.4 0.8\n    coefficients: {all}\n"
            );
            Dispersion::parse("x.yml", &text)
        };
        for (number, right, wrong) in [
            (1, vec![1, 3, 17], vec![2, 4]),
            (2, vec![3, 11], vec![4]),
            (3, vec![5, 15], vec![6]),
            (4, vec![9, 11, 17], vec![7, 10, 12]),
            (5, vec![1, 11], vec![2]),
            (6, vec![3, 11], vec![4]),
            (7, vec![3, 5, 6], vec![2, 7]),
            (8, vec![4], vec![3, 5]),
            (9, vec![6], vec![5, 7]),
        ] {
            assert!(right.iter().all(|&count| formula(number, count).is_ok()), "formula {number}");
            for count in wrong {
                let reason = formula(number, count).unwrap_err();
                assert!(reason.contains(&format!("formula {number} has {count} coefficients")), "{reason}");
            }
        }
        // the parser's own limits hold for what has no brackets
        assert!(!reason(&"- ".repeat(100_000)).is_empty());
    }
}
