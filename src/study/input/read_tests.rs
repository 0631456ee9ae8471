//! Tests of messages about unknown keys and wrong values.

use super::*;
use crate::input::tree::parse_toml;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "read only")]
struct Outer {
    #[serde(rename = "new", alias = "old")]
    renamed: Option<f64>,
    count: Option<u64>,
    inner: Vec<Inner>,
    kind: Option<Kind>,
    pair: Option<[f64; 2]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "read only")]
struct Inner {
    size: f64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(dead_code, reason = "read only")]
enum Kind {
    Plain,
    Round { radius: f64 },
}

fn faults(text: &str) -> Vec<Fault> {
    read::<Outer>(parse_toml(text).unwrap().into()).map(|outer| panic!("{outer:?}")).unwrap_err()
}

#[test]
fn every_unknown_key_is_named_with_its_place_and_what_was_meant() {
    let found =
        faults("cuont = 1\n[[inner]]\nsize = 1\n[[inner]]\nsize = 2\nsise = 3\nx = 1\nkind.round.r = 1");
    let fields: Vec<&str> = found.iter().map(|f| f.field.as_str()).collect();
    assert_eq!(fields, ["cuont", "inner[1].kind", "inner[1].sise", "inner[1].x"]);
    assert!(found[0].remedy.contains("did you mean count?"), "{:?}", found[0]);
    assert!(found[0].allowed.contains("`new`, `old`"), "aliases are known keys: {:?}", found[0]);
    assert_eq!(found[3].remedy, "remove it");
}

#[test]
fn values_that_do_not_fit_are_named_where_they_are() {
    for (text, field, found, allowed) in [
        ("count = -1\ninner = []", "count", "integer `-1`", "a whole number from 0"),
        ("inner = [{ size = 'a' }]", "inner[0].size", "string \"a\"", "a number"),
        ("inner = [{}]", "inner[0].size", "nothing", "a value"),
        ("count = 1", "inner", "nothing", "a value"),
        ("inner = []\nkind = 'plane'", "kind", "`plane`", "`plain`, `round`"),
        ("inner = []\nkind.round = {}", "kind.round.radius", "nothing", "a value"),
        ("inner = []\npair = [1]", "pair", "1 entries", "a list of 2 in brackets"),
        ("inner = []\npair = [1, 2, 3]", "pair", "3 entries", "2 entries"),
        ("inner = []\nold = 1\nnew = 2", "new", "two values", "one"),
    ] {
        let fault = faults(text).pop().unwrap();
        assert_eq!(fault.field, field, "{text}: {fault:?}");
        assert!(fault.found.contains(found) && fault.allowed.contains(allowed), "{text}: {fault:?}");
    }
}

#[test]
fn a_misspelt_key_is_one_error() {
    for (text, key) in [("iner = []", "iner"), ("inner = [{ sise = 1 }]", "inner[0].sise")] {
        let told = faults(text);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].field == key && told[0].is_of_key(), "{told:?}");
    }
    // a key of another place does not excuse a missing one
    let told = faults("sise = 1\ninner = [{}]");
    assert_eq!(told.iter().map(|f| f.field.as_str()).collect::<Vec<_>>(), ["sise", "inner[0].size"]);
}

#[test]
fn control_characters_are_refused_wherever_they_stand() {
    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "read only")]
    struct Texts {
        title: String,
        names: Vec<String>,
        free: std::collections::BTreeMap<String, String>,
    }
    let read = |text: &str| read::<Texts>(parse_toml(text).unwrap().into());
    let text = |title: &str, name: &str, key: &str| {
        format!("title = {title:?}\nnames = ['a', {name:?}]\nfree = {{ {key:?} = 'b' }}")
    };
    assert!(read(&text("two\nlines\tand é", "b", "c")).is_ok());
    for (wrong, code) in
        [("\u{1b}", "U+001B"), ("\u{7}", "U+0007"), ("\u{85}", "U+0085"), ("\u{ffff}", "U+FFFF")]
    {
        let escaped = format!("a\\u{:04X}", u32::from(wrong.chars().next().unwrap()));
        for (place, text) in [
            ("title", text("T", "b", "c").replace("\"T\"", &format!("\"{escaped}\""))),
            ("names[1]", text("T", "N", "c").replace("\"N\"", &format!("\"{escaped}\""))),
            ("free", text("T", "b", "K").replace("\"K\"", &format!("\"{escaped}\""))),
        ] {
            let told = read(&text).unwrap_err();
            assert!(told.len() == 1 && told[0].field == place && told[0].found.contains(code), "{told:?}");
        }
    }
}

#[test]
fn many_errors_are_told_as_few() {
    let told = faults(&(0..50_000).map(|i| format!("[a{i}]\n")).collect::<String>());
    assert_eq!(told.len(), 21);
    assert!(told[..20].iter().all(|fault| fault.field.starts_with('a')), "{told:?}");
    assert_eq!(told[20].field, "other fields");
}

#[test]
fn numbers_fit_where_they_can() {
    let text =
        "old = 1\ncount = 3\ninner = [{ size = 2 }]\nkind = { round = { radius = 1.5 } }\npair = [1, 2.5]";
    let outer: Outer = read(parse_toml(text).unwrap().into()).unwrap();
    assert_eq!((outer.renamed, outer.count, outer.pair), (Some(1.0), Some(3), Some([1.0, 2.5])));
}
