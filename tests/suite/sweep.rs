//! Sweeps: stopped, killed, divided among machines and joined again; wrong sweep files.

use crate::run_support::described_tables;
use crate::sweep_support::{Place, TINY, inkwave, points, results, said, store, succeed};
use inkwave::store::{PointRecord, Record};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

#[test]
fn solves_that_variants_share_are_made_once() {
    // closer wavelengths: what lies between those 100 nm apart would leave the conclusion open
    let place = Place::new(&TINY.replace("step_nm = 100", "step_nm = 20"));
    let told = place.sweep("local", &[]);
    assert!(told.contains("dark paper: confirmed"), "{told}");
    // 2 shares × (96 of grains + 48 without), each once for both papers
    assert_eq!(points(&place.path("local")), 288);
    assert!(!Path::new(&place.path("local/PARTIAL")).exists());
}

/// Two shards of three, and the third by a scheduler's number.
fn shards(place: &Place) -> [String; 3] {
    place.sweep("one", &["--shard", "1/3", "--jobs", "1"]);
    place.sweep("two", &["--shard", "2/3"]);
    let mut third =
        inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("three"), "--shard", "3"]);
    assert!(third.env("SLURM_ARRAY_TASK_ID", "3").status().unwrap().success());
    ["one", "two", "three"].map(|name| place.path(name))
}

#[test]
fn shards_merged_are_the_local_run_bit_for_bit() {
    let place = Place::swept("local");
    let shards = shards(&place);
    succeed(&["merge", &shards[2], &shards[0], &shards[1], "--output", &place.path("merged")]);
    for (local, merged) in results(&place.path("local")).iter().zip(&results(&place.path("merged"))) {
        assert!(local == merged, "{} differs", local.0.display());
    }
}

#[test]
fn a_merge_of_some_shards_is_partial_and_says_so() {
    let place = Place::new(TINY);
    let shards = shards(&place);
    let partly =
        inkwave(&["merge", &shards[0], &shards[2], "--output", &place.path("partly")]).output().unwrap();
    assert!(!partly.status.success() && said(&partly).contains("variants are finished"), "{}", said(&partly));
    assert!(std::fs::read_to_string(place.path("partly/report.html")).unwrap().contains("Partial results"));
}

#[test]
fn a_sweep_has_plots_and_a_table_of_differences_that_is_described() {
    let place = Place::swept("local");
    let page = std::fs::read_to_string(place.path("local/report.html")).unwrap();
    for plot in ["transmittance at 400 nm against concentration", "chroma C* against grain size"] {
        assert!(page.contains(plot), "no plot of {plot}");
    }
    let table = std::fs::read_to_string(place.path("local/sweep.csv")).unwrap();
    let differences: Vec<&str> = table.lines().skip(1).map(|line| line.rsplit(',').next().unwrap()).collect();
    // The first variant is the reference; all others have an error of their difference to it.
    assert!(
        differences[0].is_empty() && differences[1..].iter().all(|d| d.parse::<f64>().is_ok()),
        "{table}"
    );
    // sweep.csv, conclusions.csv, and two tables of each of eight variants
    assert!(described_tables(Path::new(&place.path("local"))) >= 18);
}

#[test]
fn a_report_made_anew_is_the_same() {
    let place = Place::swept("local");
    let before = results(&place.path("local"));
    std::fs::remove_file(place.path("local/sweep.csv")).unwrap();
    succeed(&["report", &place.path("local")]);
    assert!(before == results(&place.path("local")));
}

#[cfg(unix)]
#[test]
fn a_kill_loses_at_most_the_points_in_flight() {
    let place = Place::new(&TINY.replace("step_nm = 100", "step_nm = 15"));
    let file = place.path("tiny.toml");
    let out = place.path("out");
    let mut child = inkwave(&["sweep", &file, "--output", &out])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let since = Instant::now();
    while points(&out) < 20 {
        assert!(since.elapsed() < Duration::from_secs(60), "no points");
        std::thread::sleep(Duration::from_millis(3));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let survived = store(&out);
    let keys = survived.database().keys(PointRecord::KIND);
    let before: Vec<PointRecord> =
        keys.iter().map(|key| survived.get(key).expect("a whole record")).collect();
    assert!(before.len() >= 20 && Path::new(&out).join("PARTIAL").exists());
    let unfinished = inkwave(&["report", &out]).output().unwrap();
    assert!(said(&unfinished).contains("variants are finished"), "{}", said(&unfinished));
    place.sweep("out", &[]);
    let after = store(&out);
    for record in before {
        assert_eq!(after.get(&record.key), Some(record), "computed twice");
    }
}

#[test]
fn a_variant_that_fails_is_recorded_and_tried_again_when_asked() {
    let hard = TINY.replace("[[axis]]\nname = \"paper\"", "[[override]]\nwhere = { share = \"15 %\" }\nset = { \"solver.max_applications\" = 2 }\n[[axis]]\nname = \"paper\"");
    let place = Place::new(&hard);
    let file = place.path("tiny.toml");
    let out = place.path("out");
    let run =
        |more: &[&str]| inkwave(&[&["sweep", &file, "--output", &out], more].concat()).output().unwrap();
    let first = run(&[]);
    assert_eq!(first.status.code(), Some(1));
    assert!(said(&first).contains("--retry-failed"), "{}", said(&first));
    let finished = points(&out);
    assert!(finished >= 36, "the others are finished: {finished}");
    let table = std::fs::read_to_string(place.path("out/sweep.csv")).unwrap();
    assert!(table.lines().nth(3).unwrap().starts_with("10-200-0.9,10 %,200,0.9,24,24,0,2,"), "{table}");
    assert!(!said(&run(&[])).contains("no result at"), "known failures are not tried again");
    assert!(said(&run(&["--retry-failed"])).contains("no result"), "{}", said(&run(&["--retry-failed"])));
}

/// Sequential addition that may try no more than 7000 times for a grain gets stuck in one of seven realisations, be it after the four
/// that the grid is chosen on or the first of them; the six others count.
#[test]
fn a_packing_that_fails_costs_its_own_realisation_alone() {
    for (seed, stuck) in [(3, 6), (10, 1)] {
        costs_itself_alone(seed, stuck);
    }
}

/// Papers of two albedos under packings that hardly find room.
fn tight(seed: u64, run: &str) -> String {
    let tight = TINY
        .replace("period_um = 0.8\nthickness_um = 0.5", "period_um = 0.6\nthickness_um = 0.4")
        .replace("diameter_nm = 200", "diameter_nm = 180")
        .replace("volume_fraction = 0.15", "volume_fraction = 0.28")
        .replace("realisations = 2\nseed = 7", &format!("{run}\nfailed_packings = 0.5\nseed = {seed}"))
        .replace("step_nm = 100", "step_nm = 150")
        .replace("points_per_um = 20", "points_per_um = 12");
    let packing = "[base.packing]\nmethod = \"sequential_addition\"\nsequential.attempts_per_grain = 7000\n";
    let axes = "[[axis]]\nname = \"paper\"\nfield = \"paper.albedo\"\nvalues = [0.9, 0.5]\n";
    let base = tight.split("[[axis]]").next().expect("a base");
    format!("{base}{packing}{axes}")
}

fn costs_itself_alone(seed: u64, stuck: usize) {
    let place = Place::new(&tight(seed, "realisations = 7"));
    let run =
        || inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out")]).output().unwrap();
    let ran = run();
    let told = said(&ran);
    assert!(
        ran.status.success() && told.contains(&format!("realisation {stuck}: volume fraction")),
        "{told}"
    );
    let table = std::fs::read_to_string(place.path("out/sweep.csv")).unwrap();
    // variant, paper, solves, finished, failures, realisations
    assert!(table.contains("0.9,0.9,54,54,1,6,") && table.contains("0.5,0.5,54,54,1,6,"), "{table}");
    // The same of a variant that runs as a study.
    let variant = std::fs::read_dir(place.path("out/variants")).unwrap().flatten().next().unwrap();
    let study = variant.path().join("study.toml").display().to_string();
    let alone = inkwave(&["run", &study, "--output", &place.path("alone")]).output().unwrap();
    let told = said(&alone);
    assert!(alone.status.success() && told.contains("1 of 7 packings have no room: "), "{told}");
    let spectra = |folder: &Path| std::fs::read(folder.join("spectra.csv")).unwrap();
    assert_eq!(spectra(&variant.path()), spectra(Path::new(&place.path("alone"))));
}

/// A bar that every colour meets is met in spite of a packing that fails.
#[test]
fn a_packing_that_fails_does_not_end_the_way_to_a_bar() {
    let place = Place::new(&tight(10, "realisations = 40\ntarget_delta_e = 99"));
    let run = inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out")]).output().unwrap();
    let table = std::fs::read_to_string(place.path("out/sweep.csv")).unwrap();
    let first: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    let [solves, finished, failures, cells] =
        [2, 3, 4, 5].map(|column| first[column].parse::<usize>().unwrap());
    // the first look has sixteen packings that found room
    let tried = failures + cells;
    assert!(
        solves == finished && failures > 0 && cells >= 16 && tried % 8 == 0 && tried < 40,
        "{table}{}",
        said(&run)
    );
}

#[test]
fn a_plan_counts_what_is_shared_and_computes_nothing_for_good() {
    let place = Place::new(TINY);
    let told = succeed(&["sweep", &place.path("tiny.toml"), "--plan"]);
    let line = |name: &str| {
        told.lines().find(|l| l.starts_with(name)).unwrap_or_else(|| panic!("{told}")).to_owned()
    };
    assert!(line("variants").ends_with(" 8") && line("solves").ends_with(" 72"), "{told}");
    assert!(line("packings").ends_with(" 5"), "{told}");
    let json = succeed(&["sweep", &place.path("tiny.toml"), "--plan", "--json"]);
    assert!(json.contains("\"memory_mb\"") && json.contains("\"core_seconds\""), "{json}");
    assert_eq!(std::fs::read_dir(place.0.path()).unwrap().count(), 1);
}

/// A slip, and words that its message must have: field, value, allowed, remedy.
fn slip(from: &str, to: &str, words: &[&str]) {
    assert!(TINY.contains(from), "{from}");
    let place = Place::new(&TINY.replacen(from, to, 1));
    let output =
        inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out")]).output().unwrap();
    let told = said(&output).split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(!told.contains("panicked") && !Path::new(&place.path("out")).exists(), "{told}");
    words.iter().for_each(|word| assert!(told.contains(word), "{to}: no {word} in\n{told}"));
}

#[test]
fn slips_in_values_and_labels_of_an_axis_are_told() {
    slip(
        "values = [0.10, 0.15]",
        "values = [0.10, 1.15]",
        &["axis[0].values", "1.15", "0.64", "volume_fraction"],
    );
    slip("values = [0.10, 0.15]", "values = []", &["axis[0].values", "an empty list", "from, to"]);
    let once = ["axis[0].count", "found 1 from 0.1 to 0.15", "2 or more", "values = […]"];
    slip("values = [0.10, 0.15]", "from = 0.10\nto = 0.15\ncount = 1", &once);
    let short = ["axis[0].step", "0.04 from 0.1, which ends at 0.14 before 0.15", "to = 0.14"];
    slip(
        "values = [0.10, 0.15]\nlabels = [\"10 %\", \"15 %\"]",
        "from = 0.10\nto = 0.15\nstep = 0.04",
        &short,
    );
    let alone = ["axis[1].zip", "found \"a\" of one axis", "two axes or more", "remove it"];
    slip("\"molecular\", 200]", "\"molecular\", 200]\nzip = \"a\"", &alone);
    slip("name = \"paper\"", "name = \" \"", &["axis[2].name", "a blank name", "name the axis"]);
    slip(
        "[\"10 %\", \"15 %\"]",
        "[\"10 %\", \" \"]",
        &["axis[0].labels", "a blank name", "value of the axis"],
    );
    slip("[\"10 %\", \"15 %\"]", "[\"10 %\"]", &["axis[0].labels", "1 labels", "2 labels"]);
    slip("\"molecular\", 200]", "\"molecular\", 200]\nzip = \"a\"\nfrom = 3", &["axis[1].values"]);
    slip("\"molecular\", 200]", "\"atomic\", 200]", &["atomic", "molecular"]);
    slip(
        "\"15 %\"]",
        &format!("\"{}\"]", "long ".repeat(60)),
        &["axis: found labels", "at most 200", "shorten"],
    );
}

#[test]
fn slips_in_the_fields_of_an_axis_are_told() {
    slip(
        "pigment.yellow.volume",
        "pigment.blue.volume",
        &["axis[0].field", "yellow", "none of them is blue"],
    );
    slip("paper.albedo", "paper.albdo", &["unknown key", "albedo", "did you mean"]);
    slip("pigment.yellow.volume", "pigment[[0].volume", &["axis[0].field", "is no name such as"]);
}

#[test]
fn slips_in_conclusions_are_told() {
    slip(
        "size = 200, paper = 0.9",
        "size = 250, paper = 0.9",
        &["conclusion[0].plus[0].size", "250", "molecular, 200"],
    );
    slip("size = 200, paper = 0.9", "size = 200", &["conclusion[0].plus[0]", "2 variants", "exactly one"]);
    slip(
        "id = \"size\"",
        "id = \"dark paper\"",
        &["conclusion[1].id", "\"dark paper\" twice", "a name that no other conclusion has"],
    );
}

#[test]
fn slips_in_exclusions_and_in_the_base_are_told() {
    slip(
        "[[axis]]",
        "[[exclude]]\nwhere = { colour = 1 }\n[[axis]]",
        &["exclude[0].where", "share, size, paper"],
    );
    let nothing = ["override[0].set", "nothing", "one field or more", "run.seed"];
    slip("[[axis]]", "[[override]]\nwhere = { size = 200 }\nset = {}\n[[axis]]", &nothing);
    let rows = ["sheet.columns", "\"size\", which are the rows", "another axis than sheet.rows"];
    slip("[[axis]]", "[sheet]\nrows = \"size\"\ncolumns = \"size\"\n[[axis]]", &rows);
    slip("period_um = 0.8", "period_um = -0.8", &["base.layer.period_um", "-0.8", "µm is usual"]);
}

#[test]
fn a_study_gets_the_name_of_its_own_command() {
    let start = TINY.find("[base.layer]").unwrap();
    let study = TINY[start..TINY.find("[[axis]]").unwrap()].replace("base.", "");
    let place = Place::new(&study);
    let output =
        inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out")]).output().unwrap();
    let words = said(&output).replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(!output.status.success() && !Path::new(&place.path("out")).exists(), "{words}");
    assert!(words.contains("tiny.toml is a study") && words.contains("`inkwave run "), "{words}");
}

#[test]
fn folders_and_shards_that_are_none_are_refused() {
    let place = Place::new(TINY);
    let fail = |arguments: &[&str], word: &str| {
        let output = inkwave(arguments).output().unwrap();
        assert!(output.status.code() == Some(1) && said(&output).contains(word), "{}", said(&output));
    };
    let file = place.path("tiny.toml");
    for shard in ["4/3", "0/3", "x", "3"] {
        fail(&["sweep", &file, "--shard", shard], "--shard: found");
    }
    fail(&["report", &place.path("nowhere")], "holds no sweep");
    fail(&["merge", &place.path("nowhere"), "--output", &place.path("m")], "holds no sweep");
}

#[test]
fn the_example_studies_are_sound() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for (name, variants) in
        [("paper-study.toml", 260), ("paper-study-small.toml", 12), ("paper-study-errors.toml", 4)]
    {
        let sweep = inkwave::sweep::load::load(&examples.join(name)).unwrap();
        assert_eq!(sweep.variants.len(), variants, "{name}");
    }
}
