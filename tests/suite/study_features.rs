//! What a study may ask for beyond grains of one pigment between plane walls: reliefs, mixtures, spectral paper.

use crate::run_support::{TINY, results_of, study, succeed};
use inkwave::input::load::load;
use inkwave::store::{PointRecord, Record, Store};
use inkwave::wave::Side;
use serde_json::Value;
use std::path::Path;

/// Every solve's record.
fn points(folder: &Path) -> Vec<PointRecord> {
    let store: Store<PointRecord> = Store::open(folder.join("out")).unwrap();
    store.database().keys(PointRecord::KIND).iter().filter_map(|key| store.get(key)).collect()
}

#[test]
fn a_relief_is_lit_from_the_exit_side_too_and_both_ways_to_its_reflectance_agree() {
    both_ways_agree("depth_um = 0.1");
    both_ways_agree(
        "depth_um = 0.2, face = \"exit\", rule = { kind = \"random\", rms_um = 0.05, correlation_um = 0.1 }",
    );
}

fn both_ways_agree(relief: &str) {
    let folder = tempfile::tempdir().unwrap();
    let relief = TINY
        .replace("binder.index", &format!("relief = {{ {relief} }}\nbinder.index"))
        .replace("realisations = 2", "realisations = 6");
    let results = results_of(folder.path(), &relief);
    assert_eq!(results["solves"]["finished"], 6 * 4 * (3 + 1));
    let certainty = &results["certainty"];
    assert!(certainty["largest_energy_error"].as_f64().unwrap() < 1e-5);
    let points = points(folder.path());
    let lit = |from: Side| points.iter().filter(|p| p.incidence.from == from).count();
    assert_eq!((lit(Side::Incident), lit(Side::Exit)), (6 * 4 * 3, 6 * 4));
    // R̄ from the exit side by its own quadrature and by reciprocity, 1 − T̄ − Ā: they share nothing but the absorption.
    let apart = &certainty["exit_reflectance_difference"];
    let value = apart["value"].as_f64().unwrap();
    let error = apart["standard_error"].as_f64().unwrap();
    // Student's t of 5 degrees of freedom exceeds 6.9 once in a thousand
    assert!(error > 0.0 && value.abs() < 6.9 * error, "{value} ± {error}");
}

#[test]
fn a_mixture_has_both_shares_and_absorbs_where_either_pigment_does() {
    let folder = tempfile::tempdir().unwrap();
    let start = TINY.find("[[pigment]]").unwrap();
    let pigment = &TINY[start..TINY.find("[light]").unwrap()];
    let blue = pigment.replace("yellow", "blue").replace("0.15", "0.10");
    let mixture = TINY.replace("[light]", &format!("{blue}[light]"));
    let in_folder = |text: &str, name: &str| {
        let folder = folder.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        results_of(&folder, text)
    };
    let alone = in_folder(TINY, "yellow");
    let both = in_folder(&mixture, "both");
    let shares = both["packings"][0]["shares"].as_array().unwrap();
    let share = |i: usize| shares[i]["achieved_fraction"].as_f64().unwrap();
    // One grain of 200 nm is 1.3 % of this cell.
    assert!((share(0) - 0.15).abs() < 0.013 && (share(1) - 0.10).abs() < 0.013, "{shares:?}");
    let transmitted = |r: &Value, w: usize| r["spectra"][w]["transmittance"]["value"].as_f64().unwrap();
    // At 600 nm the yellow pigment hardly absorbs (κ < 0.01) and the blue one does.
    assert!(transmitted(&alone, 2) - transmitted(&both, 2) > 0.1);
    let hue = |r: &Value| r["colours"][0]["hue_deg"]["value"].as_f64().unwrap();
    assert!((80.0..120.0).contains(&hue(&alone)) && (120.0..250.0).contains(&hue(&both)), "{}", hue(&both));
}

#[test]
fn the_papers_albedo_may_be_a_spectrum() {
    let folder = tempfile::tempdir().unwrap();
    let with = |name: &str, albedo: &str| {
        let folder = folder.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("paper.csv"), "wavelength_nm,albedo\n400,0.5\n700,0.8\n").unwrap();
        let results =
            results_of(&folder, &TINY.replace("[light]", &format!("[paper]\nalbedo = {albedo}\n[light]")));
        let rows = results["spectra"].as_array().unwrap();
        let normal = rows.iter().filter(|row| row["polar_deg"] == 0.0);
        normal.map(|row| row["natural_light"]["value"].as_f64().unwrap()).collect::<Vec<f64>>()
    };
    let dark = with("dark", "0.5");
    let light = with("light", "0.8");
    let listed = with("listed", "[[400, 0.5], [700, 0.8]]");
    assert_eq!(listed, with("table", "{ csv = \"paper.csv\" }"));
    assert!(listed[0] == dark[0] && listed[3] == light[3]);
    assert!((1..3).all(|w| dark[w] < listed[w] && listed[w] < light[w]));
}

/// The same table in another folder is the same study.
#[test]
fn a_folder_does_not_change_the_hash() {
    let key = || {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("n.csv"), "wavelength_nm,k,n\n400,0,1.5\n700,0,1.4\n").unwrap();
        let text = TINY.replace("{ built_in = \"yellow\" }", "{ csv = \"n.csv\" }");
        load(&study(folder.path(), &text)).unwrap().key()
    };
    assert_eq!(key(), key());
}

/// What a file leaves open is said, on a run's error stream too; results do not hold it.
#[test]
fn a_range_that_ends_early_and_an_unnamed_sample_are_remarked_on() {
    let folder = tempfile::tempdir().unwrap();
    let cgats = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME SPEC_400 SPEC_700\nEND_DATA_FORMAT\n\
                 BEGIN_DATA\n\"first ink\" 20 40\n\"second ink\" 30 90\nEND_DATA\n";
    std::fs::write(folder.path().join("inks.cgats"), cgats).unwrap();
    let remarks = |text: &str| load(&study(folder.path(), text)).unwrap().remarks;
    assert_eq!(remarks(TINY), [""; 0]);
    let early = remarks(&TINY.replace("to_nm = 700", "to_nm = 690"));
    assert!(
        early.len() == 1 && early[0].contains("light.to_nm = 690") && early[0].contains("600 nm"),
        "{early:?}"
    );
    let compared = format!("{TINY}[compare]\nmeasured = \"inks.cgats\"\n");
    let first = remarks(&compared);
    assert!(first.len() == 3 && first[0].contains("\"first ink\", sample 1 of 2"), "{first:?}");
    assert!(
        first[1].contains("no unit is stated; taken as percent") && first[1].contains("compare.unit"),
        "{first:?}"
    );
    let named = format!("{compared}patch = \"second ink\"\n");
    let gap = remarks(&named);
    assert!(gap.len() == 2 && gap[1].contains("no row between 400 and 700 nm"), "{gap:?}");
    let measured = load(&study(folder.path(), &named)).unwrap().judgement.measured.unwrap();
    assert_eq!(measured.rows, [[400.0, 0.3], [700.0, 0.9]]);
    let wrong =
        load(&study(folder.path(), &format!("{compared}patch = \"third\"\n"))).unwrap_err().to_string();
    assert!(wrong.contains("\"first ink\", \"second ink\""), "{wrong}");
    let alone = load(&study(folder.path(), &format!("{TINY}[compare]\npatch = \"third\"\n"))).unwrap_err();
    assert!(alone.to_string().contains("compare.patch"), "{alone}");
    let path = study(folder.path(), &compared.replace("to_nm = 700", "to_nm = 790"));
    let told = succeed(&path, &folder.path().join("out"), &[]);
    assert!(told.contains("the last wavelength is 700 nm") && told.contains("sample 1 of 2"), "{told}");
}

#[test]
fn albedos_that_are_none_are_refused_with_field_value_range_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |albedo: &str, words: &[&str]| {
        let text = TINY.replace("[light]", &format!("[paper]\nalbedo = {albedo}\n[light]"));
        let done = crate::run_support::run(&study(folder.path(), &text), &folder.path().join("out"), &[]);
        let told = String::from_utf8_lossy(&done.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!done.status.success() && !told.contains("panicked"), "{told}");
        words.iter().for_each(|word| assert!(told.contains(word), "no {word} in {told}"));
    };
    refused("1.5", &["paper.albedo", "1.5", "0 to 1", "0.9 is good paper"]);
    refused("[[400, 0.5], [700, 1.5]]", &["paper.albedo[1]", "1.5 at 700 nm", "from 0 to 1"]);
    refused(
        "[[450, 0.5], [700, 0.5]]",
        &["paper.albedo", "450 to 700 nm, requested at 400", "extend the table"],
    );
    refused("{ csv = \"none.csv\" }", &["paper.albedo.csv", "none.csv", "wavelength_nm and albedo"]);
    refused("\"white\"", &["white", "a number, rows"]);
}

/// Cells of 0.12 µm are as high as the waves of 400 nm allow in the packings that the grid was chosen on; elsewhere they hold more
/// pigment, and the wave is shorter.
#[test]
fn a_grid_that_the_probes_just_fit_in_does_not_fail_the_other_packings() {
    let study = r#"
        layer = { thickness_um = 0.6, binder.index = 1.558 }
        light = { from_nm = 400, to_nm = 460, step_nm = 20 }
        angles = { polar_deg = [0] }
        run = { realisations = 4, seed = 2 }
        resolution = { accuracy = 3e-2 }
        [[pigment]]
        name = "yellow"
        diameter_nm = 200
        volume_fraction = 0.25
        share = "scale_sizes"
        index = { built_in = "yellow" }
    "#;
    for seed in [2, 3, 4] {
        let folder = tempfile::tempdir().unwrap();
        let results = results_of(folder.path(), &study.replace("seed = 2", &format!("seed = {seed}")));
        assert_eq!(results["solves"]["asked"], results["solves"]["finished"], "seed {seed}");
    }
}

/// T of a layer that lets nothing through is within its error of zero, and K and S may be anything: the rest is published.
#[test]
fn an_opaque_ink_is_published_without_what_cannot_be_known() {
    let opaque = TINY
        .replace("thickness_um = 0.5", "thickness_um = 2")
        .replace("{ built_in = \"yellow\" }", "{ n = 1.8, k = 0.8 }");
    let folder = tempfile::tempdir().unwrap();
    let results = results_of(folder.path(), &opaque);
    assert!(results["colours"].as_array().unwrap().len() == 2);
    let rows = results["ink_maker"]["kubelka_munk"].as_array().unwrap();
    let known = |key: &str| rows.iter().all(|row| row[key]["value"].is_number());
    assert!(known("absorption_per_um") && known("scattering_per_um"));
    assert!(!rows.is_empty() || results["ink_maker"]["no_kubelka_munk"].is_string());
}

/// Lab alone in a measured file is the target, under the conditions that it states and the study has; nothing is guessed.
#[test]
fn a_file_of_lab_alone_is_the_target_if_it_states_the_conditions_of_the_study() {
    let folder = tempfile::tempdir().unwrap();
    let lab = "CGATS.17\nWEIGHTING_FUNCTION \"ILLUMINANT, D50\"\nWEIGHTING_FUNCTION \"OBSERVER, 2 degree\"\n\
               BEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\nBEGIN_DATA\n\"ink\" 85.5 -10 80\nEND_DATA\n";
    std::fs::write(folder.path().join("lab.cgats"), lab).unwrap();
    std::fs::write(
        folder.path().join("bare.cgats"),
        lab.replace("ILLUMINANT, D50", "LIGHT").replace("OBSERVER, 2 degree", "EYE"),
    )
    .unwrap();
    let loaded = |name: &str, colour: &str| {
        let text = format!("{TINY}[compare]\nmeasured = \"{name}\"\n[colour]\n{colour}\n");
        load(&study(folder.path(), &text))
    };
    let judgement = loaded("lab.cgats", "illuminant = \"D50\"").unwrap().judgement;
    assert_eq!((judgement.target_lab, judgement.measured), (Some([85.5, -10.0, 80.0]), None));
    let refused = |name: &str, colour: &str| loaded(name, colour).unwrap_err().to_string();
    let other = refused("lab.cgats", "");
    assert!(other.contains("compare.measured") && other.contains("Lab under D50, 2° observer"), "{other}");
    assert!(other.contains("D65, 2° observer"), "{other}");
    let bare = refused("bare.cgats", "illuminant = \"D50\"");
    assert!(bare.contains("compare.measured") && bare.contains("not stated"), "{bare}");
    let two = refused("lab.cgats", "illuminant = \"D50\"\ntarget_lab = [85, -10, 80]");
    assert!(two.contains("one target"), "{two}");
}

/// Packed layers are drawn from the law of thicknesses that the film behind them is averaged over.
#[test]
fn packed_layers_are_as_uneven_as_the_film() {
    let folder = tempfile::tempdir().unwrap();
    let uneven = TINY.replace("thickness_um = 0.5", "thickness_um = { mean = 0.5, std = 0.05 }");
    let study = load(&study(folder.path(), &uneven)).unwrap();
    let moments = |all: &[(f64, f64)]| {
        let mean: f64 = all.iter().map(|(um, share)| um * share).sum();
        let square: f64 = all.iter().map(|(um, share)| share * (um - mean).powi(2)).sum();
        (mean, square.sqrt())
    };
    let drawn: Vec<(f64, f64)> = (0..512).map(|r| (study.draw(r).thickness_um, 1.0 / 512.0)).collect();
    let nodes: Vec<(f64, f64)> = study.thicknesses().iter().map(|of| (of.um, of.share)).collect();
    let (mean, spread) = moments(&drawn);
    let (_, film) = moments(&nodes);
    // A normal law cut at three standard deviations has 0.98657 of its spread. 512 places of an even sequence leave about
    // 1/512 of a law's range.
    assert!((mean - 0.5).abs() < 1e-3 && (spread / 0.04933 - 1.0).abs() < 0.01, "{mean} ± {spread}");
    assert!((film - 0.049_328).abs() < 1e-6, "{film}");
}
