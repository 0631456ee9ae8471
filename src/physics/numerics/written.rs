//! What the schema of a file must say beyond its types: other names of keys and values, and choices by name alone.

use schemars::Schema;
use schemars::transform::Transform;
use serde_json::{Map, Value, json};

/// Another name of a key, as `serde(alias)` reads it; both at a time are refused.
#[derive(Clone, Copy, Debug)]
pub struct Alias {
    /// The key.
    pub key: &'static str,
    /// Its other name.
    pub also: &'static str,
}

impl Alias {
    /// `also` means `key`.
    pub const fn new(key: &'static str, also: &'static str) -> Self {
        Self { key, also }
    }
}

impl Transform for Alias {
    fn transform(&mut self, schema: &mut Schema) {
        let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) else { return };
        let Some(mut same) = properties.get(self.key).cloned() else { return };
        same["description"] = format!("Another name of `{}`.", self.key).into();
        same["deprecated"] = true.into();
        properties.insert(self.also.into(), same);
        let both = json!({ "not": { "required": [self.key, self.also] } });
        let rules = schema.ensure_object().entry("allOf").or_insert_with(|| json!([]));
        rules.as_array_mut().into_iter().for_each(|rules| rules.push(both.clone()));
    }
}

/// Another name of a value of a plain choice.
#[derive(Clone, Copy, Debug)]
pub struct AlsoCalled {
    /// The value.
    pub name: &'static str,
    /// Its other name.
    pub also: &'static str,
}

impl Transform for AlsoCalled {
    fn transform(&mut self, schema: &mut Schema) {
        let other = json!({
            "description": format!("Another name of `{}`.", self.name),
            "type": "string",
            "const": self.also,
            "deprecated": true,
        });
        let choices = schema.get_mut("oneOf").and_then(Value::as_array_mut);
        choices.into_iter().for_each(|choices| choices.push(other.clone()));
    }
}

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

/// Takes a default away that the file could not hold, such as an empty table.
pub fn without_default(schema: &mut Schema) {
    schema.remove("default");
}

/// Marks keys that a file usually has although they may be left out.
pub const USUAL: &str = "x-usual";

/// Marks a key with [`USUAL`].
pub fn usual(schema: &mut Schema) {
    schema.insert(USUAL.into(), true.into());
}

/// An older place of a key.
pub fn older_place(schema: &mut Schema) {
    schema.insert("deprecated".into(), true.into());
}
