//! Conclusions of a sweep: whose they are, which wavelengths they speak of, and what they compare.

use crate::sweep_support::{Place, TINY, inkwave, said};
use inkwave::sweep::load::load;
use std::collections::BTreeMap;
use std::path::Path;

const CONCLUSIONS: &str = r#"
[[conclusion]]
id = "pale"
each = "share"
statement = "Grains transmit more where the molecular mixture absorbs well"
source = "P1"
quote = "слой пропускает заметно больше света"
translation = "the layer transmits noticeably more light"
because = "On the mean over that part"
quantity = "transmittance"
range_nm = [400, 700]
over = "mean"
absorbed_by = { size = "molecular", paper = 0.9 }
plus = [{ size = 200, paper = 0.9 }]
minus = [{ size = "molecular", paper = 0.9 }]
at_least = 0
[[conclusion]]
id = "somewhere"
statement = "They differ somewhere"
quantity = "transmittance"
range_nm = [400, 700]
over = "some"
absolute = true
plus = [{ share = "15 %", size = 200, paper = 0.9 }]
minus = [{ share = "15 %", size = "molecular", paper = 0.9 }]
at_least = 0.001
[[conclusion]]
id = "hiding"
statement = "More pigment hides more"
quantity = "contrast_ratio"
plus = [{ share = "15 %", size = 200, paper = 0.9 }]
minus = [{ share = "10 %", size = 200, paper = 0.9 }]
at_most = 0.5
[[conclusion]]
id = "nearer"
statement = "White paper is nearer to the target"
quantity = "delta_e_to_target"
plus = [{ share = "10 %", size = 200, paper = 0.5 }]
minus = [{ share = "10 %", size = 200, paper = 0.9 }]
at_least = 1
"#;

type Row = BTreeMap<String, String>;

fn rows(path: &str) -> Vec<Row> {
    let mut table = csv::Reader::from_path(path).unwrap();
    table.deserialize().map(|row| row.unwrap()).collect()
}

fn found<'a>(rows: &'a [Row], key: &str, name: &str) -> &'a Row {
    rows.iter().find(|row| row[key] == name).unwrap_or_else(|| panic!("no {name}"))
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {row:?}"))
}

/// T at the smallest angle where T of the molecular mixture is in the lower half between its least and its greatest.
fn mean_gain(place: &Place, share: &str) -> f64 {
    let of = |size: &str| -> Vec<f64> {
        let rows = rows(&place.path(&format!("out/variants/{share}-{size}-0.9/spectra.csv")));
        let first = rows[0]["polar_deg"].clone();
        rows.iter().filter(|row| row["polar_deg"] == first).map(|row| number(row, "transmittance")).collect()
    };
    let grains = of("200");
    let mixture = of("molecular");
    let low = mixture.iter().copied().reduce(f64::min).unwrap();
    let high = mixture.iter().copied().reduce(f64::max).unwrap();
    let part = mixture.iter().zip(&grains).filter(|(m, _)| **m <= 0.5 * (low + high));
    let gains: Vec<f64> = part.map(|(m, g)| g - m).collect();
    assert!(!gains.is_empty() && gains.len() < mixture.len(), "{mixture:?}");
    gains.iter().sum::<f64>() / gains.len() as f64
}

/// *Planted*: a mean over the whole range, or the same labels for both shares, gives other numbers.
#[test]
fn conclusions_say_whose_they_are_and_measure_what_they_say() {
    let text = TINY.replace("[base.output]", "[base.colour]\ntarget_lab = [90, -5, 30]\n[base.output]");
    let place = Place::new(&format!("{text}{CONCLUSIONS}"));
    place.sweep("out", &[]);
    let judged = rows(&place.path("out/conclusions.csv"));
    let of_variants = rows(&place.path("out/sweep.csv"));
    // numbers of 16 digits, a few additions
    for (id, share) in [("10 %: pale", "10"), ("15 %: pale", "15")] {
        let row = found(&judged, "id", id);
        let wanted = mean_gain(&place, share);
        approx::assert_abs_diff_eq!(number(row, "measured"), wanted, epsilon = 1e-12);
        assert_eq!((row["source"].as_str(), row["because"].as_str()), ("P1", "On the mean over that part"));
        assert!(
            row["quote"].contains("заметно больше") && row["translation"].contains("noticeably"),
            "{row:?}"
        );
    }
    let difference = |column: &str, [a, b]: [&str; 2]| {
        number(found(&of_variants, "variant", a), column) - number(found(&of_variants, "variant", b), column)
    };
    let hiding = difference("contrast_ratio", ["15-200-0.9", "10-200-0.9"]);
    let nearer = difference("delta_e_2000_to_target", ["10-200-0.5", "10-200-0.9"]);
    approx::assert_abs_diff_eq!(number(found(&judged, "id", "hiding"), "measured"), hiding, epsilon = 1e-12);
    approx::assert_abs_diff_eq!(number(found(&judged, "id", "nearer"), "measured"), nearer, epsilon = 1e-10);
    assert!(number(found(&judged, "id", "hiding"), "standard_error") > 0.0);
    assert!(found(&judged, "id", "somewhere")["inequality"].starts_with("|T400–700("));
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("no {words}"));
    assert!(at("What P1 says") < at("слой пропускает") && at("слой пропускает") < at("Our own questions"));
    assert!(at("Our own questions") < at("White paper is lighter"));
}

#[test]
fn slips_of_conclusions_name_their_key() {
    let slip = |from: &str, to: &str, words: [&str; 2]| {
        let place = Place::new(&format!("{TINY}{CONCLUSIONS}").replace(from, to));
        let output = inkwave(&["sweep", &place.path("tiny.toml"), "--plan"]).output().unwrap();
        let text = said(&output).replace("\n  │ ", " ");
        assert!(!output.status.success() && words.iter().all(|word| text.contains(word)), "{text}");
    };
    let near = "id = \"nearer\"";
    slip(near, near, ["conclusion.quantity", "base.colour.target_lab"]);
    slip("each = \"share\"", "each = \"shape\"", ["conclusion[2].each", "share, size, paper"]);
    slip("source = \"P1\"\n", "", ["conclusion[2].quote", "quotation without a source"]);
    slip("[400, 700]\nover = \"some\"", "[400, 700]\nover = \"any\"", ["any", "some"]);
    let range = "range_nm = [400, 700]\nover = \"some\"";
    let point = "wavelength_nm = 400\nover = \"some\"";
    slip(range, point, ["conclusion[3].over", "range_nm"]);
}

/// What is published are the sentences that the study asks, the paper's with their words; `scripts/paper-study --judge` renews it.
#[test]
fn the_published_verdicts_are_of_the_conclusions_that_the_study_asks() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sweep = load(&root.join("examples/paper-study.toml")).unwrap();
    let table = root.join("reports/paper-study/variants-260/conclusions.csv");
    let published = rows(&table.display().to_string());
    let ids = |of: &[Row]| of.iter().map(|row| row["id"].clone()).collect::<Vec<_>>();
    let asked: Vec<String> = sweep.outline.claims.iter().map(|claim| claim.table.id.clone()).collect();
    assert_eq!(ids(&published), asked, "scripts/paper-study --judge");
    for (row, claim) in published.iter().zip(&sweep.outline.claims) {
        let words = &claim.table;
        assert_eq!(row["quote"], words.quote.as_deref().unwrap_or_default(), "{}", words.id);
        assert_eq!(row["statement"], words.statement, "{}", words.id);
        assert_eq!(words.source.is_some(), words.quote.is_some() && words.translation.is_some());
        assert!(words.because.is_some() && !row["verdict"].is_empty(), "{}", words.id);
    }
}
