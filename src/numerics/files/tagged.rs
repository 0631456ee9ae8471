//! Choices tagged by `kind` that a file may also give by name alone: reading and schema.

use serde::de::value::{MapAccessDeserializer, MapDeserializer, StrDeserializer};
use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// Reads a choice tagged by `kind` from its bare name (`shape = "cylinder"`) or a table.
pub fn name_or_table<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    from.deserialize_any(NameOrTable(PhantomData))
}

struct NameOrTable<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for NameOrTable<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a name, or a table with `kind`")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<T, E> {
        let pair = (StrDeserializer::<E>::new("kind"), StrDeserializer::<E>::new(name));
        T::deserialize(MapDeserializer::<_, E>::new([pair].into_iter()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct NoKeys {}

/// The default N/D of a key.
pub fn ratio<const N: u32, const D: u32>() -> f64 {
    f64::from(N) / f64::from(D)
}

/// Reads a choice that has no keys but `kind`: serde by itself passes over any others.
pub fn no_keys<'de, D: Deserializer<'de>>(from: D) -> Result<(), D::Error> {
    NoKeys::deserialize(from).map(|_| ())
}

/// Lets a choice tagged by `kind` be written as its bare name if it has no required key.
#[cfg(feature = "schema")]
pub fn also_by_name(schema: &mut schemars::Schema) {
    use serde_json::Value;
    let Some(choices) = schema.get_mut("oneOf").and_then(Value::as_array_mut) else { return };
    let names: Vec<Value> = choices.iter().filter_map(bare_name).collect();
    choices.splice(0..0, names);
}

/// The schema of a choice's bare name; `None` if the choice has further required keys.
#[cfg(feature = "schema")]
fn bare_name(choice: &serde_json::Value) -> Option<serde_json::Value> {
    let alone = choice.get("required")?.as_array()?.iter().all(|key| key == "kind");
    let name = choice.get("properties")?.get("kind")?.get("const")?;
    let description = choice.get("description").cloned().unwrap_or_default();
    alone.then(|| serde_json::json!({ "description": description, "type": "string", "const": name }))
}
