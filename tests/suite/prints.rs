//! Prints as a user runs them: dots, measured and brightened paper, of layers that are solved as a whole and of composed ones.

use super::run_support::{TINY, described_tables, study, succeed};
use serde_json::Value;
use std::path::Path;

const DOTS: &str =
    "[dots]\nruling_per_cm = 60\nspread_um = 40\nphysical_gain = 0.05\n[[area]]\ncoverage = [0.25, 0.5]\n";
const BANDS: &str =
    "excitation = [[300, 0.2], [360, 0.8], [420, 0]], emission = [[410, 0], [440, 1], [500, 0]]";
const COMPOSED: &str = r#"
[layer]
period_um = 0.8
thickness_um = [1, 2]
binder.index = 1.5
composed = { slab_um = 0.5 }
[[pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.15
index = { n = 2.0, k = 0.02 }
[light]
wavelengths_nm = [300, 360, 400, 450, 500, 550, 600, 650, 700]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 36
"#;

fn results(text: &str) -> (Value, tempfile::TempDir) {
    let scratch = tempfile::tempdir().unwrap();
    let output = scratch.path().join("out");
    succeed(&study(scratch.path(), text), &output, &[]);
    let results = std::fs::read(output.join("results.json")).expect("results");
    (serde_json::from_slice(&results).expect("JSON"), scratch)
}

fn lab(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value["lab"][i]["value"].as_f64().expect("a number"))
}

/// The solid in dots is the solid; tints lie between it and the paper, darker than Murray and Davies say; tables are
/// described. *Planted*: the spread of a solid's light left out.
#[test]
fn tints_lie_between_paper_and_solid() {
    // an ink that absorbs: of a clear one the layer sends back more of what the paper returns than it takes
    let absorbing = TINY.replace("{ built_in = \"yellow\" }", "{ n = 1.5, k = 0.3 }");
    let (results, scratch) = results(&format!("{absorbing}{DOTS}"));
    let prints = results["prints"]["prints"].as_array().expect("prints");
    assert_eq!(prints.len(), 4);
    let factors = prints[3]["factors"].as_array().expect("factors");
    let lit: Vec<&Value> =
        results["spectra"].as_array().unwrap().iter().filter(|row| row["polar_deg"] == 0.0).collect();
    for (factor, row) in factors.iter().zip(lit) {
        let solid = factor["value"].as_f64().unwrap();
        let lit = row["lit_at_45"]["value"].as_f64().unwrap();
        // an identity: rounding
        assert!((solid - lit).abs() < 1e-14, "{solid} {lit}");
    }
    let lightness: Vec<f64> = prints.iter().map(|print| lab(print)[0]).collect();
    assert!(lightness.windows(2).all(|pair| pair[0] > pair[1]), "{lightness:?}");
    let gain = prints[2]["optical_gain"]["value"].as_f64().expect("a gain");
    assert!(
        gain > 0.0 && (prints[2]["physical_gain"].as_f64().unwrap() - 0.05).abs() < 1e-12,
        "{}",
        prints[2]
    );
    assert!(prints[2]["yule_nielsen"].as_f64().unwrap() > 1.1);
    assert!(prints[2]["lab"][0]["standard_error"].as_f64().unwrap() > 0.0);
    assert!(described_tables(&scratch.path().join("out")) >= 4);
    let page = std::fs::read_to_string(scratch.path().join("out/report.html")).unwrap();
    assert!(page.contains("<h2>Prints</h2>") && page.contains("Clapper"), "no prints on the page");
}

/// Composed layers: dots of full coverage are the solid, and a brightener without yield changes no number.
#[test]
fn composed_layers_are_printed_as_well() {
    let paper = |quantum_yield: f64| {
        format!(
            "{COMPOSED}{DOTS}[paper]\nalbedo = 0.9\nfluorescence = {{ {BANDS}, yield = {quantum_yield} }}\n"
        )
    };
    let (dark, _) = results(&paper(0.0));
    let (bright, _) = results(&paper(0.7));
    let number = |row: &Value, key: &str| row[key]["value"].as_f64().expect("a number");
    let rows = |results: &Value| results["spectra"].as_array().expect("rows").clone();
    let prints = |results: &Value| results["prints"]["prints"].as_array().expect("prints").clone();
    assert_eq!(prints(&bright).len(), 2 * 3 * 4);
    for (plain, lit) in rows(&dark).iter().zip(rows(&bright)) {
        let nm = plain["wavelength_nm"].as_f64().unwrap();
        for key in ["lit_at_45", "natural_light"] {
            let emitted = number(&lit, key) - number(plain, key);
            match nm {
                450.0 => assert!(emitted > 0.01, "{key} at {nm} nm: {emitted}"),
                // emission ends at 500 nm
                500.0.. => assert!(emitted.abs() < 1e-12, "{key} at {nm} nm: {emitted}"),
                _ => {}
            }
        }
    }
    // without ultraviolet light there is no more light than without a brightener
    for (plain, lit) in prints(&dark).iter().zip(prints(&bright)) {
        if plain["condition"] == "M2" {
            assert_eq!(lab(plain), lab(&lit));
        } else {
            let difference: f64 = lab(plain)[2] - lab(&lit)[2];
            assert!(difference > 0.0, "bluer by what is emitted: {difference}");
        }
    }
    // the solid at 45:0 without emission
    for (print, um) in [(prints(&dark)[3].clone(), 1.0), (prints(&dark)[15].clone(), 2.0)] {
        assert_eq!(print["thickness_um"], um);
        let rows = rows(&dark);
        let of_thickness = rows.iter().filter(|row| row["thickness_um"] == um);
        for (factor, row) in print["factors"].as_array().unwrap().iter().zip(of_thickness) {
            assert!((factor["value"].as_f64().unwrap() - number(row, "lit_at_45")).abs() < 1e-12);
        }
    }
}

/// A brightener without yield and without excitation changes no digit of a study; one with both makes the print bluer, and
/// its bare paper reads what was measured.
#[test]
fn brightened_paper_is_bluer_and_a_dark_brightener_changes_nothing() {
    let base = TINY
        .replace("from_nm = 400", "from_nm = 300")
        .replace("step_nm = 100", "step_nm = 20")
        .replace("index = { built_in = \"yellow\" }", "index = { n = 1.7, k = 0.05 }");
    let paper = |fluorescence: &str| format!("{base}[paper]\nalbedo = 0.9\n{fluorescence}\n");
    let (plain, _) = results(&paper(""));
    let (dark, _) = results(&paper(
        "fluorescence = { excitation = [[300, 0], [420, 0]], emission = [[410, 0], [440, 1], [500, 0]], yield = 0 }",
    ));
    assert_eq!(plain["spectra"], dark["spectra"]);
    assert_eq!(plain["colours"], dark["colours"]);
    let (bright, _) = results(&paper(&format!("fluorescence = {{ {BANDS}, yield = 0.6 }}")));
    let b = |results: &Value| results["colours"][1]["lab"][2].as_f64().expect("b*");
    assert!(b(&plain) - b(&bright) > 1.0, "{} {}", b(&plain), b(&bright));
}

/// What is read of a measured paper is what the study's bare paper reads, and the page says so.
#[test]
fn measured_paper_is_returned() {
    let scratch = tempfile::tempdir().unwrap();
    let rows: String =
        (0..=15).map(|k| format!("{},{}\n", 400 + 20 * k, 0.80 + 0.004 * f64::from(k))).collect();
    std::fs::write(scratch.path().join("paper.csv"), format!("wavelength_nm,reflectance\n{rows}")).unwrap();
    let text = TINY.replace("binder.index = 1.558", "binder.index = 1.5\nindex_out = 1.5");
    let paper =
        "[paper]\ncoupling = \"optical_contact\"\nmeasured = { csv = \"paper.csv\", unit = \"factor\" }\n";
    let output = scratch.path().join("out");
    let printed = succeed(&study(scratch.path(), &format!("{text}{DOTS}{paper}")), &output, &[]);
    assert!(printed.contains("behind the paper's surface the albedo is"), "{printed}");
    let results: Value =
        serde_json::from_slice(&std::fs::read(output.join("results.json")).unwrap()).unwrap();
    let bare = &results["prints"]["prints"][0];
    for (k, factor) in bare["factors"].as_array().unwrap().iter().enumerate() {
        let measured = 0.80 + 0.004 * 5.0 * k as f64;
        assert!((factor["value"].as_f64().unwrap() - measured).abs() < 1e-12, "{factor} {measured}");
    }
    assert!(results["study"]["paper"]["measured"]["geometry"] == "45:0");
    let page = std::fs::read_to_string(Path::new(&output).join("report.html")).unwrap();
    assert!(page.contains("paper as measured"), "the page says how the albedo was made");
}

/// Three inks that absorb one third of the spectrum each, and their overprints: clear layers, which need no grains.
const THIRDS: &str = r#"
[layer]
thickness_um = THICKNESS
binder.index = { n = 1.5, k = 0.02 }
index_out = 1.5
[paper]
coupling = "optical_contact"
albedo = 0.93
[light]
from_nm = 400
to_nm = 700
step_nm = 20
"#;

fn of_thickness(um: f64) -> String {
    THIRDS.replace("THICKNESS", &um.to_string())
}

/// Prints of two inks whose layers and overprint are three runs: every factor is what returns that are followed one by one
/// give with Demichel's shares; without spread it is the average of the solids. 49 patches need no further solve.
/// *Planted*: the shares of the second ink for those of the overprint.
#[test]
fn overprints_share_the_area_as_demichel_says() {
    use inkwave_validation::formulas::returns::Returns;
    let scratch = tempfile::tempdir().unwrap();
    let run = |name: &str, text: &str| -> Value {
        let file = scratch.path().join(format!("{name}.toml"));
        std::fs::write(&file, text).unwrap();
        let output = scratch.path().join(name);
        succeed(&file, &output, &[]);
        serde_json::from_slice(&std::fs::read(output.join("results.json")).unwrap()).unwrap()
    };
    let alone = [run("cyan", &of_thickness(0.7)), run("yellow", &of_thickness(1.1))];
    let levels = "[0, 0.1, 0.25, 0.5, 0.75, 0.9, 1]";
    let inks = format!(
        "[[ink]]\nname = 'cyan'\ncoverage = {levels}\n[[ink]]\nname = 'yellow'\ncoverage = {levels}\n\
         [[area]]\ninks = ['cyan']\nresults = 'cyan'\n[[area]]\ninks = ['yellow']\nresults = 'yellow'\n\
         [[area]]\ninks = ['yellow', 'cyan']\n"
    );
    let screen = |spread_um: f64| {
        format!("[dots]\nruling_per_cm = 60\nspread_um = {spread_um}\npatches = 'grid'\n{inks}")
    };
    let spread = run("spread", &format!("{}{}", of_thickness(1.8), screen(40.0)));
    let open = run("open", &format!("{}{}", of_thickness(1.8), screen(0.0)));
    let number = |value: &Value| value.as_f64().expect("a number");
    let factor = |print: &Value, w: usize| number(&print["factors"][w]["value"]);
    let prints = |results: &Value| results["prints"]["prints"].as_array().expect("prints").clone();
    assert_eq!(prints(&spread).len(), 1 + 49 + 1);
    let bare = behind_bare(&spread);
    for print in &prints(&spread)[1..50] {
        let c = number(&print["inks"][0]["coverage"]);
        let y = number(&print["inks"][1]["coverage"]);
        for w in [0, 7, 15] {
            let kinds = [&alone[0], &alone[1], &spread].map(|results| areas_of(results, w));
            let shares = [c * (1.0 - y), y * (1.0 - c), c * y, (1.0 - c) * (1.0 - y)];
            let reflected: f64 = kinds.iter().zip(shares).map(|((alone, _), share)| alone * share).sum();
            let areas = [kinds.iter().map(|(_, area)| *area).chain([bare]).collect::<Vec<_>>()];
            let truth = Returns {
                areas: &areas,
                shares: &shares,
                spread: number(&print["spread"]),
                paper: &[vec![0.93]],
                light: &[1.0],
            };
            let expected = reflected + truth.factors(600)[0];
            let printed = factor(print, w);
            // rounding, and what 600 returns of 0.6 leave
            assert!((printed - expected).abs() < 1e-12, "{c} {y}: {printed} {expected}");
        }
    }
    let all = prints(&open);
    let solid = |c: f64, y: f64| {
        let is = |print: &&Value| {
            number(&print["inks"][0]["coverage"]) == c && number(&print["inks"][1]["coverage"]) == y
        };
        all[1..50].iter().find(is).expect("a patch").clone()
    };
    let corners = [solid(0.0, 0.0), solid(1.0, 0.0), solid(0.0, 1.0), solid(1.0, 1.0)];
    for (corner, results) in corners[1..].iter().zip([&alone[0], &alone[1], &open]) {
        let rows = results["spectra"].as_array().unwrap();
        let lit: Vec<&Value> = rows.iter().filter(|row| row["polar_deg"] == 0.0).collect();
        for (w, row) in lit.into_iter().enumerate() {
            // a solid patch is the run of its layer
            assert!((factor(corner, w) - number(&row["lit_at_45"]["value"])).abs() < 1e-13);
        }
    }
    // densities of the layers add up, and what the paper returns more than once makes less of a dense one
    let additivity = number(&corners[3]["additivity"]["value"]);
    let densities = [1, 2, 3].map(|k| number(&corners[k]["density"]["value"]));
    assert!((additivity - densities[2] / (densities[0] + densities[1])).abs() < 1e-12);
    assert!(additivity > 0.5 && additivity < 1.0, "{additivity}");
    assert!(corners[1]["additivity"].is_null());
    let tint = solid(0.25, 0.5);
    for w in 0..16 {
        let [paper, cyan, yellow, both] = corners.each_ref().map(|corner| factor(corner, w));
        let mean = 0.375 * paper + 0.125 * cyan + 0.375 * yellow + 0.125 * both;
        assert!((factor(&tint, w) - mean).abs() < 1e-13, "Neugebauer's average");
    }
    assert!(described_tables(&scratch.path().join("open")) >= 4);
}

/// What a run says of its layer at a wavelength: its own light, and its area in the series of returns.
fn areas_of(results: &Value, w: usize) -> (f64, inkwave_validation::formulas::halftone::Area) {
    let optics = &results["optics"]["whole"][w];
    let number = |key: &str| optics[key].as_f64().expect("a number");
    let area = inkwave_validation::formulas::halftone::Area {
        entering: number("entering"),
        leaving: number("leaving"),
        back: 1.0 - number("lost"),
    };
    (number("own"), area)
}

/// Bare paper behind its surface, from its factor and that surface's means.
fn behind_bare(results: &Value) -> inkwave_validation::formulas::halftone::Area {
    use inkwave::appearance::bare_paper::{BareSurface, PaperGeometry};
    use inkwave::appearance::paper::Coupling;
    let surface = BareSurface::new(Coupling::OpticalContact { index: 1.5 });
    let [entering, leaving] = surface.passed(PaperGeometry::LitAt45);
    let back = 1.0 - surface.escaping();
    // the first print is bare paper
    let factor = results["prints"]["prints"][0]["factors"][3]["value"].as_f64().unwrap();
    assert!((factor - 0.93 * entering * leaving / (1.0 - 0.93 * back)).abs() < 1e-13);
    inkwave_validation::formulas::halftone::Area { entering, leaving, back }
}

/// A table of CGATS.17 as readers of other programs see it: keywords with their values, fields, sets.
struct Cgats {
    keywords: Vec<(String, String)>,
    fields: Vec<String>,
    sets: Vec<Vec<String>>,
}

/// Keywords of the standard.
const STANDARD: [&str; 20] = [
    "ORIGINATOR",
    "FILE_DESCRIPTOR",
    "DESCRIPTOR",
    "CREATED",
    "MANUFACTURER",
    "PROD_DATE",
    "SERIAL",
    "MATERIAL",
    "INSTRUMENTATION",
    "MEASUREMENT_SOURCE",
    "PRINT_CONDITIONS",
    "NUMBER_OF_FIELDS",
    "NUMBER_OF_SETS",
    "SAMPLE_BACKING",
    "WEIGHTING_FUNCTION",
    "COMPUTATIONAL_PARAMETER",
    "TARGET_TYPE",
    "COLORANT",
    "TABLE_DESCRIPTOR",
    "TABLE_NAME",
];
/// Fields that the sets may have besides bands and values of other inks.
const FIELDS: [&str; 12] = [
    "SAMPLE_ID",
    "SAMPLE_NAME",
    "CMYK_C",
    "CMYK_M",
    "CMYK_Y",
    "CMYK_K",
    "XYZ_X",
    "XYZ_Y",
    "XYZ_Z",
    "LAB_L",
    "LAB_A",
    "LAB_B",
];

/// Reads a file by the rules of CGATS.17 (ANSI CGATS.17-2009) as makers of profiles take them: ASCII, an identifier, keywords
/// of the standard or declared by KEYWORD before their use, once each, counts that are so, each sample named once.
fn strict_cgats(text: &str) -> Cgats {
    assert!(text.is_ascii(), "{text}");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("CGATS.17"));
    let words = |line: &str| -> Vec<String> {
        let parts = line.split('"').enumerate();
        let word = |(k, part): (usize, &str)| match k % 2 {
            1 => vec![part.to_owned()],
            _ => part.split_whitespace().map(str::to_owned).collect(),
        };
        assert_eq!(line.matches('"').count() % 2, 0, "{line}");
        parts.flat_map(word).collect()
    };
    let mut declared: Vec<String> = STANDARD.map(str::to_owned).into();
    let mut found = Cgats { keywords: Vec::new(), fields: Vec::new(), sets: Vec::new() };
    while let Some(line) = lines.next() {
        let line = words(line);
        match line.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
            [] => (),
            ["KEYWORD", name] => {
                assert!(!declared.contains(&(*name).to_owned()), "{name} is declared twice");
                declared.push((*name).to_owned());
            }
            ["BEGIN_DATA_FORMAT"] => {
                let format = lines.by_ref().take_while(|line| *line != "END_DATA_FORMAT");
                found.fields = format.flat_map(words).collect();
            }
            ["BEGIN_DATA"] => {
                found.sets = lines.by_ref().take_while(|line| *line != "END_DATA").map(words).collect();
            }
            [keyword, value] => {
                assert!(declared.contains(&(*keyword).to_owned()), "{keyword} is not declared");
                found.keywords.push(((*keyword).to_owned(), (*value).to_owned()));
            }
            other => panic!("no line of CGATS.17: {other:?}"),
        }
    }
    let count = |keyword: &str| found.value(keyword).parse::<usize>().expect("a count");
    assert_eq!((count("NUMBER_OF_FIELDS"), count("NUMBER_OF_SETS")), (found.fields.len(), found.sets.len()));
    let known = |field: &String| {
        let wave = field.strip_prefix("SPEC_").is_some_and(|nm| nm.len() == 3 && nm.parse::<u32>().is_ok());
        let other = field
            .split_once("CLR_")
            .is_some_and(|(n, k)| n.parse::<u32>().is_ok() && k.parse::<u32>().is_ok());
        wave || other || FIELDS.contains(&field.as_str())
    };
    assert!(found.fields.iter().all(known), "{:?}", found.fields);
    let mut ids: Vec<&String> = found.sets.iter().map(|set| &set[0]).collect();
    assert!(found.fields[0] == "SAMPLE_ID" && found.sets.iter().all(|set| set.len() == found.fields.len()));
    ids.dedup();
    assert_eq!(ids.len(), found.sets.len());
    found
}

impl Cgats {
    fn value(&self, keyword: &str) -> &str {
        let of = self.keywords.iter().find(|(name, _)| name == keyword);
        &of.unwrap_or_else(|| panic!("no {keyword}")).1
    }

    fn numbers(&self, field: &str) -> Vec<f64> {
        let place = self.fields.iter().position(|name| name == field);
        let place = place.unwrap_or_else(|| panic!("no {field} among {:?}", self.fields));
        self.sets.iter().map(|set| set[place].parse().expect("a number")).collect()
    }
}

/// Characterisation sets are files that strict readers take: device values in percent, Y of a perfect white 100, Lab of D50
/// and 2° whatever the study's light, one set for each condition of a brightened paper, no two colours of one device value.
/// *Planted*: Lab of the study's own light; all conditions in one file; ink names as they are.
#[test]
fn characterisation_sets_are_what_makers_of_profiles_read() {
    let scratch = tempfile::tempdir().unwrap();
    let exported = |name: &str, text: &str| {
        let file = scratch.path().join(format!("{name}.toml"));
        std::fs::write(&file, text).unwrap();
        let output = scratch.path().join(name);
        succeed(&file, &output, &[]);
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"))
            .args(["export", output.to_str().unwrap(), "--to", "cgats"])
            .output()
            .expect("the program");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        output
    };
    let read = |folder: &Path, name: &str| {
        let found = walk(folder, name).unwrap_or_else(|| panic!("no {name} in {}", folder.display()));
        strict_cgats(&std::fs::read_to_string(found).unwrap())
    };
    exported("other", &of_thickness(0.7));
    // the light of the study is A, and names hold what no such file may
    let inks = "[dots]\nruling_per_cm = 60\nspread_um = 40\npatches = 'grid'\n[[ink]]\nname = 'Cyan'\ncoverage = [0, 0.5, 1]\n\
                [[ink]]\nname = 'yellow'\ncoverage = [0, 1]\n[[area]]\ninks = ['Cyan']\nresults = 'other'\n[[area]]\n\
                inks = ['yellow']\nresults = 'other'\n[[area]]\ninks = ['yellow', 'Cyan']\n[colour]\nilluminant = 'A'\n";
    let title = "title = 'Zyan \"matt\" über Gelb, 5 µm'\n";
    let set = read(&exported("inks", &format!("{title}{}{inks}", of_thickness(1.8))), "prints.cgats");
    assert_eq!(set.value("LAB_CONDITIONS").matches("D50").count(), 1);
    assert!(set.value("DESCRIPTOR").contains("Zyan 'matt' ?ber Gelb, 5 um"), "{}", set.value("DESCRIPTOR"));
    let inks = set.numbers("CMYK_C").into_iter().zip(set.numbers("CMYK_Y"));
    let bare = inks.filter(|inks| *inks == (0.0, 0.0)).count();
    assert_eq!((bare, set.sets.len()), (1, 6), "the paper once, and all combinations of its inks");
    assert!(set.numbers("CMYK_C").contains(&50.0) && set.numbers("CMYK_K").iter().all(|k| *k == 0.0));
    let [x, y, z] = ["XYZ_X", "XYZ_Y", "XYZ_Z"].map(|field| set.numbers(field));
    let lab = ["LAB_L", "LAB_A", "LAB_B"].map(|field| set.numbers(field));
    // D50 and 2° of ISO 13655, table A: white of 10 nm
    let white = [96.422, 100.0, 82.521];
    let f = |t: f64| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let waves: Vec<usize> = (400..=700).step_by(10).collect();
    assert_eq!(set.value("SPECTRAL_BANDS"), waves.len().to_string());
    assert_eq!((set.value("SPECTRAL_START_NM"), set.value("SPECTRAL_END_NM")), ("400.000000", "700.000000"));
    for k in 0..set.sets.len() {
        let [fx, fy, fz] = [f(x[k] / white[0]), f(y[k] / white[1]), f(z[k] / white[2])];
        let own = [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)];
        // light from 400 to 700 nm alone makes another white, by a few thousandths
        assert!((0..3).all(|i| (own[i] - lab[i][k]).abs() < 0.5), "{own:?} {:?}", set.sets[k]);
        let spectrum: Vec<f64> = waves.iter().map(|nm| set.numbers(&format!("SPECTRAL_NM{nm}"))[k]).collect();
        assert!(spectrum.iter().all(|percent| (0.0..=100.0).contains(percent)), "{spectrum:?}");
        let [low, high] =
            [spectrum.iter().copied().fold(1e9, f64::min), spectrum.iter().copied().fold(0.0, f64::max)];
        assert!(low <= y[k] && y[k] <= high, "Y is a mean of the spectrum: {low} {} {high}", y[k]);
    }
    // the darkest print is the overprint, the lightest the paper
    let lightest = (0..y.len()).max_by(|a, b| y[*a].total_cmp(&y[*b])).unwrap();
    assert_eq!((set.numbers("CMYK_C")[lightest], set.numbers("CMYK_Y")[lightest]), (0.0, 0.0));
    // a brightened paper has a set for each condition
    let bright = format!("fluorescence = {{ {BANDS}, yield = 0.6 }}\n");
    let text = of_thickness(1.0).replace("albedo = 0.93\n", &format!("albedo = 0.93\n{bright}"));
    let text = text.replace("from_nm = 400", "from_nm = 300") + DOTS;
    let folder = exported("bright", &text);
    let blues = ["m0", "m1", "m2"].map(|condition| {
        let set = read(&folder, &format!("prints-{condition}.cgats"));
        let source = set.value("MEASUREMENT_SOURCE").to_owned();
        assert_eq!(source.to_lowercase(), format!("measurementcondition={condition}"));
        let mut device: Vec<String> = set.sets.iter().map(|set| set[2].clone()).collect();
        assert_eq!(device.len(), 4, "paper, two tints, solid");
        device.dedup();
        assert_eq!(device.len(), 4, "one colour for a device value");
        set.numbers("LAB_B")[0]
    });
    assert!(blues[1] < blues[0] && blues[0] < blues[2], "ultraviolet light makes paper blue: {blues:?}");
}

/// A file of this name below a folder.
fn walk(folder: &Path, name: &str) -> Option<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?.filter_map(Result::ok).map(|entry| entry.path());
    let found = |path: std::path::PathBuf| match path.is_dir() {
        true => walk(&path, name),
        false => path.file_name().is_some_and(|own| own == name).then_some(path),
    };
    entries.filter_map(found).next()
}

/// The refusal of a study, or its remarks.
fn checked(folder: &Path, text: &str) -> Result<Vec<String>, String> {
    let file = folder.join("study.toml");
    std::fs::write(&file, text).unwrap();
    match inkwave::input::load::load(&file) {
        Ok(study) => Ok(study.remarks),
        Err(inkwave::input::fault::StudyError::Values { faults, .. }) => {
            Err(faults.iter().map(|f| format!("{f}; {}", f.remedy)).collect::<Vec<_>>().join("\n"))
        }
        Err(other) => Err(other.to_string()),
    }
}

/// Factors above 1 of a brightened paper need no unit, as no paper is as dark as a percent; a table with rows and columns
/// exchanged would emit nothing, and a file from a sphere is no measurement at 45:0. *Planted*: the table's lower half taken
/// for nothing; the geometry beside the file believed, whatever the file says.
#[test]
fn papers_that_would_be_taken_for_others_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(scratch.path().join(name), text).unwrap();
    let waves = || (380..=740).step_by(10);
    let gauss = |nm: f64, at: f64, width: f64| (-((nm - at) / width).powi(2)).exp();
    let factors = |extra: f64| -> String {
        let row = |nm: i32| format!("{nm},{:.5}\n", 0.85 + extra * gauss(f64::from(nm), 445.0, 25.0));
        format!("wavelength_nm,factor\n{}", waves().map(row).collect::<String>())
    };
    write("m1.csv", factors(0.18));
    write("m2.csv", factors(0.0));
    let base = TINY.replace("binder.index = 1.558", "binder.index = 1.5\nindex_out = 1.5");
    let base = base.replace("from_nm = 400", "from_nm = 300").replace("step_nm = 100", "step_nm = 50");
    let base = base.replace("index = { built_in = \"yellow\" }", "index = { n = 1.7, k = 0.05 }");
    let paper = |words: &str| format!("{base}[paper]\ncoupling = \"optical_contact\"\n{words}\n");
    let told = checked(scratch.path(), &paper("fluorescence = { m1_csv = \"m1.csv\", m2_csv = \"m2.csv\" }"));
    let told = told.expect("a paper").join("\n");
    for words in ["m1.csv states no unit", "factors of a perfect white", "45:0, that of M0 to M2"] {
        assert!(told.contains(words), "{words:?} is missing: {told}");
    }
    // emission at 440 nm of light at 365 nm, and the same table with rows and columns exchanged
    let nm = || (300..=700).step_by(20).map(f64::from);
    let table = |factor: &dyn Fn(f64, f64) -> f64| -> String {
        let head: String = nm().map(|from| format!(",{from}")).collect();
        let row = |at: f64| -> String {
            let cells: String = nm().map(|from| format!(",{:.6}", factor(at, from))).collect();
            format!("{at}{cells}\n")
        };
        format!("emission_nm{head}\n{}", nm().map(row).collect::<String>())
    };
    let emits = |at: f64, from: f64| 0.002 * gauss(at, 440.0, 25.0) * gauss(from, 365.0, 25.0);
    let later = |at: f64, from: f64| if at > from { emits(at, from) } else { 0.0 };
    write("right.csv", table(&later));
    write("exchanged.csv", table(&|at, from| later(from, at)));
    let donaldson =
        |name: &str| paper(&format!("albedo = 0.9\nfluorescence = {{ donaldson_csv = \"{name}\" }}"));
    checked(scratch.path(), &donaldson("right.csv")).expect("a table");
    let told = checked(scratch.path(), &donaldson("exchanged.csv")).expect_err("nothing would be emitted");
    assert!(
        told.contains("paper.fluorescence.donaldson_csv") && told.contains("exchange rows and columns"),
        "{told}"
    );
    let bands: String = waves().map(|nm| format!(" SPEC_{nm}")).collect();
    let values: String = waves().map(|_| " 0.85").collect();
    write(
        "sphere.cgats",
        format!(
            "CGATS.17\nMEASUREMENT_GEOMETRY \"d/8\"\nBEGIN_DATA_FORMAT\nSAMPLE_ID{bands}\nEND_DATA_FORMAT\n\
             NUMBER_OF_SETS 1\nBEGIN_DATA\n1{values}\nEND_DATA\n"
        ),
    );
    let visible = |geometry: &str| {
        paper(&format!("measured = {{ csv = \"sphere.cgats\", geometry = \"{geometry}\" }}"))
            .replace("from_nm = 300", "from_nm = 400")
    };
    for geometry in ["d:8", "d:8 excluded"] {
        checked(scratch.path(), &visible(geometry)).expect("which of both it is");
    }
    let told = checked(scratch.path(), &visible("45:0")).expect_err("a contradiction");
    assert!(told.contains("paper.measured.geometry") && told.contains("where the file states"), "{told}");
}

/// A composed layer as an area of another print: as its solid, it reads what its own run reads at 45:0 on the same paper, and
/// the bar of the print holds the bar of that run. *Planted*: a composed layer without its errors, or off its surface.
#[test]
fn a_composed_layer_is_an_area_of_another_print() {
    let scratch = tempfile::tempdir().unwrap();
    let run = |name: &str, text: &str| -> Value {
        let file = scratch.path().join(format!("{name}.toml"));
        std::fs::write(&file, text).unwrap();
        let output = scratch.path().join(name);
        succeed(&file, &output, &[]);
        serde_json::from_slice(&std::fs::read(output.join("results.json")).unwrap()).unwrap()
    };
    let coat = COMPOSED
        .replace("300, 360, ", "")
        .replace("binder.index = 1.5\n", "binder.index = 1.5\nindex_out = 1.5\n");
    let paper = "[paper]\ncoupling = \"optical_contact\"\nalbedo = 0.93\n";
    let coat = run("coat", &format!("{coat}{paper}"));
    let areas = "[dots]\nruling_per_cm = 60\nspread_um = 40\n[[area]]\ncoverage = [0, 0.3]\n[[area]]\nresults = \"coat\"\n\
                 coverage = [1, 0.5]\n";
    let clear = of_thickness(1.0).replace(
        "from_nm = 400\nto_nm = 700\nstep_nm = 20",
        "wavelengths_nm = [400, 450, 500, 550, 600, 650, 700]",
    );
    let print = run("print", &format!("{clear}{areas}"));
    let rows: Vec<&Value> =
        coat["spectra"].as_array().unwrap().iter().filter(|row| row["thickness_um"] == 1.0).collect();
    let solid = &print["prints"]["prints"][1];
    assert_eq!(rows.len(), 7);
    for (factor, row) in solid["factors"].as_array().unwrap().iter().zip(rows) {
        let of = |value: &Value, key: &str| value[key].as_f64().expect("a number");
        let [solid, lit] =
            [factor, &row["lit_at_45"]].map(|number| (of(number, "value"), of(number, "standard_error")));
        // rounding
        assert!((solid.0 - lit.0).abs() < 1e-12, "{factor} {row}");
        // chance, grid and directions alike; composing is an estimate for the whole spectrum here, and near each wavelength there
        assert!(solid.1 > 0.4 * lit.1 && solid.1 < 2.5 * lit.1, "{factor} {}", row["lit_at_45"]);
    }
    assert!(print["prints"]["prints"][2]["lab"][0]["standard_error"].as_f64().unwrap() > 0.0);
    // and the other way round: an area of a composed print bears the layer of a run with its bar
    run(
        "grains",
        &format!("{}{paper}", TINY.replace("binder.index = 1.558", "binder.index = 1.5\nindex_out = 1.5")),
    );
    let base = COMPOSED
        .replace("300, 360, ", "")
        .replace("binder.index = 1.5\n", "binder.index = 1.5\nindex_out = 1.5\n");
    let base = base.replace("thickness_um = [1, 2]", "thickness_um = 1");
    let areas = areas.replace("\"coat\"", "\"grains\"");
    let print = run("composed", &format!("{base}{paper}{areas}"));
    let grains: Value =
        serde_json::from_slice(&std::fs::read(scratch.path().join("grains/results.json")).unwrap()).unwrap();
    let own = grains["spectra"].as_array().unwrap().iter().find(|row| row["polar_deg"] == 0.0).unwrap();
    let solid = &print["prints"]["prints"][1]["factors"][0];
    let error = |value: &Value| value["standard_error"].as_f64().expect("a bar");
    assert!((solid["value"].as_f64().unwrap() - own["lit_at_45"]["value"].as_f64().unwrap()).abs() < 1e-12);
    assert!((error(solid) / error(&own["lit_at_45"]) - 1.0).abs() < 0.3, "{solid} {}", own["lit_at_45"]);
}
