//! Adapts generated schemas to what the reader of the files accepts.

use schemars::Schema;
use schemars::transform::transform_subschemas;
use serde_json::Value;

/// Removes formats (`double`, `uint64`), which validators do not know, and defaults that cannot be
/// written in a file: null, and whole tables, whose keys have defaults of their own.
pub(super) fn tidy(schema: &mut Schema) {
    schema.remove("format");
    let table = |value: &Value| value.is_object() && value.get("kind").is_none();
    if schema.get("default").is_some_and(|value| value.is_null() || table(value)) {
        schema.remove("default");
    }
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = for_readers(text);
    }
    transform_subschemas(&mut tidy, schema);
}

/// A doc comment without its links and line breaks.
fn for_readers(text: &str) -> String {
    let plain = text.replace("[`", "`").replace("`]", "`").replace("`crate::", "`").replace("`super::", "`");
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Removes null from the values allowed.
pub(super) fn without_null(schema: &mut Schema) {
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|kind| kind != "null");
        let only = types.first().filter(|_| types.len() == 1).cloned();
        only.into_iter().for_each(|only| drop(schema.insert("type".into(), only)));
    }
    if let Some(Value::Array(forms)) = schema.get_mut("anyOf") {
        forms.retain(|form| form["type"] != "null");
        if forms.len() == 1 {
            let forms = schema.remove("anyOf").unwrap_or_default();
            schema.insert("allOf".into(), forms);
        }
    }
    transform_subschemas(&mut without_null, schema);
}
