//! Damage to what is stored: it counts as absent, is said, heals, and no published file differs.

use crate::sweep_support::{Place, TINY as SWEEP, inkwave, results, said, succeed};
use inkwave::run::resolve::Resolved;
use inkwave::store::{PackingRecord, PointRecord, Record, Store};
use std::path::{Path, PathBuf};

const RECORDS: &str = "records/1.sqlite";

/// Everything published of a study, without what tells of time and files.
fn published(out: &Path) -> Vec<(String, Vec<u8>)> {
    let timeless = |text: String| -> Vec<u8> {
        let line = |l: &&str| {
            !["solve_seconds", "process_seconds", "time in solves"].iter().any(|word| l.contains(word))
        };
        text.lines().filter(line).collect::<Vec<_>>().join("\n").into_bytes()
    };
    let read = |name: &str| {
        let bytes = std::fs::read(out.join(name)).unwrap();
        let text = name.ends_with(".json") || name.ends_with(".html");
        (name.to_owned(), if text { timeless(String::from_utf8(bytes).unwrap()) } else { bytes })
    };
    let names =
        ["results.json", "report.html", "spectra.csv", "bdf.csv", "picture.png", "picture-with-axes.png"];
    names.map(read).to_vec()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &target),
            false => std::fs::copy(entry.path(), target).map(drop).unwrap(),
        }
    }
}

/// A finished study, and copies of it to be damaged.
struct Finished {
    folder: tempfile::TempDir,
    study: PathBuf,
}

impl Finished {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let study = crate::run_support::study(folder.path(), crate::run_support::TINY);
        crate::run_support::succeed(&study, &folder.path().join("whole"), &[]);
        Self { folder, study }
    }

    fn whole(&self) -> PathBuf {
        self.folder.path().join("whole")
    }

    /// Damages a copy and runs the study there; the outcome must be as before, the damage said, and gone afterwards.
    fn heals(&self, name: &str, damage: impl Fn(&Path)) {
        let out = self.folder.path().join("damaged");
        copy(&self.whole(), &out);
        damage(&out);
        let told = crate::run_support::succeed(&self.study, &out, &[]);
        assert!(told.contains("of the store damaged"), "{name}: {told}");
        for (whole, healed) in published(&self.whole()).iter().zip(&published(&out)) {
            assert!(whole == healed, "{name}: {} differs", whole.0);
        }
        let again = crate::run_support::succeed(&self.study, &out, &[]);
        assert!(!again.contains("damaged") && again.contains("24 of 24 solves"), "{name}: {again}");
        std::fs::remove_dir_all(out).unwrap();
    }

    fn sql(&self, name: &str, sql: &str) {
        self.heals(name, |out| {
            let changed = rusqlite::Connection::open(out.join(RECORDS)).unwrap().execute_batch(sql);
            changed.unwrap_or_else(|error| panic!("{name}: {error}"));
        });
    }

    /// Changes the bytes of the records' file.
    fn bytes(&self, name: &str, change: impl Fn(&mut Vec<u8>)) {
        self.heals(name, |out| {
            let mut bytes = std::fs::read(out.join(RECORDS)).unwrap();
            change(&mut bytes);
            std::fs::write(out.join(RECORDS), bytes).unwrap();
        });
    }
}

#[test]
fn digits_changed_in_any_record_are_found_and_computed_again() {
    let finished = Finished::new();
    for kind in [PointRecord::KIND, PackingRecord::KIND, Resolved::KIND] {
        // A byte at a tenth, the middle and the end of one record: numbers of eight bytes fill most of it.
        for place in ["length(content) / 10", "length(content) / 2", "length(content) - 1"] {
            let head = format!("substr(content, 1, {place})");
            let flipped =
                format!("case substr(content, {place} + 1, 1) when x'3f' then x'40' else x'3f' end");
            let tail = format!("substr(content, {place} + 2)");
            let one = format!("(select min(key) from records where kind = '{kind}')");
            let content = format!("cast({head} || {flipped} || {tail} as blob)");
            let sql = format!("update records set content = {content} where kind = '{kind}' and key = {one}");
            finished.sql(&format!("{kind}, byte {place}"), &sql);
        }
    }
    finished.sql("all at once", "update records set content = cast(content || x'00' as blob)");
}

#[test]
fn swapped_renamed_and_outdated_records_are_found_and_computed_again() {
    let finished = Finished::new();
    for kind in [PointRecord::KIND, PackingRecord::KIND] {
        let ends = format!("(select min(key) as a, max(key) as b from records where kind = '{kind}')");
        // Two names change places: a → x, b → a, x → b.
        let names = format!(
            "create temp table names as select a, b from {ends};
             update records set key = 'x' where kind = '{kind}' and key = (select a from names);
             update records set key = (select a from names) where kind = '{kind}' and key = (select b from names);
             update records set key = (select b from names) where kind = '{kind}' and key = 'x';"
        );
        finished.sql(&format!("two of {kind}"), &names);
    }
    finished.sql("a point under a packing's name", "update records set content = (select content from records where kind = 'point' limit 1) where kind = 'packing'");
    finished.sql("another method", "update records set method = method + 1 where kind = 'point'");
    finished.sql("another program", "update records set program = 'inkwave 9.9' where kind = 'grid'");
}

#[test]
fn files_cut_short_overwritten_or_no_databases_are_put_aside_and_what_is_sound_is_saved() {
    let finished = Finished::new();
    let length = std::fs::metadata(finished.whole().join(RECORDS)).unwrap().len() as usize;
    for part in [100, length / 3, length - 4096] {
        finished.bytes(&format!("cut to {part}"), |bytes| bytes.truncate(part));
    }
    finished.bytes("no database", |bytes| bytes.fill(b'x'));
    for page in (0..length / 4096).step_by(7) {
        let inside = page * 4096 + 100;
        finished.bytes(&format!("page {page}"), |bytes| bytes[inside..inside + 2000].fill(0xa5));
    }
}

#[test]
fn results_say_when_builds_are_mixed() {
    let finished = Finished::new();
    let store: Store<PointRecord> = Store::open(finished.whole()).unwrap();
    let key = store.database().keys(PointRecord::KIND).pop_first().unwrap();
    let builds = || {
        crate::run_support::succeed(&finished.study, &finished.whole(), &[]);
        let results = std::fs::read(finished.whole().join("results.json")).unwrap();
        let results: serde_json::Value = serde_json::from_slice(&results).unwrap();
        results["builds"].as_array().unwrap().len()
    };
    assert_eq!(builds(), 1);
    let record = store.get(&key).unwrap();
    store.put(&key, &PointRecord { build: "inkwave 0.0.9 (abc)".into(), ..record }).unwrap();
    drop(store);
    assert_eq!(builds(), 2);
    let page = std::fs::read_to_string(finished.whole().join("report.html")).unwrap();
    assert!(page.contains("different builds") && page.contains("inkwave 0.0.9 (abc)"));
}

#[test]
fn a_merge_takes_the_sound_copy_and_names_the_point_of_a_contradiction() {
    let place = Place::new(SWEEP);
    place.sweep("local", &[]);
    place.sweep("one", &["--shard", "1/2"]);
    place.sweep("two", &["--shard", "2/2"]);
    copy(Path::new(&place.path("one")), Path::new(&place.path("copy")));
    let damage = "update records set content = x'00' where key in (select key from records where kind = 'point' limit 3)";
    rusqlite::Connection::open(place.path("one/records/1.sqlite")).unwrap().execute_batch(damage).unwrap();
    let merge = |shards: &[&str], output: &str| {
        let shards: Vec<String> = shards.iter().map(|name| place.path(name)).collect();
        let shards = shards.iter().map(String::as_str);
        let first = ["merge"].into_iter();
        let output = place.path(output);
        let arguments: Vec<&str> = first.chain(shards).chain(["--output", &output]).collect();
        inkwave(&arguments).output().unwrap()
    };
    let alone = merge(&["one", "two"], "partly");
    assert!(
        !alone.status.success() && said(&alone).contains("3 records of the store damaged"),
        "{}",
        said(&alone)
    );
    let healed = merge(&["one", "copy", "two"], "merged");
    assert!(healed.status.success(), "{}", said(&healed));
    assert!(said(&healed).contains("3 damaged records were replaced by intact copies"), "{}", said(&healed));
    for (local, merged) in results(&place.path("local")).iter().zip(&results(&place.path("merged"))) {
        assert!(local == merged, "{} differs", local.0.display());
    }

    let store: Store<PointRecord> = Store::open(place.path("copy")).unwrap();
    let key = store.database().keys(PointRecord::KIND).pop_last().unwrap();
    let record = store.get(&key).unwrap();
    store.put(&key, &PointRecord { reflectance: record.reflectance + 1e-15, ..record }).unwrap();
    drop(store);
    let told = said(&merge(&["one", "copy", "two"], "refused"));
    for word in ["realisation", "nm", "°", &key, "inkwave"] {
        assert!(told.contains(word), "no {word} in {told}");
    }
}

#[test]
fn folders_of_others_are_refused_before_anything_is_computed() {
    let folder = tempfile::tempdir().unwrap();
    let thesis = folder.path().join("thesis");
    std::fs::create_dir_all(thesis.join("points")).unwrap();
    std::fs::write(thesis.join("comparison.md"), "mine").unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let example = |name: &str| root.join("examples").join(name).display().to_string();
    let refused = |command: &str, file: &str, output: &Path, word: &str| {
        let output =
            inkwave(&[command, &example(file), "--output", &output.display().to_string()]).output().unwrap();
        // The terminal's frame breaks lines where the path is long.
        let told = said(&output).replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(output.status.code() == Some(1) && told.contains(word), "{command}: {}", said(&output));
    };
    for (command, file) in [
        ("compare", "compare-ink.toml"),
        ("pack", "pack-mixture.toml"),
        ("run", "yellow.toml"),
        ("sweep", "paper-study-small.toml"),
    ] {
        refused(command, file, &thesis, "no results of inkwave");
        refused(command, file, &thesis.join("comparison.md/below"), "cannot write");
    }
    assert_eq!(std::fs::read_to_string(thesis.join("comparison.md")).unwrap(), "mine");
    assert_eq!(std::fs::read_dir(&thesis).unwrap().count(), 2);
    let study = crate::run_support::study(folder.path(), crate::run_support::TINY);
    crate::run_support::succeed(&study, &folder.path().join("study"), &[]);
    refused("compare", "compare-ink.toml", &folder.path().join("study"), "holds a study");
}

#[test]
fn a_plan_of_a_study_counts_its_solves_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let study = crate::run_support::study(folder.path(), crate::run_support::TINY);
    let told = succeed(&["run", &study.display().to_string(), "--plan"]);
    let solves = told.lines().find(|line| line.starts_with("solves")).unwrap_or_else(|| panic!("{told}"));
    assert!(solves.ends_with(" 24") && told.contains("memory") && told.contains("time"), "{told}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
