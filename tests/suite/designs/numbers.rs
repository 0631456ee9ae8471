//! Designs whose target holds weighted numbers, beside a colour or without one.

use super::{DYE, OF_15_PERCENT, SHARE, design, designed, inkwave, run, write};
use crate::run_support::{plain, results, with};

/// The weighted numbers of a study of the dye.
const NUMBERS: &str = "[[number]]\nname = \"blue density\"\nweights = \"status_t_blue\"\nof = \"lit_at_45\"\n\
                       transform = \"density\"\n[[number]]\nname = \"sun\"\nweights = \"solar_g173\"\nfrom_nm = 400\n\
                       to_nm = 700\nof = \"albedo\"\n";

/// The dye with a range of a number instead of a colour.
fn of_number(wish: &str) -> String {
    of_target(&format!("[[target.number]]\n{wish}"))
}

fn of_target(target: &str) -> String {
    design(target, &[(SHARE, 0.05, 0.4)], "delta_e = 0.5", &format!("{DYE}{NUMBERS}"))
}

/// Without a colour, a density alone is met, surely and at one run, since films have no chance: in the middle of its
/// range. The recipe's own run has it. *Planted*: the surfaces' sums left out, or those of the wrong number.
#[test]
fn a_wanted_density_needs_no_colour() {
    let outcome = designed(&of_number("name = \"blue density\"\nat_least = 0.5\nat_most = 0.6"));
    let [verified] = &outcome.verified[..] else { panic!("one run is sure: {outcome:?}") };
    assert!(outcome.met && outcome.target.is_none() && verified.delta_e_2000.is_none(), "{outcome:?}");
    let [density] = &verified.numbers[..] else { panic!("one number is wanted: {verified:?}") };
    assert!((density.estimate.value - 0.55).abs() < 0.01, "{density:?}");
    // films differ from themselves by rounding
    assert!(density.predicted.is_some_and(|by| (by - density.estimate.value).abs() < 1e-9), "{density:?}");
    assert!(outcome.verdict.contains("blue density 0.5") && outcome.verdict.contains("0.5 to 0.6"));
    // the same layer by `inkwave run`
    let folder = tempfile::tempdir().expect("a folder");
    let share = format!("volume_fraction = {}", verified.values[0]);
    let recipe = format!("{}{NUMBERS}", with(DYE, "volume_fraction = 0.1", &share));
    write(folder.path(), "recipe.toml", &recipe);
    let done = inkwave(&["run", "recipe.toml", "-o", "out"], folder.path());
    assert!(done.status.success(), "{}", plain(&done));
    let own = &results(&folder.path().join("out"))["numbers"][0];
    assert_eq!(own["name"], "blue density");
    let value = own["value"].as_f64().expect("a value");
    assert!((value - density.estimate.value).abs() < 1e-9, "{value} {density:?}");
}

/// A colour and a number together: the number draws the recipe away from the colour where both cannot be, and the verdict tells
/// both. *Planted*: numbers left out of what is to be small.
#[test]
fn a_number_out_of_reach_stands_beside_what_was_reached() {
    let target = format!("{OF_15_PERCENT}\n[[target.number]]\nname = \"blue density\"\nat_least = 3");
    let outcome = designed(&of_target(&target));
    assert!(!outcome.met, "{outcome:?}");
    let best = &outcome.verified[0];
    // ΔE₀₀ of a few against some hundred steps of density: the densest
    assert!(best.values[0] > 0.39, "{best:?}");
    for words in ["Out of reach", "blue density", "at least 3", "to the target (requested: 0.5)"] {
        assert!(outcome.verdict.contains(words), "{words:?} is missing: {}", outcome.verdict);
    }
}

/// A design aims at the solid: dots, and settings of the solves, move no colour of it. *Planted*: any field taken.
#[test]
fn what_moves_no_solid_is_not_varied() {
    let folder = tempfile::tempdir().expect("a folder");
    let dots = "[dots]\nruling_per_cm = 60\nspread_um = 40\n[[area]]\ncoverage = 0.5\n";
    let print = DYE.to_owned() + dots;
    for field in ["area[0].coverage", "dots.spread_um", "resolution.accuracy", "light.step_nm"] {
        let told = design("lab = [89, -8, 22]", &[(field, 0.1, 0.9)], "delta_e = 0.5", &print);
        let told = plain(&run(folder.path(), &told));
        let words = ["vary[0].field", field, "the solid that a design aims at", "[[area]] coverage = [0.1"];
        assert!(words.iter().all(|word| told.contains(word)), "{words:?}: {told}");
    }
}

/// *Planted*: each refusal left out.
#[test]
fn wishes_for_numbers_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |text: &str| plain(&run(folder.path(), text));
    let two = "name = \"sun\"\nat_least = 0.5\n[[target.number]]\nname = \"sun\"\nat_most = 0.9";
    for (wish, words) in [
        (
            "name = \"density\"\nat_least = 1",
            vec!["target.number[0].name", "\"density\"", "\"blue density\", \"sun\""],
        ),
        ("name = \"sun\"", vec!["target.number[0]", "neither", "at_least, at_most, or both"]),
        ("name = \"sun\"\nat_least = 0.7\nat_most = 0.6", vec!["target.number[0]", "0.7 to 0.6"]),
        (
            "name = \"sun\"\nat_least = 60",
            vec!["target.number[0].at_least", "60", "0 to 1", "write 0.6 for 60 %"],
        ),
        (two, vec!["target.number[1].name", "twice", "in one [[target.number]]"]),
    ] {
        let told = refused(&of_number(wish));
        assert!(words.iter().all(|word| told.contains(word)), "{words:?}: {told}");
    }
    let told = refused(&of_target(""));
    assert!(told.contains("neither lab nor file nor number"), "{told}");
    // light that no eye sees carries no colour to tell recipes with
    let dark = with(DYE, "from_nm = 400\nto_nm = 700", "from_nm = 800\nto_nm = 1000");
    let dark = with(&dark, "{ built_in = \"yellow\" }", "{ n = 1.6, k = 0.01 }")
        + "[[number]]\nname = \"sun\"\nweights = \"solar_g173\"\nfrom_nm = 800\nto_nm = 1000\nof = \"albedo\"\n";
    let target = "[[target.number]]\nname = \"sun\"\nat_least = 0.5";
    let dark = design(target, &[(SHARE, 0.05, 0.4)], "delta_e = 0.5", &dark);
    let told = refused(&dark);
    assert!(told.contains("base.light") && told.contains("carry a colour"), "{told}");
}
