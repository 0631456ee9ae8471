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

/// Folders of `src` that are crates.
const CRATES: [&str; 2] = ["physics/", "study/"];

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
            "crate" => Some(parts[1..].to_vec()),
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
fn use_tree(line: &str) -> Option<&str> {
    without_visibility(line).strip_prefix("use ")
}

/// An item without `pub` and its scope.
fn without_visibility(line: &str) -> &str {
    let rest = line.strip_prefix("pub").map_or(line, |l| match l.strip_prefix('(') {
        Some(scope) => scope.split_once(')').map_or(scope, |(_, rest)| rest),
        None => l,
    });
    if rest.len() < line.len() { rest.trim_start() } else { rest }
}

/// `a::{b, c::{d, e}}` → `a::b`, `a::c::d`, `a::c::e`; what it is renamed to is left out.
fn expanded(tree: &str) -> Vec<String> {
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
fn library() -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut files) = (vec![src.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of src") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(&src).expect("below src").to_string_lossy().replace('\\', "/");
            if path.is_dir() && name != "commands" {
                folders.push(path);
            } else if name.ends_with(".rs")
                && !name.ends_with("_tests.rs")
                && name != "main.rs"
                && !is_crate_root(&name)
            {
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
    assert_eq!(order.len(), 3);
    let found = House::new(&library()).against_the_order_in(&["sweep".to_string()], &order);
    assert!(found.is_empty(), "against the order of src/sweep/mod.rs:\n{}", found.join("\n"));
}

#[test]
fn no_files_form_a_circle() {
    let found = House::new(&library()).circles();
    assert!(found.is_empty(), "circles:\n{}", found.join("\n"));
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

/// First lines (counted from 0) of closures whose bodies have more than three lines: such steps deserve names. Relies on the
/// format of `cargo fmt`.
fn long_closures(text: &str) -> Vec<usize> {
    let code = text.split("#[cfg(test)]").next().unwrap_or("");
    let lines: Vec<&str> = code.lines().collect();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let body = |at: usize| {
        lines[at + 1..].iter().take_while(|l| l.is_empty() || indent(l) > indent(lines[at])).count()
    };
    (0..lines.len()).filter(|&at| lines[at].ends_with("| {") && body(at) > 3).collect()
}

#[test]
fn long_steps_have_names() {
    let places = |(path, text): &(String, String)| {
        long_closures(text).into_iter().map(|at| format!("{path}:{}", at + 1)).collect::<Vec<_>>()
    };
    let found: Vec<String> = library().iter().flat_map(places).collect();
    assert!(found.is_empty(), "closures of more than three lines:\n{}", found.join("\n"));
}

/// The planted fault: a body of four lines is seen, one of three is not.
#[test]
fn a_long_closure_is_seen() {
    let closure =
        |lines: usize| format!("fn f() {{\n    g(|x| {{\n{}    }})\n}}\n", "        x;\n".repeat(lines));
    assert_eq!(long_closures(&closure(4)), [1]);
    assert!(long_closures(&closure(3)).is_empty());
}

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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/commands");
    let paths = std::fs::read_dir(folder).expect("commands").map(|entry| entry.expect("an entry").path());
    let text = |path: &Path| std::fs::read_to_string(path).expect("a source file");
    paths
        .map(|path| (format!("commands/{}", path.file_name().expect("a name").display()), text(&path)))
        .collect()
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

/// Parameters of the function whose list begins here, behind its opening parenthesis; `self` counts.
fn parameters(list: &str) -> usize {
    let (mut depth, mut commas, mut blank, mut before) = (0, 0, true, ' ');
    for c in list.chars() {
        match c {
            ')' if depth == 0 => break,
            ',' if depth == 0 => commas += 1,
            '(' | '[' | '<' => depth += 1,
            ')' | ']' => depth -= 1,
            '>' if before != '-' => depth -= 1,
            _ => {}
        }
        blank = c == ',' && depth == 0 || blank && c.is_whitespace();
        before = c;
    }
    commas + usize::from(!blank)
}

/// The parameter list of the function that a line begins, and what follows; generics may stand before it.
fn parameter_list(from: &str) -> Option<&str> {
    let item = without_visibility(from).trim_start_matches("const ").strip_prefix("fn ")?;
    let (mut depth, mut before) = (0, ' ');
    for (at, c) in item.char_indices() {
        match c {
            '(' if depth == 0 => return Some(&item[at + 1..]),
            '<' => depth += 1,
            '>' if before != '-' => depth -= 1,
            _ => {}
        }
        before = c;
    }
    None
}

/// Names and parameters of functions with six or more.
fn wide_functions(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let mut at = 0;
    let lines = code.split_inclusive('\n').map(|line| {
        at += line.len();
        code[at - line.len()..].trim_start_matches(' ')
    });
    let found = lines.filter_map(|from| Some((from.lines().next()?, parameters(parameter_list(from)?))));
    found.filter(|(_, count)| *count > 5).map(|(line, count)| format!("{line} {count}")).collect()
}

/// Kernels and matrices of the wave take what they multiply one by one; everything else is clearer with a type.
#[test]
fn few_functions_have_six_or_more_parameters() {
    let mut files = library();
    files.extend(commands());
    let found: Vec<String> = files.iter().flat_map(|(_, text)| wide_functions(text)).collect();
    assert!(found.len() <= 6, "{}", found.join("\n"));
    let planted = "impl A {\n    pub fn f<T: Fn(u8, u8) -> u8>(\n        &self,\n        a: (B, C),\n        b: D<E, F>,\n";
    let rest =
        ["        c: [u8; 2],\n        d: u8,\n    ) -> u8 {}\n}\n", "        c: u8, d: u8, e: u8) {}\n}\n"];
    assert_eq!(rest.map(|rest| wide_functions(&format!("{planted}{rest}")).len()), [0, 1]);
}

/// Lines that hold code: no comments, no blank ones, and no tests.
fn code_lines(text: &str) -> usize {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().map(str::trim);
    lines.filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// Closures with names, `let name = |…| …`.
fn named_closures(text: &str) -> usize {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let words = code.split_whitespace().collect::<Vec<_>>().join(" ");
    let lets = words.split("let ").filter_map(|rest| rest.split_once(" = "));
    let is_name = |name: &str| name.chars().all(|c| c.is_alphanumeric() || " _".contains(c));
    let closures = lets.filter(|(_, value)| value.trim_start_matches("move ").starts_with('|'));
    closures.filter(|(name, _)| is_name(name)).count()
}

/// A step with a name of its own is clearer as a function; within a chain it needs none.
#[test]
fn few_closures_have_names() {
    let mut files = library();
    files.extend(commands());
    let lines: usize = files.iter().map(|(_, text)| code_lines(text)).sum();
    let named: usize = files.iter().map(|(_, text)| named_closures(text)).sum();
    assert!(1000 * named <= NAMED_CLOSURES * lines, "{named} named closures in {lines} lines");
    let planted = "fn f() {\n    let f = |x| x;\n    let mut g =\n        move |x| x;\n    let z = a | b;\n";
    assert_eq!([named_closures(planted), code_lines(planted)], [2, 5]);
}

/// Most named closures in a thousand lines.
const NAMED_CLOSURES: usize = 19;
