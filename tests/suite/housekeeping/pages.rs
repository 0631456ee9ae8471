//! Generated pages are as they were generated, and links lead somewhere.

use super::{read, root};
use inkwave::draw::seal;
use inkwave::store::identity::METHOD_VERSION;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

#[test]
fn generated_pages_are_as_they_were_generated() {
    for page in [
        "reports/latest/report.md",
        "reports/latest/mutations.md",
        "reports/benchmarks/README.md",
        "reports/comparison/README.md",
    ] {
        seal::check(&read(page)).unwrap_or_else(|broken| panic!("{page}: {broken}"));
    }
}

/// Pages whose numbers may be older than the method, and why they are not made anew with it.
const OLDER: [(&str, &str); 11] = [
    ("reports/benchmarks", "costs alone, which methods 7 to 18 leave alone"),
    (
        "reports/comparison",
        "single cells of the requested volume fraction, which methods 2, 3 and 6 to 18 leave alone",
    ),
    (
        "reports/latest",
        "the night of method 16: 17 changed absorbing layers of composed stacks, 18 light at 0° of composed layers in small cells",
    ),
    ("reports/peers", "layers solved at once, which methods 8 to 18 leave alone"),
    (
        "reports/paper-study",
        "totals and colours of single layers under a whole sky, which methods 10 to 18 leave alone",
    ),
    (
        "reports/inverse",
        "three hours of a core; its one uneven case is of the coarser mean before method 12, unmeasured since",
    ),
    ("reports/print", "solids of single layers, which methods 15 to 18 leave alone"),
    ("reports/speed", "costs of layers solved at once, which methods 10 to 18 leave alone"),
    ("reports/white-paint", "pages of composed layers leave the method to results.json"),
    ("reports/scalar-against-vector", "half an hour of processor time"),
    ("reports/measured", "measurements beside formulas, without a solve"),
];

/// Pages (HTML and Markdown) in a folder and below.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let is_page = |path: &PathBuf| path.extension().is_some_and(|e| e == "md" || e == "html");
    let found = entries.flat_map(|path| if path.is_dir() { pages(&path) } else { vec![path] });
    found.filter(is_page).collect()
}

/// Every committed page says by which method its numbers were made, and those of another one are named above. A page that is
/// made anew is taken off the list. *Planted*: a version counted up, or a page without one.
#[test]
fn committed_pages_are_no_older_than_their_method() {
    let mut excused = BTreeSet::new();
    for page in pages(&root().join("reports")) {
        let name = page.strip_prefix(root()).expect("below the root").to_owned();
        if seal::method_of(&read(&page)) == Some(METHOD_VERSION) {
            continue;
        }
        let excuse = OLDER.iter().find(|(place, _)| name.starts_with(place)).map(|(place, _)| *place);
        excused.insert(excuse.unwrap_or_else(|| {
            panic!("{} is older than method {METHOD_VERSION}: make it anew with its script, or say in OLDER why not", name.display())
        }));
    }
    let all: BTreeSet<&str> = OLDER.iter().map(|(place, _)| *place).collect();
    assert_eq!(all, excused, "a page of the list was made anew, or is not there");
}

/// The accuracy stated is that of the reference cases in the report beside it.
#[test]
fn the_accuracy_in_the_tables_is_that_of_the_references() {
    let readme = read("reports/latest/README.md");
    let report = read("reports/latest/report.md");
    let table =
        readme.split("<!-- accuracy -->\n").nth(1).and_then(|rest| rest.split("<!-- /accuracy -->").next());
    let table = table.expect("a table between its marks").trim_end();
    let claim = report.split("\n## ").find(|section| section.starts_with("08-references")).expect("claim 8");
    assert!(table.lines().count() > 2 && claim.contains(table), "not the table of claim 8:\n{table}");
}

/// The tables of cost are those of `reports/speed`, README's summary is that of the tables.
#[test]
fn the_costs_in_the_readme_are_those_measured() {
    let checked =
        Command::new("python3").current_dir(root()).args(["scripts/readme-tables", "--check"]).output();
    let checked = checked.expect("python3");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

/// The schedule renews the page outside of the clone; what is committed says how old it is.
#[test]
fn the_readme_says_how_old_the_benchmarks_are() {
    let readme = read("README.md");
    let page = read("reports/benchmarks/README.md");
    let told = readme.split("](reports/benchmarks/README.md) of ").nth(1).and_then(|rest| rest.get(..10));
    let day = told.expect("a date beside the link");
    assert!(page.contains(&format!("{day}T")), "the page is not of {day}");
}

/// The page of planted faults names commits of this repository, or says that it has none.
#[test]
fn commits_that_pages_name_are_in_the_repository() {
    let git = |arguments: &[&str]| Command::new("git").current_dir(root()).args(arguments).output();
    let Ok(shallow) = git(&["rev-parse", "--is-shallow-repository"]) else { return };
    if String::from_utf8_lossy(&shallow.stdout).trim() != "false" {
        return;
    }
    let mut table = csv::Reader::from_path(root().join("reports/latest/mutations.csv")).expect("a table");
    for row in table.records() {
        let commit = row.expect("a row").get(3).expect("a commit").to_owned();
        let known =
            || git(&["cat-file", "-e", &format!("{commit}^{{commit}}")]).is_ok_and(|o| o.status.success());
        assert!(commit == "not in this repository" || known(), "{commit}");
    }
}

/// Files in a folder and below, by their paths from `root`, with `/` between the parts.
fn files_below(folder: &Path, root: &Path) -> BTreeSet<String> {
    let mut files = BTreeSet::new();
    for path in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() {
            files.extend(files_below(&path, root));
        } else {
            let parts = path.strip_prefix(root).expect("below the root").iter();
            files.insert(parts.map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"));
        }
    }
    files
}

/// Files that the lines of an index name, a table row each, in order: `| [name](name) | what it shows |`.
fn indexed(page: &str) -> Vec<String> {
    let rows = page.lines().filter_map(|line| line.strip_prefix("| [")?.split_once("]("));
    rows.map(|(name, rest)| {
        assert!(rest.starts_with(&format!("{name}) | ")), "{name} leads to {rest}");
        name.to_owned()
    })
    .collect()
}

/// The index of the examples has one line for every file, and none for a file that is gone. *Planted*: a file without a
/// line, a line without a file, a file named twice.
#[test]
fn every_example_has_its_line_in_the_index() {
    let examples = root().join("examples");
    let mut files = files_below(&examples, &examples);
    files.remove("README.md");
    let lines = indexed(&read("examples/README.md"));
    let named: BTreeSet<String> = lines.iter().cloned().collect();
    assert_eq!(named, files, "lines of examples/README.md (left) and files of examples (right)");
    assert_eq!(named.len(), lines.len(), "a file is named twice in {lines:?}");
}

/// Links of README, of the examples' index and of CONTRIBUTING lead to files of the repository. *Planted*: a link to a
/// page that is gone.
#[test]
fn links_of_the_readme_lead_somewhere() {
    for page in ["README.md", "examples/README.md", "CONTRIBUTING.md"] {
        let text = read(page);
        let folder = root().join(page).parent().expect("a folder").to_owned();
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        let lost: Vec<&str> = targets.filter(|target| !folder.join(target).exists()).collect();
        assert!(lost.is_empty(), "{page} links to what is not there: {lost:?}");
    }
}
