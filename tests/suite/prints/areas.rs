//! Prints whose areas bear the layers of several runs: overprints of two inks, and areas of composed layers.

use super::{COMPOSED, Place, ink_of_thickness};
use crate::run_support::{TINY, described_tables};
use inkwave_validation::formulas::halftone::Area;
use serde_json::Value;

/// Prints of two inks whose layers and overprint are three runs: every factor is what returns that are followed one by one
/// give with Demichel's shares; without spread it is the average of the solids. 49 patches need no further solve.
/// *Planted*: the shares of the second ink for those of the overprint.
#[test]
fn overprints_share_the_area_as_demichel_says() {
    use inkwave_validation::formulas::returns::Returns;
    let place = Place::new();
    let alone = [place.run("cyan", &ink_of_thickness(0.7)), place.run("yellow", &ink_of_thickness(1.1))];
    let levels = "[0, 0.1, 0.25, 0.5, 0.75, 0.9, 1]";
    let inks = format!(
        "[[ink]]\nname = 'cyan'\ncoverage = {levels}\n[[ink]]\nname = 'yellow'\ncoverage = {levels}\n\
         [[area]]\ninks = ['cyan']\nresults = 'cyan'\n[[area]]\ninks = ['yellow']\nresults = 'yellow'\n\
         [[area]]\ninks = ['yellow', 'cyan']\n"
    );
    let screen = |spread_um: f64| {
        format!("[dots]\nruling_per_cm = 60\nspread_um = {spread_um}\npatches = 'grid'\n{inks}")
    };
    let spread = place.run("spread", &format!("{}{}", ink_of_thickness(1.8), screen(40.0)));
    let open = place.run("open", &format!("{}{}", ink_of_thickness(1.8), screen(0.0)));
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
    assert!(described_tables(&place.output("open")) >= 4);
}

/// What a run says of its layer at a wavelength: its own light, and its area in the series of returns.
fn areas_of(results: &Value, w: usize) -> (f64, Area) {
    let optics = &results["optics"]["whole"][w];
    let number = |key: &str| optics[key].as_f64().expect("a number");
    let area = Area { entering: number("entering"), leaving: number("leaving"), back: 1.0 - number("lost") };
    (number("own"), area)
}

/// Bare paper behind its surface, from its factor and that surface's means.
fn behind_bare(results: &Value) -> Area {
    use inkwave::appearance::bare_paper::{BareSurface, PaperGeometry};
    use inkwave::appearance::paper::Coupling;
    let surface = BareSurface::new(Coupling::OpticalContact { index: 1.5 });
    let [entering, leaving] = surface.passed(PaperGeometry::LitAt45);
    let back = 1.0 - surface.escaping();
    // the first print is bare paper
    let factor = results["prints"]["prints"][0]["factors"][3]["value"].as_f64().unwrap();
    assert!((factor - 0.93 * entering * leaving / (1.0 - 0.93 * back)).abs() < 1e-13);
    Area { entering, leaving, back }
}

/// A composed layer as an area of another print: as its solid, it reads what its own run reads at 45:0 on the same paper, and
/// the bar of the print holds the bar of that run. *Planted*: a composed layer without its errors, without those of chance, or
/// off its surface.
#[test]
fn a_composed_layer_is_an_area_of_another_print() {
    let place = Place::new();
    let visible = COMPOSED
        .replace("300, 360, ", "")
        .replace("binder.index = 1.5\n", "binder.index = 1.5\nindex_out = 1.5\n");
    let paper = "[paper]\ncoupling = \"optical_contact\"\nalbedo = 0.93\n";
    let coat = place.run("coat", &format!("{visible}{paper}"));
    let areas = "[dots]\nruling_per_cm = 60\nspread_um = 40\n[[area]]\ncoverage = [0, 0.3]\n[[area]]\nresults = \"coat\"\n\
                 coverage = [1, 0.5]\n";
    let clear = ink_of_thickness(1.0).replace(
        "from_nm = 400\nto_nm = 700\nstep_nm = 20",
        "wavelengths_nm = [400, 450, 500, 550, 600, 650, 700]",
    );
    let print = place.run("print", &format!("{clear}{areas}"));
    let rows: Vec<&Value> =
        coat["spectra"].as_array().unwrap().iter().filter(|row| row["thickness_um"] == 1.0).collect();
    let solid = &print["prints"]["prints"][1];
    let value = |estimate: &Value| estimate["value"].as_f64().expect("a number");
    let error = |estimate: &Value| estimate["standard_error"].as_f64().expect("a bar");
    assert_eq!(rows.len(), 7);
    for (factor, row) in solid["factors"].as_array().unwrap().iter().zip(rows) {
        let lit = &row["lit_at_45"];
        // rounding
        assert!((value(factor) - value(lit)).abs() < 1e-12, "{factor} {row}");
        // chance, grid and directions alike; composing is an estimate for the whole spectrum here, and near each wavelength there
        assert!((0.4..2.5).contains(&(error(factor) / error(lit))), "{factor} {lit}");
    }
    assert!(print["prints"]["prints"][2]["lab"][0]["standard_error"].as_f64().unwrap() > 0.0);
    // what the two realisations of each kind of slab change is in the bar, as much to either side
    let optics = &coat["optics"];
    let own = |rows: &Value, w: usize| rows[w]["own"].as_f64().expect("a number");
    for w in 0..7 {
        let by = |r: usize| own(&optics["moved"][r], w) - own(&optics["whole"], w);
        assert!((0..6).any(|r| by(r).abs() > 1e-6), "no chance");
        assert!((0..3).all(|kind| (by(2 * kind) + by(2 * kind + 1)).abs() < 1e-12));
    }
    // and the other way round: an area of a composed print bears the layer of a run with its bar
    let grains = place.run(
        "grains",
        &format!("{}{paper}", TINY.replace("binder.index = 1.558", "binder.index = 1.5\nindex_out = 1.5")),
    );
    let base = visible.replace("thickness_um = [1, 2]", "thickness_um = 1");
    let areas = areas.replace("\"coat\"", "\"grains\"");
    let print = place.run("composed", &format!("{base}{paper}{areas}"));
    let normal = grains["spectra"].as_array().unwrap().iter().find(|row| row["polar_deg"] == 0.0).unwrap();
    let solid = &print["prints"]["prints"][1]["factors"][0];
    let lit = &normal["lit_at_45"];
    assert!((value(solid) - value(lit)).abs() < 1e-12);
    assert!((error(solid) / error(lit) - 1.0).abs() < 0.3, "{solid} {lit}");
}

/// Bare paper, the solid and every tint stand once, from light to dark, however a ramp is written. *Planted*: tints as listed.
#[test]
fn a_ramp_has_every_tint_once() {
    let place = Place::new();
    let dots = |list: &str| {
        format!(
            "{}[dots]\nruling_per_cm = 60\nspread_um = 40\n[[area]]\ncoverage = {list}\n",
            ink_of_thickness(1.0)
        )
    };
    let plain = place.run("plain", &dots("[0.25, 0.5]"));
    let repeated = place.run("repeated", &dots("[1, 0.5, 0, 0.25, 0.5]"));
    assert_eq!(plain["prints"]["prints"].as_array().map(Vec::len), Some(4));
    assert_eq!(plain["prints"]["prints"], repeated["prints"]["prints"]);
}

/// Areas of one screen grow at the cost of the bare paper, all alike; light is spread between areas of these shares, and what
/// they bear is of one wave. *Planted*: light spread between areas that grow each for itself.
#[test]
fn areas_of_one_screen_grow_together() {
    use inkwave::appearance::halftone::spread_share;
    let place = Place::new();
    place.run("coat", &ink_of_thickness(1.8));
    let areas = "[dots]\nruling_per_cm = 60\nspread_um = 40\nphysical_gain = 0.05\n[[area]]\ncoverage = 0.2\n\
                 [[area]]\ncoverage = 0.2\nresults = 'coat'\n";
    let text = format!("{}{areas}", ink_of_thickness(0.7));
    let print = &place.run("print", &text)["prints"]["prints"][1];
    // 40 % grow by 4 × 0.05 × 0.4 × 0.6, and both areas alike
    let grown = 0.4 + 0.2 * 0.4 * 0.6;
    let number = |key: &str| print[key].as_f64().expect("a number");
    assert!((number("coverage") - grown).abs() < 1e-12, "{print}");
    let spread = spread_share(0.5 * grown, 60.0 / 1e4, 40.0);
    assert!((number("spread") - spread).abs() < 1e-12, "{} {spread}", number("spread"));
    let file = place.0.path().join("vector.toml");
    std::fs::write(&file, text.replace("[light]", "[light]\nwave = 'unpolarised'")).unwrap();
    let refused = inkwave::input::load::load(&file).unwrap_err().to_string();
    for words in ["area[1].results", "the scalar wave", "the unpolarised wave"] {
        assert!(refused.contains(words), "{refused}");
    }
    // a run that was interrupted has results, and not yet those that it will have
    let results = place.0.path().join("coat").join("results.json");
    let complete = std::fs::read_to_string(&results).unwrap();
    std::fs::write(&results, complete.replacen("\"complete\"", "\"partial\"", 1)).unwrap();
    std::fs::write(&file, &text).unwrap();
    let refused = inkwave::input::load::load(&file).unwrap_err().to_string();
    for words in ["area[1].results", "a run that was interrupted"] {
        assert!(refused.contains(words), "{refused}");
    }
}
