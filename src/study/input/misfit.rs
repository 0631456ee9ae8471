//! Translates serde's errors about values of the wrong type into the messages of this program.

use super::fault::Fault;
use crate::numerics::allowed::shown;
use serde::de::{self, Expected, Unexpected};
use std::fmt;

/// A value of the wrong type; its path is extended while the error is passed outwards.
#[derive(Debug)]
pub struct Misfit(pub(super) Box<Fault>);

/// Maximum length of a value in a message, characters.
const LONGEST_FOUND: usize = 200;

impl Misfit {
    pub(super) fn new(
        place: impl Into<String>,
        found: impl fmt::Display,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self(Box::new(Fault::new(place, shortened(found.to_string()), allowed, remedy)))
    }

    /// Extends the path by `place`, which contains `found`.
    pub(super) fn inside(mut self, place: &str, found: &str) -> Self {
        if self.0.found.is_empty() {
            self = Self(Box::new(Fault { found: shortened(found.to_owned()), ..*self.0 }));
        }
        let own = std::mem::take(&mut self.0.field);
        self.0.field = join(place, &own);
        self
    }
}

fn shortened(found: String) -> String {
    if found.chars().count() <= LONGEST_FOUND {
        return found;
    }
    found.chars().take(LONGEST_FOUND).chain(['…']).collect()
}

/// Joins paths: `layer` and `binder.index` → `layer.binder.index`; indices keep their brackets.
pub(super) fn join(outer: &str, inner: &str) -> String {
    match (outer, inner) {
        ("", name) | (name, "") => name.to_owned(),
        (outer, inner) if inner.starts_with('[') => format!("{outer}{inner}"),
        (outer, inner) => format!("{outer}.{inner}"),
    }
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl std::error::Error for Misfit {}

pub(super) const FORM: &str =
    "write the value in that form; `inkwave schema KIND` describes every key of a file";

/// Remedies for keys that older files lack.
const NEWER: [(&str, &str); 1] =
    [("by", "write by = \"number\", the meaning of older files, or by = \"volume\", as sizers print")];

impl de::Error for Misfit {
    /// Types with several forms describe what is allowed; only the reader knows what was found.
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new("", "", message.to_string(), FORM)
    }

    fn invalid_type(found: Unexpected, allowed: &dyn Expected) -> Self {
        Self::new("", said(found), in_words(&allowed.to_string()), FORM)
    }

    fn invalid_value(found: Unexpected, allowed: &dyn Expected) -> Self {
        Self::new("", said(found), in_words(&allowed.to_string()), FORM)
    }

    fn invalid_length(found: usize, allowed: &dyn Expected) -> Self {
        Self::new("", format!("{found} entries"), allowed.to_string(), FORM)
    }

    fn unknown_variant(found: &str, allowed: &'static [&'static str]) -> Self {
        Self::new("", format!("`{found}`"), quoted(allowed), meant(found, allowed, "write one of these"))
    }

    fn unknown_field(found: &str, allowed: &'static [&'static str]) -> Self {
        Self(Box::new(unknown_key("", found, allowed)))
    }

    fn missing_field(key: &'static str) -> Self {
        let remedy = NEWER.iter().find(|(name, _)| *name == key).map_or_else(
            || format!("add {key}; `inkwave schema KIND` describes every key of a file"),
            |(_, remedy)| (*remedy).to_owned(),
        );
        Self::new(key, "nothing", "a value: it has no default", remedy)
    }

    fn duplicate_field(key: &'static str) -> Self {
        Self::new(key, "two values", "one", "both names of the same key: remove one")
    }
}

/// Describes what was found, in terms of documents rather than of Rust.
pub(super) fn said(found: Unexpected) -> String {
    match found {
        Unexpected::Unit => "null".into(),
        Unexpected::Map => "a table".into(),
        Unexpected::Seq => "a list".into(),
        // the parser would write all digits of 1e-300
        Unexpected::Float(x) if x.to_string() != shown(x) => format!("the number `{}`", shown(x)),
        other => other.to_string(),
    }
}

/// Describes a Rust number type.
fn in_words(kind: &str) -> String {
    match kind {
        "f64" | "f32" => "a number".into(),
        "u64" | "usize" | "u32" | "u16" | "u8" => "a whole number from 0".into(),
        "i64" | "i32" | "isize" => "a whole number".into(),
        "a boolean" => "true or false".into(),
        other => {
            other.strip_prefix("struct ").map_or_else(|| other.to_owned(), |name| format!("a table ({name})"))
        }
    }
}

pub(super) fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

pub(super) fn unknown_key(place: &str, key: &str, known: &'static [&'static str]) -> Fault {
    Fault::new(join(place, key), "an unknown key", quoted(known), meant(key, known, "remove it"))
}

/// Suggests the known name that is most similar, or else another remedy.
fn meant(found: &str, known: &[&str], otherwise: &str) -> String {
    let likeness = |name: &&&str| (1000.0 * strsim::jaro_winkler(found, name)) as u32;
    let nearest = known.iter().max_by_key(likeness).filter(|name| likeness(name) > 800);
    nearest.map_or_else(|| otherwise.to_owned(), |name| format!("did you mean {name}? Else {otherwise}"))
}
