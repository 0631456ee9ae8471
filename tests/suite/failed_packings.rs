//! Packings without room: no result where they are many, and wider error bars where they are asked for.

use crate::run_support::{TINY, run, study, succeed};
use crate::sweep_support::inkwave;
use inkwave::input::load::load;
use inkwave::run::point::pack_realisation;
use serde_json::Value;
use std::path::Path;

/// A study of seven cells that are packed with so few attempts that some are blocked, and the number of those.
fn blocked(folder: &Path) -> (String, usize) {
    let dense = TINY.replace("volume_fraction = 0.15", "volume_fraction = 0.3");
    let seven = dense.replace("realisations = 2", "realisations = 7");
    let text = |attempts: usize| {
        format!(
            "{seven}[packing]\nmethod = \"sequential_addition\"\nsequential.attempts_per_grain = {attempts}\n"
        )
    };
    let refused = |attempts: usize| {
        let study = load(&study(folder, &text(attempts))).unwrap();
        (0..7).filter(|&r| pack_realisation(&study, r, &()).is_err()).count()
    };
    let suitable = (0..14).map(|k| 4 << k).find(|&attempts| (2..=3).contains(&refused(attempts)));
    let attempts = suitable.expect("attempts between too few and enough");
    (text(attempts), refused(attempts))
}

#[test]
fn many_packings_without_room_are_no_result_unless_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (text, refused) = blocked(folder.path());
    let out = folder.path().join("out");
    let done = run(&study(folder.path(), &text), &out, &[]);
    let message = String::from_utf8_lossy(&done.stderr).replace('│', " ");
    let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let expected =
        format!("{refused} of 7 packings have no room, more than run.failed_packings = 0.1 allows");
    assert!(
        !done.status.success() && message.contains(&expected) && message.contains("smaller layer.period_um"),
        "{message}"
    );
    assert!(!out.join("results.json").exists() && !out.join("report.html").exists());

    let tolerant = text.replace("seed = 7", "seed = 7\nfailed_packings = 0.5");
    let message = succeed(&study(folder.path(), &tolerant), &out, &[]);
    assert!(message.contains(&format!("{refused} of 7 packings have no room: ")), "{message}");
    assert!(!out.join("PARTIAL").exists());
    let export = inkwave(&["export", &out.display().to_string(), "--to", "npz"]).status().unwrap();
    assert!(export.success());
    let results: Value = serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    assert_eq!(results["tried_packings"]["refused"], refused);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("the means are those of the others"));
    // The worst selection of a quarter and more outweighs the chance that it was estimated from.
    let budget = &results["colours"][0]["budget"];
    let [chance, angles, missing] =
        ["chance_and_cell", "angles", "missing_cells"].map(|part| budget[part].as_f64().unwrap());
    assert!(missing > chance.hypot(angles), "{budget}");
    let bars = results["colours"][0]["lab_standard_error"].as_array().unwrap();
    let bar = bars.iter().map(|x| x.as_f64().unwrap().powi(2)).sum::<f64>().sqrt();
    assert!(bar >= missing, "{bar} holds {missing}");
}

#[test]
fn where_all_have_room_nothing_is_added() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), TINY), &out, &[]);
    let results: Value = serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    assert_eq!(results["tried_packings"]["refused"], 0);
    assert!(results["colours"][0]["budget"].get("missing_cells").is_none());
}
