//! Which build of the program this is.

use std::sync::OnceLock;

static BUILD: OnceLock<&str> = OnceLock::new();

/// Name, version and, where the program knows it, commit of this build, such as `inkwave 0.1.0 (7207559)`. A `+` after the
/// commit says that the sources had changes of their own.
pub fn build() -> &'static str {
    BUILD.get().copied().unwrap_or(concat!("inkwave ", env!("CARGO_PKG_VERSION")))
}

/// States the build, once, before anything is stored: libraries on their own do not know the commit.
pub fn set_build(build: &'static str) {
    _ = BUILD.set(build);
}
