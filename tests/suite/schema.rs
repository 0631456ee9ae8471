//! The schemas say what the readers say: examples and reference cases fit, slips do not, and a value that the schema refuses is
//! refused by the program, wherever it stands.

mod agreement;

use inkwave::design::file::DesignFile;
use inkwave::fit::file::FitFile;
use inkwave::input::case::Case;
use inkwave::input::case_inputs::CaseInputs;
use inkwave::input::check::{check, check_packing};
use inkwave::input::fault::Fault;
use inkwave::input::file::StudyFile;
use inkwave::input::read::read;
use inkwave::input::tree::{Node, parse_toml};
use inkwave::schema::Document;
use inkwave::solve::Registry;
use inkwave::sweep::file::SweepFile;
use inkwave::sweep::load::load;
use inkwave_bench::experiment::ComparisonFile;
use jsonschema::Validator;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// All kinds of input files.
const ALL: [Document; 6] =
    [Document::Study, Document::Sweep, Document::Compare, Document::Fit, Document::Design, Document::Case];

/// The name of a kind on the command line and of its file in `schema/`.
fn name(document: Document) -> String {
    format!("{document:?}").to_lowercase()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The validator of an input file, made once.
fn validator(document: Document) -> &'static Validator {
    static VALIDATORS: LazyLock<[Validator; ALL.len()]> = LazyLock::new(|| {
        ALL.map(|document| jsonschema::validator_for(&document.schema()).expect("a schema of draft 7"))
    });
    &VALIDATORS[ALL.iter().position(|kind| *kind == document).expect("an input file")]
}

/// Every TOML file of `examples`, with the kind that its first line names.
fn examples() -> Vec<(PathBuf, Document, Value)> {
    let files = std::fs::read_dir(root().join("examples")).expect("examples");
    let files = files.map(|entry| entry.expect("an entry").path());
    files.filter(|path| path.extension().is_some_and(|e| e == "toml")).map(example).collect()
}

fn example(path: PathBuf) -> (PathBuf, Document, Value) {
    let text = std::fs::read_to_string(&path).expect("readable");
    let line = text.lines().find(|line| line.starts_with("#:schema")).expect("a line #:schema");
    let kind = |kind: &Document| line == format!("#:schema ../schema/{}.json", name(*kind));
    let document = ALL.into_iter().find(kind).expect("a known schema");
    let value = as_json(&text);
    (path, document, value)
}

fn as_json(text: &str) -> Value {
    serde_json::to_value(parse_toml(text).expect("TOML")).expect("no dates and no NaN")
}

fn reference_cases() -> Vec<Value> {
    let text = std::fs::read_to_string(root().join("validation/data/waves.json")).expect("readable");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    file["cases"].as_array().expect("cases").iter().map(|case| case["inputs"].clone()).collect()
}

/// Whether the keys and the kinds of values are those of the types; ranges are judged later.
fn is_read(document: Document, value: &Value) -> bool {
    let node = || Node::deserialize(value).expect("a node");
    match document {
        Document::Study => read::<StudyFile>(node()).is_ok(),
        Document::Sweep => read::<SweepFile>(node()).is_ok(),
        Document::Compare => read::<ComparisonFile>(node()).is_ok(),
        Document::Fit => read::<FitFile>(node()).is_ok(),
        Document::Design => read::<DesignFile>(node()).is_ok(),
        Document::Case => read::<CaseInputs>(node().get("inputs").cloned().unwrap_or(node())).is_ok(),
        Document::External | Document::Columns | Document::Library | Document::Composition => {
            unreachable!("no input file here")
        }
    }
}

/// What the program finds wrong with a study that is run.
fn faults(value: &Value) -> Vec<Fault> {
    let file: StudyFile = match read(Node::deserialize(value).expect("a node")) {
        Ok(file) => file,
        Err(faults) => return faults,
    };
    let judge = if file.layer.walls { check } else { check_packing };
    judge(&file, &root().join("examples"), "study").err().unwrap_or_default()
}

fn refused(document: Document, value: &Value) -> bool {
    match document {
        Document::Study => !faults(value).is_empty(),
        Document::Case => !is_read(document, value) || Case::parse(&value.to_string(), false).is_err(),
        Document::Sweep => !is_read(document, value) || !in_a_file(value, |path| load(path).is_ok()),
        Document::Compare => !is_read(document, value) || !in_a_file(value, is_planned),
        Document::Fit => {
            !is_read(document, value) || !in_a_file(value, |path| inkwave::fit::load::load(path).is_ok())
        }
        Document::Design => {
            let loads = |path: &Path| inkwave::design::recipe::load(path).is_ok();
            !is_read(document, value) || !in_a_file(value, loads)
        }
        Document::External | Document::Columns | Document::Library | Document::Composition => {
            unreachable!("no input file here")
        }
    }
}

fn is_planned(path: &Path) -> bool {
    ComparisonFile::read(path).is_ok_and(|file| file.plan(&Registry::default()).is_ok())
}

/// What `judge` finds of a document in a file, beside the study that examples name.
fn in_a_file(document: &Value, judge: impl Fn(&Path) -> bool) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let base = root().join("examples/yellow.toml");
    std::fs::copy(base, folder.path().join("yellow.toml")).expect("copied");
    for file in ["fit/drawdown.toml", "fit/white.csv", "fit/black.csv", "design/ink.toml"] {
        let from = root().join("examples").join(file);
        std::fs::copy(&from, folder.path().join(from.file_name().expect("a name"))).expect("copied");
    }
    let path = folder.path().join("document.toml");
    std::fs::write(&path, toml::to_string(document).expect("TOML")).expect("written");
    judge(&path)
}

#[test]
fn the_committed_schemas_are_what_the_program_prints() {
    for document in ALL.into_iter().chain([Document::Library, Document::Composition]) {
        let name = name(document);
        let text = std::fs::read_to_string(root().join(format!("schema/{name}.json"))).expect("committed");
        let committed: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(committed, document.schema(), "inkwave schema {name} > schema/{name}.json");
    }
}

/// The committed dictionary is the program's, and knows every column of the committed comparisons. *Planted*: a column added to
/// a comparison and not to the list.
#[test]
fn the_committed_dictionary_of_columns_is_what_the_program_prints() {
    let text = std::fs::read_to_string(root().join("schema/columns.json")).expect("committed");
    let committed: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(committed, Document::Columns.schema(), "inkwave schema columns > schema/columns.json");
    for folder in ["reports/comparison", "reports/peers"] {
        let table = csv::Reader::from_path(root().join(folder).join("comparison.csv"));
        for name in table.expect("a table").headers().expect("a header") {
            assert!(inkwave::report::columns::column("comparison.csv", name).is_some(), "{folder}: {name}");
        }
    }
}

/// Every key of a schema occurs in the commented file of its kind, written or behind a `#`, and the file is good as it stands.
#[test]
fn files_with_every_key_name_every_key() {
    for document in ALL {
        let missing = keys_missing_in(document.every_key(), document);
        assert!(missing.is_empty(), "{document:?}: {missing:?}");
        assert!(!refused(document, &as_json(document.every_key())), "{document:?}");
    }
    assert_eq!(faults(&as_json(Document::Study.every_key())), []);
    // The planted fault: a key without a description.
    let without = Document::Study.every_key().replace("per_realisation", "…");
    assert_eq!(keys_missing_in(&without, Document::Study), ["per_realisation"]);
}

/// Keys of the schema that the text does not set, neither in a line nor in a table within one. A study within another file is
/// written out in its own.
fn keys_missing_in(text: &str, document: Document) -> Vec<String> {
    let mut keys = BTreeSet::new();
    all_keys(&document.schema(), &mut keys);
    if document != Document::Study {
        let mut study = BTreeSet::new();
        all_keys(&Document::Study.schema(), &mut study);
        keys.retain(|key| key != "inputs" && (document == Document::Case || !study.contains(key)));
    }
    let words: BTreeSet<&str> = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
    keys.into_iter().filter(|key| !words.contains(key.as_str())).collect()
}

fn all_keys(schema: &Value, keys: &mut BTreeSet<String>) {
    match schema {
        Value::Object(table) => {
            let own = table.get("properties").and_then(Value::as_object).into_iter().flatten();
            keys.extend(own.map(|(key, _)| key.clone()));
            table.values().for_each(|value| all_keys(value, keys));
        }
        Value::Array(items) => items.iter().for_each(|value| all_keys(value, keys)),
        _ => {}
    }
}

/// A key behind a `#` is good as it stands there: written into its table, it is read, and the schema takes it.
#[test]
fn keys_behind_a_hash_are_good_as_they_stand() {
    let text = Document::Study.every_key();
    let good = validator(Document::Study);
    let mut header = String::new();
    let mut count = 0;
    for line in text.lines() {
        if let Some(table) = line.trim_start_matches("# ").strip_prefix('[') {
            header = if line.starts_with('#') { String::new() } else { format!("[{table}") };
        }
        let Some(entry) = line.strip_prefix("# ").filter(|entry| is_entry(entry)) else { continue };
        if header.is_empty() {
            continue;
        }
        let must = match header.as_str() {
            "[[pigment]]" => "volume_fraction = 0.1",
            "[layer]" => "thickness_um = 1.0",
            "[[number]]" => "name = 'sun'\nweights = 'solar_g173'\nof = 'albedo'",
            _ => "",
        };
        let layer = if header == "[layer]" { "" } else { "[layer]\nthickness_um = 1.0" };
        let value = as_json(&format!("{layer}\n{header}\n{must}\n{entry}"));
        assert!(good.is_valid(&value) && is_read(Document::Study, &value), "{header} {entry}");
        count += 1;
    }
    assert!(count >= 20, "{count} keys");
}

fn is_entry(line: &str) -> bool {
    let key = line.split(" = ").next().filter(|_| line.contains(" = ")).unwrap_or_default();
    !key.is_empty() && key.chars().all(|c| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit())
}

#[test]
fn every_example_and_every_reference_case_fits() {
    let all = examples();
    assert!(all.len() >= 15, "{} examples", all.len());
    for (path, document, value) in all {
        let good = validator(document);
        let errors: Vec<String> =
            good.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(errors.is_empty(), "{}: {errors:?}", path.display());
        assert!(is_read(document, &value), "{}", path.display());
    }
    let good = validator(Document::Case);
    for inputs in
        reference_cases().into_iter().filter(|inputs| Case::parse(&inputs.to_string(), false).is_ok())
    {
        assert!(good.is_valid(&inputs) && good.is_valid(&json!({ "inputs": inputs, "more": 1 })), "{inputs}");
    }
}

/// The slips that people make, each refused by the schema and by the program.
#[test]
fn bad_files_do_not_fit() {
    use Document::{Case, Compare, Study, Sweep};
    let study = as_json(&std::fs::read_to_string(root().join("examples/yellow.toml")).expect("an example"));
    let sweep = as_json("base = 'yellow.toml'\n[[axis]]\nfield = 'layer.thickness_um'\nvalues = [1, 2]");
    let compare = as_json("study = 'yellow.toml'\nstrategies = ['krylov']");
    let case = reference_cases().swap_remove(0);
    let slips: [(Document, &Value, &str, Value); 30] = [
        (Study, &study, "/layer/thicknes_um", json!(1)),
        (Study, &study, "/layer/thickness_um", json!("1 µm")),
        (Study, &study, "/layer/thickness_um", json!(-1)),
        (Study, &study, "/layer/thickness_um", json!({ "mean": 1 })),
        (Study, &study, "/layer/period_um", json!([1, 2, 3])),
        (Study, &study, "/layer/cell", json!("hexagonal")),
        (Study, &study, "/layer/walls", json!("yes")),
        (Study, &study, "/layer/binder/index", json!({ "k": 0.1, "csv": "a.csv" })),
        (Study, &study, "/pigment/0/volume_fraction", json!(30)),
        (Study, &study, "/pigment/0/shape", json!("cube")),
        (Study, &study, "/pigment/0/shape", json!({ "kind": "cylinder", "length_in_radii": 1 })),
        (Study, &study, "/pigment/0/diameter_nm", json!("small")),
        (Study, &study, "/pigment/0/index", json!({ "built_in": "purple" })),
        (Study, &study, "/pigment/0/index", json!({ "n": 1.4, "k": -0.1 })),
        (Study, &study, "/pigment/0/orientation", json!({ "kind": "along" })),
        (Study, &study, "/paper/albedo", json!(90)),
        (Study, &study, "/paper/coupling", json!("glue")),
        (Study, &study, "/light/step_nm", json!(0)),
        (Study, &study, "/angles/count", json!(2.5)),
        (Study, &study, "/run/realisations", json!(0)),
        (Study, &study, "/resolution/accuracy", json!(1)),
        (Study, &study, "/solver/strategy", json!({ "krylov": { "restart": "many" } })),
        (Sweep, &sweep, "/axis/0/vales", json!([1])),
        (Sweep, &sweep, "/base", json!(3)),
        (Compare, &compare, "/schemes", json!(["kubic"])),
        (Compare, &compare, "/goal", json!({ "tolerence": 1e-6 })),
        (Case, &case, "/wavelength", json!("550 nm")),
        (Case, &case, "/sigma_deg", json!(90)),
        (Case, &case, "/directions", json!([])),
        (Case, &case, "/directions", json!([{ "sigma_deg": 90 }])),
    ];
    for (document, good, place, value) in slips {
        let judge = validator(document);
        assert!(judge.is_valid(good) && !refused(document, good), "{place}: good as it was");
        let bad = with(good, place, value);
        assert!(!judge.is_valid(&bad), "{place} = {} fits the schema", bad.pointer(place).unwrap());
        assert!(refused(document, &bad), "{place} = {} is taken by the program", bad.pointer(place).unwrap());
    }
}

/// `whole` with a value put in place of another, or added.
fn with(whole: &Value, place: &str, value: Value) -> Value {
    let mut whole = whole.clone();
    let (table, key) = place.rsplit_once('/').expect("a place");
    if whole.pointer(table).is_none() {
        whole = with(&whole, table, json!({}));
    }
    match whole.pointer_mut(table).expect("a table") {
        Value::Array(items) => items[key.parse::<usize>().expect("a number")] = value,
        table => table[key] = value,
    }
    whole
}
