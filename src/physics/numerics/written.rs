//! What the schema of a file must say beyond its types: choices by name alone.

use schemars::Schema;
use serde_json::{Map, Value, json};

/// A choice tagged by `kind` may be written by its bare name where it has no key that must be there.
pub fn also_by_name(schema: &mut Schema) {
    let Some(choices) = schema.get_mut("oneOf").and_then(Value::as_array_mut) else { return };
    let names: Vec<Value> = choices.iter().filter_map(Value::as_object).filter_map(bare_name).collect();
    choices.splice(0..0, names);
}

fn bare_name(choice: &Map<String, Value>) -> Option<Value> {
    let alone = choice.get("required")?.as_array()?.iter().all(|key| key == "kind");
    let name = choice.get("properties")?.get("kind")?.get("const")?;
    let description = choice.get("description").cloned().unwrap_or_default();
    alone.then(|| json!({ "description": description, "type": "string", "const": name }))
}
