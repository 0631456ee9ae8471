//! Translates serde's errors about values of the wrong type into the messages of this program.

use super::fault::{Fault, UNKNOWN_KEY, shortened};
use crate::numerics::allowed::shown;
use serde::de::{self, Expected, Unexpected};
use std::fmt;

/// A value of the wrong type, whose path still begins at the struct that is read; `None` once it is
/// recorded with its whole path.
#[derive(Debug, thiserror::Error)]
#[error("{0:?}")]
pub struct Misfit(Option<Fault>);

/// Names of keys or of variants.
pub(super) type KeyNames = &'static [&'static str];

impl Misfit {
    pub(super) const RECORDED: Self = Self(None);

    pub(super) fn new(found: impl fmt::Display, allowed: impl Into<String>) -> Self {
        Self(Some(Fault::new("", found, allowed, FORM)))
    }

    /// The error of the node at `place`, with what was `found` there unless serde says it.
    pub(super) fn at(self, place: &str, found: String) -> Option<Fault> {
        let fault = self.0?;
        let found = shortened(if fault.found.is_empty() { found } else { fault.found });
        let field = Some(join(place, &fault.field)).filter(|field| !field.is_empty());
        Some(Fault { field: field.unwrap_or_else(|| "the whole file".to_owned()), found, ..fault })
    }
}

/// Joins paths: `layer` and `binder.index` → `layer.binder.index`; indices keep their brackets.
pub(super) fn join(outer: &str, inner: &str) -> String {
    match (outer, inner) {
        ("", name) | (name, "") => name.to_owned(),
        (outer, inner) if inner.starts_with('[') => format!("{outer}{inner}"),
        (outer, inner) => format!("{outer}.{inner}"),
    }
}

const FORM: &str =
    "write the value in that form; `inkwave schema` describes every key of a kind of file, such as study";

/// What is found where a key is missing.
const MISSING: &str = "nothing";

const QUOTES: &str = "write text in quotes, numbers too, such as \"10\"";

impl de::Error for Misfit {
    /// Types with several forms describe what is allowed; only the reader knows what was found.
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new("", message.to_string())
    }

    fn invalid_type(found: Unexpected, allowed: &dyn Expected) -> Self {
        let fault = Fault::new("", said(found), in_words(&allowed.to_string()), FORM);
        let remedy = if fault.allowed == "a string" { format!("{QUOTES}; {FORM}") } else { fault.remedy };
        Self(Some(Fault { remedy, ..fault }))
    }

    fn invalid_value(found: Unexpected, allowed: &dyn Expected) -> Self {
        Self::invalid_type(found, allowed)
    }

    fn invalid_length(found: usize, allowed: &dyn Expected) -> Self {
        Self::new(format!("{found} entries"), in_words(&allowed.to_string()))
    }

    fn unknown_variant(found: &str, allowed: KeyNames) -> Self {
        let remedy = meant(found, allowed, "write one of these");
        Self(Some(Fault::new("", format!("`{found}`"), quoted(allowed), remedy)))
    }

    fn unknown_field(found: &str, allowed: KeyNames) -> Self {
        Self(Some(unknown_key("", found, allowed)))
    }

    fn missing_field(key: &'static str) -> Self {
        let remedy = match key {
            // older files lack it
            "by" => "write by = \"number\", the meaning of older files, or by = \"volume\", as sizers print"
                .into(),
            _ => format!("add {key}; `inkwave schema` describes every key of a kind of file, such as study"),
        };
        Self(Some(Fault::new(key, MISSING, "a value: it has no default", remedy)))
    }

    fn duplicate_field(key: &'static str) -> Self {
        Self(Some(Fault::new(key, "two values", "one", "both names of the same key: remove one")))
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
        "a sequence" => "a list in brackets, such as [1, 2]".into(),
        "an array of length 2" => "a list of 2 in brackets, such as [1, 2]".into(),
        "an array of length 3" => "a list of 3 in brackets, such as [1, 2, 3]".into(),
        other => {
            if ["struct ", "internally tagged enum "].iter().any(|kind| other.starts_with(kind)) {
                "a table".into()
            } else {
                other.to_owned()
            }
        }
    }
}

pub(super) fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

pub(super) fn unknown_key(place: &str, key: &str, known: KeyNames) -> Fault {
    let allowed = if known.is_empty() { "no key here".to_owned() } else { quoted(known) };
    Fault::new(join(place, key), UNKNOWN_KEY, allowed, meant(key, known, "remove it"))
}

/// Whether a key that is missing is the one that an unknown key beside it was meant to be.
pub(super) fn is_misspelt(missing: &Fault, faults: &[Fault]) -> bool {
    let (place, key) = missing.field.rsplit_once('.').unwrap_or(("", &missing.field));
    let beside = |fault: &&Fault| fault.field.rsplit_once('.').map_or("", |(place, _)| place) == place;
    let meant = format!("did you mean {key}?");
    missing.found == MISSING
        && faults.iter().filter(beside).any(|fault| fault.is_of_key() && fault.remedy.starts_with(&meant))
}

/// Suggests the known name that is most similar, or else another remedy.
fn meant(found: &str, known: &[&str], otherwise: &str) -> String {
    let likeness = |name: &&&str| (1000.0 * strsim::jaro_winkler(found, name)) as u32;
    let nearest = known.iter().max_by_key(likeness).filter(|name| likeness(name) > 800);
    nearest.map_or_else(|| otherwise.to_owned(), |name| format!("did you mean {name}? Else {otherwise}"))
}
