//! Fits of films, whose spectra closed forms give.

use super::{BLACK, WHITE, assert_found, fitted, measured, predicted, study, write_column};
use inkwave::fit::load::{FitTask, load};
use inkwave::fit::response::Origin;
use inkwave::fit::run::FitRun;
use inkwave::run::RunSettings;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::{Holds, PARTIAL};
use inkwave_validation::formulas::films::{Film, amplitudes};
use num_complex::Complex64;
use std::path::Path;

/// Grains so small that the layer is a film of their mean η².
const FINE: &str = "[layer]\nperiod_um = 0.2\nthickness_um = 0.9\nbinder.index = 1.5\n[[pigment]]\nname = \"a\"\n\
                    diameter_nm = 30\nvolume_fraction = 0.3\nindex = INDEX\n[light]\nwavelengths_nm = WAVES\n\
                    [angles]\ncount = 5\n[run]\nrealisations = 6\nseed = 7\n[resolution]\npoints_per_um = 50\nplanes_per_um = 50\n";
const GREY: f64 = 0.4;

/// R and T of a film in air at angles, and over the hemisphere.
struct FilmInAir(Film, f64);

impl FilmInAir {
    fn at(&self, deg: f64) -> [f64; 2] {
        amplitudes(1.0, &[self.0], 1.0.into(), self.1, deg).map(|a| a.norm_sqr())
    }

    /// Means over Lambertian light: ∫ R d(sin²θ), by the midpoint rule.
    fn mean(&self) -> [f64; 2] {
        let count = 20_000;
        let mut sums = [0.0; 2];
        for k in 0..count {
            let deg = ((f64::from(k) + 0.5) / f64::from(count)).sqrt().asin().to_degrees();
            let [r, t] = self.at(deg);
            sums = [sums[0] + r, sums[1] + t];
        }
        sums.map(|sum| sum / f64::from(count))
    }

    /// What an instrument reads of the film over a Lambertian card, with a gap: what passes the film, and is sent back and
    /// forth between card and film.
    fn on_card(&self, albedo: f64, geometry: &str) -> f64 {
        let [r_mean, t_mean] = self.mean();
        let series = albedo / (1.0 - albedo * r_mean);
        let [r_normal, t_normal] = self.at(0.0);
        match geometry {
            "45:0" => self.at(45.0)[1] * series * t_normal,
            // reciprocal: lit at 8°, all light collected
            "d:8" => self.at(8.0)[0] + self.at(8.0)[1] * series * t_mean,
            "d:8 excluded" => self.at(8.0)[1] * series * t_mean,
            "transmittance" => t_normal,
            _ => r_normal + t_mean * series * t_normal,
        }
    }
}

/// The film of the mean η² of binder and pigment.
fn mean_film(pigment: Complex64, share: f64, thickness_um: f64) -> Film {
    let square = (1.0 - share) * 1.5 * 1.5 + share * pigment * pigment;
    Film { index: square.sqrt(), thickness_um }
}

/// The task of a fit of `FINE` at two wavelengths, with spectra of a film on cards in some geometries.
fn film_task(folder: &Path, pigment: Complex64, cards: &[(f64, &str)]) -> FitTask {
    film_task_at(&[500.0, 620.0], folder, pigment, cards)
}

fn film_task_at(waves_nm: &[f64], folder: &Path, pigment: Complex64, cards: &[(f64, &str)]) -> FitTask {
    let mut fit = "base = \"base.toml\"\n".to_owned();
    for (k, &(albedo, geometry)) in cards.iter().enumerate() {
        let value = |nm: f64| FilmInAir(mean_film(pigment, 0.3, 0.9), 1e-3 * nm).on_card(albedo, geometry);
        let column = if geometry == "transmittance" { geometry } else { "reflectance" };
        let rows: Vec<[f64; 2]> = waves_nm.iter().map(|&nm| [nm, value(nm)]).collect();
        write_column(&folder.join(format!("{k}.csv")), column, &rows);
        fit += &measured(&format!("{k}.csv"), albedo, geometry);
    }
    let waves = format!("{waves_nm:?}");
    std::fs::write(folder.join("base.toml"), study(FINE, "1.6", &waves)).expect("written");
    std::fs::write(folder.join("fit.toml"), fit).expect("written");
    load(&folder.join("fit.toml")).expect("sound")
}

const GEOMETRIES: [(f64, &str); 6] = [
    (WHITE, "45:0"),
    (BLACK, "45:0"),
    (WHITE, "d:8"),
    (BLACK, "d:8"),
    (WHITE, "natural"),
    (BLACK, "natural"),
];

/// *Planted*: a sphere's instrument at 45°, a uniform sky without what the surface mirrors, a sphere without
/// specular light with it, and what passes the layer with its card.
#[test]
fn instruments_read_a_film_on_a_card_as_closed_forms_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let pigment = Complex64::new(1.75, 0.06);
    let all = [&GEOMETRIES[..], &[(WHITE, "d:8 excluded"), (WHITE, "transmittance")]].concat();
    let task = film_task(folder.path(), pigment, &all);
    let index = [[pigment.re, pigment.im]; 2];
    let seen = Origin::Film.spectra(&task, &task.measured, &index, ([0.0; 2], 0.0)).expect("spectra");
    for (drawdown, seen) in task.measured.iter().zip(seen) {
        let expected = drawdown.values.as_ref().expect("values");
        for (a, b) in seen.values.iter().zip(expected) {
            // the midpoint rule
            assert!((a - b).abs() < 1e-5, "{}, {:?}: {a} for {b}", drawdown.name, drawdown.geometry);
        }
    }
}

/// A thickness keeps the relative spread of the base, and a factor on all thicknesses does, too. *Planted*: either
/// without.
#[test]
fn the_spread_of_a_thickness_goes_with_the_thickness() {
    let folder = tempfile::tempdir().expect("a folder");
    let uneven = |mean: f64, std: f64| {
        let task = film_task(folder.path(), Complex64::new(1.75, 0.06), &GEOMETRIES[..1]);
        let layer = format!("thickness_um = {{ mean = {mean}, std = {std} }}");
        let text = study(FINE, "1.6", "[500, 620]").replace("thickness_um = 0.9", &layer);
        std::fs::write(folder.path().join("base.toml"), text).expect("written");
        drop(task);
        load(&folder.path().join("fit.toml")).expect("sound")
    };
    let task = uneven(0.6, 0.06);
    let index = [1.75, 0.06];
    let twice = predicted(&uneven(1.2, 0.12), index, 0.0);
    let factor = predicted(&task, index, 2.0_f64.ln());
    assert!(twice.iter().zip(&factor).all(|(a, b)| (a - b).abs() < 1e-9), "{twice:?} {factor:?}");
    let fit = std::fs::read_to_string(folder.path().join("fit.toml")).expect("a fit");
    drop(uneven(0.6, 0.06));
    std::fs::write(folder.path().join("fit.toml"), fit + "thickness_um = 1.2\n").expect("written");
    let own = load(&folder.path().join("fit.toml")).expect("sound");
    assert!((own.coats[0].variation.thickness_std_um - 0.12).abs() < 1e-12);
}

/// A density in a narrow band about 500 nm.
const DENSITY: &str = "[[number]]\nname = \"density\"\nweights = { csv = \"band.csv\" }\nof = \"lit_at_45\"\ntransform = \"density\"\n";

/// An independent truth: Airy's and Fresnel's formulas for the film of the mean η², which grains of 30 nm are; of a grey card
/// there is a density alone. *Planted*: the density of another card (χ² finds it).
#[test]
fn a_film_gives_the_index_of_its_pigment_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = Complex64::new(1.75, 0.06);
    drop(film_task_at(&[500.0, 560.0, 620.0], folder.path(), truth, &GEOMETRIES));
    let fit = std::fs::read_to_string(folder.path().join("fit.toml")).expect("a fit");
    let density = -FilmInAir(mean_film(truth, 0.3, 0.9), 0.5).on_card(GREY, "45:0").log10();
    let number = format!("[[measured.number]]\nname = \"density\"\nvalue = {density}\nerror = 0.003\n");
    let fit = fit.replace("base = \"base.toml\"\n", "")
        + &format!("[[measured]]\nbacking = {GREY}\n{number}[fit]\nprior = \"smooth\"\n");
    let base = std::fs::read_to_string(folder.path().join("base.toml")).expect("a base") + DENSITY;
    let band = "wavelength_nm,weight\n499.5,0\n500,1\n500.5,0\n";
    std::fs::write(folder.path().join("band.csv"), band).expect("written");
    let (said, found) = fitted(folder.path(), &base, &fit);
    let fit = &found["fit"];
    // 95 %: there is no noise, but grains scatter and keep a distance from the faces
    assert_found(fit, [truth.re, truth.im], 1.96);
    assert_eq!(
        (fit["n_is_determined"].as_bool(), fit["trust"].as_str()),
        (Some(true), Some("consistent")),
        "{said}"
    );
    let number = &fit["numbers"][0];
    let of = |key: &str| number[key].as_f64().expect(key);
    assert!((of("fitted") - density).abs() < 2.0 * of("sigma") && of("sigma") < 0.03, "{number}");
}

/// Results of another input do not outlive the start of new work.
#[test]
fn a_fit_that_begins_removes_earlier_results() {
    let folder = tempfile::tempdir().expect("a folder");
    let task = film_task(folder.path(), Complex64::new(1.75, 0.06), &GEOMETRIES[..2]);
    let out = OutputFolder::open(&folder.path().join("fit"), Holds::Fit).expect("a folder");
    let old = ["fit.json", "pigment.csv", "pigment-other.csv", "report.html"];
    old.iter().for_each(|name| out.write(name, b"old").expect("written"));
    // stopped right after the packings
    let settings = RunSettings::default();
    drop(FitRun::new(&task, &out, settings, &()).expect("begun"));
    assert!(old.iter().all(|name| !out.path().join(name).exists()) && out.path().join(PARTIAL).exists());
}
