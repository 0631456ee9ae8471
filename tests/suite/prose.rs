//! The prose of the repository: no calques anywhere; in the sources, summaries that stand alone and lines of a readable
//! length.

use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Phrases that are no English, or none that a reader of the field would use.
const CALQUES: [&str; 19] = [
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
    "wished",
    "usual slips",
    "errors hold",
    "bars hold",
    "hardly contain",
    "laid through",
    "lays response surfaces",
];

/// Files and folders whose prose is read for this: sources with help, messages and pages; tests; tools; documents.
const READ: [&str; 18] = [
    ".ci",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Cargo.toml",
    "README.md",
    "benches",
    "build.rs",
    "clippy.toml",
    "deny.toml",
    "docs",
    "examples",
    "python",
    "schema",
    "scripts",
    "src",
    "tests",
    "validation",
];

/// The file with the list itself.
const LIST: &str = "tests/suite/prose.rs";

/// Extensions of files that hold prose; scripts have none. Data and generated files are left out.
const KINDS: [&str; 12] = ["cff", "css", "def", "html", "js", "lead", "md", "mjs", "py", "rs", "sh", "toml"];

/// Folders whose comments keep to 100 characters.
const NARROW: [&str; 4] = ["src/numerics", "src/physics", "src/study", "src/sweep"];

/// All files in a folder and below, or the file itself.
fn files(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| files(&path)).collect()
}

/// Whether a file holds prose, by its name.
fn holds_prose(path: &Path) -> bool {
    let kind = path.extension().map(|kind| kind.to_string_lossy().into_owned());
    !path.ends_with(LIST) && kind.is_none_or(|kind| KINDS.contains(&kind.as_str()))
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
    assert_eq!(long_comments(&planted).len(), 1);
    assert!(long_comments(&planted.replace("/// x", "/// ```text\n/// x")).is_empty());
    for path in
        files(&root().join("src")).into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs"))
    {
        let text = std::fs::read_to_string(&path).expect("a source file");
        let mut faults = leaning_summaries(&text);
        if NARROW.iter().any(|folder| path.starts_with(root().join(folder))) {
            faults.extend(long_comments(&text));
        }
        assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
    }
}

/// No file with prose (sources, help, messages, pages, tests, tools, documents) has a phrase of the list. *Planted*: a
/// phrase across a line break of a comment, and one in the name of a test; a word that only contains one is none.
#[test]
fn no_prose_has_a_phrase_of_the_list() {
    assert_eq!(calques("/// of so\n/// many of them."), ["so many"]);
    assert_eq!(calques("fn a_fault_is_told() {}"), ["is told"]);
    assert!(calques("shallow").is_empty());
    let all: Vec<PathBuf> = READ.iter().flat_map(|name| files(&root().join(name))).collect();
    let read: Vec<PathBuf> = all.into_iter().filter(|path| holds_prose(path)).collect();
    for kind in [
        "README.md",
        "src/report/study.html",
        "src/commands/solve.rs",
        "scripts/nightly",
        "validation/golden.py",
    ] {
        assert!(read.iter().any(|path| path.ends_with(kind)), "{kind} is not read");
    }
    let mut faults = Vec::new();
    for path in read {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        faults.extend(calques(&text).into_iter().map(|phrase| format!("{}: {phrase}", path.display())));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
