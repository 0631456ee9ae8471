//! Weighted numbers of whole studies: in `results.json`, tables and pages, of thin and composed layers and in sweeps.

use crate::run_support::{TINY, results, study, succeed};
use inkwave_validation::formulas::films::{Film, amplitudes};
use num_complex::Complex64;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

fn number(results: &Value, name: &str) -> [f64; 2] {
    let all = results["numbers"].as_array().unwrap();
    let note = all.iter().find(|note| note["name"] == name).unwrap();
    // none where nothing is left open
    [note["value"].as_f64().unwrap(), note["standard_error"].as_f64().unwrap_or(0.0)]
}

const NUMBERS: &str = r#"
[[number]]
name = "red density"
weights = "status_t_red"
of = "lit_at_45"
transform = "density"
[[number]]
name = "blue density"
weights = "status_t_blue"
of = "lit_at_45"
transform = "density"
[[number]]
name = "Y"
weights = "D65/2"
of = "natural_light"
[[number]]
name = "yellowness"
weights = "D65/10"
of = "natural_light"
transform = "yellowness"
[[number]]
name = "haze"
weights = "C/2"
of = "scattered_transmittance"
over = "transmittance"
"#;

/// A yellow ink is dense in blue light and yellow; its Y under natural light is the colour's, whether
/// the wavelengths are listed or shifted; the table and the page have every number with its bar.
/// *Planted*: residuals of the fits left out of shifted sums; the second spectrum of a haze left out.
#[test]
fn a_yellow_ink_has_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let listed = TINY.replace("step_nm = 100", "step_nm = 20");
    let shifted =
        listed.replace("sampling = \"listed\"\n", "").replace("realisations = 2", "realisations = 4");
    for (name, text) in [("listed", listed), ("shifted", shifted)] {
        let out = folder.path().join(name);
        let said = succeed(&study(folder.path(), &format!("{text}{NUMBERS}")), &out, &[]);
        let results = results(&out);
        let red = number(&results, "red density");
        let blue = number(&results, "blue density");
        assert!(blue[0] > red[0] + 0.05 && red[1] > 0.0, "{name}: {red:?} {blue:?}");
        let [luminous, error] = number(&results, "Y");
        let of_colour = results["colours"][0]["xyz"][1].as_f64().unwrap();
        // the CIE's tables from 380 to 780 nm against sums from 400 to 700 nm
        assert!((100.0 * luminous - of_colour).abs() < 0.2, "{name}: {luminous} {of_colour}");
        assert!(error > 0.0 && error < 0.1, "{name}: {error}");
        assert!(number(&results, "yellowness")[0] > 10.0, "{name}");
        let [haze, error] = number(&results, "haze");
        assert!(haze > 0.0 && haze < 1.0 && error > 0.0, "{name}: {haze} {error}");
        let table = fs::read_to_string(out.join("numbers.csv")).unwrap();
        assert!(table.lines().count() == 6 && table.contains("red density,,"), "{table}");
        let page = fs::read_to_string(out.join("report.html")).unwrap();
        assert!(
            page.contains("Weighted numbers")
                && page.contains("density of lit_at_45, weighted with status_t_red")
        );
        assert!(!said.contains("[number"), "{said}");
    }
}

/// The density of light that is not there cannot be: it is withheld with the reason, and nothing else is.
#[test]
fn a_density_of_nothing_is_withheld() {
    let folder = tempfile::tempdir().unwrap();
    let dark = TINY.replace("[light]", "[paper]\nalbedo = 0.0\n[light]");
    let dark = dark.replace("binder.index = 1.558", "binder.index = 1.0").replace(
        "[[pigment]]\nname = \"yellow\"\ndiameter_nm = 200\nvolume_fraction = 0.15\nindex = { built_in = \"yellow\" }\n",
        "",
    );
    let text = format!(
        "{dark}[[number]]\nname = \"black\"\nweights = \"status_t_red\"\nof = \"albedo\"\ntransform = \"density\"\n"
    );
    let out = folder.path().join("out");
    succeed(&study(folder.path(), &text), &out, &[]);
    let results = results(&out);
    assert!(results["numbers"][0]["value"].is_null() && out.join("picture.png").exists());
    let reason = results["withheld"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("not above 0"), "{reason}");
}

/// Slabs of milliseconds from 400 to 1400 nm: colours take the visible part and say so, and are those of the visible part
/// alone; the sun's part has a bar from every source. *Planted*: the eye given all wavelengths.
#[test]
fn a_composed_layer_beyond_the_eye_has_colours_and_numbers() {
    let text = |nm: &str, number: &str| {
        format!(
            "title = 'Wide'\n[layer]\nperiod_um = 0.8\nthickness_um = [2, 4]\nbinder.index = 1.5\n\
             composed = {{ slab_um = 0.5 }}\n[[pigment]]\nname = 'grains'\ndiameter_nm = 200\nvolume_fraction = 0.15\n\
             index = 2.0\n[paper]\nalbedo = 0.5\n[light]\nwavelengths_nm = [{nm}]\n[run]\nrealisations = 2\nseed = 7\n\
             [resolution]\npoints_per_um = 16\nplanes_per_um = 40\n{number}"
        )
    };
    let sun =
        "[[number]]\nname = 'sun'\nweights = 'solar_g173'\nfrom_nm = 400\nto_nm = 1400\nof = 'albedo'\n";
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let wide = study(folder.path(), &text("400, 480, 560, 640, 720, 860, 1060, 1400", sun));
    let said = succeed(&wide, &out, &[]);
    assert!(said.contains("colours take the wavelengths from 380 to 780 nm"), "{said}");
    let all = results(&out);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("Colours and pictures take the wavelengths from 380 to 780 nm")
            && page.contains("Weighted numbers")
    );
    assert!(fs::read_to_string(out.join("numbers.csv")).unwrap().contains("sun,2,"));
    // of the visible part alone, from the same solves
    succeed(&study(folder.path(), &text("400, 480, 560, 640, 720", "")), &out, &[]);
    let eye = results(&out);
    for k in 0..2 {
        let lab =
            |results: &Value, c: usize| results["colours"][k]["natural_light"][c]["value"].as_f64().unwrap();
        // the same solves; error bars take their model's part from neighbouring wavelengths, values do not
        assert!((0..3).all(|c| (lab(&eye, c) - lab(&all, c)).abs() < 1e-9), "{:?}", lab(&all, 0));
        let note = &all["numbers"][k];
        assert_eq!((&note["name"], note["thickness_um"].as_f64()), (&"sun".into(), Some([2.0, 4.0][k])));
        let value = note["value"].as_f64().unwrap();
        let error = note["standard_error"].as_f64().unwrap();
        assert!((0.2..0.9).contains(&value) && error > 0.0 && error < 0.2, "{value} {error}");
        assert!(
            note["parts"]["chance"].as_f64().unwrap() > 0.0
                && note["parts"]["wavelengths"].as_f64().unwrap() > 0.0
        );
    }
}

/// Weighted numbers of a sweep's variants are in its table, and conclusions judge them. *Planted*: the difference judged
/// without its sign.
#[test]
fn sweeps_have_columns_and_verdicts_of_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let (base, rest) = TINY.split_once("[light]").unwrap();
    let base = base
        .replace("title = \"Tiny yellow\"\n", "")
        .replace("[layer]", "[base.layer]")
        .replace("[[pigment]]", "[[base.pigment]]");
    let rest =
        format!("[base.light]{rest}").replace("[angles]", "[base.angles]").replace("[run]", "[base.run]");
    let rest = rest.replace("[resolution]", "[base.resolution]").replace("[output]", "[base.output]");
    let text = format!(
        "title = \"Densities\"\n{base}{rest}[[base.number]]\nname = \"blue density\"\nweights = \"status_t_blue\"\n\
         of = \"lit_at_45\"\ntransform = \"density\"\n[[axis]]\nname = \"share\"\n\
         field = \"pigment.yellow.volume_fraction\"\nvalues = [0.05, 0.2]\n[[conclusion]]\nid = \"denser\"\n\
         statement = \"More pigment is denser\"\nquantity = \"number\"\nnumber = \"blue density\"\n\
         plus = [{{ share = 0.2 }}]\nminus = [{{ share = 0.05 }}]\nat_least = 0.0\n"
    );
    let path = folder.path().join("sweep.toml");
    fs::write(&path, &text).unwrap();
    let out = folder.path().join("out");
    let sweep = |path: &Path| {
        Command::new(env!("CARGO_BIN_EXE_inkwave"))
            .arg("sweep")
            .arg(path)
            .arg("--output")
            .arg(&out)
            .output()
            .unwrap()
    };
    let done = sweep(&path);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let table = fs::read_to_string(out.join("sweep.csv")).unwrap();
    assert!(table.lines().next().unwrap().ends_with("blue density,blue density_standard_error"), "{table}");
    let conclusions = fs::read_to_string(out.join("conclusions.csv")).unwrap();
    assert!(conclusions.contains("denser") && !conclusions.contains("refuted"), "{conclusions}");
    fs::write(&path, text.replace("number = \"blue density\"", "number = \"green density\"")).unwrap();
    let said = String::from_utf8_lossy(&sweep(&path).stderr).into_owned();
    assert!(said.contains("green density") && said.contains("one of blue density"), "{said}");
}

/// R and T of a clear or absorbing film between media of index 1 and `exit`, light along the normal.
fn film(index: Complex64, thickness_um: f64, exit: f64, nm: f64) -> [f64; 2] {
    let film = Film { index, thickness_um };
    let [r, t] = amplitudes(1.0, &[film], exit.into(), 1e-3 * nm, 0.0);
    [r.norm_sqr(), exit * t.norm_sqr()]
}

/// A sunscreen is as good as its thin places: the mean over the law of thicknesses, against a sum over its density.
/// *Planted*: places of equal probability.
#[test]
fn uneven_films_are_averaged_over_their_law() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("flat.csv"), "wavelength_nm,weight\n300,1\n320,1\n").unwrap();
    let text = "[layer]\nthickness_um = { mean = 2.0, std = 0.5 }\nbinder.index = { n = 1.5, k = 0.06 }\nindex_out = 1.4\n\
                [paper]\ncoupling = \"optical_contact\"\nalbedo = 0\n[light]\nfrom_nm = 295\nto_nm = 325\nstep_nm = 10\n[[number]]\nname = \"T\"\nweights = { csv = \"flat.csv\" }\n\
                of = \"transmittance\"\n";
    let out = folder.path().join("out");
    succeed(&study(folder.path(), text), &out, &[]);
    let density = |z: f64| (-0.5 * z * z).exp();
    let z = |k: usize| 3.0 * (f64::from(k as u32) - 299.5) / 300.0;
    let all: f64 = (0..600).map(|k| density(z(k))).sum();
    let at = |nm: f64| -> f64 {
        let of = |k: usize| density(z(k)) * film(Complex64::new(1.5, 0.06), 2.0 + 0.5 * z(k), 1.4, nm)[1];
        (0..600).map(of).sum::<f64>() / all
    };
    let truth: f64 = (0..200).map(|k| at(300.05 + 0.1 * f64::from(k))).sum::<f64>() / 200.0;
    let [value, _] = number(&results(&out), "T");
    // steps of 3 nm; places of equal probability are 1 to 3 % off
    assert!((value / truth - 1.0).abs() < 2e-3, "{value} {truth}");
}

/// Fringes as close as the wavelengths of a sum have no colour: sums are as close as they need, or a bar says so.
/// *Planted*: steps of 5 nm, or of 1 %, whatever the thickness.
#[test]
fn fringes_of_thick_films_have_no_colour() {
    let folder = tempfile::tempdir().unwrap();
    for um in [18.3, 29.0] {
        let clear = format!(
            "[layer]\nthickness_um = {um}\nbinder.index = 1.5\n[paper]\nalbedo = 0.5\n[light]\nfrom_nm = 380\nto_nm = 780\n\
             step_nm = 20\n[[number]]\nname = \"R\"\nweights = \"D65/2\"\nof = \"reflectance\"\n\
             [[number]]\nname = \"T\"\nweights = \"status_t_red\"\nof = \"transmittance\"\n"
        );
        let listed = clear.replace("step_nm = 20", "step_nm = 5\nsampling = \"listed\"");
        for (name, text) in [("shifted", clear), ("listed", listed)] {
            let out = folder.path().join(format!("{name}{um}"));
            succeed(&study(folder.path(), &text), &out, &[]);
            let results = results(&out);
            // the mean over all phases of two faces of 4 %
            let face: f64 = 0.04;
            let mean = 2.0 * face / (1.0 + face);
            let [reflected, r_error] = number(&results, "R");
            let [transmitted, t_error] = number(&results, "T");
            // what is left of fringes in a band of 30 nm and more
            let left = 2e-3;
            assert!((reflected - mean).abs() < left + 3.0 * r_error, "{name} {um}: {reflected} ± {r_error}");
            assert!(
                (transmitted - 1.0 + mean).abs() < left + 3.0 * t_error,
                "{name} {um}: {transmitted} ± {t_error}"
            );
            let lab = &results["colours"][1]["lab"];
            let bars = &results["colours"][1]["lab_standard_error"];
            for i in 1..3 {
                let value = lab[i].as_f64().expect("Lab");
                let error = bars[i].as_f64().unwrap_or(0.0);
                assert!(value.abs() < 0.15 + 3.0 * error, "{name} {um}: {lab} ± {bars}");
            }
        }
    }
}

/// Mean of a film's R with weights that are linear between rows, in steps of a thousandth of each interval.
fn weighted_film(rows: &[[f64; 2]], thickness_um: f64) -> f64 {
    let mut sum = 0.0;
    let mut total = 0.0;
    for pair in rows.windows(2) {
        let width = (pair[1][0] - pair[0][0]) / 1000.0;
        for k in 0..1000 {
            let share = (f64::from(k) + 0.5) / 1000.0;
            let weight = width * (pair[0][1] + share * (pair[1][1] - pair[0][1]));
            let nm = pair[0][0] + share * (pair[1][0] - pair[0][0]);
            sum += weight * film(Complex64::new(1.9, 0.0), thickness_um, 1.0, nm)[0];
            total += weight;
        }
    }
    sum / total
}

/// A laser, a line of 2 nm and a band of an LED are weighted where they are, whichever is closer: the fringes, the rows of
/// the weights or the wavelengths of broad sums. *Planted*: the wavelengths of broad sums alone, rows alone.
#[test]
fn narrow_weights_are_summed_as_closely_as_they_vary() {
    let laser = vec![[531.99, 0.0], [532.0, 1.0], [532.01, 0.0]];
    let line = vec![[531.0, 0.0], [532.0, 1.0], [533.0, 0.0]];
    let band: Vec<[f64; 2]> = (0..=8)
        .map(|k| {
            let nm = 600.0 + 5.0 * f64::from(k);
            [nm, 1.0 - ((nm - 620.0) / 20.0).powi(2)]
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let mut numbers = String::new();
    let all = [("laser", &laser), ("line", &line), ("band", &band)];
    for (name, rows) in all {
        let lines: String = rows.iter().map(|[nm, weight]| format!("{nm},{weight}\n")).collect();
        fs::write(folder.path().join(format!("{name}.csv")), format!("wavelength_nm,weight\n{lines}"))
            .unwrap();
        numbers += &format!(
            "[[number]]\nname = \"{name}\"\nweights = {{ csv = \"{name}.csv\" }}\nof = \"reflectance\"\n"
        );
    }
    numbers +=
        "[[number]]\nname = \"part\"\nweights = \"E/2\"\nfrom_nm = 531\nto_nm = 533\nof = \"reflectance\"\n";
    for um in [1.3, 8.0, 20.0, 150.0] {
        let text = format!(
            "[layer]\nthickness_um = {um}\nbinder.index = 1.9\n[light]\nfrom_nm = 400\nto_nm = 700\nstep_nm = 20\n{numbers}"
        );
        let out = folder.path().join(format!("{um}"));
        succeed(&study(folder.path(), &text), &out, &[]);
        let results = results(&out);
        for (name, rows) in all {
            let [value, _] = number(&results, name);
            let truth = weighted_film(rows, um);
            // thirty-two steps a fringe, whose amplitude is 0.15: trapezia miss 0.003 of it
            assert!((value - truth).abs() < 1e-3, "{name} of {um} µm: {value} {truth}");
        }
        // the luminosity hardly changes within 2 nm
        let [value, _] = number(&results, "part");
        let truth = weighted_film(&[[531.0, 0.874], [532.0, 0.885], [533.0, 0.895]], um);
        assert!((value - truth).abs() < 2e-3, "part of {um} µm: {value} {truth}");
    }
}
