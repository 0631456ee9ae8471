//! From a tree to a type, with every unknown key told at once.
//!
//! Serde stops at the first thing that it does not like and says it in English. This deserializer knows each struct's keys
//! before their values are read, so it can take the unknown ones out, note them all and go on; and its error has
//! places for what was found and what is allowed, so that nobody needs to understand the English.

use super::fault::Fault;
use super::tree::Node;
use serde::de::value::StringDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Expected, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, VariantAccess, Visitor,
};
use std::cell::RefCell;
use std::fmt;

/// Reads a `T`.
///
/// # Errors
/// All unknown keys, and the first value that is missing or of the wrong kind, each at its place.
pub fn read<T: DeserializeOwned>(node: Node) -> Result<T, Vec<Fault>> {
    let unknown = RefCell::new(Vec::new());
    let result = T::deserialize(Reader { node, place: String::new(), unknown: &unknown });
    let mut faults = unknown.into_inner();
    match result {
        Ok(value) if faults.is_empty() => return Ok(value),
        Ok(_) => {}
        Err(misfit) => faults.push(*misfit.0),
    }
    Err(faults)
}

/// A value that does not fit, in the making: its place grows while the error travels outwards.
#[derive(Debug)]
pub struct Misfit(Box<Fault>);

/// Longest value that is shown as found, characters.
const LONGEST_FOUND: usize = 200;

impl Misfit {
    fn new(
        place: impl Into<String>,
        found: impl fmt::Display,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let mut found = found.to_string();
        if found.chars().count() > LONGEST_FOUND {
            found = found.chars().take(LONGEST_FOUND).chain(['…']).collect();
        }
        Self(Box::new(Fault::new(place, found, allowed, remedy)))
    }

    /// The same, seen from outside of `place`.
    fn inside(mut self, place: &str) -> Self {
        let own = std::mem::take(&mut self.0.field);
        self.0.field = join(place, &own);
        self
    }
}

/// `layer` and `binder.index` → `layer.binder.index`; indices keep their brackets.
fn join(outer: &str, inner: &str) -> String {
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

const FORM: &str = "write the value in that form; examples/yellow.toml shows a whole study";

impl de::Error for Misfit {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new("", message, "another value", FORM)
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
        let remedy = format!("add {key}; examples/yellow.toml shows a whole study");
        Self::new(key, "nothing", "a value: it has no default", remedy)
    }

    fn duplicate_field(key: &'static str) -> Self {
        Self::new(key, "two values", "one", "an old and a new name of the same key, or a slip: remove one")
    }
}

/// What was found, in the words of documents rather than of Rust.
fn said(found: Unexpected) -> String {
    match found {
        Unexpected::Unit => "null".into(),
        Unexpected::Map => "a table".into(),
        Unexpected::Seq => "a list".into(),
        other => other.to_string(),
    }
}

/// What Rust calls a number, in words.
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

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn unknown_key(place: &str, key: &str, known: &'static [&'static str]) -> Fault {
    Fault::new(join(place, key), "an unknown key", quoted(known), meant(key, known, "remove it"))
}

/// The name that was probably meant, or else another remedy.
fn meant(found: &str, known: &[&str], otherwise: &str) -> String {
    let likeness = |name: &&&str| (1000.0 * strsim::jaro_winkler(found, name)) as u32;
    let nearest = known.iter().max_by_key(likeness).filter(|name| likeness(name) > 800);
    nearest.map_or_else(|| otherwise.to_owned(), |name| format!("did you mean {name}? Else {otherwise}"))
}

/// Reads one node.
struct Reader<'a> {
    node: Node,
    /// Path of the node.
    place: String,
    /// Unknown keys so far.
    unknown: &'a RefCell<Vec<Fault>>,
}

impl<'a> Reader<'a> {
    fn child(&self, node: Node, step: &str) -> Reader<'a> {
        Reader { node, place: join(&self.place, step), unknown: self.unknown }
    }

    /// Takes the keys that are not `known` out of a table, and notes them.
    fn keep_known(&mut self, known: &'static [&'static str]) {
        if let Node::Table(entries) = &mut self.node {
            let strangers = entries.extract_if(.., |(key, _)| !known.contains(&key.as_str()));
            let faults = strangers.map(|(key, _)| unknown_key(&self.place, &key, known));
            self.unknown.borrow_mut().extend(faults);
        }
    }

    fn unexpected(&self) -> Unexpected<'_> {
        match &self.node {
            Node::Null => Unexpected::Unit,
            Node::Bool(b) => Unexpected::Bool(*b),
            Node::Int(i) => Unexpected::Signed(*i),
            Node::Float(x) => Unexpected::Float(*x),
            Node::Text(text) => Unexpected::Str(text),
            Node::List(_) => Unexpected::Seq,
            Node::Table(_) => Unexpected::Map,
        }
    }
}

impl<'de> Deserializer<'de> for Reader<'_> {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.node {
            Node::Null => visitor.visit_unit(),
            Node::Bool(b) => visitor.visit_bool(b),
            Node::Int(i) => visitor.visit_i64(i),
            Node::Float(x) => visitor.visit_f64(x),
            Node::Text(text) => visitor.visit_string(text),
            Node::List(ref items) => {
                let count = items.len();
                let mut items = Items { reader: self, next: 0 };
                let value = visitor.visit_seq(&mut items)?;
                let read = items.next;
                if read < count {
                    return Err(Misfit::new("", format!("{count} entries"), format!("{read} entries"), FORM));
                }
                Ok(value)
            }
            Node::Table(_) => visitor.visit_map(Entries { reader: self, next: 0 }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.node {
            Node::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        mut self,
        _: &'static str,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        // Derived code would take the values of a list for the keys in their order.
        if let Node::List(_) = self.node {
            return Err(de::Error::invalid_type(self.unexpected(), &visitor));
        }
        self.keep_known(known);
        self.deserialize_any(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match &self.node {
            Node::Text(name) => visitor.visit_enum(name.clone().into_deserializer()),
            Node::Table(entries) if entries.len() == 1 => visitor.visit_enum(Chosen { reader: self }),
            _ => Err(Misfit::new("", said(self.unexpected()), quoted(variants), FORM)),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

/// The entries of a list, one after the other.
struct Items<'a> {
    reader: Reader<'a>,
    next: usize,
}

impl<'de> SeqAccess<'de> for &mut Items<'_> {
    type Error = Misfit;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misfit> {
        let step = format!("[{}]", self.next);
        let Node::List(items) = &mut self.reader.node else { return Ok(None) };
        let Some(item) = items.get_mut(self.next) else { return Ok(None) };
        let item = std::mem::replace(item, Node::Null);
        self.next += 1;
        seed.deserialize(self.reader.child(item, &step)).map(Some).map_err(|e| e.inside(&step))
    }
}

/// The keys and values of a table, one after the other.
struct Entries<'a> {
    reader: Reader<'a>,
    next: usize,
}

impl Entries<'_> {
    fn entry(&mut self) -> Option<&mut (String, Node)> {
        match &mut self.reader.node {
            Node::Table(entries) => entries.get_mut(self.next),
            _ => None,
        }
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Misfit> {
        let Some((key, _)) = self.entry() else { return Ok(None) };
        let key: StringDeserializer<Misfit> = key.clone().into_deserializer();
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misfit> {
        let Some((key, node)) = self.entry() else {
            return Err(de::Error::custom("a value without its key"));
        };
        let (key, node) = (key.clone(), std::mem::replace(node, Node::Null));
        self.next += 1;
        seed.deserialize(self.reader.child(node, &key)).map_err(|e| e.inside(&key))
    }
}

/// A table with one key that names a variant.
struct Chosen<'a> {
    reader: Reader<'a>,
}

impl<'de, 'a> EnumAccess<'de> for Chosen<'a> {
    type Error = Misfit;
    type Variant = Content<'a>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Content<'a>), Misfit> {
        let mut entries = Entries { reader: self.reader, next: 0 };
        let Some((key, node)) = entries.entry() else {
            return Err(de::Error::custom("no variant"));
        };
        let (key, node) = (key.clone(), std::mem::replace(node, Node::Null));
        let name: StringDeserializer<Misfit> = key.clone().into_deserializer();
        let variant = seed.deserialize(name)?;
        Ok((variant, Content { reader: entries.reader.child(node, &key), key }))
    }
}

/// What a variant holds.
struct Content<'a> {
    reader: Reader<'a>,
    key: String,
}

impl<'de> VariantAccess<'de> for Content<'_> {
    type Error = Misfit;

    /// A choice without settings is written by its name.
    fn unit_variant(self) -> Result<(), Misfit> {
        let found = said(self.reader.unexpected()).to_owned();
        Err(Misfit::new(self.key, found, "no settings: the name alone", FORM))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Misfit> {
        let Content { reader, key } = self;
        seed.deserialize(reader).map_err(|e| e.inside(&key))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misfit> {
        let Content { reader, key } = self;
        reader.deserialize_any(visitor).map_err(|e| e.inside(&key))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        let Content { reader, key } = self;
        reader.deserialize_struct("", known, visitor).map_err(|e| e.inside(&key))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::tree::parse_toml;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "read only")]
    struct Outer {
        #[serde(rename = "new", alias = "old")]
        renamed: Option<f64>,
        count: Option<u64>,
        inner: Vec<Inner>,
        kind: Option<Kind>,
        pair: Option<[f64; 2]>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "read only")]
    struct Inner {
        size: f64,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[allow(dead_code, reason = "read only")]
    enum Kind {
        Plain,
        Round { radius: f64 },
    }

    fn faults(text: &str) -> Vec<Fault> {
        read::<Outer>(parse_toml(text).unwrap().into()).map(|outer| panic!("{outer:?}")).unwrap_err()
    }

    #[test]
    fn every_unknown_key_is_told_with_its_place_and_what_was_meant() {
        let found =
            faults("cuont = 1\n[[inner]]\nsize = 1\n[[inner]]\nsize = 2\nsise = 3\nx = 1\nkind.round.r = 1");
        let fields: Vec<&str> = found.iter().map(|f| f.field.as_str()).collect();
        assert_eq!(fields, ["cuont", "inner[1].kind", "inner[1].sise", "inner[1].x"]);
        assert!(found[0].remedy.contains("did you mean count?"), "{:?}", found[0]);
        assert!(found[0].allowed.contains("`new`, `old`"), "aliases are known keys: {:?}", found[0]);
        assert_eq!(found[3].remedy, "remove it");
    }

    #[test]
    fn values_that_do_not_fit_are_told_where_they_are() {
        for (text, field, found, allowed) in [
            ("count = -1\ninner = []", "count", "integer `-1`", "a whole number from 0"),
            ("inner = [{ size = 'a' }]", "inner[0].size", "string \"a\"", "a number"),
            ("inner = [{}]", "inner[0].size", "nothing", "a value"),
            ("count = 1", "inner", "nothing", "a value"),
            ("inner = []\nkind = 'plane'", "kind", "`plane`", "`plain`, `round`"),
            ("inner = []\nkind.round = {}", "kind.round.radius", "nothing", "a value"),
            ("inner = []\npair = [1]", "pair", "1 entries", "array of length 2"),
            ("inner = []\npair = [1, 2, 3]", "pair", "3 entries", "2 entries"),
            ("inner = []\nold = 1\nnew = 2", "new", "two values", "one"),
        ] {
            let fault = faults(text).pop().unwrap();
            assert_eq!(fault.field, field, "{text}: {fault:?}");
            assert!(fault.found.contains(found) && fault.allowed.contains(allowed), "{text}: {fault:?}");
        }
    }

    #[test]
    fn numbers_fit_where_they_can() {
        let text = "old = 1\ncount = 3\ninner = [{ size = 2 }]\nkind = { round = { radius = 1.5 } }\npair = [1, 2.5]";
        let outer: Outer = read(parse_toml(text).unwrap().into()).unwrap();
        assert_eq!((outer.renamed, outer.count, outer.pair), (Some(1.0), Some(3), Some([1.0, 2.5])));
    }
}
