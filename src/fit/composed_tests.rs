//! The fit of opaque coats on a table whose values are a closed form, so that the inversion alone is
//! judged.

use super::*;
use crate::fit::file::{AlsoFitted, KnownN};
use crate::fit::load::load;
use crate::fit::run::coverage_tests::pigment;
use crate::numerics::Draws;

const FIT: &str = "[base]\n[base.layer]\nthickness_um = 20.0\nperiod_um = 0.8\nbinder.index = 1.5\n[base.layer.composed]\nslab_um = 1.0\n\
                   [[base.pigment]]\nname = \"a\"\ndiameter_nm = 200\nvolume_fraction = 0.15\n[base.light]\nwave = \"unpolarised\"\n\
                   from_nm = 400\nto_nm = 700\nstep_nm = 20\n[base.run]\nrealisations = 8\n[[measured]]\nfile = \"masstone.csv\"\nbacking = 0.04\n\
                   [fit]\nn = [1.6, 2.4]\nkappa = [0.0, 0.6]\n";

fn read(text: &str) -> Result<FitTask, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fit.toml");
    let rows = "wavelength_nm,reflectance\n400,0.1\n700,0.5\n";
    std::fs::write(folder.path().join("masstone.csv"), rows).unwrap();
    std::fs::write(&path, text).unwrap();
    load(&path).map_err(|error| format!("{error:?}"))
}

/// Kubelka and Munk behind a surface: S in proportion to (n − n_binder)², K to κ, both to powers of the
/// wavelength.
fn closed_form(nm: f64, [n, kappa]: [f64; 2]) -> f64 {
    let scattering = 4.0 * (n - 1.5).powi(2) * (500.0 / nm).powi(2);
    let absorption = 40.0 * kappa / (nm / 500.0);
    seen_from_outside(absorption, scattering)
}

/// R∞ of two fluxes behind a surface.
fn seen_from_outside(absorption: f64, scattering: f64) -> f64 {
    let x = absorption / (10.0 * scattering);
    let inner = 1.0 / (1.0 + x + (x * x + 2.0 * x).sqrt());
    0.96 * 0.4 * inner / (1.0 - 0.6 * inner)
}

fn table(task: &FitTask) -> NodeTable {
    let [n, kappa] = axes(task);
    let nm = task.wavelengths_nm();
    let node = |_: usize, w: usize, i: usize, j: usize| {
        let value = closed_form(nm[w], [n[i], kappa[j]]);
        NodeValue { value, thicker: value, error: 0.001 }
    };
    NodeTable::of((1, nm.len(), n.len(), kappa.len()), 1.5, [n.clone(), kappa.clone()], node)
}

/// Pigments above the binder, with 0.3 % of noise and n known at one wavelength: where the coat is neither white nor black
/// κ is within 10 %, root mean square over all of them, and its intervals hold. Without the known n, n is said to be
/// undetermined. *Planted*: an ultraviolet without absorption (n and κ too small in the blue).
///
/// κ goes with scattering, so with (n − n_binder)², and n from one wavelength to the others depends on absorption that
/// was not measured: 3 to 20 % are usual.
#[test]
fn opaque_coats_give_kappa_where_n_is_known() {
    let mut task = read(FIT).expect("sound");
    assert!(task.is_composed());
    let nm = task.wavelengths_nm().to_vec();
    let table = table(&task);
    let mut draws = Draws::new(9, 0);
    let mut relative = Vec::new();
    let (mut count, mut inside) = (0.0, 0.0);
    for k in 0..20 {
        let mut truth = pigment(&nm, &mut draws);
        // lifts n off the binder's, which leaves it causal
        let lowest = truth.iter().map(|row| row[0]).fold(f64::INFINITY, f64::min);
        truth.iter_mut().for_each(|row| row[0] += (1.95 - lowest).max(0.0));
        let noisy = nm.iter().zip(&truth).map(|(nm, eta)| closed_form(*nm, *eta) + 0.003 * draws.normal());
        task.measured[0].values = Some(noisy.collect());
        task.settings.known_n = None;
        if k < 4 {
            let free = table.fitted(&task).expect("a fit");
            assert!(!free.n_is_determined, "{:?}", free.remarks);
            assert!(free.remarks[0].contains("fit.known_n"), "{:?}", free.remarks);
        }
        task.settings.known_n = Some(KnownN { n_nm: nm[8], n: truth[8][0], n_error: 0.01 });
        let fit = table.fitted(&task).expect("a fit");
        for ((row, truth), nm) in fit.index.iter().zip(&truth).zip(&nm) {
            if (0.03..0.33).contains(&closed_form(*nm, *truth)) {
                let off = row.kappa - truth[1];
                relative.push(off / truth[1]);
                count += 1.0;
                inside += f64::from(u8::from(off.abs() < 1.96 * row.kappa_error.unwrap_or(0.0)));
            }
        }
    }
    let off = rms(relative);
    assert!(count > 100.0 && off < 0.10, "κ off by {off} of itself, of {count}");
    assert!(inside / count > 0.9, "inside 95 %: {}", inside / count);
}

/// A white whose index is known, before the pigment that is fitted, in the base's file.
const WHITE: &str = "[[base.pigment]]\nname = \"white\"\ndiameter_nm = 250\nvolume_fraction = 0.1\nindex = 2.7\n[[base.pigment]]\nname = \"a\"";

fn tinted(measured: &str) -> String {
    let text = FIT.replace("[[base.pigment]]\nname = \"a\"", WHITE);
    let text = text.replace(
        "[fit]",
        "[fit]\npigment = \"a\"\ndensities_g_per_cm3 = { a = 5.0, white = 4.0, binder = 1.0 }",
    );
    text.replace("[[measured]]\nfile = \"masstone.csv\"\nbacking = 0.04\n", measured)
}

/// 5 g of a at 5 g/cm³, 4 of a white at 4, 8 of a binder at 1: 1, 1 and 8 cm³. A pigment without weight
/// is not there, and the fitted one keeps its place. *Planted*: weights taken for volumes; the place of
/// the file kept.
#[test]
fn shares_by_weight_are_volumes_by_densities() {
    let masstone = "[[measured]]\nfile = \"masstone.csv\"\nopaque = true\n";
    let tint = "[[predict]]\nopaque = true\n";
    let task = read(&tinted(&format!(
        "{masstone}weights = {{ a = 5, binder = 4 }}\n{tint}weights = {{ a = 5, white = 4, binder = 8 }}\n\
         {tint}volume_fractions = {{ a = 0.03 }}\n"
    )))
    .expect("sound");
    let shares = |drawdown: &Drawdown| -> Vec<(String, f64)> {
        let of = |p: &crate::input::study::Pigment| (p.name.clone(), p.grains.volume_fraction);
        drawdown.study.pigments.iter().map(of).collect()
    };
    let [masstone, by_weight, by_volume] =
        [&task.measured[0], &task.predicted[0], &task.predicted[1]].map(shares);
    assert_eq!((task.pigment, masstone.len()), (0, 1));
    let expected = [("a", 0.2), ("a", 0.1), ("white", 0.1), ("a", 0.03), ("white", 0.1)];
    for ((name, share), (expected_name, expected)) in
        masstone.iter().chain(&by_weight).chain(&by_volume).zip(expected)
    {
        assert!(name == expected_name && (share - expected).abs() < 1e-12, "{name} {share}");
    }
    // opaque: no card, and so thick that one more slab changes nothing
    assert_eq!(
        (task.measured[0].albedo(550.0), task.measured[0].study.layer.thickness_um),
        (Some(0.0), 500.0)
    );
    // another file's order in messages
    let said = read(
        &tinted("[[measured]]\nfile = \"masstone.csv\"\nopaque = true\nvolume_fractions = { a = 0.1 }\n")
            .replace("index = 2.7", "index = -2.7"),
    );
    let said = said.expect_err("refused");
    assert!(said.contains("base.pigment[0].index"), "{said}");
}

/// A tint of a tenth of the pigment with a white of n = 2.7, by the same two fluxes.
fn tint(nm: f64, [n, kappa]: [f64; 2]) -> f64 {
    let of = |apart: f64| 4.0 * apart.powi(2) * (500.0 / nm).powi(2);
    let scattering = 0.1 * of(n - 1.5) + 0.9 * of(1.2);
    seen_from_outside(0.1 * 40.0 * kappa / (nm / 500.0), scattering)
}

/// Light that a matt face adds is found beside κ from a masstone and a tint: one alone tells them not apart. Without it κ
/// is wrong by several times as much. *Planted*: the derivative with respect to it left out.
#[test]
fn light_of_a_face_is_fitted_beside_the_index() {
    let mut task = read(FIT).expect("sound");
    let nm = task.wavelengths_nm().to_vec();
    let [n, kappa] = axes(&task);
    let both =
        NodeTable::of((2, nm.len(), n.len(), kappa.len()), 1.5, [n.clone(), kappa.clone()], |d, w, i, j| {
            let value = [closed_form, tint][d](nm[w], [n[i], kappa[j]]);
            NodeValue { value, thicker: value, error: 0.001 }
        });
    let alone = table(&task);
    task.measured.push(task.measured[0].clone());
    let mut draws = Draws::new(21, 0);
    let mut misses = [Vec::new(), Vec::new()];
    for _ in 0..6 {
        let mut truth = pigment(&nm, &mut draws);
        let lowest = truth.iter().map(|row| row[0]).fold(f64::INFINITY, f64::min);
        truth.iter_mut().for_each(|row| row[0] += (1.95 - lowest).max(0.0));
        for (drawdown, seen) in task.measured.iter_mut().zip([closed_form, tint]) {
            let matt =
                nm.iter().zip(&truth).map(|(nm, eta)| seen(*nm, *eta) + 0.015 + 0.001 * draws.normal());
            drawdown.values = Some(matt.collect());
        }
        task.settings.known_n = Some(KnownN { n_nm: nm[8], n: truth[8][0], n_error: 0.01 });
        for (fitted, misses) in [true, false].into_iter().zip(&mut misses) {
            task.settings.also = if fitted { vec![AlsoFitted::FaceLight] } else { Vec::new() };
            let fit = both.fitted(&task).expect("a fit");
            if let Some(light) = fit.face_light {
                let error = light.standard_error.expect("its error");
                assert!((light.value - 0.015).abs() < 3.0 * error, "{} ± {error}", light.value);
                assert!(
                    fit.remarks.iter().all(|remark| !remark.contains("light of the faces is not")),
                    "{:?}",
                    fit.remarks
                );
            }
            let grey = fit.index.iter().zip(&truth).zip(&nm);
            let grey = grey.filter(|((_, eta), nm)| (0.03..0.33).contains(&closed_form(**nm, **eta)));
            misses.extend(grey.map(|((row, eta), _)| row.kappa / eta[1] - 1.0));
        }
    }
    let [with, without] = misses.map(rms);
    assert!(with < 0.5 * without, "κ off by {with} with the light fitted, {without} without");
    task.measured.truncate(1);
    task.settings.also = vec![AlsoFitted::FaceLight];
    let one = alone.fitted(&task).expect("a fit");
    assert!(
        one.remarks.iter().any(|said| said.contains("light of the faces is not determined")),
        "{:?}",
        one.remarks
    );
}

/// Nodes of white coats are uncertain by much, and dark samples are fitted as well as their own nodes are known.
/// *Planted*: the errors of all nodes taken together.
#[test]
fn errors_of_white_nodes_do_not_loosen_dark_samples() {
    let mut task = read(FIT).expect("sound");
    let nm = task.wavelengths_nm().to_vec();
    let [n, kappa] = axes(&task);
    let table =
        NodeTable::of((1, nm.len(), n.len(), kappa.len()), 1.5, [n.clone(), kappa.clone()], |_, w, i, j| {
            let value = closed_form(nm[w], [n[i], kappa[j]]);
            NodeValue { value, thicker: value, error: if j == 0 { 0.2 } else { 0.001 } }
        });
    task.measured[0].values = Some(nm.iter().map(|nm| closed_form(*nm, [2.0, 0.2])).collect());
    task.settings.known_n = Some(KnownN { n_nm: 560.0, n: 2.0, n_error: 0.01 });
    let fit = table.fitted(&task).expect("a fit");
    let spectrum = &fit.spectra[0];
    assert!(spectrum.sigma.iter().all(|sigma| *sigma < 0.006), "{:?}", spectrum.sigma);
    for (fitted, measured) in spectrum.fitted.iter().zip(&spectrum.measured) {
        assert!((fitted - measured).abs() < 0.006, "{fitted} for {measured}");
    }
}

/// Between the nodes the table is as accurate as stated, and its derivatives are its own.
#[test]
fn the_table_is_accurate_between_its_nodes() {
    let task = read(FIT).expect("sound");
    let table = table(&task);
    let nm = task.wavelengths_nm();
    for n in [1.65, 1.9, 2.3] {
        for kappa in [0.001, 0.004, 0.03, 0.15, 0.5] {
            let index = vec![[n, kappa]; nm.len()];
            let response = table.response(&index, 0.0);
            for (w, nm) in nm.iter().enumerate() {
                let off = response.values[0][w] - closed_form(*nm, [n, kappa]);
                assert!(off.abs() < 0.004, "{n} {kappa} {nm}: {off}");
                let more = table.response(&vec![[n, 1.01 * kappa]; index.len()], 0.0).values[0][w];
                let slope = (more - response.values[0][w]) / (0.01 * kappa);
                assert!((slope - response.slopes[1][0][w]).abs() < 0.02 * slope.abs() + 1e-6);
            }
        }
    }
}

/// Fits with a part of their file replaced are refused with what must be said.
fn assert_refused(cases: &[(&str, &str, [&str; 4])]) {
    for (from, to, says) in cases {
        let said = read(&FIT.replace(from, to)).expect_err("refused");
        assert!(says.iter().all(|part| said.contains(part)), "{said}");
    }
}

#[test]
fn settings_that_a_composed_base_cannot_have_are_refused() {
    assert_refused(&[
        (
            "n = [1.6, 2.4]",
            "n = [1.3, 2.0]",
            ["fit.n", "[1.3, 2]", "above or all below the binder's 1.500", "1.60"],
        ),
        (
            "[fit]",
            "[fit]\nknown_n = { n_nm = 589, n = 1.45 }",
            ["fit.known_n.n", "1.45", "n above the binder's 1.500", "correct fit.known_n"],
        ),
        (
            "backing = 0.04\n[fit]",
            "opaque = true\n[fit]\nalso = [\"thickness\"]",
            ["fit.also", "thickness", "face_light", "has no thickness"],
        ),
        (
            "backing = 0.04\n[fit]",
            "opaque = true\n[fit]\nprior = \"smooth\"",
            ["fit.prior", "smooth", "fit.known_n", "absorption over scattering"],
        ),
        (
            "kappa = [0.0, 0.6]",
            "kappa = [0.1, 0.1]",
            ["fit.kappa", "[0.1, 0.1]", "from < to", "n and κ are fitted together"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\nweights = { a = 3, binder = 40 }",
            ["fit.densities_g_per_cm3.a", "nothing", "its density", "volume_fractions"],
        ),
        (
            "[fit]",
            "[fit]\ndensities_g_per_cm3 = { a = 0 }",
            ["fit.densities_g_per_cm3.a", "0", "0.1 to 30", "4 to 5 for an oxide"],
        ),
        (
            "[fit]",
            "[fit]\ndensities_g_per_cm3 = { bindre = 1.1 }",
            ["fit.densities_g_per_cm3.bindre", "unknown name", "binder, and the names", "as in the base"],
        ),
        (
            "backing = 0.04\n[fit]",
            "backing = 0.04\nweights = { a = 0, binder = 0 }\n[fit]\ndensities_g_per_cm3 = { a = 5.0, white = 4.0, binder = 1.0 }",
            ["measured[0].weights", "0 in all", "more than 0", "{ red = 3, binder = 40 }"],
        ),
        (
            "[fit]",
            "[fit]\nalso = [\"thickness\", \"thickness\"]",
            ["fit.also", "one number twice", "every number once", "remove one"],
        ),
        (
            "[fit]",
            "[fit]\nknown_n = { n_nm = 100, n = 1.65 }",
            ["fit.known_n.n_nm", "100", "from 250", "the pole of the ultraviolet"],
        ),
        (
            "[fit]",
            "[fit]\nprior = \"smooth\"\nknown_n = { n_nm = 589, n = 1.65 }",
            ["fit.known_n", "smooth", "kramers-kronig", "remove fit.known_n"],
        ),
        (
            "[fit]",
            "[fit]\nknown_n = { n_nm = 589, n = 1.65, n_error = 0 }",
            ["fit.known_n.n_error", "0", "0.0001", "0.01 is usual"],
        ),
    ]);
}

#[test]
fn samples_that_contradict_themselves_are_refused() {
    assert_refused(&[
        (
            "backing = 0.04",
            "backing = 0.04\nopaque = true",
            ["measured[0].backing", "0.04", "none where opaque = true", "remove backing"],
        ),
        (
            "backing = 0.04",
            "geometry = \"transmittance\"",
            ["measured[0].file", "reflectance, not transmittance", "of one sample", "name its column"],
        ),
        (
            "backing = 0.04",
            "opaque = true\nthickness_um = 30",
            ["measured[0].thickness_um", "30", "none where opaque", "remove thickness_um"],
        ),
        ("backing = 0.04", "", ["measured[0].backing", "nothing", "the albedo of the card", "opaque = true"]),
        (
            "backing = 0.04",
            "backing = 0.04\nface = { k1 = 0.03 }",
            ["measured[0].face", "0.03", "k1 and k2 together", "k2 = 0.6"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\nface = { light = 0.3 }",
            ["measured[0].face.light", "0.3", "0 to 0.2", "0.01 to 0.02"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\nweights = { a = 3 }",
            ["measured[0].weights.binder", "nothing", "the part of the binder", "binder = 40"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\nvolume_fractions = { white = 0.1 }",
            ["measured[0].volume_fractions.white", "a share", "the base's pigments: a", "name a pigment"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\nvolume_fractions = { a = 0 }",
            ["measured[0].volume_fractions.a", "0", "more than 0", "remove this spectrum"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\nvolume_fractions = { a = 0.9 }",
            ["measured[0].volume_fractions", "0.9", "0.64", ""],
        ),
    ]);
}
