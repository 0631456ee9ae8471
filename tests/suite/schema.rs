//! The schemas say what the readers say: examples and reference cases fit, slips do not, and a value that the schema refuses is
//! refused by the program, wherever it stands.

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

fn validator(document: Document) -> Validator {
    jsonschema::validator_for(&document.schema()).expect("a schema of draft 7")
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

/// Values of the largest document that is changed everywhere.
const MOST_PLACES: usize = 120;

/// At every place of every example: another kind of value, an unknown key, a key left out. What the schema refuses the program
/// refuses, and what the reader cannot read the schema does not let pass.
#[test]
fn schema_and_reader_agree_on_every_change() {
    let mut changes = 0;
    let cases = reference_cases().into_iter().map(|inputs| (PathBuf::from("a case"), Document::Case, inputs));
    for (path, document, good) in examples().into_iter().chain(cases) {
        let judge = validator(document);
        // Sweeps of many variants say the same things over and over.
        if places(&good, "").len() > MOST_PLACES || refused(document, &good) {
            continue;
        }
        // What an axis sets anew may stand in a sweep's base as it likes.
        let kept = |place: &String| document != Document::Sweep || !place.starts_with("/base");
        for changed in every_change(&good, kept) {
            changes += 1;
            let fits = judge.is_valid(&changed);
            let is_read = is_read(document, &changed);
            assert!(fits || refused(document, &changed), "{}: the program takes {changed}", path.display());
            assert!(!fits || is_read, "{}: the schema lets pass {changed}", path.display());
        }
    }
    assert!(changes > 2000, "{changes} changes");
}

fn every_change(good: &Value, kept: impl Fn(&String) -> bool) -> Vec<Value> {
    let mut all = Vec::new();
    for place in places(good, "").into_iter().filter(kept) {
        let others = [
            json!("zzz"),
            json!(-1e9),
            json!(1),
            json!(true),
            json!([]),
            json!([[1]]),
            json!({}),
            json!({ "zzz": 1 }),
        ];
        all.extend(others.map(|other| with(good, &place, other)));
        let Some(parent) = place.rsplit_once('/').map(|(parent, _)| parent) else { continue };
        if good.pointer(parent).is_some_and(Value::is_object) {
            all.push(with(good, &format!("{parent}/zzz"), json!(1)));
            all.push(without(good, &place));
        }
    }
    all
}

fn without(whole: &Value, place: &str) -> Value {
    let mut whole = whole.clone();
    let (table, key) = place.rsplit_once('/').expect("a place");
    let table = whole.pointer_mut(table).and_then(Value::as_object_mut).expect("a table");
    table.remove(&key.replace("~1", "/").replace("~0", "~"));
    whole
}

/// JSON pointers of all values below.
fn places(value: &Value, here: &str) -> Vec<String> {
    let escaped = |key: &str| key.replace('~', "~0").replace('/', "~1");
    let children: Vec<(String, &Value)> = match value {
        Value::Object(table) => table.iter().map(|(key, child)| (escaped(key), child)).collect(),
        Value::Array(items) => items.iter().enumerate().map(|(i, child)| (i.to_string(), child)).collect(),
        _ => Vec::new(),
    };
    let below = |(key, child): (String, &Value)| {
        let place = format!("{here}/{key}");
        let mut all = places(child, &place);
        all.push(place);
        all
    };
    children.into_iter().flat_map(below).collect()
}

/// A number beyond its bound is refused by both, at its bound by neither for that reason.
#[test]
fn bounds_are_the_same() {
    let good = with(&as_json(Document::Study.every_key()), "/run/realisations", json!(2));
    let judge = validator(Document::Study);
    let ranges: [(&str, f64, f64); 9] = [
        ("/layer/thickness_um", f64::NAN, 1000.0),
        ("/pigment/0/volume_fraction", f64::NAN, 0.64),
        ("/paper/albedo", 0.0, 1.0),
        ("/angles/azimuth_deg", -360.0, 360.0),
        ("/run/realisations", 1.0, 1e5),
        ("/solver/max_applications", 1.0, 1e6),
        ("/output/picture_pixels", 16.0, 8192.0),
        ("/packing/relaxation/step", 0.01, 1.0),
        ("/packing/relaxation/inflation", 1e-6, 0.05),
    ];
    for (place, low, high) in ranges {
        let whole = good.pointer(place).is_some_and(Value::is_u64);
        let number = |x: f64| if whole { json!(x as i64) } else { json!(x) };
        let step = if whole { 1.0 } else { 1e-9 };
        let field = place.trim_start_matches('/').replace("/0/", "[0].").replace('/', ".");
        for (bound, beyond) in [(low, low - step), (high, high + step)] {
            if bound.is_nan() {
                continue;
            }
            let at = with(&good, place, number(bound));
            let beyond = with(&good, place, number(beyond));
            let own = |value: &Value| faults(value).iter().any(|fault| fault.field == field);
            assert!(judge.is_valid(&at) && !own(&at), "{place} at {bound}: {:?}", faults(&at));
            assert!(
                !judge.is_valid(&beyond) && own(&beyond),
                "{place} beyond {bound}: {:?}",
                faults(&beyond)
            );
        }
    }
}

/// Entries of lists have the bounds of their checks: the first and the last value that is allowed, and one beyond each.
/// *Planted*: a schema that lets directions be 2 to 17.
#[test]
fn bounds_of_entries_are_the_same() {
    let good = as_json(&std::fs::read_to_string(root().join("examples/yellow.toml")).expect("an example"));
    let composed = with(&good, "/layer/composed", json!({ "slab_um": 2.0 }));
    let composed = with(&composed, "/layer/thickness_um", json!(20));
    let voxels = json!({ "voxels": "cut.npy", "voxel_nm": [20, 20, 20] });
    let voxels = with(&good, "/layer/microstructure", voxels);
    let judge = validator(Document::Study);
    let lists: [(&Value, &str, &str, Value, Value); 8] = [
        (&composed, "/layer/composed/directions", "[0]", json!([2, 16]), json!([1, 16])),
        (&composed, "/layer/composed/directions", "[1]", json!([2, 16]), json!([2, 17])),
        (&composed, "/layer/thickness_um", "[1]", json!([20, 1000]), json!([20, 1001])),
        (&good, "/colour/target_lab", "", json!([85, -300, 300]), json!([85, -301, 300])),
        (&good, "/colour/target_lab", "", json!([85, -300, 300]), json!([85, -300, 301])),
        (&voxels, "/layer/microstructure/cuts", "[0]", json!([1, 100]), json!([0, 100])),
        (&voxels, "/layer/microstructure/cuts", "[1]", json!([1, 100]), json!([1, 101])),
        (&voxels, "/layer/microstructure/voxel_nm", "", json!([0.1, 20, 10_000]), json!([0.09, 20, 20])),
    ];
    for (base, place, entry, within, beyond) in lists {
        let field = place.trim_start_matches('/').replace('/', ".") + entry;
        let is_refused = |value: &Value| faults(value).iter().any(|fault| fault.field == field);
        let within = with(base, place, within);
        let beyond = with(base, place, beyond);
        assert!(judge.is_valid(&within) && !is_refused(&within), "{field}: {:?}", faults(&within));
        assert!(!judge.is_valid(&beyond) && is_refused(&beyond), "{field} beyond: {:?}", faults(&beyond));
    }
}
