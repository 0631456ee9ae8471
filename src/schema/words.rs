//! Schemas in words, and JSON values as TOML.

use serde_json::Value;

/// Longest line of a comment, characters.
const WIDTH: usize = 110;

/// Tables of more keys are whole files, which are not spelt out inside of another.
const MOST_KEYS: usize = 10;

/// What a schema refers to; itself where it stands alone.
pub(super) fn resolve<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let alone = schema.get("allOf").and_then(Value::as_array).filter(|all| all.len() == 1).map(|all| &all[0]);
    let reference = |schema: &'a Value| schema.get("$ref").and_then(Value::as_str);
    let Some(name) = reference(schema).or_else(|| alone.and_then(reference)) else { return schema };
    root.pointer(name.trim_start_matches('#')).map_or(schema, |found| resolve(root, found))
}

/// Whether a keyword is true.
pub(super) fn is_marked(schema: &Value, keyword: &str) -> bool {
    schema.get(keyword).and_then(Value::as_bool).unwrap_or(false)
}

/// The range of a number, or of a list's entries.
pub(super) fn allowed(schema: &Value) -> Option<String> {
    if let Some(range) = schema.get("items").and_then(allowed) {
        return Some(format!("each {range}"));
    }
    let natural = schema.get("type").is_some_and(|kind| kind == "integer") && schema.get("maximum").is_none();
    if natural && schema.get("minimum").is_some_and(|low| low == 0) {
        return None;
    }
    let bound = |key: &str, word: &str| schema.get(key).map(|limit| format!("{word} {}", number(limit)));
    let low = bound("minimum", "from").or_else(|| bound("exclusiveMinimum", "above"));
    let high = bound("maximum", "to").or_else(|| bound("exclusiveMaximum", "to below"));
    let parts: Vec<String> = [low, high].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(" "))
}

/// Whole numbers without their point.
fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(x) if x.fract() == 0.0 && x.abs() < 1e15 => format!("{x:.0}"),
        _ => value.to_string(),
    }
}

/// The forms that a value may have, one line or more each; none where there is only one.
pub(super) fn forms(root: &Value, schema: &Value) -> Vec<String> {
    let all = ["oneOf", "anyOf"].iter().filter_map(|key| schema.get(*key)?.as_array()).flatten();
    // A table of its kind alone is written as its name.
    let only_kind = |form: &Value| {
        let keys = form.get("properties").and_then(Value::as_object);
        keys.is_some_and(|keys| keys.len() == 1 && keys.contains_key("kind"))
    };
    let all = all.map(|form| resolve(root, form)).filter(|form| !only_kind(form));
    all.flat_map(|form| one_form(root, form)).collect()
}

fn one_form(root: &Value, form: &Value) -> Vec<String> {
    if ["oneOf", "anyOf"].iter().any(|key| form.get(*key).is_some()) {
        return forms(root, form);
    }
    if let Some(names) = form.get("enum").and_then(Value::as_array) {
        let names: Vec<String> = names.iter().map(toml).collect();
        return vec![format!("one of {}", names.join(", "))];
    }
    let shape = shape(root, form);
    if shape.is_empty() {
        return Vec::new();
    }
    let meaning = form["description"].as_str().map_or_else(String::new, |text| format!(": {text}"));
    let range = allowed(form).map_or_else(String::new, |range| format!(" ({range})"));
    let mut lines = vec![format!("{shape}{meaning}{range}")];
    let keys = form.get("properties").and_then(Value::as_object);
    let keys = keys.filter(|keys| keys.len() <= MOST_KEYS).into_iter().flatten();
    let keys = keys.filter(|(_, value)| value.get("const").is_none());
    lines.extend(keys.flat_map(|(key, value)| key_of_form(root, key, value)));
    lines
}

/// A key of a form: its meaning, range and default, and its own forms further in.
fn key_of_form(root: &Value, key: &str, value: &Value) -> Vec<String> {
    let whole = resolve(root, value);
    let meaning = value["description"].as_str().or(whole["description"].as_str()).unwrap_or_default();
    let range = allowed(value).map_or_else(String::new, |range| format!(" Allowed: {range}."));
    let default = value.get("default").filter(|default| !default.is_object());
    let default = default.map_or_else(String::new, |value| format!(" Default: {}.", toml(value)));
    let mut lines = vec![format!("  {key}: {meaning}{range}{default}")];
    let inner = whole.get("properties").and_then(Value::as_object).into_iter().flatten();
    let further = inner.flat_map(|(key, value)| key_of_form(root, key, value)).chain(forms(root, whole));
    lines.extend(further.map(|line| format!("  {line}")));
    lines
}

/// How a form looks.
fn shape(root: &Value, form: &Value) -> String {
    if let Some(name) = form.get("const") {
        return toml(name);
    }
    match form.get("type").and_then(Value::as_str) {
        Some("object") => table_shape(root, form),
        Some("array") => "a list".into(),
        Some("integer") => "a whole number".into(),
        Some(kind) => format!("a {kind}"),
        None => String::new(),
    }
}

fn table_shape(root: &Value, form: &Value) -> String {
    let keys = form["properties"].as_object().into_iter().flatten();
    if form["properties"].as_object().is_some_and(|keys| keys.len() > MOST_KEYS) {
        return "a table".into();
    }
    let entries = keys.map(|(key, value)| format!("{key} = {}", value_shape(root, value)));
    format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
}

/// How a key's value looks: by its constant, default or example where it has one.
fn value_shape(root: &Value, value: &Value) -> String {
    let whole = resolve(root, value);
    let given = value.get("const").or(value.get("default")).or(value.get("examples").and_then(|e| e.get(0)));
    match given.or(whole.get("examples").and_then(|e| e.get(0))) {
        Some(value) => toml(value),
        None if whole.get("properties").is_some() => table_shape(root, whole),
        None => "…".into(),
    }
}

/// A value as TOML; a choice that can be written by its name alone is.
pub(super) fn text_of(schema: &Value, value: &Value) -> String {
    let names = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
    let kind = value.get("kind").filter(|_| value.as_object().is_some_and(|table| table.len() == 1));
    let bare = names.filter_map(|form| form.get("const")).find(|name| Some(*name) == kind);
    toml(bare.unwrap_or(value))
}

/// A JSON value on one line of TOML.
fn toml(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(toml).collect::<Vec<_>>().join(", ")),
        Value::Object(table) => {
            let entries = table.iter().filter(|(_, value)| !value.is_null());
            let entries = entries.map(|(key, value)| format!("{} = {}", key_text(key), toml(value)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

/// A key, in quotes where it must be.
fn key_text(key: &str) -> String {
    let bare = key.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if bare { key.to_owned() } else { Value::from(key).to_string() }
}

/// Lines of at most [`WIDTH`] characters.
pub(super) fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut().filter(|line| line.chars().count() + word.chars().count() < WIDTH) {
            Some(line) => *line += &format!(" {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}
