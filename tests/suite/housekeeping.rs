//! What the repository says about itself: generated pages are as they were generated, versions agree, schedules run.

use inkwave::draw::seal;
use inkwave::store::identity::METHOD_VERSION;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(root().join(path)).expect("a file of the repository")
}

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
const OLDER: [(&str, &str); 10] = [
    ("reports/benchmarks", "costs alone, which methods 7 to 10 leave alone"),
    (
        "reports/comparison",
        "single cells of the requested volume fraction, which methods 2, 3 and 6 to 10 leave alone",
    ),
    ("reports/peers", "layers solved at once, which methods 8 to 10 leave alone"),
    (
        "reports/latest",
        "the last night is of method 9; method 10 changes claim 26 alone, whose chapter is to be made anew",
    ),
    ("reports/paper-study", "totals and colours of shifted wavelengths, which method 10 leaves alone"),
    ("reports/inverse", "three hours of a core; layers of 15 and 30 %, which method 9 packs as before"),
    ("reports/speed", "costs of layers solved at once, which method 10 leaves alone"),
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

/// A home without rustup and a cargo that only notes how it is called.
struct Home(tempfile::TempDir);

impl Home {
    fn new() -> Home {
        let home = Home(tempfile::tempdir().expect("a folder"));
        std::fs::create_dir(home.path("bin")).expect("a folder");
        let cargo = home.path("bin/cargo");
        std::fs::write(&cargo, "#!/bin/sh\necho \"$@\" >> \"$HOME/calls\"\n").expect("a file");
        let executable = Command::new("chmod").arg("+x").arg(&cargo).status().expect("chmod");
        assert!(executable.success());
        home
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn night(&self, nights: Option<&Path>, arguments: &[&str], bin: &str) -> std::process::Output {
        let mut night = Command::new(root().join("scripts/schedule/night"));
        night.args(arguments).env_clear().env("HOME", self.0.path());
        night.env("PATH", format!("{bin}:/usr/bin:/bin"));
        nights.iter().for_each(|folder| _ = night.env("INKWAVE_NIGHTS", folder));
        night.output().expect("the script starts")
    }

    fn bin(&self) -> String {
        self.path("bin").display().to_string()
    }
}

#[cfg(target_os = "linux")]
#[test]
fn scheduled_nights_write_outside_of_the_clone() {
    let home = Home::new();
    let done = home.night(None, &[], &home.bin());
    assert!(done.status.success(), "{done:?}");
    let calls = std::fs::read_to_string(home.path("calls")).expect("cargo was called");
    let nights = home.path("inkwave-nights").display().to_string();
    assert!(calls.contains(&format!("--out {nights}/latest")), "{calls}");
    assert!(
        calls.contains(&format!("--history {nights}/history.csv")) && !calls.contains("--readme"),
        "{calls}"
    );
    assert!(home.path("inkwave-nights/log").exists() && home.path("inkwave-nights/history.csv").exists());

    let inside = home.night(Some(&root().join("target/nights")), &[], &home.bin());
    let said = String::from_utf8_lossy(&inside.stderr).into_owned();
    assert!(!inside.status.success() && said.contains("outside"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_failed_night_says_so_in_one_line_on_standard_error() {
    use std::os::unix::fs::PermissionsExt;
    let home = Home::new();
    assert!(home.night(None, &[], &home.bin()).stderr.is_empty(), "a good night mails nothing");
    let cargo = home.path("bin/cargo");
    std::fs::write(&cargo, "#!/bin/sh\necho much to say\nexit 3\n").expect("a script");
    std::fs::set_permissions(&cargo, std::fs::Permissions::from_mode(0o755)).expect("made executable");
    for arguments in [&[][..], &["benchmarks"], &["nonsense"]] {
        let done = home.night(None, arguments, &home.bin());
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && said.lines().count() == 1, "{arguments:?}: {said}");
        assert!(said.contains("failed with status") && said.contains("log"), "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_schedule_without_cargo_says_so() {
    if Path::new("/usr/bin/cargo").exists() || Path::new("/usr/local/bin/cargo").exists() {
        return;
    }
    let home = Home::new();
    let done = home.night(None, &[], "/nowhere");
    let log = std::fs::read_to_string(home.path("inkwave-nights/log")).expect("a log");
    assert!(done.status.code() == Some(127) && log.contains("cargo is not found"), "{log}");
}

/// The checks of dependencies run where their tools and databases are, and say what they skip. *Planted*: a tool that is there and not
/// called; a failure of one that passes for a skip.
#[cfg(target_os = "linux")]
#[test]
fn checks_of_dependencies_run_or_say_that_they_are_skipped() {
    let home = Home::new();
    let check = |cargo: &str| {
        std::fs::write(
            home.path("bin/cargo"),
            format!("#!/bin/sh\necho \"$@\" >> \"$HOME/calls\"\n{cargo}\n"),
        )
        .expect("a script");
        std::fs::write(home.path("calls"), "").expect("a file");
        let mut check = Command::new(root().join("scripts/check-dependencies"));
        check.env_clear().env("HOME", home.0.path()).env("PATH", format!("{}:/usr/bin:/bin", home.bin()));
        let done = check.output().expect("the script starts");
        let calls = std::fs::read_to_string(home.path("calls")).expect("calls");
        (done.status.success(), String::from_utf8_lossy(&done.stdout).into_owned(), calls)
    };
    let (passed, said, _) = check("exit 101");
    assert!(
        passed && said.contains("cargo deny (not installed)") && said.contains("cargo audit (not installed)")
    );

    let (passed, said, calls) = check("exit 0");
    assert!(passed && said.matches("(no database in").count() == 2, "{said}");
    assert!(calls.contains("check licenses bans sources") && !calls.contains("advisories"), "{calls}");

    for database in ["advisory-dbs", "advisory-db"] {
        std::fs::create_dir_all(home.path(".cargo").join(database)).expect("a folder");
    }
    let (passed, said, calls) = check("exit 0");
    assert!(
        passed && said.is_empty() && calls.contains("advisories") && calls.contains("audit --no-fetch"),
        "{said} {calls}"
    );
    let (passed, said, _) = check("case \"$*\" in *advisories*) exit 1;; esac");
    assert!(!passed, "an advisory is no reason to go on: {said}");
}
