//! Composed layers as a user runs them: any thickness of one set of solves, resumed, swept, in either wave.

use super::run_support::{COMPOSED, described_tables, results, study, succeed, value};
use num_complex::Complex64;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// No light is lost at any thickness, all of it comes back from a perfect white, T falls with the thickness.
fn is_sound(results: &Value) {
    let rows = results["spectra"].as_array().expect("rows");
    assert_eq!((rows.len(), results["status"].as_str()), (9, Some("complete")));
    for row in rows {
        for light in ["normal", "45", "diffuse"] {
            let sum = ["reflectance", "transmittance"].map(|lobe| value(row, &format!("{lobe}_{light}")));
            // rounding of some hundred products
            assert!((sum[0] + sum[1] - 1.0).abs() < 1e-7, "{light} {sum:?}");
        }
        assert!((value(row, "natural_light") - 1.0).abs() < 1e-6, "{row}");
    }
    // What leaves in single directions and in the beams is all that leaves. *Planted*: étendue without π.
    let leaves = results["distributions"].as_array().expect("directions");
    for row in rows {
        let same = |key: &str, other: &Value| other[key] == row[key];
        let here = |other: &&Value| {
            same("thickness_um", other) && same("wavelength_nm", other) && other["reflected"] == true
        };
        let part = |other: &Value| other["projected_sr"].as_f64().expect("sr") * value(other, "bdf_per_sr");
        let spread: f64 = leaves.iter().filter(here).map(part).sum();
        let whole = value(row, "reflectance_normal") - value(row, "mirrored");
        assert!((spread - whole).abs() < 0.02, "{spread} {whole}: all but what interference changes");
    }
    let through: Vec<f64> = rows.iter().step_by(3).map(|row| value(row, "transmittance_diffuse")).collect();
    assert!(through.windows(2).all(|t| t[1] < t[0]), "{through:?}");
}

#[test]
fn one_set_of_solves_answers_all_thicknesses_and_is_resumed() {
    let scratch = tempfile::tempdir().unwrap();
    let file = study(scratch.path(), COMPOSED);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let first = results(&output);
    is_sound(&first);
    // Three wavelengths make no colour, and without one there is no hiding: the reason is given.
    let no_hiding = first["no_hiding"].as_str().unwrap_or_default();
    assert!(no_hiding.contains("without a colour"), "{first}");
    for name in ["report.html", "spectra.csv", "medium.csv", "bdf.csv"] {
        assert!(output.join(name).exists(), "{name}");
    }
    assert_eq!(described_tables(&output), 3);
    // other thicknesses with the same slabs need no solve
    let other = study(scratch.path(), &COMPOSED.replace("[1, 2, 50]", "[1, 7]"));
    let said = succeed(&other, &output, &[]);
    assert!(
        said.contains("already stored") && !said.contains("per hour") && !said.contains("of 0 solves"),
        "{said}"
    );
    assert_eq!(results(&output)["spectra"][0], first["spectra"][0]);
    let refused = |more: &[&str], why: &str| {
        let done = export(&output, more);
        let said = String::from_utf8_lossy(&done.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!done.status.success() && said.contains(why), "{said}");
    };
    for format in ["vti", "positions", "labels", "viewer"] {
        refused(&["--to", format], &format!("{format} shows one packing"));
    }
    refused(&["--to", "cxf", "--thickness", "3"], "found 3 µm; allowed is 1, 7 µm");
}

fn export(folder: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inkwave")).arg("export").arg(folder).args(more).output().unwrap()
}

/// What the exports of a composed layer on a perfect white must hold.
fn exports_are_sound(output: &Path) {
    let done = export(output, &["--to", "mitsuba,cxf,cgats,npz,crate", "--thickness", "50"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let names = ["ink-rgb.bsdf", "spectra.cxf", "spectra.sp", "ro-crate-metadata.json", "bdf.csv"];
    for name in names.into_iter().chain(["far-fields-inner-slab.npz", "brdf-samples.csv"]) {
        assert!(output.join("export").join(name).exists(), "{name}");
    }
    let mut table = csv::Reader::from_path(output.join("export/specular.csv")).unwrap();
    for row in table.deserialize::<[f64; 5]>().map(|row| row.expect("numbers")) {
        let [nm, deg, mirrored, diffuse, of_brdf] = row;
        // the furnace from every side: what comes back is all; rounding of doubling, of which angles
        // between the nodes have more
        assert!((mirrored + diffuse - 1.0).abs() < 1e-4, "{nm} nm, {deg}°: {mirrored} {diffuse}");
        // Three directions carry the BRDF, at 60° within some 0.06 with the noise of two packings; the
        // mirrored light left in it, or étendue without π, would be more.
        assert!(deg > 60.0 || (of_brdf - diffuse).abs() < 0.1, "{nm} nm, {deg}°: {of_brdf} {diffuse}");
    }
    for name in ["picture.png", "picture-with-axes.png", "picture-50um.png"] {
        assert!(output.join(name).exists(), "{name}");
    }
}

#[test]
fn unpolarised_light_is_composed_from_s_and_p() {
    let scratch = tempfile::tempdir().unwrap();
    let text = COMPOSED
        .replace("[light]\n", "[light]\nwave = \"unpolarised\"\n")
        .replace("index = 2.0", "index = 1.8");
    let text = text.replace("450, 550, 650", "440, 530, 620");
    let file = study(scratch.path(), &text);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    is_sound(&results(&output));
    exports_are_sound(&output);
}

#[test]
fn a_sweep_of_composed_layers_has_a_table_and_a_page() {
    let scratch = tempfile::tempdir().unwrap();
    let base = COMPOSED.replace("title = \"Composed\"\n", "").replace("[1, 2, 50]", "1");
    let base = base.replace("[[pigment]]", "[[base.pigment]]");
    let tables = ["layer", "paper", "light", "run", "resolution"];
    let base = tables.iter().fold(base, |text, t| text.replace(&format!("[{t}]"), &format!("[base.{t}]")));
    let axis =
        "[[axis]]\nname = \"share\"\nfield = \"pigment.grains.volume_fraction\"\nvalues = [0.05, 0.15]\n";
    let file = scratch.path().join("sweep.toml");
    std::fs::write(&file, format!("title = \"Crowding\"\n{base}{axis}")).unwrap();
    let output = scratch.path().join("out");
    let done = Command::new(env!("CARGO_BIN_EXE_inkwave"))
        .arg("sweep")
        .arg(&file)
        .arg("--output")
        .arg(&output)
        .output();
    let done = done.unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let table = std::fs::read_to_string(output.join("composed.csv")).unwrap();
    assert_eq!(table.lines().count(), 7, "{table}");
    // sweep.csv, composed.csv, conclusions.csv, and three tables of each layer
    assert_eq!(described_tables(&output), 9);
    let page = std::fs::read_to_string(output.join("report.html")).unwrap();
    for shown in ["against share, with standard errors", "Curves and spectra of the layer", "Colours"] {
        assert!(page.contains(shown), "{shown}");
    }
}

/// A layer that is solved as a whole and one composed of slabs have one table: on a perfect white, both are as light as
/// it. *Planted*: variants of one kind alone are published.
#[test]
fn a_sweep_of_both_kinds_of_layers_has_one_table() {
    let scratch = tempfile::tempdir().unwrap();
    let base = COMPOSED.replace("[1, 2, 50]", "1").replace("composed = { slab_um = 0.5 }\n", "");
    let base = base.replace("[450, 550, 650]", "[400, 500, 600, 700]");
    std::fs::write(scratch.path().join("base.toml"), base).unwrap();
    let axis = "base = \"base.toml\"\n[[axis]]\nname = \"solved\"\n[[axis.case]]\nlabel = \"as a whole\"\n\
                [[axis.case]]\nlabel = \"in slabs\"\nset.\"layer.composed\" = { slab_um = 0.5 }\n";
    let file = scratch.path().join("sweep.toml");
    let output = scratch.path().join("out");
    std::fs::write(&file, axis).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    let done = command.arg("sweep").arg(&file).arg("--output").arg(&output).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut table = csv::Reader::from_path(output.join("sweep.csv")).unwrap();
    let lightness = table.headers().unwrap().iter().position(|name| name == "L").unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2, "{rows:?}");
    for row in rows {
        let l: f64 = row[lightness].parse().unwrap();
        // no light is lost but for the solver's residual
        assert!((l - 100.0).abs() < 0.1, "{row:?}");
    }
    assert!(output.join("composed.csv").exists() && output.join("contact-sheet.png").exists());
}

/// Grains of the binder's index: a film of 1.5, whose fringes at any thickness are Airy's.
const CLEAR: &str = r#"
title = "A film in slabs"
[layer]
thickness_um = [2, 5.3, 128, 300.7]
period_um = 0.8
binder.index = 1.5
composed = { slab_um = 1.0 }
[[pigment]]
diameter_nm = 200
volume_fraction = 0.1
index = 1.5
[paper]
albedo = 0.9
[light]
wavelengths_nm = [450, 550, 650]
[run]
realisations = 2
[resolution]
accuracy = 5e-2
"#;

/// R of a film of 1.5 between air and another medium for s light (and the scalar wave), by the sine
/// of its angle in air.
fn airy(thickness_um: f64, wavelength_um: f64, index_out: f64, sine: f64) -> f64 {
    let normal = |index: f64| (index * index - sine * sine).sqrt();
    let face = |a: f64, b: f64| (a - b) / (a + b);
    let front = face(normal(1.0), normal(1.5));
    let back = face(normal(1.5), normal(index_out));
    let phase = (2.0 * std::f64::consts::TAU / wavelength_um * normal(1.5) * thickness_um).cos();
    let f2 = front * front;
    let b2 = back * back;
    let product = front * back;
    (f2 + b2 + 2.0 * product * phase) / (1.0 + f2 * b2 + 2.0 * product * phase)
}

/// Its mean over the hemisphere, by the midpoint rule over the cosine.
fn airy_of_diffuse(thickness_um: f64, wavelength_um: f64, index_out: f64) -> f64 {
    let steps = 200_000;
    let at = |k: usize| {
        let cosine = (k as f64 + 0.5) / f64::from(steps);
        2.0 * cosine * airy(thickness_um, wavelength_um, index_out, (1.0 - cosine * cosine).sqrt())
    };
    (0..steps as usize).map(at).sum::<f64>() / f64::from(steps)
}

/// Between whole slabs too, at 0°, at 45°, in diffuse light and on the paper. *Planted*: a fraction
/// of a slab rounded, the paper's series without what interference sends back.
fn film_is_exact(text: &str, index_out: f64) {
    let scratch = tempfile::tempdir().unwrap();
    let file = study(scratch.path(), text);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let results = results(&output);
    for row in results["spectra"].as_array().expect("rows") {
        let um = row["thickness_um"].as_f64().expect("a number");
        let nm = row["wavelength_nm"].as_f64().expect("a number");
        let normal = airy(um, 1e-3 * nm, index_out, 0.0);
        let slanted = airy(um, 1e-3 * nm, index_out, 0.5_f64.sqrt());
        let diffuse = airy_of_diffuse(um, 1e-3 * nm, index_out);
        // the series between the film and the paper: of the paper's light, T̄/n² leaves
        let leaves = (1.0 - diffuse) / (index_out * index_out);
        let returned = 0.9 / (1.0 - 0.9 * (1.0 - leaves)) * (1.0 - normal);
        for (name, want) in [
            ("reflectance_normal", normal),
            ("transmittance_normal", 1.0 - normal),
            ("reflectance_45", slanted),
            ("transmittance_45", 1.0 - slanted),
            ("reflectance_diffuse", diffuse),
            ("transmittance_diffuse", 1.0 - diffuse),
            ("mirrored", normal),
            ("natural_light", normal + returned * leaves),
            ("lit_at_45", returned * (1.0 - slanted) / (index_out * index_out)),
        ] {
            // The mean over fringes that are too many to follow is off by up to 1e-4, and as much the
            // sum of the series; else it is the accuracy of the solves.
            let tolerance = if um > 100.0 { 3e-4 } else { 1e-6 };
            let off = (value(row, name) - want).abs();
            assert!(off < tolerance, "{um} µm, {nm} nm, {name}: {} {want}", row[name]);
        }
    }
    // a film scatters nothing, so that its medium has no coefficients; numbers of a thickness are all there
    assert!(!results["withheld"].to_string().contains("µm"), "{}", results["withheld"]);
}

#[test]
fn a_film_in_slabs_is_exact_at_any_thickness() {
    film_is_exact(CLEAR, 1.0);
}

/// Light from the paper meets the film from a denser medium. *Planted*: the series with R̄ of the
/// front.
#[test]
fn a_film_in_slabs_in_contact_with_its_paper_is_exact() {
    let contact = CLEAR.replace("binder.index = 1.5\n", "binder.index = 1.5\nindex_out = 1.3\n");
    let contact = contact.replace("albedo = 0.9", "albedo = 0.9\ncoupling = \"optical_contact\"");
    film_is_exact(&contact.replace("[2, 5.3, 128, 300.7]", "[2, 3.7]"), 1.3);
}

/// R and T of an even film between air and another medium, for light from either side, by its characteristic matrix; `sine` is the
/// lateral wavenumber, `p` says whether the light is p-polarised.
fn film_of_matrix(
    index: Complex64,
    phase_per_normal: f64,
    between: [f64; 2],
    sine: f64,
    p: bool,
) -> [f64; 2] {
    let normal = |index: Complex64| (index * index - sine * sine).sqrt();
    let admittance = |index: Complex64| if p { normal(index) / (index * index) } else { normal(index) };
    let [before, behind] = between.map(|index| admittance(index.into()));
    let own = admittance(index);
    let phase = phase_per_normal * normal(index);
    let b = phase.cos() - Complex64::I * phase.sin() * behind / own;
    let c = -Complex64::I * own * phase.sin() + phase.cos() * behind;
    let sum = before * b + c;
    [((before * b - c) / sum).norm_sqr(), 4.0 * before.re * behind.re / sum.norm_sqr()]
}

/// \[absorbed of diffuse light from behind, natural light on the paper\] of an even film.
fn absorbing_film(index: Complex64, phase: f64, index_out: f64, albedo: f64, polarised: &[bool]) -> [f64; 2] {
    let mean =
        |of: &dyn Fn(bool) -> f64| polarised.iter().map(|p| of(*p)).sum::<f64>() / polarised.len() as f64;
    let steps = 40_000;
    let over = |from: f64, to: f64, of: &dyn Fn(f64) -> f64| {
        // ∫ 2s ds along an arc of v = √(to² − s²), smooth at both ends
        let width = to * to - from * from;
        let at = |k: usize| {
            let t = std::f64::consts::FRAC_PI_2 * (k as f64 + 0.5) / f64::from(steps);
            (2.0 * t).sin() * of((to * to - width * t.cos().powi(2)).sqrt())
        };
        width * std::f64::consts::FRAC_PI_2 * (0..steps as usize).map(at).sum::<f64>() / f64::from(steps)
    };
    let from_front = |s: f64| mean(&|p| film_of_matrix(index, phase, [1.0, index_out], s, p)[1]);
    let lost_behind = |s: f64| {
        mean(&|p| {
            let [r, t] = film_of_matrix(index, phase, [index_out, 1.0], s, p);
            1.0 - r - t
        })
    };
    let through = over(0.0, 1.0, &from_front);
    let square = index_out * index_out;
    let lost = (over(0.0, 1.0, &lost_behind) + over(1.0, index_out, &lost_behind)) / square;
    let leaves = through / square;
    let [r, t] = film_of_matrix(index, phase, [1.0, index_out], 0.0, false);
    [lost, r + t * albedo / (1.0 - albedo * (1.0 - lost - leaves)) * leaves]
}

/// Light from a paper in contact beyond the critical angle of air goes to and fro in the film as in its formula, in either wave.
/// *Planted*: the change of that light left out.
#[test]
fn an_absorbing_film_in_slabs_in_contact_with_its_paper_has_its_fringes() {
    for (wave, polarised) in [("scalar", &[false][..]), ("unpolarised", &[false, true])] {
        for (n, k, index_out) in [(1.56, 0.01, 1.45), (1.5, 0.004, 1.5)] {
            let scratch = tempfile::tempdir().unwrap();
            let text = CLEAR
                .replace(
                    "binder.index = 1.5\n",
                    &format!("binder.index = {{ n = {n}, k = {k} }}\nindex_out = {index_out}\n"),
                )
                .replace("index = 1.5\n[paper]", &format!("index = {{ n = {n}, k = {k} }}\n[paper]"))
                .replace("albedo = 0.9", "albedo = 0.9\ncoupling = \"optical_contact\"")
                .replace("[2, 5.3, 128, 300.7]", "[0.8, 1.3, 4]")
                .replace("slab_um = 1.0", "slab_um = 0.4")
                .replace("[light]\n", &format!("[light]\nwave = \"{wave}\"\n"));
            let file = study(scratch.path(), &text);
            let output = scratch.path().join("out");
            succeed(&file, &output, &[]);
            for row in results(&output)["spectra"].as_array().expect("rows") {
                let um = row["thickness_um"].as_f64().expect("a number");
                let nm = row["wavelength_nm"].as_f64().expect("a number");
                let phase = std::f64::consts::TAU / (1e-3 * nm) * um;
                let [lost, light] = absorbing_film(Complex64::new(n, k), phase, index_out, 0.9, polarised);
                let off = [("absorptance_behind", lost), ("natural_light", light)]
                    .map(|(name, want)| value(row, name) - want);
                // Polynomials between the few directions that are solved; without the change 0.8 µm are off by 0.007.
                assert!(
                    off.iter().all(|off| off.abs() < 2.5e-3),
                    "{wave} {n} {k} {um} µm {nm} nm: {off:?} of {lost} {light}"
                );
            }
        }
    }
}

/// An ink that hardly scatters, in contact with its paper, is the same in slabs and solved at once: what it absorbs of light from the
/// paper, and R. *Planted*: light beyond the critical angle of air without interference, off by 0.009 and 0.004.
#[test]
fn an_ink_in_slabs_in_contact_with_its_paper_is_the_ink_solved_at_once() {
    let scratch = tempfile::tempdir().unwrap();
    let text = r#"
title = "An ink that hardly scatters"
[layer]
thickness_um = [0.8]
period_um = 0.8
binder.index = { n = 1.56, k = 0.01 }
index_out = 1.45
composed = { slab_um = 0.4 }
[[pigment]]
diameter_nm = 150
volume_fraction = 0.1
index = { n = 1.6, k = 0.01 }
[paper]
albedo = 0.9
coupling = "optical_contact"
[light]
wavelengths_nm = [450, 550, 600, 650]
[run]
realisations = 4
[resolution]
accuracy = 5e-2
"#;
    let whole = text.replace("[0.8]", "0.8").replace("composed = { slab_um = 0.4 }\n", "");
    let rows = [("slabs", text), ("whole", whole.as_str())].map(|(name, text)| {
        let folder = scratch.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        let output = folder.join("out");
        succeed(&study(&folder, text), &output, &[]);
        let rows = results(&output)["spectra"].as_array().expect("rows").clone();
        rows.into_iter().filter(|row| row["polar_deg"].as_f64().unwrap_or(0.0) == 0.0).collect::<Vec<_>>()
    });
    assert_eq!((rows[0].len(), rows[1].len()), (4, 4));
    // what the directions and the packings leave open is a third of what the planted fault is
    for (name, most) in [("absorptance_behind", 0.003), ("natural_light", 0.002)] {
        let apart = rows[0].iter().zip(&rows[1]).map(|(a, b)| (value(a, name) - value(b, name)).powi(2));
        let apart = (apart.sum::<f64>() / 4.0).sqrt();
        assert!(apart < most, "{name}: {apart}");
    }
}

/// A layer that is no whole number of the slabs of its list is the layer cut into slabs of its own.
/// *Planted*: a polynomial over whole numbers of slabs through what has fringes.
#[test]
fn a_thickness_in_a_list_is_the_thickness_alone() {
    let scratch = tempfile::tempdir().unwrap();
    let text = r#"
title = "Fringes between whole slabs"
[layer]
thickness_um = [3, 4]
period_um = 0.8
binder.index = 1.558
composed = { slab_um = 1.5 }
[[pigment]]
diameter_nm = 250
volume_fraction = 0.1
index = { n = 1.4, k = 0.003 }
[paper]
albedo = 0.9
[light]
wavelengths_nm = [450, 550, 650]
[run]
realisations = 6
[resolution]
accuracy = 5e-2
"#;
    let run = |name: &str, text: &str| {
        let folder = scratch.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        let file = study(&folder, text);
        let output = folder.join("out");
        succeed(&file, &output, &[]);
        let rows = results(&output)["spectra"].as_array().expect("rows").clone();
        rows.into_iter().filter(|row| row["thickness_um"] == 4.0).collect::<Vec<_>>()
    };
    let listed = run("listed", text);
    let alone = run("alone", &text.replace("[3, 4]", "4"));
    let error = |row: &Value, name: &str| row[name]["standard_error"].as_f64().expect("an error");
    let mut worst: f64 = 0.0;
    for (a, b) in listed.iter().zip(&alone) {
        for name in
            ["reflectance_normal", "transmittance_normal", "reflectance_45", "transmittance_45", "lit_at_45"]
        {
            let z = (value(a, name) - value(b, name)) / error(a, name).hypot(error(b, name));
            assert!(z.abs() < 4.5, "{name}, {} nm: {} {}", a["wavelength_nm"], a[name], b[name]);
            assert!(error(a, name) < 0.04, "{name}: {}", a[name]);
            worst = worst.max(z.abs());
        }
    }
    assert!(worst > 0.1, "different slabs differ");
}
