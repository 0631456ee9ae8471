//! `datapackage.json` beside the tables of a folder: their columns for readers and programs
//! (Frictionless Data Package).

use super::definitions::NUMBER;
use super::{Column, column};
use crate::store::folder::{FolderError, OutputFolder};
use serde_json::{Value, json};

/// Name of the file that describes a folder's tables.
pub const DATA_PACKAGE: &str = "datapackage.json";

/// A folder's tables, which are described together when all are written.
pub struct FolderTables<'a> {
    folder: &'a OutputFolder,
    resources: Vec<Value>,
}

impl<'a> FolderTables<'a> {
    /// None yet.
    pub fn new(folder: &'a OutputFolder) -> Self {
        Self { folder, resources: Vec::new() }
    }

    /// Writes a table; `user_columns` describes those that the user has named.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(
        &mut self,
        name: &str,
        bytes: &[u8],
        about: &str,
        user_columns: &[Column],
    ) -> Result<(), FolderError> {
        self.folder.write(name, bytes)?;
        self.resources.push(resource(name, bytes, about, user_columns));
        Ok(())
    }

    /// Writes `datapackage.json`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn describe(self, title: &str) -> Result<(), FolderError> {
        let package = json!({
            "profile": "data-package",
            "name": "inkwave",
            "title": title,
            "version": env!("CARGO_PKG_VERSION"),
            "resources": self.resources,
        });
        self.folder.write(DATA_PACKAGE, format!("{package:#}").as_bytes())
    }
}

/// A table as a resource of a data package.
pub fn resource(name: &str, bytes: &[u8], about: &str, user_columns: &[Column]) -> Value {
    let commented = bytes.starts_with(b"#");
    let mut resource = json!({
        "name": name.to_lowercase().replace([' ', '/', '.', '_'], "-"),
        "path": name,
        "description": about,
        "profile": "tabular-data-resource",
        "mediatype": "text/csv",
        "format": "csv",
        "encoding": "utf-8",
        "bytes": bytes.len(),
        "schema": { "fields": fields(name, bytes, user_columns), "missingValues": [""] },
    });
    if commented {
        resource["dialect"] = json!({ "commentChar": "#" });
    }
    resource
}

/// The columns of a table in order, as a schema of tables has them. Columns that are named by the
/// user are in `user_columns`; those of which nothing is known are numbers without a description.
pub fn fields(table: &str, bytes: &[u8], user_columns: &[Column]) -> Vec<Value> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(bytes);
    let Ok(header) = reader.headers() else { return Vec::new() };
    let field = |name: &str| {
        let given = user_columns.iter().find(|column| column.name == name).cloned();
        let Some(Column { name, kind, unit, about }) = given.or_else(|| column(table, name)) else {
            return json!({ "name": name, "type": NUMBER });
        };
        let mut field = json!({ "name": name, "type": kind, "description": about });
        if !unit.is_empty() {
            field["unit"] = unit.into();
        }
        field
    };
    header.iter().map(field).collect()
}
