//! The house: dependencies between the folders of `src` run one way, in the order that `src/lib.rs` states, and no files
//! form a circle, where a file and those in the folder of its name count as one room. Both are read from `use` lines and
//! from paths that begin with `crate::` or `super::`; names that a folder re-exports count as the file they come from.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Names of a module from the crate's root on.
type Module = Vec<String>;

/// One file: whether it only gathers others (`mod.rs`, `lib.rs`), and the paths it uses (public re-exports apart).
#[derive(Default)]
struct Source {
    gathers: bool,
    uses: Vec<String>,
    exports: Vec<String>,
}

struct House(BTreeMap<Module, Source>);

/// Folders of `src` that are crates of several rooms.
const CRATES: [&str; 2] = ["physics/", "study/"];
/// Folders of `src` that are crates of one room, which has the folder's name.
const ROOMS: [&str; 3] = ["numerics", "draw", "bench"];
/// The crate that nothing of the product may lean on, and the files that use it all the same.
const LEAF: &str = "inkwave_bench";
const USERS_OF_THE_LEAF: [&str; 2] = ["commands/compare.rs", "schema.rs"];

impl House {
    /// From (path below `src`, text) of every file.
    fn new(files: &[(String, String)]) -> House {
        House(files.iter().map(|(path, text)| (module_of(path), source(path, text))).collect())
    }

    /// The files that each file uses, tests left out.
    fn edges(&self) -> BTreeMap<&Module, BTreeSet<Module>> {
        let plain = self.0.iter().filter(|(_, s)| !s.gathers);
        plain.map(|(module, source)| (module, self.used_by(module, source))).collect()
    }

    fn used_by(&self, module: &Module, source: &Source) -> BTreeSet<Module> {
        let paths = source.uses.iter().chain(&source.exports);
        let found = paths.filter_map(|p| self.absolute(module, p)).map(|p| self.file_of(&p));
        found.filter(|used| !one_room(used, module) && !self.0[used].gathers).collect()
    }

    /// The path from the crate's root on; `None` for other crates.
    fn absolute(&self, module: &Module, path: &str) -> Option<Module> {
        let parts: Vec<String> = path.split("::").map(str::to_string).collect();
        let up = parts.iter().take_while(|p| *p == "super").count();
        let own = &module[..module.len().saturating_sub(up)];
        match parts[0].as_str() {
            "crate" => {
                let room: Module =
                    module.iter().take(1).filter(|m| ROOMS.contains(&m.as_str())).cloned().collect();
                let inside = [&room, &parts[1..parts.len().min(2)]].concat();
                let of_room = !room.is_empty() && self.0.contains_key(&inside);
                Some(if of_room { [&room, &parts[1..]].concat() } else { parts[1..].to_vec() })
            }
            "super" => Some([own, &parts[up..]].concat()),
            "self" => Some([own, &parts[1..]].concat()),
            child => {
                let inner = [own, &[child.to_string()]].concat();
                self.0.contains_key(&inner).then(|| [own, &parts].concat())
            }
        }
    }

    /// The file that a path ends in: its longest module, or where a gathering module has the name from.
    fn file_of(&self, path: &[String]) -> Module {
        let mut module = path.to_vec();
        while !self.0.contains_key(&module) {
            module.pop();
        }
        let source = &self.0[&module];
        let Some(name) = path.get(module.len()).filter(|_| source.gathers) else { return module };
        let sources = source.exports.iter().filter_map(|e| self.absolute(&module, e));
        let origin = sources.into_iter().find(|e| e.last() == Some(name) && **e != *path);
        origin.map_or(module, |origin| self.file_of(&origin))
    }

    /// Uses of a folder from one that the order puts before it.
    fn against_the_order(&self, order: &[Vec<String>]) -> Vec<String> {
        self.against_the_order_in(&[], order)
    }

    /// The same of the folders inside one.
    fn against_the_order_in(&self, inside: &[String], order: &[Vec<String>]) -> Vec<String> {
        let depth = inside.len();
        let rank = |m: &Module| order.iter().position(|row| m.get(depth).is_some_and(|f| row.contains(f)));
        let mut found = Vec::new();
        for (module, used) in self.edges().into_iter().filter(|(module, _)| module.starts_with(inside)) {
            let others = used.iter().filter(|o| o.starts_with(inside) && o.get(depth) != module.get(depth));
            for other in others {
                match (rank(module), rank(other)) {
                    (Some(own), Some(other)) if other < own => {}
                    _ => found.push(format!("{} uses {}", module.join("::"), other.join("::"))),
                }
            }
        }
        found
    }

    /// A file that reaches itself, with the way; none when there is no circle.
    fn circles(&self) -> Vec<String> {
        let edges = self.edges();
        edges.keys().filter_map(|start| way_back(&edges, start)).collect()
    }
}

/// A file and those in the folder of its name are one room: `run.rs` with `run/*.rs`.
fn one_room(a: &Module, b: &Module) -> bool {
    a.starts_with(b) || b.starts_with(a)
}

/// A shortest way from a file back to itself.
fn way_back(edges: &BTreeMap<&Module, BTreeSet<Module>>, start: &Module) -> Option<String> {
    let mut ways: Vec<Vec<&Module>> = edges[start].iter().map(|next| vec![next]).collect();
    let mut seen: BTreeSet<&Module> = edges[start].iter().collect();
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            let last = *way.last().expect("a way has an end");
            if last == start {
                let names: Vec<String> = way.iter().map(|m| m.join("::")).collect();
                return Some(format!("{} → {}", start.join("::"), names.join(" → ")));
            }
            for next in edges.get(last).into_iter().flatten().filter(|next| seen.insert(next)) {
                longer.push([way.as_slice(), &[next]].concat());
            }
        }
        ways = longer;
    }
    None
}

/// The crates' own folders are no rooms: each re-exports those of the one before, so that paths read alike everywhere.
fn module_of(path: &str) -> Module {
    let path = CRATES.iter().find_map(|folder| path.strip_prefix(folder)).unwrap_or(path);
    let mut parts: Module = path.trim_end_matches(".rs").split('/').map(str::to_string).collect();
    parts.pop_if(|last| last == "mod" || last == "lib");
    parts
}

fn source(path: &str, text: &str) -> Source {
    let gathers = path.ends_with("mod.rs") || path.ends_with("lib.rs");
    let mut found = Source { gathers, ..Source::default() };
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let mut lines = code.lines().map(str::trim).filter(|l| !l.starts_with("//"));
    while let Some(line) = lines.next() {
        let is_public = line.starts_with("pub");
        let Some(mut tree) = use_tree(line).map(str::to_string) else {
            found.uses.extend(inline_paths(line));
            continue;
        };
        while !tree.contains(';') {
            tree.push_str(lines.next().expect("a use ends with a semicolon"));
        }
        let paths = expanded(tree.trim_end_matches(';'));
        if is_public { found.exports.extend(paths) } else { found.uses.extend(paths) }
    }
    found
}

/// What follows `use` in a line that begins with it.
pub fn use_tree(line: &str) -> Option<&str> {
    without_visibility(line).strip_prefix("use ")
}

/// An item without `pub` and its scope.
pub fn without_visibility(line: &str) -> &str {
    let rest = line.strip_prefix("pub").map_or(line, |l| match l.strip_prefix('(') {
        Some(scope) => scope.split_once(')').map_or(scope, |(_, rest)| rest),
        None => l,
    });
    if rest.len() < line.len() { rest.trim_start() } else { rest }
}

/// `a::{b, c::{d, e}}` → `a::b`, `a::c::d`, `a::c::e`; what it is renamed to is left out.
pub fn expanded(tree: &str) -> Vec<String> {
    let Some((head, rest)) = tree.split_once('{') else {
        let name = tree.split(" as ").next().unwrap_or(tree).trim();
        return if name.is_empty() { Vec::new() } else { vec![name.to_string()] };
    };
    let inner = &rest[..rest.rfind('}').unwrap_or(rest.len())];
    let mut depth = 0;
    let parts = inner.split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    parts.flat_map(expanded).map(|part| format!("{}{part}", head.trim())).collect()
}

/// Paths within the crate in a line of code.
fn inline_paths(line: &str) -> Vec<String> {
    let starts = ["crate::", "super::"].into_iter().flat_map(|k| line.match_indices(k));
    let path = |from: usize| -> String {
        line[from..].chars().take_while(|c| c.is_alphanumeric() || *c == '_' || *c == ':').collect()
    };
    starts.map(|(from, _)| path(from).trim_end_matches(':').to_string()).collect()
}

/// All files of the library below `src`; the program's own (`main.rs`, `commands`) stand outside the house.
pub fn library() -> Vec<(String, String)> {
    let mut files = sources();
    files.retain(|(name, _)| {
        !name.starts_with("commands/")
            && !name.ends_with("_tests.rs")
            && name != "main.rs"
            && !is_crate_root(name)
    });
    files
}

/// All files below `src` with their texts.
fn sources() -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![src.clone()];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of src") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(&src).expect("below src").to_string_lossy().replace('\\', "/");
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs") {
                files.push((name, std::fs::read_to_string(&path).expect("a source file")));
            }
        }
    }
    files
}

/// Roots of the inner crates only gather folders.
fn is_crate_root(name: &str) -> bool {
    CRATES.iter().any(|folder| name.strip_prefix(folder) == Some("lib.rs"))
}

/// The order as `src/lib.rs` states it: folders between commas stand side by side.
fn order() -> Vec<Vec<String>> {
    order_in(include_str!("../../src/lib.rs"))
}

/// The order that a text states in a block, with arrows.
fn order_in(text: &str) -> Vec<Vec<String>> {
    let block = text.split("//! ```text\n").nth(1).and_then(|rest| rest.split("//! ```").next());
    let stated = block.expect("the order is stated in a block").replace("//!", "");
    stated.split('←').map(|row| row.split(',').map(|f| f.trim().to_string()).collect()).collect()
}

#[test]
fn folders_depend_one_way_only() {
    let found = House::new(&library()).against_the_order(&order());
    assert!(found.is_empty(), "against the order of src/lib.rs:\n{}", found.join("\n"));
}

#[test]
fn rooms_of_a_sweep_depend_one_way_only() {
    let order = order_in(include_str!("../../src/sweep/mod.rs"));
    assert_eq!(order.len(), 2);
    let found = House::new(&library()).against_the_order_in(&["sweep".to_string()], &order);
    assert!(found.is_empty(), "against the order of src/sweep/mod.rs:\n{}", found.join("\n"));
}

/// Fit, design and sweep stand in one row of the order, so that none may use another; the statement in `src/lib.rs` must
/// not come apart. *Planted*: `use crate::sweep::definition::file::SheetTable;` in `fit/file.rs`.
#[test]
fn fit_design_and_sweep_stand_side_by_side() {
    let order = order();
    let row = order.iter().find(|row| row.iter().any(|folder| folder == "sweep")).expect("a row with sweep");
    assert!(["design", "fit"].iter().all(|other| row.iter().any(|folder| folder == other)), "{row:?}");
}

/// Files that name the leaf and are neither its own nor users of it.
fn leaning_on_the_leaf(files: &[(String, String)]) -> Vec<&str> {
    let names = files.iter().filter(|(_, text)| text.contains(LEAF)).map(|(name, _)| name.as_str());
    names.filter(|name| !name.starts_with("bench/") && !USERS_OF_THE_LEAF.contains(name)).collect()
}

/// *Planted*: `use inkwave_bench::row::Row;` in `sweep/merge.rs`.
#[test]
fn comparisons_are_a_leaf() {
    let files = sources();
    let leaning = leaning_on_the_leaf(&files);
    assert!(leaning.is_empty(), "nothing but {USERS_OF_THE_LEAF:?} uses {LEAF}: {leaning:?}");
    let used = |user: &&str| files.iter().any(|(name, text)| name == *user && text.contains(LEAF));
    assert!(USERS_OF_THE_LEAF.iter().all(used), "a user of {LEAF} has gone: take it off the list");
}

#[test]
fn no_files_form_a_circle() {
    let found = House::new(&library()).circles();
    assert!(found.is_empty(), "circles:\n{}", found.join("\n"));
}

/// A path from the root of a crate of one room is one of that room, if the room has such a file.
#[test]
fn paths_of_a_crate_of_one_room_stay_in_it() {
    let file = |path: &str, text: &str| (path.to_string(), text.to_string());
    let house = House::new(&[
        file("lib.rs", ""),
        file("draw/lib.rs", "pub mod chart;\npub mod leaf;"),
        file("draw/chart.rs", "use crate::leaf::fitting;\nuse crate::store::seal;"),
        file("draw/leaf.rs", "use crate::chart::Chart;"),
        file("study/store/mod.rs", "pub mod seal;"),
        file("study/store/seal.rs", ""),
    ]);
    assert_eq!(
        house.circles(),
        ["draw::chart → draw::leaf → draw::chart", "draw::leaf → draw::chart → draw::leaf"]
    );
    let order = [vec!["draw".to_string()], vec!["store".to_string()]];
    assert_eq!(house.against_the_order(&order), ["draw::chart uses store::seal"]);
}

/// The planted faults: an arrow back, directly and through a re-export, and a circle of three.
#[test]
fn planted_faults_are_seen() {
    let file = |path: &str, text: &str| (path.to_string(), text.to_string());
    let house = House::new(&[
        file("lib.rs", ""),
        file("a/mod.rs", "pub mod x;\npub mod y;\npub use x::X;"),
        file("a/x.rs", "use super::y;\npub struct X;"),
        file("a/y.rs", "fn f() { crate::b::z::g() }"),
        file("b/mod.rs", "pub mod z;"),
        file("b/z.rs", "use crate::{\n    a::X,\n};\n#[cfg(test)]\nmod tests { use crate::c; }"),
    ]);
    let order = [vec!["a".to_string()], vec!["b".to_string()]];
    assert_eq!(house.against_the_order(&order), ["a::y uses b::z"]);
    assert_eq!(house.circles()[0], "a::x → a::y → b::z → a::x");
    assert_eq!(house.circles().len(), 3);
}
