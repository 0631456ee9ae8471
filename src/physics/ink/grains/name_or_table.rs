//! Reads a tagged choice either as a bare name (`shape = "cylinder"`) or as a table with `kind`.

use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, MapDeserializer, StrDeserializer};
use serde::de::{self, Deserializer, MapAccess, Visitor};
use std::marker::PhantomData;

/// Deserialises `T`, an enum internally tagged with `kind`, from a string or a table.
pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    from.deserialize_any(NameOrTable(PhantomData))
}

struct NameOrTable<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for NameOrTable<T> {
    type Value = T;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a name, or a table with `kind`")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<T, E> {
        let pair = (StrDeserializer::<E>::new("kind"), StrDeserializer::<E>::new(name));
        T::deserialize(MapDeserializer::<_, E>::new([pair].into_iter()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}
