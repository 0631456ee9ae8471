//! Fits to the spectra of other packings than the fit's own, where nothing absorbs.

use super::{ALL_CARDS, BLACK, GRAINS, WHITE, column, fitted, on_cards, spectrum, study};

/// What a fit states is solved: the fitted spectra are those of a run at the index of `pigment.csv`,
/// and χ² is no larger than at the truth. Resonances of tiny cells bend the response within a step.
/// *Planted*: the spectra and the index of the last step, to first order.
#[test]
fn fitted_spectra_are_those_of_a_run_at_the_fitted_index() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let waves = "[560, 600, 640]";
    let others = GRAINS.replace("seed = 7", "seed = 11");
    let fit = on_cards(folder, &study(&others, "{ n = 1.7, k = 0.0 }", waves), &ALL_CARDS);
    let (words, found) = fitted(folder, &study(GRAINS, "1.6", waves), &(fit + "[fit]\nnoise = 0.003\n"));
    let fit = &found["fit"];
    let at_it = study(GRAINS, "{ csv = \"fit/pigment.csv\" }", waves);
    for (spectrum_number, (card, geometry)) in ALL_CARDS.into_iter().enumerate() {
        let backing = if card == "white" { WHITE } else { BLACK };
        let name = if geometry == "45:0" { "lit_at_45" } else { "natural_light" };
        let run = spectrum(folder, &at_it, backing, name);
        let fitted = fit["spectra"][spectrum_number]["fitted"].as_array().expect("values");
        for ([nm, run], fitted) in run.iter().zip(fitted) {
            let fitted = fitted.as_f64().expect("a number");
            // an identity, but for the six decimals of n in the table
            assert!((run - fitted).abs() < 3e-5, "{card} {geometry} at {nm} nm: {fitted} for {run}: {words}");
        }
    }
    // one of the wavelengths in twenty may miss by more than 2 standard errors, hardly by more than 4
    for (n, error) in column(&fit["index"], "n").iter().zip(column(&fit["index"], "n_error")) {
        assert!((n - 1.7).abs() < 4.0 * error, "{n} ± {error}: {words}");
    }
}
