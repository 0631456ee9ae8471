//! Which build of the program this is.

/// Name, version and, where it is known, commit of this build, such as `inkwave 0.1.0 (7207559)`. A `+` after the commit
/// says that the sources had changes of their own.
pub fn build() -> &'static str {
    env!("INKWAVE_BUILD")
}
