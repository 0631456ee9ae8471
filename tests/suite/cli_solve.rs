//! `inkwave solve` from outside: what a good run prints, and how bad input is refused.

mod refusals;
mod results;

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("a writable folder");
        path
    }
}

pub fn inkwave(path: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.arg("solve").arg(path).args(options).output().expect("the program starts")
}

/// Standard error without the frame that the terminal report draws around it.
pub fn message(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '×', '╰', '─', '▶'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A good case: one absorbing sphere in a binder.
pub fn good() -> Value {
    json!({
        "wavelength": 0.55, "sigma_deg": 20, "L": 0.5, "H": 0.6, "eta_binder": [1.558, 0],
        "spheres": [{ "center": [0.2, 0.2, 0.3], "radius": 0.15, "eta": [1.4, 0.1] }]
    })
}

/// The good case with one value changed (at a JSON pointer) or added (a key at the top).
fn with(pointer: &str, value: Value) -> String {
    let mut case = good();
    match case.pointer_mut(pointer) {
        Some(place) => *place = value,
        None => case[&pointer[1..]] = value,
    }
    case.to_string()
}

/// The program refuses the text, and its message holds every word.
fn refuses_text(name: &str, text: &str, options: &[&str], words: &[&str]) {
    let folder = Folder::new();
    refuses(&folder.file(name, text), options, words);
}

fn refuses(path: &Path, options: &[&str], words: &[&str]) {
    let output = inkwave(path, options);
    let message = message(&output);
    assert!(!output.status.success(), "accepted, but {words:?} was expected: {message}");
    assert!(output.stdout.is_empty(), "a refusal prints no result");
    for word in words {
        assert!(message.contains(word), "“{word}” is missing in: {message}");
    }
}

pub fn solved(text: &str, name: &str, options: &[&str]) -> Value {
    let folder = Folder::new();
    let output = inkwave(&folder.file(name, text), options);
    assert!(output.status.success(), "{}", message(&output));
    assert!(output.stderr.is_empty(), "nothing but the result without a terminal: {}", message(&output));
    serde_json::from_slice(&output.stdout).expect("standard output is JSON")
}
