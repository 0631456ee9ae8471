//! What the repository says about itself: generated pages are as they were generated, versions agree, schedules run.

mod build;
mod nights;
mod pages;

use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(root().join(path)).expect("a file of the repository")
}
