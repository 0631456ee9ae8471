//! Pages of a sweep while it runs.

use crate::sweep_support::{Place, TINY, results, store, succeed};
use base64::prelude::{BASE64_STANDARD, Engine};
use inkwave::appearance::colour::ciede2000;
use inkwave::run::RunSettings;
use inkwave::run::watch::{Event, RunWatch};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::store::{PointRecord, Record};
use inkwave::sweep::folder;
use inkwave::sweep::load::load;
use inkwave::sweep::publish::Publisher;
use inkwave::work::run::{Scope, run};
use inkwave::work::units::Shard;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::SystemTime;

/// Stops after a number of solves.
struct Impatient(AtomicUsize);

impl RunWatch for Impatient {
    fn stop(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }

    fn hear(&self, event: Event) {
        if let Event::Solved(..) = event {
            let _ = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        }
    }
}

/// The plot at the start of what follows the mark of its encoding.
fn drawn(rest: &str) -> String {
    let code = rest.split('"').next().unwrap().replace("&#x2f;", "/");
    String::from_utf8(BASE64_STANDARD.decode(code).unwrap()).unwrap()
}

/// The pages of a sweep that runs: written again and again by one publisher, which sees a finished variant once, they say what is
/// missing and end as those of a sweep that was reported once. *Planted*: variants kept before they are finished stay partial.
#[test]
fn pages_written_while_a_sweep_runs_say_what_is_missing_and_end_like_all_others() {
    let place = Place::new(&format!("{TINY}[sheet]\nrows = \"paper\"\ncolumns = \"share\"\n"));
    let sweep = load(Path::new(&place.path("tiny.toml"))).unwrap();
    let folder = OutputFolder::open(Path::new(&place.path("live")), Holds::Sweep).unwrap();
    folder::write(&sweep, &folder).unwrap();
    let mut publisher = Publisher::new(&sweep);
    let settings = RunSettings { jobs: Some(1), ..RunSettings::default() };
    let mut told = Vec::new();
    for solves in [30, 25, 1000] {
        let watch = Impatient(AtomicUsize::new(solves));
        run(&sweep.variants, &folder, (Shard::ALL, Scope::Solves), settings, &watch).unwrap();
        let reported = publisher.publish(&folder).unwrap();
        let page = std::fs::read_to_string(place.path("live/report.html")).unwrap();
        let finished: usize = reported.outcomes.iter().map(|o| o.solves.finished).sum();
        let missing = page.contains(&format!("{finished} of 144 solves"));
        told.push((reported.complete(), missing, Path::new(&place.path("live/PARTIAL")).exists()));
    }
    let [(first, ..), (second, ..), last] = told[..] else { panic!("three pages") };
    assert!(0 < second && first <= second && second < 8 && last == (8, false, false), "{told:?}");
    assert!(told[..2].iter().all(|(_, missing, partial)| *missing && *partial), "{told:?}");
    // Rows of one sheet that differ in the paper alone are two curves, not one.
    let page = std::fs::read_to_string(place.path("live/report.html")).unwrap();
    let plots: Vec<String> = page.split("svg+xml;base64,").skip(1).map(drawn).collect();
    for curve in ["200 nm spheres, paper 0.9", "200 nm spheres, paper 0.5"] {
        assert!(plots.iter().any(|plot| plot.contains(curve)), "no curve {curve}");
    }
    place.sweep("local", &[]);
    for (local, live) in results(&place.path("local")).iter().zip(&results(&place.path("live"))) {
        assert!(local == live, "{} differs", local.0.display());
    }
}

/// When the report page of each variant was written, by the variant's name.
fn pages_written(place: &Place) -> BTreeMap<String, SystemTime> {
    let variants = std::fs::read_dir(place.path("out/variants")).unwrap().map(|entry| entry.unwrap());
    let written = |page: &Path| page.metadata().unwrap().modified().unwrap();
    let name = |entry: &std::fs::DirEntry| entry.file_name().into_string().unwrap();
    variants.map(|entry| (name(&entry), written(&entry.path().join("report.html")))).collect()
}

/// The names of the variants whose pages a sweep makes anew; all its results must be as before.
fn made_anew(place: &Place, whole: &[(PathBuf, Vec<u8>)]) -> Vec<String> {
    let before = pages_written(place);
    place.sweep("out", &[]);
    for (before, after) in whole.iter().zip(&results(&place.path("out"))) {
        assert!(before == after, "{} differs", before.0.display());
    }
    let after = pages_written(place);
    before.into_iter().filter(|(name, at)| after[name] != *at).map(|(name, _)| name).collect()
}

/// Finished pages stay as they are, with the numbers that the sweep's own page and conclusions need; what is damaged, missing or
/// made from other records is made anew. *Planted*: files are not compared; the records are not; contributions of realisations
/// to weighted numbers are lost; nothing is kept.
#[test]
fn a_page_is_made_anew_only_where_something_changed() {
    let conclusion = "[[conclusion]]\nid = \"luminance\"\nstatement = \"White paper reflects more\"\nquantity = \"number\"\n\
                      number = \"Y\"\nplus = [{ share = \"10 %\", size = 200, paper = 0.9 }]\n\
                      minus = [{ share = \"10 %\", size = 200, paper = 0.5 }]\nat_least = 0.1\n";
    let number = "[[base.number]]\nname = \"Y\"\nweights = \"D65/2\"\nof = \"natural_light\"\n";
    let place = Place::new(&format!("{TINY}{number}{conclusion}"));
    place.sweep("out", &[]);
    let whole = results(&place.path("out"));
    let names: Vec<String> = pages_written(&place).into_keys().collect();
    assert_eq!(made_anew(&place, &whole), [""; 0], "nothing has changed");
    let file = |variant: usize, name: &str| place.path(&format!("out/variants/{}/{name}", names[variant]));
    std::fs::remove_file(file(1, "picture.png")).unwrap();
    let damaged = std::fs::read_to_string(file(4, "results.json")).unwrap().replacen('1', "2", 1);
    std::fs::write(file(4, "results.json"), damaged).unwrap();
    assert_eq!(made_anew(&place, &whole), [names[1].clone(), names[4].clone()]);
    assert_eq!(made_anew(&place, &whole), [""; 0], "mended");
    // a solve that is done again takes another time, which the pages of all papers on which it is shown tell
    let records = store(&place.path("out"));
    let key = records.database().keys(PointRecord::KIND).pop_first().unwrap();
    records.remove(&key).unwrap();
    drop(records);
    let anew = made_anew(&place, &whole);
    assert!((1..=4).contains(&anew.len()), "{anew:?}");
    assert_eq!(made_anew(&place, &whole), [""; 0], "done again");
}

/// Rows of `sweep.csv` by column.
fn table(place: &Place) -> Vec<BTreeMap<String, String>> {
    let mut rows = csv::Reader::from_path(place.path("out/sweep.csv")).unwrap();
    rows.deserialize().collect::<Result<_, _>>().unwrap()
}

/// The colour of one variant as the target of all: that one is the nearest on both pages, and the table has the numbers of each
/// variant's own results. Without a target the table has no further column, and with one the others stay.
#[test]
fn a_sweep_with_a_target_names_the_variant_that_meets_it() {
    let place = Place::swept("out");
    let results = |variant: &str| -> serde_json::Value {
        let path = place.path(&format!("out/variants/{variant}/results.json"));
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
    };
    let plain = table(&place);
    let wanted = "15-200-0.5";
    let header = |text: &str| text.lines().next().unwrap().to_owned();
    let before = header(&std::fs::read_to_string(place.path("out/sweep.csv")).unwrap());
    assert!(before.ends_with(",delta_e_2000,delta_e_2000_standard_error"), "{before}");
    let lab: [f64; 3] = serde_json::from_value(results(wanted)["ink_maker"]["print"]["lab"].clone()).unwrap();
    let target = format!("[base.colour]\ntarget_lab = {lab:?}\n[[axis]]");
    std::fs::write(place.path("tiny.toml"), TINY.replacen("[[axis]]", &target, 1)).unwrap();
    let console = place.sweep("out", &[]);
    let text = std::fs::read_to_string(place.path("out/sweep.csv")).unwrap();
    let more = ",delta_e_2000_to_target,delta_e_2000_to_target_standard_error,contrast_ratio,contrast_ratio_standard_error";
    assert_eq!(header(&text), before + more);
    for (row, plain) in table(&place).iter().zip(&plain) {
        assert!(plain.iter().all(|(name, value)| row[name] == *value), "{row:?}");
        let maker = &results(&row["variant"])["ink_maker"];
        for (column, number) in [
            ("delta_e_2000_to_target", &maker["target"]["delta_e_2000"]),
            ("contrast_ratio", &maker["contrast_ratio"]),
        ] {
            for (end, key) in [("", "value"), ("_standard_error", "standard_error")] {
                let cell = row[&format!("{column}{end}")].parse::<f64>().ok();
                assert_eq!(cell, number[key].as_f64(), "{column}{end} of {}", row["variant"]);
            }
        }
    }
    let nearest = table(&place).into_iter().min_by(|a, b| {
        let far = |row: &BTreeMap<String, String>| row["delta_e_2000_to_target"].parse::<f64>().unwrap();
        far(a).total_cmp(&far(b))
    });
    assert_eq!(nearest.unwrap()["variant"], wanted);
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(page.contains("Nearest to the target") && page.contains(&format!("{wanted} is nearest.")));
    let edge = "It lies at the edge of the sweep (share 15 % is the largest";
    let explorer = std::fs::read_to_string(place.path("out/explore.html")).unwrap();
    assert!(explorer.contains("\"target\":{\"colour\":\"L* ") && explorer.contains(edge));
    assert!(page.contains(edge), "{page}");
    assert!(console.contains(&format!("{wanted} is nearest.")) && console.contains(edge), "{console}");
    succeed(&["report", &place.path("out")]);
    assert_eq!(std::fs::read_to_string(place.path("out/sweep.csv")).unwrap(), text);
}

/// Two inks of two sizes, the yellow one first.
const INKS: &str = r#"
[[axis]]
name = "ink"
[[axis.case]]
label = "yellow"
[[axis.case]]
label = "blue"
set = { pigment = [{ name = "blue", diameter_nm = 200, volume_fraction = 0.15, index = { built_in = "blue" } }] }
[[axis]]
field = "pigment[0].diameter_nm"
values = [200, 150]
"#;

/// The cells of a sweep's table that a variant has: its labels and its numbers.
fn cells<'a>(page: &'a str, labels: [&str; 2]) -> Vec<&'a str> {
    let [ink, size] = labels;
    let row = page.split(&format!("<tr><td>{ink}</td><td>{size}</td>")).nth(1).expect("a row");
    let row = row.split("</tr>").next().unwrap();
    row.split("<td class=\"n\">").skip(1).map(|cell| cell.split("</td>").next().unwrap()).collect()
}

/// *Planted*: a blue ink had a ΔE to a yellow one that was not requested, and the axis of diameters no unit.
#[test]
fn differences_between_inks_are_shown_where_they_are_asked_for_and_axes_have_units() {
    let base = TINY.split("[[axis]]").next().unwrap();
    let place = Place::new(&format!("{base}{INKS}"));
    place.sweep("out", &[]);
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(page.contains("<th>diameter, nm</th>"), "{page}");
    let explorer = std::fs::read_to_string(place.path("out/explore.html")).unwrap();
    assert!(explorer.contains("\"name\":\"diameter, nm\""));
    let difference = |ink: &str, size: &str| cells(&page, [ink, size])[5].to_owned();
    assert!(difference("yellow", "150").contains('.'), "{:?}", cells(&page, ["yellow", "150"]));
    assert_eq!([difference("blue", "200"), difference("blue", "150")], ["", ""]);
    std::fs::write(place.path("tiny.toml"), format!("reference = {{ ink = \"yellow\" }}\n{base}{INKS}"))
        .unwrap();
    place.sweep("out", &[]);
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(cells(&page, ["blue", "200"])[5].contains('.'), "{page}");
}

/// What the explorer of a sweep in `out` shows.
fn explored(place: &Place) -> serde_json::Value {
    let page = std::fs::read_to_string(place.path("out/explore.html")).unwrap();
    let data = page.lines().find_map(|line| line.strip_prefix("const data = ")).unwrap();
    serde_json::from_str(data.trim_end_matches(';')).unwrap()
}

/// L*, a*, b* with their errors of the explorer's variant at a place, and those of a study of its own.
fn evaluated_and_run(place: &Place, at: [f64; 3], study: &str) -> [Vec<f64>; 2] {
    let data = explored(place);
    let is_here = |variant: &&serde_json::Value| {
        let place = variant["place"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
        place.eq(at[..data["axes"].as_array().unwrap().len()].iter().copied())
    };
    let variant = data["variants"].as_array().unwrap().iter().find(is_here).expect("a variant");
    assert!(variant["nearest"].is_u64(), "{variant}");
    let shown = (0..6).map(|i| variant["numbers"][i / 2][i % 2].as_f64().unwrap());
    std::fs::write(place.path("own.toml"), study).unwrap();
    succeed(&["run", &place.path("own.toml"), "--output", &place.path("own")]);
    let own: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("own/results.json")).unwrap()).unwrap();
    let number = |i: usize| {
        let lab = i / 2;
        let name = ["value", "standard_error"][i % 2];
        let colours = own["colours"].as_array().unwrap();
        match colours.iter().find(|colour| colour["conditions"] == "natural light") {
            Some(whole) => whole[["lab", "lab_standard_error"][i % 2]][lab].as_f64(),
            None => colours.last().unwrap()["natural_light"][lab][name].as_f64(),
        }
    };
    [shown.collect(), (0..6).map(|i| number(i).unwrap_or_else(|| panic!("{own}"))).collect()]
}

/// Papers need no solves of their own: what the explorer shows between them is a study's own result, while it interpolates
/// shares. *Planted*: half-way between both colours instead (L* off by .6).
#[test]
fn the_explorer_evaluates_papers_between_others_from_the_same_solves() {
    let place = Place::swept("out");
    let data = explored(&place);
    let steps: Vec<u64> = (0..3).map(|a| data["axes"][a]["steps"].as_u64().unwrap()).collect();
    assert_eq!(steps, [1, 1, 8]);
    assert_eq!(data["variants"].as_array().unwrap().len(), 8 + 4 * 7);
    let text = std::fs::read_to_string(place.path("out/variants/15-200-0.5/study.toml")).unwrap();
    let [shown, own] =
        evaluated_and_run(&place, [1.0, 1.0, 0.25], &text.replace("albedo = 0.5", "albedo = 0.8"));
    let half_a_digit = 1e-6;
    assert!(shown.iter().zip(&own).all(|(a, b)| (a - b).abs() < half_a_digit), "{shown:?} {own:?}");
    let before = std::fs::read(place.path("out/explore.html")).unwrap();
    succeed(&["report", &place.path("out")]);
    assert!(
        before == std::fs::read(place.path("out/explore.html")).unwrap(),
        "kept numbers are those of before"
    );
}

/// Thicknesses of a composed layer are powers of its slabs, whole and broken ones. *Planted*: thicknesses interpolated.
#[test]
fn the_explorer_evaluates_thicknesses_between_others_from_the_same_slabs() {
    let base = "title = 'Slabs'\n[base.layer]\nperiod_um = 0.8\nbinder.index = 1.5\ncomposed = { slab_um = 0.5 }\n\
                [[base.pigment]]\nname = 'grains'\ndiameter_nm = 200\nvolume_fraction = 0.15\nindex = { n = 2.0, k = 0.02 }\n\
                [base.paper]\nalbedo = 0.5\n[base.light]\nwavelengths_nm = [400, 460, 520, 580, 640, 700]\n\
                [base.run]\nrealisations = 2\nseed = 7\n[base.resolution]\npoints_per_um = 12\nplanes_per_um = 36\n";
    let place = Place::new(&format!(
        "{base}[[axis]]\nname = 'thickness'\nfield = 'layer.thickness_um'\nvalues = [1.0, 3.0]\n"
    ));
    place.sweep("out", &[]);
    assert_eq!(explored(&place)["axes"][0]["steps"], 8);
    let text = base.replace("base.", "").replace("[layer]\n", "[layer]\nthickness_um = [1.0, 1.75]\n");
    let [shown, own] = evaluated_and_run(&place, [0.375, 0.0, 0.0], &text);
    assert!(shown.iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-6), "{shown:?} {own:?}");
}

/// The explorer interpolates along the axis of three shares; with two papers, or sizes of which one is a word, it does not. Its
/// leave-one-out errors follow from the table alone. *Planted*: errors of the variants at the ends would be extrapolated.
#[test]
fn the_explorer_interpolates_between_three_numbers_with_the_error_of_leaving_one_out() {
    let three = "values = [0.10, 0.15, 0.20]\nlabels = [\"10 %\", \"15 %\", \"20 %\"]";
    let two = "values = [0.10, 0.15]\nlabels = [\"10 %\", \"15 %\"]";
    let place = Place::new(&TINY.replace(two, three));
    place.sweep("out", &[]);
    let data = explored(&place);
    let between = |a: usize| &data["axes"][a]["between"];
    assert_eq!(between(0)["values"], serde_json::json!([10.0, 15.0, 20.0]));
    assert!(between(1).is_null() && between(2).is_null(), "{}", data["axes"]);
    let rows = table(&place);
    let row = |variant: &str| rows.iter().find(|row| row["variant"] == variant).unwrap();
    let lab = |variant: &str| ["L", "a", "b"].map(|c| row(variant)[c].parse::<f64>().unwrap());
    let t = if between(0)["logarithmic"] == true { 1.5_f64.log2() } else { 0.5 };
    let solved = data["variants"].as_array().unwrap().iter().filter(|variant| variant["nearest"].is_null());
    for (v, variant) in solved.enumerate() {
        let (share, rest) = variant["name"].as_str().unwrap().split_once('-').unwrap();
        let low = lab(&format!("10-{rest}"));
        let middle = lab(&format!("15-{rest}"));
        let high = lab(&format!("20-{rest}"));
        let line: [f64; 3] = std::array::from_fn(|i| low[i] + t * (high[i] - low[i]));
        let expected = (share == "15").then(|| ciede2000(line, middle));
        let found = between(0)["left_out"][v].as_f64();
        assert!(
            (found.unwrap_or(-1.0) - expected.unwrap_or(-1.0)).abs() < 1e-9,
            "{variant}: {found:?} {expected:?}"
        );
    }
}
