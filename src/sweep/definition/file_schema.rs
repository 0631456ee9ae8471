//! Parts of the sweep schema that its types do not express: the axes may complete the base study,
//! and they set fields of a study.

use crate::input::file::StudyFile;
use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::Value;

/// A study that the axes may complete.
pub(super) fn base(_: &mut SchemaGenerator) -> Schema {
    let mut study = study();
    unfinished(&mut study);
    study
}

/// The schema of a study, without references.
fn study() -> Schema {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<StudyFile>();
    ["$schema", "title"].iter().for_each(|key| drop(schema.remove(*key)));
    schema
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

/// Dotted fields of a study with their values.
pub(super) fn fields(_: &mut SchemaGenerator) -> Schema {
    let study = study();
    let tables = study.get("properties").and_then(Value::as_object);
    let names: Vec<&str> = tables.into_iter().flat_map(|all| all.keys().map(String::as_str)).collect();
    let pattern = format!("^({})([.\\[].*)?$", names.join("|"));
    json_schema!({ "type": "object", "propertyNames": { "pattern": pattern } })
}
