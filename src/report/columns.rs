//! What the columns of all tables hold: unit, type and description, each defined once in
//! `definitions`; `data_package` describes the tables of a folder with them.

mod data_package;
mod definitions;

pub use data_package::{DATA_PACKAGE, FolderTables, fields, resource};

use definitions::{COLUMNS, Definition, NUMBER};
use serde_json::{Value, json};

/// A table's name, bytes and description.
pub type NamedTable = (&'static str, Vec<u8>, &'static str);

/// A number's name with its unit, for readers.
pub fn heading(name: &str) -> String {
    name.replace("kubelka_munk", "Kubelka–Munk")
        .replace("_per_um", ", 1/µm")
        .replace("_um", ", µm")
        .replace('_', " ")
}

/// What a column holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name in the header.
    pub name: String,
    /// `number`, `integer`, `boolean` or `string`. Stated because readers that guess take an angle
    /// that happens to be whole for an integer.
    pub kind: &'static str,
    /// Unit; empty for shares, ratios and words.
    pub unit: String,
    /// What it holds.
    pub about: String,
}

/// Endings of columns that belong to another one, with what they add to its description.
const ENDINGS: [(&str, &str); 2] = [
    ("_standard_error", "one standard error of"),
    ("_half_width_95", "half the width of the 95 % interval of"),
];

/// The column of this name in a table; `None` if nothing is known of it.
pub fn column(table: &str, name: &str) -> Option<Column> {
    let lines = || COLUMNS.iter().filter(|line| line.name == name);
    let of_table = lines().find(|line| line.tables.contains(&table));
    if let Some(found) = of_table.or_else(|| lines().find(|line| line.tables.is_empty())) {
        let Definition { kind, unit, about, .. } = *found;
        return Some(Column { name: name.to_owned(), kind, unit: unit.to_owned(), about: about.to_owned() });
    }
    ENDINGS.iter().find_map(|(ending, start)| {
        let stem = column(table, name.strip_suffix(ending)?)?;
        Some(Column { name: name.to_owned(), kind: NUMBER, about: format!("{start} {}", stem.name), ..stem })
    })
}

/// All columns that tables may have, in the order of the light: name, type, unit, description, and
/// the tables where a name means this alone.
pub fn dictionary() -> Value {
    let column = |line: &Definition| {
        let mut column = json!({ "name": line.name, "type": line.kind, "description": line.about });
        if !line.unit.is_empty() {
            column["unit"] = line.unit.into();
        }
        if !line.tables.is_empty() {
            column["tables"] = line.tables.into();
        }
        column
    };
    let endings = ENDINGS.map(|(ending, about)| json!({ "ending": ending, "description": about }));
    json!({ "columns": COLUMNS.iter().map(column).collect::<Vec<_>>(), "endings": endings })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::manifest::SpectrumRow;
    use crate::evaluate::manifest::composed::{ComposedRow, MediumRow};
    use crate::evaluate::published::PublishedRow;

    #[test]
    fn a_columns_error_has_its_unit_and_its_name() {
        let own = column("kubelka-munk.csv", "scattering_per_um_half_width_95").unwrap();
        assert_eq!((own.unit.as_str(), own.kind), ("1/µm", NUMBER));
        assert_eq!(own.about, "half the width of the 95 % interval of scattering_per_um");
        assert_eq!(column("bdf.csv", "n").unwrap().kind, "integer");
        assert_eq!(column("pigment.csv", "n").unwrap().kind, NUMBER);
        assert_eq!(column("spectra.csv", "bdf"), None);
    }

    /// A quantity that is published has a unit and a meaning. *Planted*: a quantity added to a row
    /// and not to the list of columns.
    #[test]
    fn every_published_number_is_described() {
        let undescribed = |table: &str, names: Vec<&'static str>| {
            names.into_iter().filter(|name| column(table, name).is_none()).collect::<Vec<_>>()
        };
        assert_eq!(undescribed("spectra.csv", SpectrumRow::names()), Vec::<&str>::new());
        assert_eq!(undescribed("spectra.csv", ComposedRow::names()), Vec::<&str>::new());
        assert_eq!(undescribed("medium.csv", MediumRow::names()), Vec::<&str>::new());
    }

    #[test]
    fn no_column_is_described_twice() {
        for (i, line) in COLUMNS.iter().enumerate() {
            let same = |other: &&Definition| {
                let everywhere = other.tables.is_empty() && line.tables.is_empty();
                other.name == line.name
                    && (everywhere || other.tables.iter().any(|t| line.tables.contains(t)))
            };
            assert!(!COLUMNS[..i].iter().any(|other| same(&other)), "{}", line.name);
        }
    }
}
