//! The Python module and the listings of the documentation, run by Python where it has NumPy.

use std::path::Path;
use std::process::{Command, Output};

/// The Python of these tests: $INKWAVE_PYTHON, else python3.
fn python() -> Command {
    let mut command = Command::new(std::env::var("INKWAVE_PYTHON").unwrap_or_else(|_| "python3".into()));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("INKWAVE", env!("CARGO_BIN_EXE_inkwave"));
    command
}

/// Says why a test is skipped where Python has no NumPy.
fn has_numpy() -> bool {
    let found = python().args(["-c", "import numpy"]).output().is_ok_and(|done| done.status.success());
    if !found {
        eprintln!("skipped: python3 has no numpy");
    }
    found
}

fn assert_passed(done: &Output) {
    let said = [&done.stdout, &done.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).join("\n");
    assert!(done.status.success(), "{said}");
}

/// *Planted*: an interrupt that is not passed on; an index that loses its imaginary part; terminal codes left in a message.
#[test]
fn the_python_module_keeps_its_promises() {
    if has_numpy() {
        let tests = Path::new("python/tests/test_inkwave.py");
        assert_passed(&python().arg(tests).output().expect("python3"));
    }
}

/// Links lead to files of the repository, and every listing prints what stands below it. *Planted*: a digit of a printed
/// result; a link to a page that is gone.
#[test]
fn the_pages_print_what_they_say() {
    let listings = if has_numpy() { "all" } else { "--links" };
    assert_passed(&python().args(["scripts/check_docs.py", listings]).output().expect("python3"));
}
