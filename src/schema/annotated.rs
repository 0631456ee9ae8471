//! A file with every key of its kind: what it means, what is allowed, its default. Keys with a default are written with
//! it; the others follow a `#`, with an example.

use super::document::Document;
use super::words::{allowed, forms, is_marked, resolve, text_of, wrapped};
use crate::numerics::written::USUAL;
use serde_json::Value;

/// The annotated file of a kind.
pub fn annotated(document: Document) -> String {
    let root = document.schema();
    let name = document.name();
    let kind = if name == "compare" { "comparison" } else { name };
    let mut page = Page { root: &root, text: String::new() };
    page.comment(&format!(
        "Every key of a {kind}, with its meaning, what is allowed and its default. Keys with a default are written with \
         it; keys behind a # may be added, some of them instead of others. Made by `inkwave schema {name} --annotated`."
    ));
    page.comment(&format!(":schema ../schema/{name}.json"));
    page.text.push('\n');
    // A case may also stand inside of an object.
    page.table(root.pointer("/definitions/Case").unwrap_or(&root), "", false);
    page.text
}

struct Page<'a> {
    root: &'a Value,
    text: String,
}

/// How a key is written.
enum Place {
    /// On a line: `key = value`.
    Line,
    /// `[key]`
    Table,
    /// `[[key]]`
    Tables,
}

impl<'a> Page<'a> {
    /// All keys of a table, those on lines first, as TOML wants it.
    fn table(&mut self, schema: &'a Value, path: &str, silent: bool) {
        let whole = resolve(self.root, schema);
        let properties = whole["properties"].as_object().into_iter().flatten();
        let (lines, tables): (Vec<_>, Vec<_>) =
            properties.partition(|(_, value)| matches!(self.place(value), Place::Line));
        let required =
            |key: &str| whole["required"].as_array().is_some_and(|all| all.iter().any(|k| k == key));
        lines.into_iter().for_each(|(key, value)| self.line(key, value, silent, required(key)));
        tables.into_iter().for_each(|(key, value)| self.below(key, value, path, silent, required(key)));
    }

    fn place(&self, value: &Value) -> Place {
        let whole = resolve(self.root, value);
        let has_keys = |schema: &Value| schema.get("properties").is_some() && schema.get("anyOf").is_none();
        match () {
            () if is_marked(value, "deprecated") => Place::Line,
            () if has_keys(whole) => Place::Table,
            () if whole.get("items").is_some_and(|items| has_keys(resolve(self.root, items))) => {
                Place::Tables
            }
            () => Place::Line,
        }
    }

    /// `key = value` under its meaning.
    fn line(&mut self, key: &str, value: &Value, silent: bool, required: bool) {
        let whole = resolve(self.root, value);
        self.comment(description(value, whole));
        for form in forms(self.root, whole) {
            self.form(&form);
        }
        let default = value.get("default").map(|default| format!("Default: {}.", text_of(whole, default)));
        let must = required.then(|| "Must be given.".to_owned());
        let range = allowed(value).or_else(|| allowed(whole)).map(|range| format!("Allowed: {range}."));
        let facts: Vec<String> = [must, default, range].into_iter().flatten().collect();
        self.comment(&facts.join(" "));
        let example = example(value, whole);
        let (known, usual) = (!example.is_null(), required || has_value(value));
        let written = known && usual && !silent && !is_marked(value, "deprecated");
        let sign = if written { "" } else { "# " };
        let text = if known { text_of(whole, &example) } else { "…".to_owned() };
        self.text += &format!("{sign}{key} = {text}\n\n");
    }

    /// A form of a value, further lines further in.
    fn form(&mut self, form: &str) {
        let indent = " ".repeat(form.len() - form.trim_start().len());
        for (i, line) in wrapped(form).into_iter().enumerate() {
            let further = if i > 0 { "    " } else { "" };
            self.text += &format!("#   {indent}{further}{line}\n");
        }
    }

    /// A table, or the first of several.
    fn below(&mut self, key: &str, value: &'a Value, path: &str, silent: bool, required: bool) {
        let whole = resolve(self.root, value);
        let several = matches!(self.place(value), Place::Tables);
        let inner = if several { resolve(self.root, &whole["items"]) } else { whole };
        let path = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        let may_be_empty = inner["required"].as_array().is_none_or(Vec::is_empty);
        let written = !silent && (required || may_be_empty || several || is_marked(value, USUAL));
        self.comment(description(value, whole));
        let header = if several { format!("[[{path}]]") } else { format!("[{path}]") };
        self.text += &format!("{}{header}\n\n", if written { "" } else { "# " });
        self.table(inner, &path, !written);
    }

    fn comment(&mut self, text: &str) {
        for line in wrapped(text) {
            let space = if line.starts_with(':') { "" } else { " " };
            self.text += &format!("#{space}{line}\n");
        }
    }
}

fn has_value(value: &Value) -> bool {
    value.get("default").is_some() || is_marked(value, USUAL)
}

/// What the key means, or else what its type does.
fn description<'a>(value: &'a Value, whole: &'a Value) -> &'a str {
    value["description"].as_str().or(whole["description"].as_str()).unwrap_or_default()
}

/// The default, or an example.
fn example(value: &Value, whole: &Value) -> Value {
    let first = |schema: &Value| schema.get("examples").and_then(|all| all.get(0)).cloned();
    value.get("default").cloned().or_else(|| first(value)).or_else(|| first(whole)).unwrap_or_default()
}
