//! A habit of the code that a reader relies on: a type name has one meaning. Sizes of functions and of parameter lists are clippy's.

use super::house::{library, without_visibility};
use std::collections::BTreeMap;
use std::path::Path;

/// Type names (structs, enums, traits, aliases) that are defined in more than one file, with the files; tests are left out.
fn names_with_two_meanings(files: &[(String, String)]) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (path, text) in files {
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for name in code.lines().filter_map(defined_type) {
            places.entry(name).or_default().push(path);
        }
    }
    let several = places.into_iter().filter(|(_, places)| places.len() > 1);
    several.map(|(name, places)| format!("{name}: {}", places.join(", "))).collect()
}

/// The name of the type that a line defines; types of traits (`type Value = …;`, further in) belong to them.
fn defined_type(line: &str) -> Option<&str> {
    let item = without_visibility(line);
    let rest = ["struct ", "enum ", "trait ", "type "].iter().find_map(|kind| item.strip_prefix(kind))?;
    Some(rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or(rest))
}

#[test]
fn every_type_name_has_one_meaning() {
    let mut files = library();
    files.extend(commands());
    let found = names_with_two_meanings(&files);
    assert!(found.is_empty(), "type names with two meanings:\n{}", found.join("\n"));
}

/// The program's own files.
fn commands() -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![src.join("commands")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).expect("commands").map(|entry| entry.expect("an entry").path())
        {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(&src).expect("below src").display().to_string();
            files.push((name, std::fs::read_to_string(&path).expect("a source file")));
        }
    }
    files
}

/// The planted fault: one name for two types, in whatever scope; names of tests and of traits' own types do not count.
#[test]
fn a_name_with_two_meanings_is_seen() {
    let file = |path: &str, text: &str| (path.to_string(), text.to_string());
    let found = names_with_two_meanings(&[
        file("a.rs", "pub struct Page;\nimpl X for Y {\n    type Error = Z;\n}\nstruct Own<T>(T);"),
        file("b.rs", "pub(super) enum Page {\n}\nimpl X for W {\n    type Error = Z;\n}"),
        file("c.rs", "#[cfg(test)]\nmod tests {\n    struct Own;\n}"),
    ]);
    assert_eq!(found, ["Page: a.rs, b.rs"]);
}
