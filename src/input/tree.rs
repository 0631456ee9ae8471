//! A document as a tree, whatever language it was written in.

use crate::input::fault::StudyError;
use std::ops::Range;
use std::path::Path;

/// A value of a TOML or JSON document.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// JSON's null; TOML has none.
    Null,
    /// True or false.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// Any other number.
    Float(f64),
    /// A text, or TOML's dates as they are written.
    Text(String),
    /// Values in their order.
    List(Vec<Node>),
    /// Keys with their values.
    Table(Vec<(String, Node)>),
}

impl Node {
    /// The value of a key; `None` without that key, and for what is no table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        match self {
            Node::Table(entries) => entries.iter().find(|(k, _)| k == key).map(|(_, node)| node),
            _ => None,
        }
    }
}

impl From<toml::Value> for Node {
    fn from(value: toml::Value) -> Node {
        match value {
            toml::Value::Boolean(b) => Node::Bool(b),
            toml::Value::Integer(i) => Node::Int(i),
            toml::Value::Float(x) => Node::Float(x),
            toml::Value::String(text) => Node::Text(text),
            toml::Value::Datetime(date) => Node::Text(date.to_string()),
            toml::Value::Array(items) => Node::List(items.into_iter().map(Node::from).collect()),
            toml::Value::Table(table) => Node::from(table),
        }
    }
}

impl From<toml::Table> for Node {
    fn from(table: toml::Table) -> Node {
        Node::Table(table.into_iter().map(|(key, value)| (key, value.into())).collect())
    }
}

impl From<serde_json::Value> for Node {
    fn from(value: serde_json::Value) -> Node {
        use serde_json::Value;
        match value {
            Value::Null => Node::Null,
            Value::Bool(b) => Node::Bool(b),
            Value::Number(n) => n.as_i64().map_or(Node::Float(n.as_f64().unwrap_or(f64::NAN)), Node::Int),
            Value::String(text) => Node::Text(text),
            Value::Array(items) => Node::List(items.into_iter().map(Node::from).collect()),
            Value::Object(map) => Node::Table(map.into_iter().map(|(k, v)| (k, v.into())).collect()),
        }
    }
}

/// Why a text is no document: what the parser says, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SyntaxFault {
    /// What is wrong, without its place.
    pub message: String,
    /// What to try.
    pub remedy: &'static str,
    /// Bytes of the text; unknown for some.
    pub span: Option<Range<usize>>,
}

impl SyntaxFault {
    /// With its line and column, where they are known.
    pub fn in_words(&self, text: &str) -> String {
        let Some(span) = &self.span else { return self.message.clone() };
        let before = &text[..floor_char_boundary(text, span.start)];
        let (line, start) = (before.matches('\n').count() + 1, before.rfind('\n').map_or(0, |i| i + 1));
        format!("line {line}, column {}: {}", before[start..].chars().count() + 1, self.message)
    }

    /// With the file that it is in.
    pub fn in_file(self, path: &Path, text: &str) -> StudyError {
        let SyntaxFault { message, remedy, span } = self;
        let (path, text, remedy) = (path.to_owned(), text.to_owned(), remedy.to_owned());
        StudyError::Syntax { path, text, span, message, remedy }
    }
}

/// The last boundary between characters up to a byte.
fn floor_char_boundary(text: &str, byte: usize) -> usize {
    (0..=byte.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

/// Parses TOML. The parser's own report is not used: it cannot show lines of more than 65 535 columns.
///
/// # Errors
/// The text is no TOML.
pub fn parse_toml(text: &str) -> Result<toml::Table, SyntaxFault> {
    text.parse().map_err(|error: toml::de::Error| SyntaxFault {
        message: error.message().trim().to_owned(),
        remedy: "correct the TOML here; https://toml.io shows its syntax",
        span: error.span(),
    })
}

/// Parses JSON.
///
/// # Errors
/// The text is no JSON; NaN and Infinity have a remedy of their own.
pub fn parse_json(text: &str) -> Result<serde_json::Value, SyntaxFault> {
    serde_json::from_str(text).map_err(|error| {
        let lines = text.split_inclusive('\n').take(error.line().saturating_sub(1));
        let place = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
        let place = floor_char_boundary(text, place);
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or(&message).to_owned();
        let none = ["NaN", "Infinity"].iter().any(|word| text.contains(word));
        let remedy = if none {
            "JSON knows neither NaN nor Infinity: give finite numbers"
        } else {
            "correct the JSON here, or write TOML in a file that ends in .toml"
        };
        SyntaxFault { message, remedy, span: Some(place..place) }
    })
}
