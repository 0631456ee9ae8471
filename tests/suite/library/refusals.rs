//! What the commands of libraries refuse.

use super::{PLATES, data, inkwave};
use crate::run_support::{plain, study, succeed};
use inkwave::store::identity::METHOD_VERSION;
use serde_json::{Value, json};
use std::path::Path;

/// What a command that must fail says.
fn refused(words: &[&str], folder: &Path) -> String {
    let done = inkwave(words, folder);
    assert!(!done.status.success(), "{words:?}");
    plain(&done)
}

/// Files that are no library or do not fit together, and runs without plates, with what is allowed instead.
#[test]
fn libraries_that_do_not_fit_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let library = data("library.json");
    std::fs::write(folder.join("library.json"), &library).unwrap();
    let changed = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut value: Value = serde_json::from_str(&library).unwrap();
        change(&mut value);
        std::fs::write(folder.join(name), value.to_string()).unwrap();
    };
    changed("newer.json", &|value| value["inkwave_library"] = json!(6));
    changed("method.json", &|value| value["method"] = json!(9));
    changed("other.json", &|value| value["wavelengths_nm"][0] = json!(425));
    changed("less.json", &|value| {
        drop(value["plates"][0]["portions"][0]["states"].as_array_mut().unwrap().pop())
    });
    changed("named.json", &|value| value["plates"][0]["thickness_um"] = json!(0.6));
    changed("cut.json", &|value| value["plates"][0]["portions"][0]["states"][0]["mean"] = json!("AAAA"));
    std::fs::write(folder.join("text.json"), "no library").unwrap();
    let method = format!("method: found 9; allowed {METHOD_VERSION}");
    let libraries: [(&str, &str); 8] = [
        ("newer.json", "found form 6; allowed up to 5"),
        ("method.json", &method),
        ("less.json", "incomplete"),
        ("cut.json", "incomplete"),
        ("text.json", "found no library"),
        ("missing.json", "missing.json"),
        (
            "other.json",
            "wavelengths_nm: found [425.0, 500.0, 580.0, 660.0] nm; allowed [420.0, 500.0, 580.0, 660.0] nm",
        ),
        ("named.json", "different plates of this name"),
    ];
    for (name, words) in libraries {
        let said = refused(&["library", "library.json", name, "--output", "all.json"], folder);
        assert!(said.contains(words), "{name}: {said}");
    }
    let thin = PLATES
        .replace("composed = { joint_index = 1.5, slab_um = 0.5 }\n", "")
        .replace("slab_um = 0.5\n", "");
    succeed(&study(folder, &thin.replace("[1, 2.3]", "0.3")), &folder.join("thin"), &[]);
    let said = refused(&["library", "thin"], folder);
    assert!(said.contains("holds no plates") && said.contains("joint_index"), "{said}");
}

/// Compositions that a library cannot answer, with what is allowed instead.
#[test]
fn compositions_that_do_not_fit_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    std::fs::write(folder.join("library.json"), data("library.json")).unwrap();
    let compositions = [
        ("layers = []", "layers: found none"),
        (
            "layers = [{ plate = 'gold' }]",
            "layers[0].plate: found \"gold\"; allowed are red, light, white, pale, foam",
        ),
        ("layers = [{ plate = 'red', thickness_um = 0.7 }]", "found 0.7 µm of \"red\"; allowed 0.5"),
        ("layers = [{ plate = 'white', thickness_um = 0.6 }]", "allowed from 1 µm, two slabs"),
        ("layers = [{ plate = 'red' }]\npaper = { albedo = 1.2 }", "paper.albedo"),
        (
            "layers = [{ plate = 'red' }]\npaper = { albedo = [] }",
            "paper.albedo: found an empty list; allowed two or more",
        ),
        (
            "layers = [{ plate = 'red' }]\npaper = { albedo = [[3000, 0.5], [8000, 0.6]] }",
            "found rows from 3000 to 8000 nm; allowed two or more rows [nm, albedo], rising, from 420 to",
        ),
        ("layers = [{ plate = 'red' }]\nilluminant = 'F99'", "F99"),
        ("layers = [{ plate = 'red' }]\ncolour = 1", "colour: found an unknown key"),
        (
            "layers = [{ plate = 'red' }]\npaper.contact = 'yes'",
            "paper.contact: found string \"yes\"; allowed: true or false",
        ),
        ("layers = [{ plate = 7 }]", "layers[0].plate: found integer `7`; allowed: a string"),
        ("layers = [{ plate = 'red', coverage = 0.5 }]", "layers[0].coverage: found one without a screen"),
        (
            "layers = [{ plate = 'red', coverage = 0.5 }]\ndots = { coverage = 0.5, ruling_per_cm = 60, spread_um = 0 }",
            "dots.coverage: found one beside layers[0].coverage",
        ),
        (
            "layers = [{ plate = 'red' }]\ndots = { ruling_per_cm = 60, spread_um = 0 }",
            "dots.coverage: found 0 coverages",
        ),
        (
            "layers = [{ plate = 'red' }]\npaper.fluorescence = { excitation = [[330, 0], [365, 0.5], [420, 0]], emission = [[420, 0], [440, 1], [480, 0]], yield = 0.5 }",
            "found excitation from 330 nm, a library from 420 nm; allowed is a library that holds the light that excites",
        ),
        (
            "layers = [{ plate = 'red' }]\npaper.fluorescence = { excitation = [[420, 0.9], [440, 0.9]], emission = [[450, 1], [480, 1]], yield = 2 }",
            "paper.fluorescence.yield: found 2; allowed 0 to 1",
        ),
        (
            "layers = [{ plate = 'red' }]\npaper.fluorescence = { excitation_nm = [420, 440], emission_nm = [450, 500], factors = [[0.5, 0.5], [0.5, 0.5]] }",
            "quanta reflected and emitted for each that comes in; allowed at most 1",
        ),
        (
            "layers = [{ plate = 'red' }]\ncondition = 'M3'\npaper.fluorescence = { excitation = [[420, 0.1], [440, 0.1]], emission = [[450, 1], [480, 1]], yield = 0.5 }",
            "condition: found M3; allowed M0, M1, M2",
        ),
        (
            "layers = [{ plate = 'red' }]\ndots = { coverage = 2, ruling_per_cm = 60, spread_um = 0 }",
            "dots.coverage: found 2",
        ),
    ];
    for (text, words) in compositions {
        std::fs::write(folder.join("one.toml"), text).unwrap();
        let said = refused(&["compose", "one.toml"], folder);
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// Files of another kind than a command takes: what they are, and the command that takes them; studies in JSON, which none takes.
#[test]
fn files_of_another_kind_are_named() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    std::fs::write(folder.join("library.json"), data("library.json")).unwrap();
    write("study.toml", PLATES);
    write("study.json", "{\"layer\": {\"thickness_um\": 1}, \"pigment\": []}");
    write("sweep.toml", "base = \"study.toml\"\n[[axis]]\nfield = \"run.seed\"\nvalues = [1, 2]\n");
    write("fit.toml", "base = \"study.toml\"\n[fit]\n[[measured]]\nfile = \"a.csv\"\n");
    write("case.json", "{\"wavelength\": 0.55, \"inputs\": {}}");
    for (name, kind, command) in [
        ("study.toml", "study", "run"),
        ("sweep.toml", "sweep", "sweep"),
        ("fit.toml", "fit", "fit"),
        ("case.json", "case", "solve"),
    ] {
        let takers = [("run", "study"), ("sweep", "sweep"), ("fit", "fit"), ("design", "design")];
        for (other, expected) in takers.into_iter().filter(|(_, expected)| *expected != kind) {
            let said = refused(&[other, name], folder);
            let words = format!("{name} is a {kind}, and this command reads a {expected}");
            assert!(
                said.contains(&words) && said.contains(&format!("inkwave {command} ")),
                "{other} {name}: {said}"
            );
        }
        if kind != "case" {
            let said = refused(&["compose", name], folder);
            assert!(said.contains(&format!("{name} is a {kind}")), "{said}");
        }
    }
    for command in ["run", "sweep", "fit", "design", "compose"] {
        let said = refused(&[command, "study.json"], folder);
        assert!(
            said.contains("study.json is a study in JSON; allowed: a study in TOML"),
            "{command}: {said}"
        );
    }
    assert!(!folder.join("out").exists());
}
