//! Inks without each of them, against studies of what is left and against plates.

use super::*;
use inkwave::run::RunSettings;
use inkwave::work::plan::by_size;
use inkwave::work::variant::of_one;
use std::collections::BTreeMap;

/// Inks without a layer, and a layer alone, are, to rounding, studies without it with the same seed, their bars included; the
/// stack itself is what it is without the key, and the forecast counts what it costs. *Planted*: layers packed by their number
/// in the whole stack.
#[test]
fn inks_without_a_layer_are_studies_without_it() {
    let scratch = tempfile::tempdir().unwrap();
    let output = ran(scratch.path(), "whole", INKS);
    let whole = results(&output);
    for (layer, part, others) in [
        ("varnish", "without", &["varnish"][..]),
        ("red", "without", &["red"]),
        ("blue", "without", &["blue"]),
        ("red", "alone", &["varnish", "blue"]),
        ("blue", "alone", &["varnish", "red"]),
    ] {
        let other = results(&ran(scratch.path(), &format!("{layer} {part}"), &inks_without(others)));
        for (row, print) in left_out(&whole, layer).iter().zip(printed(&other)) {
            for light in ["lit_at_45", "natural_light"] {
                let name = format!("{light}_{part}");
                assert!((value(row, &name) - value(&print, light)).abs() < 1e-12, "{row} {print}");
                assert!((error(row, &name) - error(&print, light)).abs() < 1e-12, "{row} {print}");
            }
        }
        assert_same_colours(&whole, layer, part, &other);
    }
    let plain = results(&ran(scratch.path(), "plain", &inks_without(&[])));
    assert_eq!((&whole["spectra"], &whole["colours"]), (&plain["spectra"], &plain["colours"]));
    assert!(plain["left_out"].is_null() && plain["study_hash"] != whole["study_hash"]);
    let checked = load(&study(scratch.path(), INKS)).unwrap();
    let plan = by_size(&of_one("inks", checked.clone()), RunSettings::default());
    let solves = whole["solves"]["finished"].as_u64().unwrap() as usize;
    assert_eq!((plan.solves, checked.solves()), (solves, solves));
    assert!(solves > 3 * plain["solves"]["finished"].as_u64().unwrap() as usize);
    let page = std::fs::read_to_string(output.join("report.html")).unwrap();
    for words in ["Without each layer", "without varnish", "only blue", "Densities"] {
        assert!(page.contains(words), "{words}");
    }
    // the tables hold what the file does, under the names that composed stacks have
    let table = |name: &str| -> Vec<BTreeMap<String, String>> {
        let rows = csv::Reader::from_path(output.join(name)).expect("a table").into_deserialize();
        rows.collect::<Result<_, _>>().expect("rows")
    };
    let number = |text: &str| text.parse::<f64>().unwrap();
    let rows = whole["left_out"].as_array().unwrap();
    for (line, row) in table("left-out.csv").iter().zip(rows) {
        assert_eq!(number(&line["natural_light_alone"]), value(row, "natural_light_alone"));
        let bar = number(&line["lit_at_45_without_standard_error"]);
        assert_eq!(bar, error(row, "lit_at_45_without"));
    }
    for (line, row) in table("densities.csv").iter().zip(whole["densities"].as_array().unwrap()) {
        let of_layers = ["varnish", "red", "blue"].map(|layer| {
            let own = left_out(&whole, layer);
            let own = own.iter().find(|own| own["wavelength_nm"] == row["wavelength_nm"]).unwrap();
            -(value(own, "lit_at_45_alone") / PAPER).log10()
        });
        assert!((number(&line["density_of_layers"]) - of_layers.iter().sum::<f64>()).abs() < 1e-9);
        let [sum, ratio] = ["density_of_layers", "density_ratio"].map(|name| error(row, name));
        assert!(sum > 0.0 && ratio > 0.0, "{row}");
    }
}

/// The stack of plates of the same layers says the same within bars: another way to the same numbers.
#[test]
fn plates_say_the_same_of_layers_left_out() {
    let scratch = tempfile::tempdir().unwrap();
    let whole = results(&ran(scratch.path(), "whole", &INKS.replace("realisations = 4", "realisations = 8")));
    let plates =
        INKS.replace("without_layers = true", "composed = { slab_um = 0.5 }").replace("count = 3\n", "");
    let plates = results(&ran(scratch.path(), "plates", &plates));
    let mut apart = Vec::new();
    for (one, two) in whole["left_out"].as_array().unwrap().iter().zip(plates["left_out"].as_array().unwrap())
    {
        assert_eq!((&one["layer"], &one["wavelength_nm"]), (&two["layer"], &two["wavelength_nm"]));
        for name in ["lit_at_45_without", "lit_at_45_alone", "natural_light_without", "natural_light_alone"] {
            // films alone are exact in both, but for nodes of directions
            let bars = error(one, name).hypot(error(two, name)).hypot(5e-3);
            apart.push((value(one, name) - value(two, name)) / bars);
        }
    }
    for (one, two) in
        whole["densities"].as_array().unwrap().iter().zip(plates["densities"].as_array().unwrap())
    {
        for name in ["density_of_stack", "density_of_layers"] {
            let bars = error(one, name).hypot(error(two, name)).hypot(5e-3);
            apart.push((value(one, name) - value(two, name)) / bars);
        }
    }
    let mean = (apart.iter().map(|z| z * z).sum::<f64>() / apart.len() as f64).sqrt();
    let largest = apart.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
    // 70 numbers of 5 wavelengths: significance
    assert!(apart.len() == 70 && mean < 1.5 && largest < 4.5, "{mean} {largest}: {apart:?}");
}
