//! Habits of the code that a reader relies on: short steps, one meaning for each name, few parameters.

use super::house::{library, without_visibility};
use std::collections::BTreeMap;
use std::path::Path;

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
