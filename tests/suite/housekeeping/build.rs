//! Dependencies and what the build needs: licences, versions, files of the cluster recipe, no unsafe code.

use super::{read, root};
use std::path::Path;
use std::process::Command;

/// What cargo knows of all dependencies.
fn metadata() -> serde_json::Value {
    let version = Command::new("rustc").arg("-vV").output().expect("rustc");
    let version = String::from_utf8_lossy(&version.stdout).into_owned();
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).expect("a host");
    // Other systems' dependencies need not be there.
    let arguments = ["metadata", "--format-version", "1", "--offline", "--locked", "--filter-platform", host];
    let cargo = Command::new(env!("CARGO")).current_dir(root()).args(arguments).output().expect("cargo");
    assert!(cargo.status.success(), "{}", String::from_utf8_lossy(&cargo.stderr));
    serde_json::from_slice(&cargo.stdout).expect("JSON")
}

/// Licences of deny.toml, without the tool: an SPDX expression of `OR`, `AND` and brackets.
fn is_allowed(expression: &str, allowed: &[&str]) -> bool {
    let expression = expression.trim();
    let parts = |word: &str| -> Vec<String> {
        let mut parts: Vec<String> = vec![String::new()];
        for piece in expression.split(word) {
            let last = parts.last_mut().expect("one at least");
            if last.matches('(').count() > last.matches(')').count() {
                *last += &format!("{word}{piece}");
            } else if last.is_empty() {
                *last = piece.to_owned();
            } else {
                parts.push(piece.to_owned());
            }
        }
        parts
    };
    let any = parts(" OR ");
    let all = parts(" AND ");
    match (any.len(), all.len()) {
        (2.., _) => any.iter().any(|part| is_allowed(part, allowed)),
        (_, 2..) => all.iter().all(|part| is_allowed(part, allowed)),
        _ => match expression.strip_prefix('(').and_then(|e| e.strip_suffix(')')) {
            Some(inner) => is_allowed(inner, allowed),
            None => allowed.contains(&expression),
        },
    }
}

#[test]
fn licences_of_all_dependencies_are_allowed() {
    let deny: toml::Table = read("deny.toml").parse().expect("TOML");
    let allowed: Vec<&str> = deny["licenses"]["allow"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|name| name.as_str())
        .collect();
    assert!(
        is_allowed("(MIT OR GPL-2.0) AND Unicode-3.0", &allowed) && !is_allowed("MIT AND GPL-2.0", &allowed)
    );
    assert!(is_allowed("GPL-2.0 OR (MIT AND Zlib)", &allowed) && !is_allowed("GPL-2.0", &allowed));
    for package in metadata()["packages"].as_array().expect("packages") {
        let licence = package["license"].as_str().unwrap_or("none").replace('/', " OR ");
        assert!(is_allowed(&licence, &allowed), "{}: {licence}", package["name"]);
    }
}

/// The oldest Rust is stated once in Cargo.toml, and the same in the README; no dependency asks for a newer one.
#[test]
fn the_oldest_rust_is_stated_and_enough_for_every_dependency() {
    let manifest: toml::Table = read("Cargo.toml").parse().expect("TOML");
    let stated = manifest["workspace"]["package"]["rust-version"].as_str().expect("a version").to_owned();
    assert!(read("README.md").contains(&format!("Rust {stated}")), "README states Rust {stated} or newer");
    let metadata = metadata();
    let number =
        |version: &str| version.split('.').filter_map(|n| n.parse::<u32>().ok()).take(2).collect::<Vec<_>>();
    for package in metadata["packages"].as_array().expect("packages") {
        if let Some(needed) = package["rust-version"].as_str().map(number) {
            assert!(needed <= number(&stated), "{} needs Rust {}", package["name"], package["rust-version"]);
        }
    }
}

/// What `include_str!` and `include_bytes!` in files below a folder name, as their first folder or file below the root.
fn included(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for path in std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found.extend(included(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).expect("text");
            for name in
                ["include_str!(\"", "include_bytes!(\""].iter().flat_map(|call| text.split(call).skip(1))
            {
                let file = path.with_file_name(name.split('"').next().expect("a name")).canonicalize();
                let file = file.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                let below =
                    file.strip_prefix(root().canonicalize().expect("a root")).expect("a file of the project");
                found.push(below.iter().next().expect("a name").to_string_lossy().into_owned());
            }
        }
    }
    found
}

/// The recipe for clusters copies all that cargo asks for before it builds the program.
#[test]
fn the_cluster_recipe_copies_what_the_build_needs() {
    let recipe = read("scripts/inkwave.def");
    let files = recipe.split("%files\n").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("%files");
    let copied: Vec<&str> = files.lines().filter_map(|line| line.split_whitespace().next()).collect();
    for line in files.lines() {
        let from = line.split_whitespace().next().expect("a path");
        assert!(line.ends_with(&format!(" /src/{from}")) && root().join(from).exists(), "{line}");
    }
    let manifest: toml::Table = read("Cargo.toml").parse().expect("TOML");
    let text = |value: &toml::Value| value.as_str().expect("text").to_owned();
    let mut needed: Vec<String> = ["Cargo.toml", "Cargo.lock", "src"].map(str::to_owned).into();
    needed.extend(manifest["workspace"]["members"].as_array().expect("members").iter().map(text));
    needed.push(text(&manifest["package"]["build"]));
    // Cargo refuses a manifest whose targets are not there, even those it does not build.
    for (kind, folder) in [("test", "tests"), ("example", "examples"), ("bench", "benches")] {
        for target in manifest[kind].as_array().expect("targets") {
            let usual = || format!("{folder}/{}.rs", text(&target["name"]));
            needed.push(target.get("path").map_or_else(usual, text));
        }
    }
    let own = included(&root().join("src"));
    assert!(own.iter().any(|name| name == "validation"), "{own:?}");
    for path in needed.iter().chain(&own) {
        assert!(
            copied.iter().any(|from| Path::new(path).starts_with(from)),
            "{path} is not copied: {copied:?}"
        );
    }
}

/// `forbid` would refuse ndarray's macro `s!`; `deny` is as good where no file allows it.
#[test]
fn no_code_is_unsafe() {
    assert!(
        read("Cargo.toml").contains("unsafe_code = \"deny\"")
            && read("src/main.rs").contains("#![forbid(unsafe_code)]")
    );
    let mut folders = vec![root().join("src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("text");
                let words = ["unsafe {", "unsafe fn", "unsafe impl", "allow(unsafe_code"];
                assert!(!words.iter().any(|word| text.contains(word)), "{}", path.display());
            }
        }
    }
}
