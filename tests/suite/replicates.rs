//! The jackknife replicates of published numbers: the errors by chance follow from them.

use super::run_support::{COMPOSED, TINY, with};
use inkwave::evaluate::composed::summary::summarise_slabs;
use inkwave::evaluate::seen::see;
use inkwave::evaluate::summary::summarise;
use inkwave::input::load::load;
use inkwave::input::study::Study;
use inkwave::run::RunSettings;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::work::alone::{run_portions, run_study};

fn loaded(text: &str, folder: &std::path::Path) -> (Study, OutputFolder) {
    let file = folder.join("study.toml");
    std::fs::write(&file, text).unwrap();
    (load(&file).unwrap(), OutputFolder::open(&folder.join("out"), Holds::Study).unwrap())
}

/// (n − 1)/n Σ (x − x̄)².
fn variance(replicates: &[f64]) -> f64 {
    let n = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / n;
    (n - 1.0) / n * replicates.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
}

/// Every number of a spectrum has a replicate for each realisation, and an error that is at least
/// what they scatter by; of R, the contributions of the realisations are those of the replicates.
/// *Planted*: the replicates of R and T changed round.
#[test]
fn every_number_of_a_spectrum_has_its_replicates() {
    let scratch = tempfile::tempdir().unwrap();
    let (study, folder) = loaded(TINY, scratch.path());
    let collected = run_study(&study, &folder, RunSettings::default(), &()).unwrap().collected;
    let seen = see(&study, &collected).unwrap();
    let manifest = summarise(&study, &collected, &seen);
    let rows = manifest.spectra.whole();
    assert!(!rows.is_empty());
    for row in rows {
        let all = &row.replicates;
        let mut numbers = vec![
            (row.reflectance, &all.reflectance),
            (row.specular_reflectance, &all.specular_reflectance),
            (row.transmittance, &all.transmittance),
            (row.specular_transmittance, &all.specular_transmittance),
            (row.absorptance, &all.absorptance),
        ];
        numbers.extend(row.natural_light.map(|number| (number, &all.natural_light)));
        numbers.extend(row.lit_at_45.map(|number| (number, &all.lit_at_45)));
        for (number, replicates) in numbers {
            assert_eq!(replicates.len(), row.deviations.len());
            let error = number.standard_error.unwrap();
            // rounding of a sum of squares
            assert!(error >= variance(replicates).sqrt() - 1e-12, "{error} {replicates:?}");
        }
        let of_r: f64 = row.deviations.iter().map(|(_, [r, _])| r * r).sum();
        assert!((of_r - variance(&all.reflectance)).abs() < 1e-12, "{of_r}");
    }
}

/// Of a composed layer, the variances of all portions add up to the chance of a number; without one of
/// them there are none. *Planted*: the replicates of one portion left out; what is there taken for all.
#[test]
fn the_chance_of_a_composed_layer_is_that_of_its_replicates() {
    let scratch = tempfile::tempdir().unwrap();
    let layer = with(&with(COMPOSED, "[1, 2, 50]", "[1, 2]"), "[450, 550, 650]", "[450, 550]");
    let (study, folder) = loaded(&layer, scratch.path());
    let solved = run_portions(&study, &folder, RunSettings::default(), &()).unwrap().solved;
    let manifest = summarise_slabs(&study, &solved).unwrap();
    // while it is solved, portions of which nothing is stored are missing
    for missing in 0..solved.len() {
        let mut fewer = solved.clone();
        fewer.remove(missing);
        let told = summarise_slabs(&study, &fewer).map(|_| ()).expect_err("a portion is missing");
        assert!(told.contains("not every slab"), "{told}");
    }
    let slabs = manifest.slabs.as_ref().unwrap();
    let chance = |thickness: usize, w: usize| -> [f64; 2] {
        let rows = slabs.replicates.iter().map(|all| &all.requested[thickness].spectra[w]);
        rows.fold([0.0; 2], |[r, t], row| {
            [r + variance(&row.reflectance_normal), t + variance(&row.transmittance_diffuse)]
        })
    };
    let rows = manifest.spectra.composed();
    assert_eq!(rows.len(), 4);
    for (k, row) in rows.iter().enumerate() {
        let [r, t] = chance(k / 2, k % 2).map(f64::sqrt);
        // rounding
        assert!((row.layer.reflectance_normal.unwrap().chance - r).abs() < 1e-12, "{row:?} {r}");
        assert!((row.layer.transmittance_diffuse.unwrap().chance - t).abs() < 1e-12, "{row:?} {t}");
        assert!(r > 0.0);
    }
    let row = &slabs.medium[0].medium;
    let portions = slabs.replicates.iter();
    let of_index: f64 = portions.map(|all| variance(&all.medium[0].effective_index)).sum();
    assert!((row.effective_index.unwrap().chance - of_index.sqrt()).abs() < 1e-12);
}
