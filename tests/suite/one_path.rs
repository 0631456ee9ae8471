//! Every public item of a library crate has one path: an item that a public module declares is not re-exported elsewhere,
//! and a re-export is made once. Read from the sources: `pub mod`, `pub use`, and `pub` items at the margin.

use crate::house::{expanded, use_tree};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Crates whose items have one path each; their folders hold crates that others may use.
const LIBRARIES: [&str; 2] = ["src/numerics", "src/physics"];

/// Names of a module from the crate's root on.
type ModulePath = Vec<String>;

/// What a module states in public: modules, re-exports as written, and items.
#[derive(Default)]
struct PublicNames {
    modules: BTreeSet<String>,
    exports: Vec<String>,
    items: BTreeSet<String>,
    /// Re-exports that give an item another name.
    renamed: Vec<String>,
}

/// All modules of one crate.
struct Library(BTreeMap<ModulePath, PublicNames>);

impl Library {
    /// From (path below the crate's folder, text) of every file.
    fn new(files: &[(String, String)]) -> Library {
        Library(files.iter().map(|(path, text)| (module_path(path), public_names(text))).collect())
    }

    /// The public paths of every public item, by the module and the name of its declaration.
    fn paths(&self) -> BTreeMap<Vec<String>, BTreeSet<String>> {
        let mut paths: BTreeMap<Vec<String>, BTreeSet<String>> = BTreeMap::new();
        for (module, names) in self.0.iter().filter(|(module, _)| self.is_public(module)) {
            let declared = names.items.iter().map(|item| (with(module, item), item.clone()));
            let exported = names.exports.iter().filter_map(|path| {
                let origin = self.origin(self.absolute(module, path)?);
                let name = path.rsplit("::").next().unwrap_or(path).to_string();
                Some((origin, name))
            });
            for (origin, name) in declared.chain(exported) {
                paths.entry(origin).or_default().insert(with(module, &name).join("::"));
            }
        }
        paths
    }

    /// Items with several paths, each with all of them, and re-exports of the crate's own items under another name.
    fn repeated(&self) -> Vec<String> {
        let several = self.paths().into_values().filter(|paths| paths.len() > 1);
        let several = several.map(|paths| paths.into_iter().collect::<Vec<_>>().join(", "));
        let inner = self.0.iter().filter(|(module, _)| !module.is_empty());
        several.chain(inner.flat_map(|(_, names)| names.renamed.iter().cloned())).collect()
    }

    /// Whether every module on the way to this one is public.
    fn is_public(&self, module: &[String]) -> bool {
        (0..module.len()).all(|depth| {
            self.0.get(&module[..depth]).is_some_and(|parent| parent.modules.contains(&module[depth]))
        })
    }

    /// A re-exported path from the crate's root on; `None` for other crates.
    fn absolute(&self, module: &[String], path: &str) -> Option<Vec<String>> {
        let mut parts: Vec<String> = path.split("::").map(str::to_string).collect();
        let mut start = module.to_vec();
        match parts[0].as_str() {
            "crate" => start.clear(),
            "self" | "super" => {}
            child if self.0.contains_key(&with(module, child)) => return Some([module, &parts].concat()),
            _ => return None,
        }
        while let Some("super") = parts.first().map(String::as_str) {
            start.pop();
            parts.remove(0);
        }
        parts.retain(|part| part != "crate" && part != "self");
        Some([start, parts].concat())
    }

    /// Where an item is declared, through any re-exports of the modules that its path names.
    fn origin(&self, path: Vec<String>) -> Vec<String> {
        let Some((name, module)) = path.split_last() else { return path };
        let exports = self.0.get(module).into_iter().flat_map(|names| &names.exports);
        let mut sources = exports.filter(|e| e.rsplit("::").next() == Some(name.as_str()));
        match sources.find_map(|e| self.absolute(module, e)).filter(|source| *source != path) {
            Some(source) => self.origin(source),
            None => path,
        }
    }
}

fn with(module: &[String], name: &str) -> Vec<String> {
    [module, &[name.to_string()]].concat()
}

fn module_path(file: &str) -> ModulePath {
    let mut parts: ModulePath = file.trim_end_matches(".rs").split('/').map(str::to_string).collect();
    parts.pop_if(|last| last == "mod" || last == "lib");
    parts
}

/// The public names of one file, its tests left out.
fn public_names(text: &str) -> PublicNames {
    let mut names = PublicNames::default();
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let Some(item) = line.strip_prefix("pub ") else { continue };
        if item.starts_with("use ") {
            let mut tree = line.to_string();
            while !tree.contains(';') {
                tree.push_str(lines.next().expect("a use ends with a semicolon").trim());
            }
            names.renamed.extend(tree.contains(" as ").then(|| tree.clone()));
            let tree = use_tree(tree.trim_end_matches(';')).expect("a use begins with `use`").to_string();
            names.exports.extend(expanded(&tree));
        } else if let Some(module) = item.strip_prefix("mod ") {
            names.modules.insert(module.trim_end_matches(|c| ";{} ".contains(c)).to_string());
        } else {
            names.items.extend(item_name(item).map(str::to_string));
        }
    }
    names
}

/// The name that a public item declares: the word behind its keyword.
fn item_name(item: &str) -> Option<&str> {
    const KEYWORDS: [&str; 8] = ["fn ", "struct ", "enum ", "trait ", "type ", "const ", "static ", "union "];
    let item = item.strip_prefix("const fn ").map_or(item, |_| &item["const ".len()..]);
    let rest = KEYWORDS.iter().find_map(|keyword| item.strip_prefix(keyword))?;
    rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}

/// The sources of a crate, as (path below its folder, text).
fn sources(folder: &str) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut folders = vec![root.clone()];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of a crate") {
            let path = entry.expect("an entry").path();
            let name =
                path.strip_prefix(&root).expect("below the crate").to_string_lossy().replace('\\', "/");
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs") && !name.ends_with("_tests.rs") {
                files.push((name, std::fs::read_to_string(&path).expect("a source file")));
            }
        }
    }
    files
}

#[test]
fn public_items_have_one_path() {
    let mut repeated = Vec::new();
    for folder in LIBRARIES {
        let library = Library::new(&sources(folder));
        // what is checked is there: the crates have some hundred public items
        assert!(library.paths().len() > 40, "{folder}: {}", library.paths().len());
        repeated.extend(library.repeated().into_iter().map(|paths| format!("{folder}: {paths}")));
    }
    assert!(repeated.is_empty(), "items with several paths:\n{}", repeated.join("\n"));
}

/// The planted faults: a second path by a public module, by a renaming, and by a re-export of a re-export.
#[test]
fn planted_paths_are_seen() {
    let file = |path: &str, text: &str| (path.to_string(), text.to_string());
    let files = [
        file(
            "lib.rs",
            "pub mod a;\nmod hidden;\npub use hidden::Alone;\npub use a::x::{X, Y};\npub use other::W;",
        ),
        file(
            "a/mod.rs",
            "pub mod x;\nmod y;\npub use y::{\n    deep,\n};\npub use super::Alone;\npub use y::deep as low;",
        ),
        file("a/x.rs", "pub struct X;\npub struct Y<T>(T);\npub const fn only() {}\npub(crate) fn not() {}"),
        file("a/y.rs", "pub fn deep() {}"),
        file("hidden.rs", "pub struct Alone;\n#[cfg(test)]\nmod tests {\npub struct Alone;\n}"),
    ];
    let repeated = Library::new(&files).repeated();
    assert_eq!(repeated, ["X, a::x::X", "Y, a::x::Y", "Alone, a::Alone", "pub use y::deep as low;"]);
    let paths = Library::new(&files).paths();
    assert!(paths.contains_key(&["a", "x", "only"].map(String::from)[..]));
    assert!(!paths.contains_key(&["a", "x", "not"].map(String::from)[..]));
}
