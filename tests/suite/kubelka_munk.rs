//! Kubelka–Munk coefficients of real solves: what they are for is to say what the ink is over another backing.

use crate::run_support::{TINY, study, succeed};
use inkwave::appearance::kubelka_munk::KubelkaMunk;
use inkwave::evaluate::on_paper::LayerOnPaper;
use inkwave::evaluate::samples::SolvedDirection;
use inkwave::evaluate::seen::Seen;
use inkwave::export::stored::Stored;

/// Albedo of a backing that the study knows nothing of.
const GREY: f64 = 0.4;
/// Thickness of the study's layer, µm.
const THICKNESS_UM: f64 = 0.5;

/// Mean over the hemisphere of all light that comes back over the grey backing, from R and T of the solves themselves: their
/// differences from the film, and the film's exact means. K and S come from T and A.
fn over_grey(seen: &Seen) -> Vec<f64> {
    let layer = seen.layer.as_ref().unwrap();
    let mean = |w: usize| {
        let film = layer.film(seen.solved[0].wavelengths[w].wavelength_nm);
        let strata: Vec<_> = seen.solved.iter().flat_map(|r| &r.wavelengths[w].strata).collect();
        let [r, t] = film.means();
        let beyond = |s: &&SolvedDirection| {
            let [film_r, film_t] = film.reflectance_transmittance(s.polar_deg);
            [s.reflectance - film_r, s.transmittance - film_t]
        };
        let sum = strata.iter().map(beyond).fold([0.0; 2], |[a, b], [r, t]| [a + r, b + t]);
        let r = r + sum[0] / strata.len() as f64;
        let t = t + sum[1] / strata.len() as f64;
        r + t * t * GREY / (1.0 - GREY * r)
    };
    (0..seen.solved[0].wavelengths.len()).map(mean).collect()
}

/// The layer as two fluxes, faces and all, predicts its ink over grey within two standard errors. *Planted*: without the light
/// that goes back and forth between layer and backing the prediction is further off than that. K and S themselves are not
/// published: most light goes straight through a thin layer, so that they would be those of its faces and thickness.
#[test]
fn two_fluxes_of_stored_solves_predict_a_third_backing_and_a_thin_layer_has_no_coefficients() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), &TINY.replace("realisations = 2", "realisations = 12")), &out, &[]);
    let stored = Stored::read(&out).unwrap();
    let ink = stored.seen.ink.as_ref().unwrap();
    let fluxes = |layer: &LayerOnPaper| {
        let r = layer.mean_reflectance_exit();
        let t = layer.mean_transmittance();
        KubelkaMunk::from_layer(r, t, THICKNESS_UM).unwrap()
    };
    let predicted = ink.spectrum(|layer| fluxes(layer).over(GREY, THICKNESS_UM));
    let grey = over_grey(&stored.seen);
    assert_eq!(grey.len(), 4);
    let mut most_once = 0.0f64;
    for (i, estimate) in predicted.estimates().iter().enumerate() {
        let [r, t] = fluxes(&ink.layers()[i]).layer(THICKNESS_UM);
        let bar = estimate.standard_error.unwrap();
        let once = r + t * t * GREY;
        println!("{:.5} ± {bar:.5}, over grey {:.5}, once through {once:.5}", estimate.value, grey[i]);
        assert!((estimate.value - grey[i]).abs() < 2.0 * bar, "{estimate:?} {}", grey[i]);
        most_once = most_once.max((once - grey[i]).abs() / bar);
    }
    assert!(most_once > 2.0, "the check is empty: {most_once}");
    let results: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    let reason = results["ink_maker"]["no_kubelka_munk"].as_str().expect("a reason");
    assert!(reason.contains("is unscattered") && !out.join("kubelka-munk.csv").exists(), "{reason}");
    assert!(std::fs::read_to_string(out.join("report.html")).unwrap().contains(reason));
}
