//! Kubelka–Munk coefficients of real solves: what they are for is to say what the ink is over another backing.

use crate::run_support::{TINY, study, succeed};
use inkwave::appearance::kubelka_munk::KubelkaMunk;
use inkwave::evaluate::samples::SolvedDirection;
use inkwave::evaluate::seen::Seen;
use inkwave::export::stored::Stored;
use std::path::Path;

/// Albedo of a backing that the study knows nothing of.
const GREY: f64 = 0.4;
/// Thickness of the study's layer, µm.
const THICKNESS_UM: f64 = 0.5;

fn written(folder: &Path) -> Vec<KubelkaMunk> {
    let mut table = csv::Reader::from_path(folder.join("kubelka-munk.csv")).unwrap();
    let names: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    let place = |name: &str| names.iter().position(|n| n == name).unwrap();
    let [k, s] = ["absorption_per_um", "scattering_per_um"].map(place);
    let row = |row: csv::StringRecord| KubelkaMunk {
        absorption_per_um: row[k].parse().unwrap(),
        scattering_per_um: row[s].parse().unwrap(),
    };
    table.records().map(|r| row(r.unwrap())).collect()
}

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
        let [r, t] = [r + sum[0] / strata.len() as f64, t + sum[1] / strata.len() as f64];
        r + t * t * GREY / (1.0 - GREY * r)
    };
    (0..seen.solved[0].wavelengths.len()).map(mean).collect()
}

/// K and S as written by a run over white paper predict its ink over grey within two standard errors. *Planted*: without the light
/// that goes back and forth between layer and backing the prediction is further off than that.
#[test]
fn coefficients_of_stored_solves_predict_a_third_backing_within_their_bar() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), &TINY.replace("realisations = 2", "realisations = 12")), &out, &[]);
    let stored = Stored::read(&out).unwrap();
    let ink = stored.seen.ink.as_ref().unwrap();
    let predicted = ink.spectrum(|layer| {
        let (r, t) = (layer.mean_reflectance_exit(), layer.mean_transmittance());
        KubelkaMunk::from_layer(r, t, THICKNESS_UM).unwrap().over(GREY, THICKNESS_UM)
    });
    let (coefficients, grey) = (written(&out), over_grey(&stored.seen));
    assert_eq!((coefficients.len(), grey.len()), (4, 4));
    let mut most_once = 0.0f64;
    for (i, estimate) in predicted.estimates().iter().enumerate() {
        // rounding of the table's digits
        let over = coefficients[i].over(GREY, THICKNESS_UM);
        assert!((over - estimate.value).abs() < 1e-12, "{over} {}", estimate.value);
        let [r, t] = coefficients[i].layer(THICKNESS_UM);
        let (bar, once) = (estimate.standard_error.unwrap(), r + t * t * GREY);
        println!("{:.5} ± {bar:.5}, over grey {:.5}, once through {once:.5}", estimate.value, grey[i]);
        assert!((estimate.value - grey[i]).abs() < 2.0 * bar, "{estimate:?} {}", grey[i]);
        most_once = most_once.max((once - grey[i]).abs() / bar);
    }
    assert!(most_once > 2.0, "the check is empty: {most_once}");
}
