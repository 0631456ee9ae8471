//! The prose of the sources: no calques, summaries that stand alone, lines of a readable length.

use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Phrases that are no English, or none that a reader of the field would use.
const CALQUES: [&str; 12] = [
    "so many",
    "one a solve",
    "cells a µm",
    "is told",
    "was told",
    "unless told",
    "comes about",
    "come about",
    "shall",
    "for ever",
    "whoever",
    "nobody",
];

/// Folders whose prose has been read for this.
const PLAIN: [&str; 4] = ["src/numerics", "src/physics", "src/study", "src/sweep"];

/// Every Rust file in a folder and below.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let found = entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] });
    found.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

fn is_doc(line: &str) -> bool {
    line.starts_with("///") || line.starts_with("//!")
}

/// Summaries of doc comments that need the item above to be understood.
fn leaning_summaries(text: &str) -> Vec<String> {
    let mut before = "";
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if is_doc(line) && !is_doc(before) && line[3..].trim_start().starts_with("The same") {
            found.push(line.to_owned());
        }
        before = line;
    }
    found
}

/// Phrases of the list above, in comments, messages or names, also across line breaks.
fn calques(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let words = format!(" {} ", words.collect::<Vec<_>>().join(" ").to_lowercase());
    CALQUES.iter().filter(|phrase| words.contains(&format!(" {phrase} "))).map(|p| (*p).to_owned()).collect()
}

/// Comments of more than 100 characters, examples and formulas in fences apart.
fn long_comments(text: &str) -> Vec<String> {
    let mut fenced = false;
    let mut found = Vec::new();
    for line in text.lines().filter(|line| line.trim().starts_with("//")) {
        fenced ^= line.contains("```");
        if !fenced && line.chars().count() > 100 {
            found.push(line.trim().to_owned());
        }
    }
    found
}

/// Comments are in the terms of the field, and every summary stands alone. *Planted*: one fault of each kind.
#[test]
fn the_prose_of_the_sources_is_plain() {
    let planted = format!(
        "/// The same\n/// of so\n/// many of them.\n\n/// Sizes.\n/// The same unit.\n/// {}",
        "x".repeat(100)
    );
    assert_eq!(leaning_summaries(&planted).len(), 1);
    assert_eq!(calques(&planted), ["so many"]);
    assert_eq!(long_comments(&planted).len(), 1);
    assert!(
        long_comments(&planted.replace("/// x", "/// ```text\n/// x")).is_empty()
            && calques("shallow").is_empty()
    );
    for path in sources(&root().join("src")) {
        let text = std::fs::read_to_string(&path).expect("a source file");
        let mut faults = leaning_summaries(&text);
        if PLAIN.iter().any(|folder| path.starts_with(root().join(folder))) {
            faults.extend(calques(&text).into_iter().chain(long_comments(&text)));
        }
        assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
    }
}
