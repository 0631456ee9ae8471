//! The study that sweeps, fits and designs are based on: a file, or a table that they complete.

use super::fault::StudyError;
use super::field::study_schema;
use super::load::read_file;
use schemars::transform::transform_subschemas;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Table;

/// The study that all variants are based on.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(description = "")]
#[serde(untagged, expecting = "a study file's path, or a table with a whole study")]
pub enum Base {
    /// A study file, relative to this file.
    Path(String),
    /// The study itself; what this file sets in it may be left out.
    Table(#[schemars(schema_with = "base")] Table),
}

impl Base {
    /// The study as a table, and the folder of the files that it names; `folder` is that of the
    /// file with the base.
    ///
    /// # Errors
    /// The study's file cannot be read, or is not TOML.
    pub fn read(&self, folder: &Path) -> Result<(Table, PathBuf), StudyError> {
        match self {
            Base::Table(table) => Ok((table.clone(), folder.to_owned())),
            Base::Path(base) => {
                let path = folder.join(base);
                Ok((read_file::<Table>(&path)?.1, path.parent().unwrap_or(Path::new("")).to_owned()))
            }
        }
    }
}

/// A study that may lack keys.
fn base(_: &mut SchemaGenerator) -> Schema {
    let mut study = study_schema();
    unfinished(&mut study);
    study
}

/// Makes every key optional, except those that distinguish the forms of a value or exclude each
/// other.
fn unfinished(schema: &mut Schema) {
    if ["anyOf", "oneOf", "not"].iter().any(|key| schema.get(*key).is_some()) {
        return;
    }
    schema.remove("required");
    transform_subschemas(&mut unfinished, schema);
}
