//! Studies of Maxwell's equations from file to results: films, polarisations, records, refusals.

use crate::run_support::{TINY, results_of, run, study};
use inkwave::store::{PointRecord, Record, Store};
use num_complex::Complex64;
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::Path;

/// The tiny study in one kind of light.
fn lit_by(wave: &str, text: &str) -> String {
    text.replace("[light]", &format!("[light]\nwave = \"{wave}\""))
}

/// A number of every row of the spectra.
fn column(results: &Value, name: &str) -> Vec<f64> {
    let value = |row: &Value| row[name]["value"].as_f64();
    results["spectra"].as_array().unwrap().iter().filter_map(value).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

fn keys(folder: &Path) -> Vec<String> {
    let store: Store<PointRecord> = Store::open(folder.join("out")).unwrap();
    let mut keys: Vec<String> = store.database().keys(PointRecord::KIND).into_iter().collect();
    keys.sort();
    keys
}

/// Airy's R and T of a slab in vacuum, E or H along the plane.
fn airy(index: Complex64, thickness_um: f64, wavelength_um: f64, polar_deg: f64, p: bool) -> [f64; 2] {
    let (sin, cos) = polar_deg.to_radians().sin_cos();
    let b = (index * index - sin * sin).sqrt();
    let inside = if p { b / (index * index) } else { b };
    let r = (cos - inside) / (cos + inside);
    let phase = (Complex64::i() * b * thickness_um * TAU / wavelength_um).exp();
    let denominator = 1.0 - r * r * phase * phase;
    let reflected = r * (1.0 - phase * phase) / denominator;
    [reflected.norm_sqr(), ((1.0 - r * r) * phase / denominator).norm_sqr()]
}

/// A pigment without grains mixes by Maxwell Garnett's rule by default, and the film is Airy's in s, p and both.
#[test]
fn a_film_without_grains_is_airys_in_every_polarisation() {
    let base = "[layer]\nperiod_um = 0.8\nthickness_um = 0.7\nbinder.index = 1.558\n\
        [[pigment]]\nname = 'grey'\ndiameter_nm = 'molecular'\nvolume_fraction = 0.3\nindex = { n = 1.4, k = 0.2 }\n\
        [light]\nwavelengths_nm = [450, 600]\n[angles]\npolar_deg = [0, 30, 60]\n";
    let host = Complex64::from(1.558 * 1.558);
    let grain = Complex64::new(1.4, 0.2) * Complex64::new(1.4, 0.2);
    let beta = 0.3 * (grain - host) / (grain + 2.0 * host);
    let garnett = (host * (1.0 + 2.0 * beta) / (1.0 - beta)).sqrt();
    let average = (0.7 * host + 0.3 * grain).sqrt();
    let averaged = base.replace("binder.index", "mixing = 'volume-average'\nbinder.index");
    for (text, index) in [(base, garnett), (&averaged, average)] {
        for (wave, shares) in [("s", [1.0, 0.0]), ("p", [0.0, 1.0]), ("unpolarised", [0.5, 0.5])] {
            let folder = tempfile::tempdir().unwrap();
            let results = results_of(folder.path(), &lit_by(wave, text));
            for row in results["spectra"].as_array().unwrap() {
                let number = |name: &str| row[name].as_f64().unwrap();
                let film = |p| airy(index, 0.7, 1e-3 * number("wavelength_nm"), number("polar_deg"), p);
                let s = film(false);
                let p = film(true);
                for (i, name) in ["reflectance", "transmittance"].into_iter().enumerate() {
                    let want = shares[0] * s[i] + shares[1] * p[i];
                    // the film is exact: rounding
                    let got = row[name]["value"].as_f64().unwrap();
                    assert!((got - want).abs() < 1e-11, "{wave} {name}: {got} instead of {want}");
                }
            }
        }
    }
}

/// One store, four lights: no record of one serves for another by mistake, s and p serve for both and unpolarised light,
/// whose every number that is linear in the light is the mean of theirs.
#[test]
fn unpolarised_light_is_the_mean_of_s_and_p_and_no_record_is_stale() {
    let folder = tempfile::tempdir().unwrap();
    let scalar = results_of(folder.path(), TINY);
    let first = keys(folder.path());
    let s = results_of(folder.path(), &lit_by("s", TINY));
    // paper depolarises: what comes back through the layer needs both polarisations
    assert_eq!((s["solves"]["finished"].as_u64(), first.len()), (Some(48), 24));
    assert_eq!(keys(folder.path()).len(), 24 + 48, "the scalar solves serve for nothing else");
    let p = results_of(folder.path(), &lit_by("p", TINY));
    let both = results_of(folder.path(), &lit_by("unpolarised", TINY));
    assert_eq!(keys(folder.path()).len(), 24 + 48, "s and p are solved once");
    assert_eq!(both["study"]["wave"], "unpolarised");
    for name in ["reflectance", "specular_reflectance", "transmittance", "absorptance", "natural_light"] {
        let s = column(&s, name);
        let p = column(&p, name);
        let both = column(&both, name);
        let scalar = column(&scalar, name);
        let mean = s.iter().zip(&p).map(|(s, p)| 0.5 * (s + p));
        // linear fits of the same samples: rounding
        assert!(!both.is_empty() && largest(mean.zip(&both).map(|(m, b)| m - b)) < 1e-10, "{name}");
        // the vector wave is another one than the scalar
        assert!(largest(both.iter().zip(&scalar).map(|(b, s)| b - s)) > 1e-4, "{name}");
    }
    let largest_difference = |deg: f64| {
        let rows = s["spectra"].as_array().unwrap().iter().zip(p["spectra"].as_array().unwrap());
        let rows = rows.filter(|(row, _)| row["polar_deg"].as_f64() == Some(deg));
        let reflectance = |row: &Value| row["reflectance"]["value"].as_f64().unwrap();
        rows.map(|(s, p)| (reflectance(s) - reflectance(p)).abs()).fold(0.0, f64::max)
    };
    let at_0 = largest_difference(0.0);
    let at_45 = largest_difference(45.0);
    // two packings of few grains tell s from p a little at 0°; at 45° Fresnel does
    assert!(at_0 < 0.03 && at_45 > 0.05, "{at_0} {at_45}");
}

#[test]
fn a_finished_run_in_unpolarised_light_has_everything_and_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let text = lit_by("unpolarised", TINY);
    let first = results_of(folder.path(), &text);
    assert_eq!((&first["status"], first["colours"].as_array().unwrap().len()), (&Value::from("complete"), 2));
    let out = folder.path().join("out");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("unpolarised light") && !page.contains("solved as a scalar one"));
    assert!(std::fs::read(out.join("picture.png")).unwrap().starts_with(b"\x89PNG"));
    let export = ["export", &out.display().to_string(), "--to", "mitsuba", "--near-field", "550"];
    let refused = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave")).args(export).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(said.contains("near field") && !said.contains("tabulating"), "refused before working: {said}");
    let spectra = std::fs::read(out.join("spectra.csv")).unwrap();
    let store: Store<PointRecord> = Store::open(&out).unwrap();
    let keys = store.database().keys(PointRecord::KIND);
    let lost = keys.iter().next().unwrap();
    let polarised = store.get(lost).unwrap();
    assert!(polarised.polarisation.is_some() && polarised.orders.iter().all(|o| o.crossed.is_some()));
    store.database().remove(PointRecord::KIND, Some(lost)).unwrap();
    drop(store);
    let again = results_of(folder.path(), &text);
    assert_eq!(again["solves"]["finished"], 48);
    assert!(
        spectra == std::fs::read(out.join("spectra.csv")).unwrap(),
        "the lost half of a pair comes back bit for bit"
    );
}

#[test]
fn what_is_not_solved_with_maxwells_equations_is_refused_by_its_field() {
    let folder = tempfile::tempdir().unwrap();
    let vector = lit_by("p", TINY);
    let cases = [
        (vector.replace("binder.index", "relief = { depth_um = 0.1 }\nbinder.index"), "layer.relief"),
        (vector.replace("{ built_in = \"yellow\" }", "{ n = 0.2, k = 3.0 }"), "pigment[0].index"),
        (vector.clone() + "[solver]\nstrategy = \"relaxation\"\n", "solver.strategy"),
        (lit_by("circular", TINY), "unpolarised"),
    ];
    for (text, field) in cases {
        let done = run(&study(folder.path(), &text), &folder.path().join("out"), &[]);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(!done.status.success() && said.contains(field), "{field}: {said}");
    }
}

/// Identity: grains whose two indices are equal are those of one index, bit for bit, and other axes than their own move no
/// grain. Birefringent ones scatter differently from their mean.
#[test]
fn grains_of_two_equal_indices_are_those_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, index: &str| {
        let text = TINY.replace("index = { built_in = \"yellow\" }", index);
        let own = folder.path().join(name);
        std::fs::create_dir(&own).unwrap();
        column(&results_of(&own, &lit_by("unpolarised", &text)), "natural_light")
    };
    let plain = of("plain", "index = 1.9");
    let equal = of("equal", "index = { ordinary = 1.9, extraordinary = 1.9 }\noptic_axis = [1, 0, 0]");
    assert!(!plain.is_empty());
    assert_eq!(plain, equal);
    let mean = f64::sqrt((2.0 * 1.75f64.powi(2) + 2.2f64.powi(2)) / 3.0);
    let mean = of("mean", &format!("index = {mean}"));
    let crystals = of("crystals", "index = { ordinary = 1.75, extraordinary = 2.2 }");
    let apart = largest(mean.iter().zip(&crystals).map(|(a, b)| a - b));
    assert!((1e-4..0.1).contains(&apart), "{apart}");
}
