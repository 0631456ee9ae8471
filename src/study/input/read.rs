//! Deserialises a tree into a type and reports all unknown keys at once.
//!
//! Serde stops at the first error and describes it in English. This deserialiser knows the keys of
//! each struct before their values are read: it removes the unknown ones, records them all and
//! continues. Its error type separates what was found from what is allowed.

use super::fault::Fault;
use super::misfit::{FORM, Misfit, join, quoted, said, unknown_key};
use super::tree::Node;
use serde::de::value::StringDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, VariantAccess, Visitor,
};
use std::cell::RefCell;

/// Reads a `T`.
///
/// # Errors
/// All unknown keys, and the first value that is missing or of the wrong type, each with its path.
pub fn read<T: DeserializeOwned>(node: Node) -> Result<T, Vec<Fault>> {
    let unknown = RefCell::new(Vec::new());
    let result = T::deserialize(Reader { node, place: String::new(), unknown: &unknown });
    let mut faults = unknown.into_inner();
    match result {
        Ok(value) if faults.is_empty() => return Ok(value),
        Ok(_) => {}
        Err(misfit) => {
            let mut fault = *misfit.0;
            if fault.field.is_empty() {
                fault.field.push_str("the whole file");
            }
            if fault.found.is_empty() {
                fault.found.push_str("a value of another form");
            }
            faults.push(fault);
        }
    }
    Err(faults)
}

/// Reads one node.
struct Reader<'a> {
    node: Node,
    /// Path of the node.
    place: String,
    /// Unknown keys found so far.
    unknown: &'a RefCell<Vec<Fault>>,
}

impl<'a> Reader<'a> {
    fn child(&self, node: Node, step: &str) -> Reader<'a> {
        Reader { node, place: join(&self.place, step), unknown: self.unknown }
    }

    /// Removes and records the keys of a table that are not `known`.
    fn keep_known(&mut self, known: &'static [&'static str]) {
        if let Node::Table(entries) = &mut self.node {
            let strangers = entries.extract_if(.., |(key, _)| !known.contains(&key.as_str()));
            let faults = strangers.map(|(key, _)| unknown_key(&self.place, &key, known));
            self.unknown.borrow_mut().extend(faults);
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
                let mut items = Children { left, place: self.place, unknown: self.unknown };
                let value = visitor.visit_seq(&mut items)?;
                match count - items.left.len() {
                    read if read == count => Ok(value),
                    read => Err(Misfit::new("", format!("{count} entries"), format!("{read} entries"), FORM)),
                }
            }
            Node::Table(entries) => {
                let left = entries.into_iter();
                visitor.visit_map(&mut Children { left, place: self.place, unknown: self.unknown })
            }
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
        // derived code would assign the values of a list to the keys in order
        if let Node::List(_) = self.node {
            return Err(de::Error::invalid_type(unexpected(&self.node), &visitor));
        }
        self.keep_known(known);
        self.deserialize_any(visitor)
    }

    /// A choice is written as its name, or as a table with its name and settings, which may all
    /// have defaults.
    fn deserialize_enum<V: Visitor<'de>>(
        mut self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        let content = match self.node {
            Node::Text(ref name) => {
                let (key, settings) = (name.clone(), Node::Table(Vec::new()));
                Content { reader: self.child(settings, &key), key, is_bare: true }
            }
            Node::Table(ref mut entries) if entries.len() == 1 => {
                let (key, node) = entries.remove(0);
                Content { reader: self.child(node, &key), key, is_bare: false }
            }
            ref other => return Err(Misfit::new("", said(unexpected(other)), quoted(variants), FORM)),
        };
        visitor.visit_enum(content)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

/// What is left of a list or a table, in order.
struct Children<'a> {
    left: std::vec::IntoIter<(String, Node)>,
    place: String,
    unknown: &'a RefCell<Vec<Fault>>,
}

impl Children<'_> {
    fn value<'de, T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misfit> {
        let Some((step, node)) = self.left.next() else { return Ok(None) };
        let found = described(&node);
        let reader = Reader { node, place: join(&self.place, &step), unknown: self.unknown };
        seed.deserialize(reader).map(Some).map_err(|e| e.inside(&step, &found))
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
        let key: StringDeserializer<Misfit> = key.clone().into_deserializer();
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misfit> {
        self.value(seed)?.ok_or_else(|| de::Error::custom("a value without its key"))
    }
}

/// The settings of a choice.
struct Content<'a> {
    reader: Reader<'a>,
    key: String,
    /// Whether there are no settings.
    is_bare: bool,
}

impl<'a> Content<'a> {
    fn settings<T>(self, read: impl FnOnce(Reader<'a>) -> Result<T, Misfit>) -> Result<T, Misfit> {
        let found = described(&self.reader.node);
        read(self.reader).map_err(|e| e.inside(&self.key, &found))
    }
}

impl<'de> EnumAccess<'de> for Content<'_> {
    type Error = Misfit;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Misfit> {
        let name: StringDeserializer<Misfit> = self.key.clone().into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for Content<'_> {
    type Error = Misfit;

    /// A choice without settings is written as its name.
    fn unit_variant(self) -> Result<(), Misfit> {
        if self.is_bare {
            return Ok(());
        }
        Err(Misfit::new(self.key, said(unexpected(&self.reader.node)), "no settings: the name alone", FORM))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Misfit> {
        self.settings(|reader| seed.deserialize(reader))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misfit> {
        self.settings(|reader| reader.deserialize_any(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        self.settings(|reader| reader.deserialize_struct("", known, visitor))
    }
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
