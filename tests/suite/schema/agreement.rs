//! Where a schema refuses, the program refuses: every change of every example, and every bound.

use super::{as_json, examples, faults, is_read, reference_cases, refused, root, validator, with};
use inkwave::schema::Document;
use serde_json::{Value, json};
use std::path::PathBuf;

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
    // a layer of grains is at most 100 µm thick, which no schema says
    let clear = without(&with(&good, "/layer/thickness_um", json!(1000.0)), "/pigment");
    let of_thickness = |value: &Value| faults(value).iter().any(|fault| fault.field == "layer.thickness_um");
    assert!(judge.is_valid(&clear) && !of_thickness(&clear), "{:?}", faults(&clear));
    let beyond = with(&clear, "/layer/thickness_um", json!(1000.0 + 1e-9));
    assert!(!judge.is_valid(&beyond) && of_thickness(&beyond), "{:?}", faults(&beyond));
    let ranges: [(&str, f64, f64); 8] = [
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
