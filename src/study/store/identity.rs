//! Content hashes that identify results by everything they depend on, and the build that made them.
//!
//! A key hashes the inputs as compact JSON (fields in declaration order, floats in their shortest
//! form that reads back exactly) together with [`METHOD_VERSION`]. Nothing is computed twice, and a
//! changed input recomputes only what depends on it, in any study or sweep that shares the store.

use crate::ink::PackingRequest;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io::{BufWriter, Write};
use std::sync::OnceLock;

/// Version of the numerical method, increased whenever the same inputs give different numbers, so
/// that results of older methods are not reused.
pub const METHOD_VERSION: u32 = 18;

/// Content hash (BLAKE3, first 128 bits in hexadecimal) of what a result depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Key(String);

/// Bytes that are hashed at once.
const HASHED_AT_ONCE: usize = 1 << 16;

impl Key {
    /// Key of `inputs` of a `kind` (such as `"packing"`). The inputs hold no NaN and no non-string
    /// map keys.
    pub fn of(kind: &str, inputs: &impl Serialize) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("inkwave/{kind}/{METHOD_VERSION}/").as_bytes());
        // a million given grains are written number by number, which are hashed many at a time
        let mut written = BufWriter::with_capacity(HASHED_AT_ONCE, &mut hasher);
        serde_json::to_writer(&mut written, inputs).expect("checked inputs are plain numbers and strings");
        written.flush().expect("hashing has no errors");
        drop(written);
        Self(hasher.finalize().to_hex()[..32].to_owned())
    }

    /// Key for the scalar wave (`vector` is `None`) or for Maxwell's equations, with the inputs
    /// specific to them.
    pub fn of_wave(kind: &str, inputs: &impl Serialize, vector: Option<impl Serialize>) -> Self {
        match vector {
            None => Self::of(kind, inputs),
            Some(vector) => Self::of(kind, &(inputs, "maxwell", vector)),
        }
    }

    /// Key of a packing.
    pub fn of_packing(request: &PackingRequest) -> Self {
        Self::of("packing", request)
    }

    /// The key as text, suitable for file names.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The first eight digits, for display.
    pub fn short(&self) -> &str {
        &self.0[..8]
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

static BUILD: OnceLock<&str> = OnceLock::new();

/// Name, version and, where known, commit of this build, such as `inkwave 0.1.0 (7207559)`. A `+`
/// after the commit marks uncommitted changes.
pub fn build() -> &'static str {
    BUILD.get().copied().unwrap_or(concat!("inkwave ", env!("CARGO_PKG_VERSION")))
}

/// Sets the build, once, before anything is stored: a library on its own does not know the commit.
pub fn set_build(build: &'static str) {
    _ = BUILD.set(build);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_depends_on_kind_and_content_alone() {
        assert_eq!(Key::of("point", &(1.0, "a")), Key::of("point", &(1.0, "a")));
        assert_ne!(Key::of("point", &(1.0, "a")), Key::of("packing", &(1.0, "a")));
        assert_eq!(Key::of_wave("point", &1.0, None::<u8>), Key::of("point", &1.0));
        assert_ne!(Key::of_wave("point", &1.0, Some(1)), Key::of_wave("point", &1.0, Some(2)));
        assert_ne!(Key::of("point", &1.0), Key::of("point", &(1.0 + f64::EPSILON)));
    }
}
