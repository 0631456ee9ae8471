//! `scripts/merge-comparisons`: comparisons of several machines, and folders that are none.

use std::path::Path;
use std::process::Command;

const MACHINE: &str = r#"{ "processor": "one", "threads": 2, "transforms_per_second": { "value": 100.0, "standard_error": 2.0 } }"#;
const TABLE: &str = "case,strategy,error,processor_seconds\nfilm,krylov,1e-4,0.5\nfilm,born,,\n";

/// A folder as `inkwave compare` writes it.
fn comparison(root: &Path, name: &str, machine: &[u8], table: &[u8]) {
    let folder = root.join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("machine.json"), machine).expect("written");
    std::fs::write(folder.join("comparison.csv"), table).expect("written");
}

/// What the script says, and whether it succeeds.
fn merged(root: &Path, folders: &[&str], output: &str) -> (bool, String) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/merge-comparisons");
    let mut command = Command::new("python3");
    let done = command.arg(script).args(folders).args(["-o", output]).current_dir(root).output();
    let done = done.expect("python3");
    (done.status.success(), String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn costs_of_several_machines_are_in_transforms_of_each() {
    let root = tempfile::tempdir().expect("a folder");
    comparison(root.path(), "one", MACHINE.as_bytes(), TABLE.as_bytes());
    let slower = MACHINE.replace("\"one\"", "\"a | b\"").replace("100.0", "50.0");
    // a version whose tables have a column more
    let wider = TABLE.replace("processor_seconds\n", "processor_seconds,bytes\n").replace("0.5\n", "0.5,7\n");
    let wider = wider.replace("born,,\n", "born,,,8\n");
    comparison(root.path(), "two", slower.as_bytes(), wider.as_bytes());
    assert_eq!(merged(root.path(), &["one", "two"], "out"), (true, String::new()));
    let page = std::fs::read_to_string(root.path().join("out/README.md")).expect("the page");
    // 0.5 s × 100 /s and × 50 /s; 1e-4 is reached by all targets
    assert!(page.contains("| film | krylov | one | 50 | 50 | 50 | 2.0 % |"), "{page}");
    assert!(page.contains(r"| film | krylov | a \| b | 25 | 25 | 25 | 4.0 % |"), "{page}");
    let table = std::fs::read_to_string(root.path().join("out/comparison.csv")).expect("the table");
    assert!(table.starts_with("case,strategy,error,processor_seconds,bytes,machine,"), "{table}");
}

/// *Planted*: a column, a key or a number taken for granted, which ends in a traceback.
#[test]
fn folders_that_are_no_comparisons_are_named_with_a_remedy() {
    let rate = |value: &str| MACHINE.replace("100.0", value).into_bytes();
    let table = |from: &str, to: &str| TABLE.replace(from, to).into_bytes();
    for (machine, table, words) in [
        (b"[]".to_vec(), TABLE.into(), ["machine.json", "processor"]),
        (b"{".to_vec(), TABLE.into(), ["machine.json", "give folders of"]),
        (b"{}".to_vec(), TABLE.into(), ["machine.json", "run the comparison again"]),
        (b"\xff\xfe".to_vec(), TABLE.into(), ["machine.json", "give folders of"]),
        ("[".repeat(100_000).into_bytes(), TABLE.into(), ["machine.json", "give folders of"]),
        (rate("0"), TABLE.into(), ["transforms_per_second", "above 0"]),
        (rate("NaN"), TABLE.into(), ["transforms_per_second", "above 0"]),
        (rate("\"fast\""), TABLE.into(), ["transforms_per_second", "above 0"]),
        (br#"{"processor": "one", "transforms_per_second": null}"#.into(), TABLE.into(), ["clock", "leave"]),
        (br#"{"processor": "one", "transforms_per_second": 3}"#.into(), TABLE.into(), ["is 3", "above 0"]),
        (MACHINE.into(), table("processor_seconds", "time"), ["comparison.csv", "'processor_seconds'"]),
        (MACHINE.into(), table("strategy", "name"), ["comparison.csv", "'strategy'"]),
        (MACHINE.into(), table("0.5", "half"), ["row 2", "processor_seconds is 'half'"]),
        (MACHINE.into(), table("1e-4", "nan"), ["row 2", "error is 'nan'"]),
        (MACHINE.into(), table("0.5", "0.5,7"), ["row 2", "another number of cells"]),
        (MACHINE.into(), table("1e-4,0.5", "1e-4"), ["row 2", "another number of cells"]),
        (MACHINE.into(), b"\xff\xfe,\0".to_vec(), ["comparison.csv", "give folders of"]),
        (MACHINE.into(), Vec::new(), ["comparison.csv", "'case'"]),
        (MACHINE.into(), table("film,krylov,1e-4,0.5\nfilm,born,,\n", ""), ["no rows", "again"]),
    ] {
        let root = tempfile::tempdir().expect("a folder");
        comparison(root.path(), "one", &machine, &table);
        refused(root.path(), &["one"], "out", &words);
    }
    let root = tempfile::tempdir().expect("a folder");
    comparison(root.path(), "one", MACHINE.as_bytes(), TABLE.as_bytes());
    std::fs::write(root.path().join("file"), "").expect("written");
    refused(root.path(), &["none"], "out", &["none/machine.json", "give folders of"]);
    refused(root.path(), &["one"], "one", &["would replace", "another folder"]);
    refused(root.path(), &["one", "./one"], "out", &["given twice", "counts once"]);
    refused(root.path(), &["one"], "file", &["file", "another folder"]);
    let kept = std::fs::read_to_string(root.path().join("one/comparison.csv")).expect("the table");
    assert_eq!(kept, TABLE);
}

fn refused(root: &Path, folders: &[&str], output: &str, words: &[&str]) {
    let (success, said) = merged(root, folders, output);
    assert!(!success && !said.contains("Traceback"), "{said}");
    words.iter().for_each(|word| assert!(said.contains(word), "{word:?} is missing: {said}"));
    assert!(!root.join("out").exists(), "a refusal writes nothing");
}
