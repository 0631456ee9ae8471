//! Identifies the build of the program.

use std::sync::OnceLock;

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
