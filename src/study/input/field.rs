//! Fields of a study by their dotted names: `layer.thickness_um`, `pigment[0].index`,
//! `pigment.yellow.index`, `pigment[*].index`.

use super::file::StudyFile;
use schemars::generate::SchemaSettings;
use schemars::{Schema, SchemaGenerator, json_schema};
use toml::{Table, Value};

/// Sets `field`, creating missing tables.
///
/// # Errors
/// A message that says why there is no such field.
pub fn set(study: &mut Table, field: &str, value: &Value) -> Result<(), String> {
    let steps = steps(field)?;
    put(study.entry(steps[0]).or_insert_with(empty), steps[0], &steps[1..], value)
}

fn empty() -> Value {
    Value::Table(Table::new())
}

/// Splits a name into steps: keys separated by dots, each followed by any number of `[entry]`.
///
/// # Errors
/// A step without a name, or brackets that do not close.
pub fn steps(field: &str) -> Result<Vec<&str>, String> {
    let mut all = Vec::new();
    for part in field.split('.') {
        let (key, entries) = part.split_at(part.find('[').unwrap_or(part.len()));
        all.push(key);
        if !entries.is_empty() {
            let inner = entries.strip_prefix('[').and_then(|text| text.strip_suffix(']'));
            let unclosed = || format!("{part:?} has a bracket that does not close");
            all.extend(inner.ok_or_else(unclosed)?.split("]["));
        }
    }
    match all.iter().all(|step| !step.is_empty() && !step.contains(['[', ']'])) {
        true => Ok(all),
        false => Err(format!("{field:?} is no name such as layer.thickness_um or pigment[0].index.k")),
    }
}

/// Puts a value where the steps lead from a place of this name.
fn put(here: &mut Value, name: &str, steps: &[&str], value: &Value) -> Result<(), String> {
    let Some((&step, rest)) = steps.split_first() else {
        *here = value.clone();
        return Ok(());
    };
    match here {
        Value::Table(table) => put(table.entry(step).or_insert_with(empty), step, rest, value),
        Value::Array(items) => {
            chosen(items, name, step)?.into_iter().try_for_each(|i| put(&mut items[i], name, rest, value))
        }
        other => Err(format!("{name} is a {}, not a table", other.type_str())),
    }
}

/// Entries of a list that a step means: all, the one of a number or that of a name.
fn chosen(items: &[Value], name: &str, step: &str) -> Result<Vec<usize>, String> {
    let chosen: Vec<usize> = match (step, step.parse::<usize>()) {
        ("*", _) => (0..items.len()).collect(),
        (_, Ok(i)) => (i..items.len()).take(1).collect(),
        (wanted, _) => items.iter().position(|item| item_name(item) == Some(wanted)).into_iter().collect(),
    };
    if chosen.is_empty() {
        let names: Vec<&str> = items.iter().filter_map(item_name).collect();
        let (count, names) = (items.len(), names.join(", "));
        return Err(format!("{name} has {count} entries ({names}), none of them is {step}"));
    }
    Ok(chosen)
}

fn item_name(item: &Value) -> Option<&str> {
    item.get("name")?.as_str()
}

/// The schema of a study, without references.
pub(super) fn study_schema() -> Schema {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<StudyFile>();
    ["$schema", "title"].iter().for_each(|key| drop(schema.remove(*key)));
    schema
}

/// The schema of a table of dotted fields of a study with their values.
pub fn fields_schema(_: &mut SchemaGenerator) -> Schema {
    let study = study_schema();
    let tables = study.get("properties").and_then(serde_json::Value::as_object);
    let names: Vec<&str> = tables.into_iter().flat_map(|all| all.keys().map(String::as_str)).collect();
    let pattern = format!("^({})([.\\[].*)?$", names.join("|"));
    json_schema!({ "type": "object", "propertyNames": { "pattern": pattern } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_by_place_by_name_and_all_at_once() {
        let mut study: Table =
            toml::from_str("[[pigment]]\nname = 'a'\nd = 1\n[[pigment]]\nname = 'b'\nd = 2").unwrap();
        set(&mut study, "pigment[1].d", &Value::Integer(5)).unwrap();
        set(&mut study, "pigment.a.index.k", &Value::Float(0.5)).unwrap();
        set(&mut study, "pigment[*].share", &Value::Float(0.25)).unwrap();
        assert_eq!(study["pigment"][1]["d"].as_integer(), Some(5));
        assert_eq!(study["pigment"][0]["index"]["k"].as_float(), Some(0.5));
        assert!((0..2).all(|i| study["pigment"][i]["share"].as_float() == Some(0.25)));
        let error = set(&mut study, "pigment.c.d", &Value::Integer(5)).unwrap_err();
        assert_eq!(error, "pigment has 2 entries (a, b), none of them is c");
        for slip in
            ["", "pigment[[0].d", "pigment[0.d", "pigment]0[.d", "pigment[0]d", "pigment..d", "pigment[]"]
        {
            let before = study.clone();
            assert!(set(&mut study, slip, &Value::Integer(5)).is_err() && study == before, "{slip:?}");
        }
        assert!(set(&mut study, "pigment.a.d.x", &Value::Integer(5)).unwrap_err().contains("not a table"));
    }
}
