//! Deserialises a tree into a type and reports all unknown keys at once.
//!
//! Serde stops at the first error and describes it in English. This deserialiser knows the keys of
//! each struct before their values are read: it removes the unknown ones, records them all and
//! continues. Its error type separates what was found from what is allowed.

use super::fault::Fault;
use super::misfit::{KeyNames, Misfit, is_misspelt, join, quoted, said, unknown_key};
use super::tree::Node;
use serde::de::value::StringDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, Unexpected,
    VariantAccess, Visitor,
};
use std::cell::RefCell;

/// Most errors of one file that are told.
const MOST_TOLD: usize = 20;

/// Reads a `T`.
///
/// # Errors
/// Texts with control characters; all unknown keys, and the first value that is missing or of the
/// wrong type, each with its path. A misspelt key is one error, not an unknown and a missing one.
pub fn read<T: DeserializeOwned>(node: Node) -> Result<T, Vec<Fault>> {
    let mut unprintable = Vec::new();
    find_control_characters(&node, "", &mut unprintable);
    let faults = RefCell::new(unprintable);
    let result = Reader { node, place: String::new(), faults: &faults }.recorded(T::deserialize);
    let mut faults = faults.into_inner();
    let all = faults.clone();
    faults.retain(|fault| !is_misspelt(fault, &all));
    if faults.len() > MOST_TOLD {
        faults.truncate(MOST_TOLD);
        let remedy = "correct those above first";
        faults.push(Fault::new(
            "other fields",
            "more errors",
            "the keys and values of this kind of file",
            remedy,
        ));
    }
    match result {
        Ok(value) if faults.is_empty() => Ok(value),
        _ => Err(faults),
    }
}

/// Records texts and keys with characters that pages and exported files cannot hold: XML 1.0 has
/// neither control characters (but for tabs and line breaks) nor U+FFFE and U+FFFF, and terminals
/// execute some.
fn find_control_characters(node: &Node, place: &str, faults: &mut Vec<Fault>) {
    match node {
        Node::Text(text) => {
            let Some(wrong) = text.chars().find(|&c| is_unprintable(c)) else { return };
            if faults.len() <= MOST_TOLD {
                let found = format!("a text with the control character U+{:04X}", u32::from(wrong));
                let allowed = "text of printable characters, spaces and line breaks";
                faults.push(Fault::new(place, found, allowed, "remove that character"));
            }
        }
        Node::List(items) => {
            for (i, item) in items.iter().enumerate() {
                find_control_characters(item, &join(place, &format!("[{i}]")), faults);
            }
        }
        Node::Table(entries) => {
            for (key, value) in entries {
                find_control_characters(&Node::Text(key.clone()), place, faults);
                find_control_characters(value, &join(place, key), faults);
            }
        }
        Node::Null | Node::Bool(_) | Node::Int(_) | Node::Float(_) => {}
    }
}

/// Whether pages and exported files cannot hold a character.
fn is_unprintable(c: char) -> bool {
    c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}')
}

/// A text without characters that pages and exported files cannot hold.
pub(super) fn without_control_characters(text: &str) -> String {
    text.chars().map(|c| if is_unprintable(c) { '?' } else { c }).collect()
}

/// Reads one node.
struct Reader<'a> {
    node: Node,
    /// Path of the node.
    place: String,
    /// Errors found so far.
    faults: &'a RefCell<Vec<Fault>>,
}

impl Reader<'_> {
    /// Reads the node and records an error with its path, of which serde knows the end alone.
    fn recorded<T>(self, read: impl FnOnce(Self) -> Result<T, Misfit>) -> Result<T, Misfit> {
        let place = self.place.clone();
        let found = described(&self.node);
        let faults = self.faults;
        read(self).map_err(|misfit| {
            faults.borrow_mut().extend(misfit.at(&place, found));
            Misfit::RECORDED
        })
    }

    /// Removes and records the keys of a table that are not `known`.
    fn keep_known(&mut self, known: KeyNames) {
        if let Node::Table(entries) = &mut self.node {
            let strangers = entries.extract_if(.., |(key, _)| !known.contains(&key.as_str()));
            let mut faults = self.faults.borrow_mut();
            for (key, _) in strangers {
                if faults.len() <= MOST_TOLD {
                    faults.push(unknown_key(&self.place, &key, known));
                }
            }
        }
    }
}

/// Describes a value.
fn described(node: &Node) -> String {
    match node {
        Node::List(items) => format!("a list of {} entries", items.len()),
        other => said(unexpected(other)),
    }
}

fn unexpected(node: &Node) -> Unexpected<'_> {
    match node {
        Node::Null => Unexpected::Unit,
        Node::Bool(b) => Unexpected::Bool(*b),
        Node::Int(i) => Unexpected::Signed(*i),
        Node::Float(x) => Unexpected::Float(*x),
        Node::Text(text) => Unexpected::Str(text),
        Node::List(_) => Unexpected::Seq,
        Node::Table(_) => Unexpected::Map,
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
            Node::List(items) => {
                let count = items.len();
                let steps = items.into_iter().enumerate().map(|(i, node)| (format!("[{i}]"), node));
                let left = steps.collect::<Vec<_>>().into_iter();
                let mut items = Children { left, place: self.place, faults: self.faults };
                let value = visitor.visit_seq(&mut items)?;
                match count - items.left.len() {
                    read if read == count => Ok(value),
                    read => Err(Misfit::new(format!("{count} entries"), format!("{read} entries"))),
                }
            }
            Node::Table(entries) => {
                let left = entries.into_iter();
                visitor.visit_map(&mut Children { left, place: self.place, faults: self.faults })
            }
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        if let Node::Null = self.node { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        mut self,
        _: &'static str,
        known: KeyNames,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        // derived code would assign the values of a list to the keys in order
        if let Node::List(_) = self.node {
            return Err(de::Error::invalid_type(unexpected(&self.node), &visitor));
        }
        self.keep_known(known);
        self.deserialize_any(visitor)
    }

    /// What may be a table or a list: the table is handed on with its place.
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        if let Node::Table(_) = self.node { visitor.visit_some(self) } else { self.deserialize_any(visitor) }
    }

    /// A choice is written as its name, or as a table with its name and settings, which may all
    /// have defaults.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: KeyNames,
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        let (key, settings, is_bare) = match self.node {
            Node::Text(name) => (name, Node::Table(Vec::new()), true),
            Node::Table(mut entries) if entries.len() == 1 => {
                let (key, settings) = entries.remove(0);
                (key, settings, false)
            }
            other => return Err(Misfit::new(said(unexpected(&other)), quoted(variants))),
        };
        let place = join(&self.place, &key);
        visitor.visit_enum(Content { settings: Reader { node: settings, place, ..self }, key, is_bare })
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map identifier ignored_any
    }
}

/// What is left of a list or a table, in order.
struct Children<'a> {
    left: std::vec::IntoIter<(String, Node)>,
    /// Path of the list or table.
    place: String,
    faults: &'a RefCell<Vec<Fault>>,
}

impl Children<'_> {
    fn value<'de, T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misfit> {
        let Some((step, node)) = self.left.next() else { return Ok(None) };
        let reader = Reader { node, place: join(&self.place, &step), faults: self.faults };
        reader.recorded(|reader| seed.deserialize(reader)).map(Some)
    }
}

impl<'de> SeqAccess<'de> for &mut Children<'_> {
    type Error = Misfit;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misfit> {
        self.value(seed)
    }
}

impl<'de> MapAccess<'de> for &mut Children<'_> {
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Misfit> {
        let Some((key, _)) = self.left.as_slice().first() else { return Ok(None) };
        seed.deserialize(StringDeserializer::new(key.clone())).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misfit> {
        self.value(seed)?.ok_or_else(|| de::Error::custom("a value without its key"))
    }
}

/// A choice with its settings.
struct Content<'a> {
    key: String,
    settings: Reader<'a>,
    /// Whether there are no settings.
    is_bare: bool,
}

impl<'de> EnumAccess<'de> for Content<'_> {
    type Error = Misfit;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Misfit> {
        Ok((seed.deserialize(StringDeserializer::new(self.key.clone()))?, self))
    }
}

impl<'de> VariantAccess<'de> for Content<'_> {
    type Error = Misfit;

    /// A choice without settings is written as its name.
    fn unit_variant(self) -> Result<(), Misfit> {
        if self.is_bare {
            return Ok(());
        }
        let found = said(unexpected(&self.settings.node));
        self.settings.recorded(|_| Err(Misfit::new(found, "no settings: the name alone")))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Misfit> {
        self.settings.recorded(|reader| seed.deserialize(reader))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misfit> {
        self.settings.recorded(|reader| reader.deserialize_any(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(self, known: KeyNames, visitor: V) -> Result<V::Value, Misfit> {
        self.settings.recorded(|reader| reader.deserialize_struct("", known, visitor))
    }
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
