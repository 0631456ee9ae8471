//! A document as a tree, independent of its language.

use super::fault::{SyntaxFault, floor_char_boundary};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::HashSet;
use std::fmt;
use std::ops::Range;

/// A value of a TOML or JSON document.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// JSON's null; TOML has none.
    Null,
    /// True or false.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// Any other number.
    Float(f64),
    /// A text, or a TOML date as written.
    Text(String),
    /// Values in order.
    List(Vec<Node>),
    /// Keys with their values.
    Table(Vec<(String, Node)>),
}

impl Node {
    /// The value of a key; `None` if there is none, or if this is not a table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        let Node::Table(entries) = self else { return None };
        entries.iter().find(|(k, _)| k == key).map(|(_, node)| node)
    }
}

impl From<toml::Table> for Node {
    fn from(table: toml::Table) -> Node {
        Node::deserialize(table).unwrap_or(Node::Null)
    }
}

/// JSON in which keys must be unique: the parser's own tables silently keep the last of two.
impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
        Ok(Node::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Int(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(i64::try_from(value).map_or(Node::Float(value as f64), Node::Int))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Float(value))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node, E> {
        Ok(Node::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<Node, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(items)).map(Node::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node, A::Error> {
        let mut entries: Vec<(String, Node)> = Vec::new();
        let mut keys = HashSet::new();
        while let Some(key) = map.next_key::<String>()? {
            if !keys.insert(key.clone()) {
                return Err(A::Error::custom(format!("the key {key:?} {TWICE}")));
            }
            entries.push((key, map.next_value()?));
        }
        Ok(Node::Table(entries))
    }
}

/// Message for a repeated key.
const TWICE: &str = "occurs twice";

/// Parses TOML. The parser's own report is not used: it cannot show lines of more than 65 535
/// columns.
///
/// # Errors
/// The text is not TOML.
pub fn parse_toml(text: &str) -> Result<toml::Table, SyntaxFault> {
    text.parse().map_err(|error: toml::de::Error| toml_fault(text, &error))
}

/// The message of the TOML parser; for integers that are too large it would refer to its own code.
fn toml_fault(text: &str, error: &toml::de::Error) -> SyntaxFault {
    let message = error.message().trim();
    let span = error.span();
    let found = span.clone().and_then(|span| text.get(span)).unwrap_or_default();
    if message == "duplicate key" && !found.is_empty() {
        return twice(text, found, span);
    }
    if !is_too_large(found) {
        let remedy = "correct the TOML here; https://toml.io shows its syntax";
        return SyntaxFault { message: message.to_owned(), remedy, span };
    }
    let found = match found.len() {
        n if n > MOST_DIGITS => format!("{}… ({n} characters)", found.get(..MOST_DIGITS).unwrap_or_default()),
        _ => found.to_owned(),
    };
    let message = format!("found {found}; allowed: whole numbers of at most 9223372036854775807 (64 bits)");
    SyntaxFault { message, remedy: "take a smaller number, or write it with a point or a power of ten", span }
}

/// A key that is written twice, or a table beside a list of tables.
fn twice(text: &str, name: &str, span: Option<Range<usize>>) -> SyntaxFault {
    let begins = |header: String| text.lines().any(|line| line.trim_start().starts_with(&header));
    if begins(format!("[{name}]")) && begins(format!("[[{name}]]")) {
        let message = format!("[{name}] beside [[{name}]]; allowed: one of the two");
        let remedy =
            "keep the one in single brackets where there is one table, or write all in double brackets";
        return SyntaxFault { message, remedy, span };
    }
    let message = format!("duplicate key: {name:?} {TWICE}");
    let remedy = if ["layer", "pigment"].contains(&name) && begins(format!("[{name}]")) {
        "keep one of the two; several are a list, each in double brackets, as [[layer]] or [[pigment]]"
    } else {
        "keep one of the two"
    };
    SyntaxFault { message, remedy, span }
}

/// Digits of a number that a message quotes.
const MOST_DIGITS: usize = 24;

/// Whether this is an integer of more than 64 bits.
fn is_too_large(number: &str) -> bool {
    let digits = number.replace('_', "");
    let unsigned = digits.trim_start_matches(['+', '-']);
    !unsigned.is_empty() && unsigned.bytes().all(|b| b.is_ascii_digit()) && digits.parse::<i64>().is_err()
}

/// Parses JSON.
///
/// # Errors
/// The text is not JSON, or a key is repeated; NaN and Infinity have a remedy of their own.
pub fn parse_json(text: &str) -> Result<Node, SyntaxFault> {
    serde_json::from_str(text).map_err(|error| json_fault(text, &error))
}

/// The message of the JSON parser, with the position in bytes instead of lines.
fn json_fault(text: &str, error: &serde_json::Error) -> SyntaxFault {
    let lines = text.split_inclusive('\n').take(error.line().saturating_sub(1));
    let place = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
    let place = floor_char_boundary(text, place);
    let message = error.to_string();
    let message = message.split(" at line ").next().unwrap_or(&message).to_owned();
    SyntaxFault { remedy: json_remedy(text, &message), message, span: Some(place..place) }
}

/// Suggests a remedy for invalid JSON.
fn json_remedy(text: &str, message: &str) -> &'static str {
    if ["NaN", "Infinity"].iter().any(|word| text.contains(word)) {
        "JSON has neither NaN nor Infinity: give finite numbers"
    } else if message.ends_with(TWICE) {
        "remove one of them"
    } else {
        "correct the JSON here, or write TOML in a file that ends in .toml"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_that_are_too_large_are_told_as_such() {
        let many = "9".repeat(309);
        let quoted = format!("{}… (309 characters)", "9".repeat(24));
        for (number, quoted) in [
            ("9223372036854775808", "9223372036854775808"),
            ("-99999999999999999999999", "-99999999999999999999999"),
            (many.as_str(), quoted.as_str()),
        ] {
            let fault = parse_toml(&format!("a = 1\nb = {number}\n")).unwrap_err();
            let found = format!("found {quoted}; allowed: whole numbers of at most 9223372036854775807");
            assert!(fault.message.starts_with(&found), "{fault:?}");
        }
        assert!(parse_toml("a = \n").unwrap_err().remedy.contains("toml.io"));
    }
}
